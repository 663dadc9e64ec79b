// axiscal care
#include <CLI/CLI.hpp>
#include <algorithm>
#include <memory>
#include <set>
#include <tuple>

#include "absl/strings/str_join.h"
#include "client/cli/commands.h"
#include "client/cli/context.h"
#include "client/cli/record_output.h"

namespace axiscal::cli {
namespace {

using records::Care;
using records::MachineCare;

// As many as the server gives at once.
constexpr int kRowsOfPage = 1000;

struct CareArguments {
  std::string group, label;
};

struct CareNames {
  const char* word;   // for programs
  const char* words;  // for people
};

CareNames CareNamesOf(Care care) {
  switch (care) {
    case Care::kNow:
      return {"now", "look now"};
    case Care::kDecide:
      return {"decide", "decide"};
    case Care::kUnknown:
      return {"unknown", "not known"};
    case Care::kGood:
      return {"good", "nothing to do"};
  }
  return {"", ""};
}

Json CareJson(const MachineCare& care) {
  Json findings = Json::Array(), in_use;
  for (const records::StandingFinding& finding : care.findings)
    findings.push_back({{"kind", DriftKindName(finding.kind)}, {"text", finding.text}, {"at", TimeJson(finding.at)}});
  if (care.in_use) {
    in_use = {{"calibration", care.in_use->calibration.number()},
              {"version", care.in_use->version},
              {"measured", TimeJson(care.in_use->measured_at)},
              {"rms_before_um", NumberJson(care.in_use->rms_before_um)},
              {"rms_after_um", NumberJson(care.in_use->rms_after_um)}};
  }
  return {{"machine", care.machine.text()},
          {"care", CareNamesOf(care.care).word},
          {"findings", findings},
          {"new_events", care.new_events},
          {"newest_event", care.newest_event},
          {"waiting", care.waiting},
          {"in_use", in_use},
          {"is_followed", care.is_followed},
          {"groups", care.groups}};
}

// Why, the weightiest first; one of them at least.
std::vector<std::string> Reasons(const MachineCare& care) {
  const std::string machine = care.machine.text();
  std::vector<std::string> reasons;
  for (const records::StandingFinding& finding : care.findings) reasons.push_back(finding.text);
  if (care.new_events > 0) {
    reasons.push_back(absl::StrCat(care.new_events == 1
                                       ? "an event that nobody has seen: "
                                       : absl::StrCat(care.new_events, " events that nobody has seen, the newest: "),
                                   care.newest_event, " (axiscal events --machine ", machine, " --open)"));
  }
  if (care.waiting > 0) {
    reasons.push_back(absl::StrCat(
        care.waiting,
        care.in_use ? " newer than what is in use, waiting for approval" : " waiting for approval, none in use",
        " (axiscal calibration list --machine ", machine, ")"));
  }
  if (reasons.empty() && !care.in_use) reasons.push_back("never calibrated: upload a session, then identify");
  if (!care.is_followed)
    reasons.push_back("its history has changed and is looked through soon: ask again");
  else if (reasons.empty())
    reasons.push_back("no jump and no doubt since the calibration in use");
  return reasons;
}

// Those that need care first, those with most to tell before others: as on the fleet's page.
bool NeedsMore(const MachineCare& a, const MachineCare& b) {
  const auto key = [](const MachineCare& care) {
    return std::tuple(care.care, -care.new_events - static_cast<int64_t>(care.findings.size()), care.machine.text());
  };
  return key(a) < key(b);
}

absl::StatusOr<std::vector<MachineCare>> WholeFleet(client::Client& client) {
  std::vector<MachineCare> fleet;
  records::PageRequest request{kRowsOfPage, ""};
  do {
    ASSIGN_OR_RETURN(records::Page<MachineCare> page, client.ListCare(request));
    std::move(page.rows.begin(), page.rows.end(), std::back_inserter(fleet));
    request.token = page.next_token;
  } while (!request.token.empty());
  std::sort(fleet.begin(), fleet.end(), NeedsMore);
  return fleet;
}

absl::StatusOr<std::set<MachineId>> LabelledMachines(client::Client& client, const std::string& label) {
  std::set<MachineId> machines;
  client::SessionFilter filter;
  filter.label = label;
  records::PageRequest request{kRowsOfPage, ""};
  do {
    ASSIGN_OR_RETURN(const auto page, client.ListSessions(filter, request));
    for (const records::SessionRecord& session : page.rows) machines.insert(session.machine);
    request.token = page.next_token;
  } while (!request.token.empty());
  return machines;
}

bool IsIn(const MachineCare& care, const std::string& group) {
  return std::find(care.groups.begin(), care.groups.end(), group) != care.groups.end();
}

// A name that nothing has is a mistake, not a fleet without a need.
absl::Status KeepGroup(const std::string& group, std::vector<MachineCare>& fleet) {
  std::set<std::string> known;
  for (const MachineCare& care : fleet) known.insert(care.groups.begin(), care.groups.end());
  if (!known.contains(group)) {
    return absl::NotFoundError(
        absl::StrCat("--group: none of the machines that you may see is in a group \"", group, "\"; ",
                     known.empty() ? "they are in none" : "there are: " + absl::StrJoin(known, ", ")));
  }
  std::erase_if(fleet, [&](const MachineCare& care) { return !IsIn(care, group); });
  return absl::OkStatus();
}

absl::Status KeepLabelled(client::Client& client, const std::string& label, std::vector<MachineCare>& fleet) {
  ASSIGN_OR_RETURN(const std::set<MachineId> labelled, LabelledMachines(client, label));
  if (labelled.empty()) {
    return absl::NotFoundError(absl::StrCat("--label: no session that you may see has the label \"", label,
                                            "\"; axiscal session list shows them"));
  }
  std::erase_if(fleet, [&](const MachineCare& care) { return !labelled.contains(care.machine); });
  return absl::OkStatus();
}

std::string CareText(const std::vector<MachineCare>& fleet) {
  if (fleet.empty()) return "no machine is both in that group and has a session with that label\n";
  const auto count = [&](Care care) {
    return std::count_if(fleet.begin(), fleet.end(), [&](const MachineCare& one) { return one.care == care; });
  };
  std::vector<std::vector<std::string>> rows = {{"machine", "care", "in use", "why"}};
  for (const MachineCare& care : fleet) {
    const std::string in_use = care.in_use ? absl::StrCat("version ", care.in_use->version, ", ",
                                                          TimeText(care.in_use->measured_at).substr(0, 10))
                                           : "none";
    const std::vector<std::string> reasons = Reasons(care);
    const bool is_sure = care.care != Care::kGood || care.is_followed;
    rows.push_back({care.machine.text(), is_sure ? CareNamesOf(care.care).words : "looking", in_use, reasons.front()});
    for (size_t i = 1; i < reasons.size(); ++i) rows.push_back({"", "", "", reasons[i]});
  }
  return absl::StrCat(fleet.size(), fleet.size() == 1 ? " machine: " : " machines: ", count(Care::kNow),
                      " to look at now, ", count(Care::kDecide), " to decide, ", count(Care::kUnknown), " not known\n",
                      Table(rows));
}

absl::Status ShowCare(Context& context, const CareArguments& arguments) {
  ASSIGN_OR_RETURN(client::Client * client, context.Connect());
  ASSIGN_OR_RETURN(std::vector<MachineCare> fleet, WholeFleet(*client));
  if (fleet.empty()) {
    context.Print({{"machines", Json::Array()}},
                  "no machine that you may see; the first comes with: axiscal machine add machine.json\n");
    return absl::OkStatus();
  }
  if (!arguments.group.empty()) RETURN_IF_ERROR(KeepGroup(arguments.group, fleet));
  if (!arguments.label.empty()) RETURN_IF_ERROR(KeepLabelled(*client, arguments.label, fleet));
  Json machines = Json::Array();
  for (const MachineCare& care : fleet) machines.push_back(CareJson(care));
  context.Print({{"machines", machines}}, CareText(fleet));
  return absl::OkStatus();
}

}  // namespace

void AddCareCommand(CLI::App& app, Context& context) {
  auto arguments = std::make_shared<CareArguments>();
  CLI::App* care =
      app.add_subcommand("care", "Which machine needs care, and why: the whole fleet, the sick ones first");
  care->add_option("--group", arguments->group, "of this group only (axiscal admin group)");
  care->add_option("--label", arguments->label, "of which a session has this label only (axiscal session annotate)");
  care->footer("Example: axiscal care --group turning\nWhat is looked at: docs/drift.md, docs/events.md.");
  SetAction(care, context, [&context, arguments] { return ShowCare(context, *arguments); });
}

}  // namespace axiscal::cli
