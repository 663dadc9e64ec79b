// axiscal volumetric: how far the tool point is off over a box of positions, before and after calibrations.
#include <CLI/CLI.hpp>
#include <memory>

#include "absl/strings/str_join.h"
#include "client/cli/commands.h"
#include "client/cli/context.h"
#include "client/cli/positive_number.h"
#include "client/cli/record_output.h"
#include "core/session/text.h"

namespace axiscal::cli {
namespace {

struct VolumetricArguments {
  int64_t calibration = 0, job = 0;
  std::string machine, page;
  std::vector<std::string> box;
  int page_size = 0;
};

absl::StatusOr<std::vector<records::AxisSpan>> ReadBox(const std::vector<std::string>& texts) {
  std::vector<records::AxisSpan> box;
  for (const std::string& text : texts) {
    const size_t blank = text.find(' ');
    std::vector<double> range;
    const bool is_range = blank != std::string::npos && blank > 0 &&
                          session::ParseNumbers(text.substr(blank + 1), &range) && range.size() == 2 &&
                          range[0] <= range[1];
    if (!is_range)
      return absl::InvalidArgumentError(absl::StrCat("--box '", text, "': expected \"AXIS MIN MAX\", mm or deg"));
    box.push_back({text.substr(0, blank), range[0], range[1]});
  }
  return box;
}

Json BoxJson(const std::vector<records::AxisSpan>& box) {
  Json list = Json::Array();
  for (const records::AxisSpan& span : box)
    list.push_back({{"axis", span.axis}, {"from_mm_or_deg", span.from}, {"to_mm_or_deg", span.to}});
  return list;
}

Json FiguresJson(const records::VolumetricFigures& figures) {
  const auto json = [](const records::VolumetricFigure& figure) -> Json {
    return {{"expected_um", figure.expected_um}, {"low_um", figure.low_um}, {"high_um", figure.high_um}};
  };
  return {{"rms", json(figures.rms)},
          {"median", json(figures.median)},
          {"p95", json(figures.p95)},
          {"max", json(figures.max)},
          {"largest_at_mm_or_deg", figures.largest_at}};
}

Json ErrorJson(const records::VolumetricError& error) {
  Json json = {{"calibration", error.calibration.number()},
               {"measured_at", TimeJson(error.measured_at)},
               {"state", StateName(error.state)}};
  if (error.before_calibration) json["before_calibration"] = error.before_calibration->number();
  if (!error.problem.empty()) {
    json["problem"] = error.problem;
    return json;
  }
  json["box"] = BoxJson(error.box);
  json["measured"] = BoxJson(error.measured);
  json["poses"] = error.poses;
  json["known_share"] = error.known_share;
  json["uncorrected"] = FiguresJson(error.uncorrected);
  if (error.before) json["before"] = FiguresJson(*error.before);
  json["after"] = FiguresJson(error.after);
  if (error.after_where_known) json["after_where_known"] = FiguresJson(*error.after_where_known);
  json["weakest"] = error.weakest;
  json["unknown"] = error.unknown;
  return json;
}

std::string WithInterval(const records::VolumetricFigure& figure) {
  return absl::StrCat(NumberText(figure.expected_um), " [", NumberText(figure.low_um), ", ", NumberText(figure.high_um),
                      "]");
}

std::string BoxText(const std::vector<records::AxisSpan>& box) {
  return absl::StrJoin(box, ", ", [](std::string* text, const records::AxisSpan& span) {
    absl::StrAppend(text, span.axis, " ", NumberText(span.from), " to ", NumberText(span.to));
  });
}

std::string PoseText(const records::VolumetricError& error, const records::VolumetricFigures& figures) {
  std::string text;
  for (size_t i = 0; i < figures.largest_at.size() && i < error.box.size(); ++i)
    absl::StrAppend(&text, i == 0 ? "" : " ", error.box[i].axis, NumberText(figures.largest_at[i]));
  return text;
}

std::string ErrorText(const records::VolumetricError& error) {
  std::string text = absl::StrCat("calibration ", error.calibration.number(), " (", StateName(error.state),
                                  "), tool point over ", BoxText(error.box), " (mm, deg; ", error.poses,
                                  " poses), less work offset and tool, um [95 % interval]:\n");
  std::vector<std::vector<std::string>> rows = {{"", "rms", "median", "95 % below", "max", "largest at"}};
  const auto add = [&](const std::string& what, const records::VolumetricFigures& figures) {
    rows.push_back({what, WithInterval(figures.rms), WithInterval(figures.median), WithInterval(figures.p95),
                    WithInterval(figures.max), PoseText(error, figures)});
  };
  add("machine as it is", error.uncorrected);
  if (error.before) add(absl::StrCat("corrected for ", error.before_calibration->number()), *error.before);
  add(absl::StrCat("corrected for ", error.calibration.number()), error.after);
  if (error.after_where_known) add("... of the measured poses", *error.after_where_known);
  absl::StrAppend(&text, Table(rows));
  if (error.known_share < 1.0)
    absl::StrAppendFormat(&text, "%.0f %% of the box lie within what was measured (%s); elsewhere it is extrapolated\n",
                          100.0 * error.known_share, BoxText(error.measured));
  if (!error.weakest.empty())
    absl::StrAppend(&text, "most of what is left: how well ", absl::StrJoin(error.weakest, ", "), " is known\n");
  if (!error.unknown.empty())
    absl::StrAppend(&text, "in none of the figures, as nothing tells them: ", absl::StrJoin(error.unknown, ", "), "\n");
  return text;
}

absl::Status ShowOne(Context& context, const VolumetricArguments& arguments,
                     const std::vector<records::AxisSpan>& box) {
  ASSIGN_OR_RETURN(client::Client * client, context.Connect());
  std::optional<JobId> job;
  if (arguments.job != 0) job = JobId(arguments.job);
  ASSIGN_OR_RETURN(const records::VolumetricError error,
                   client->GetVolumetricError(CalibrationId(arguments.calibration), box, job));
  context.Print(ErrorJson(error), ErrorText(error));
  return absl::OkStatus();
}

absl::Status ShowHistory(Context& context, const VolumetricArguments& arguments,
                         const std::vector<records::AxisSpan>& box) {
  ASSIGN_OR_RETURN(client::Client * client, context.Connect());
  ASSIGN_OR_RETURN(
      const records::Page<records::VolumetricError> page,
      client->ListVolumetricErrors(MachineId(arguments.machine), box, {arguments.page_size, arguments.page}));
  Json errors = Json::Array();
  std::vector<std::vector<std::string>> rows = {{"calibration", "measured (UTC)", "state", "as it is, um rms", "before",
                                                 "after [95 %]", "after, 95 % below", "measured, %"}};
  for (const records::VolumetricError& error : page.rows) {
    errors.push_back(ErrorJson(error));
    std::vector<std::string> row = {std::to_string(error.calibration.number()), TimeText(error.measured_at),
                                    StateName(error.state)};
    if (error.problem.empty()) {
      row.insert(row.end(),
                 {NumberText(error.uncorrected.rms.expected_um),
                  error.before ? NumberText(error.before->rms.expected_um) : "-", WithInterval(error.after.rms),
                  NumberText(error.after.p95.expected_um), absl::StrFormat("%.0f", 100.0 * error.known_share)});
    } else {
      row.insert(row.end(), {"-", "-", error.problem, "-", "-"});
    }
    rows.push_back(std::move(row));
  }
  context.Print({{"machine", arguments.machine}, {"errors", errors}, {"next_page", page.next_token}},
                Table(rows) + PageText(page));
  return absl::OkStatus();
}

absl::Status RunVolumetric(Context& context, const VolumetricArguments& arguments) {
  ASSIGN_OR_RETURN(const std::vector<records::AxisSpan> box, ReadBox(arguments.box));
  if (arguments.calibration != 0) return ShowOne(context, arguments, box);
  if (arguments.machine.empty()) return absl::InvalidArgumentError("volumetric: expected a calibration or --machine");
  return ShowHistory(context, arguments, box);
}

}  // namespace

void AddVolumetricCommand(CLI::App& app, Context& context) {
  auto arguments = std::make_shared<VolumetricArguments>();
  CLI::App* volumetric =
      app.add_subcommand("volumetric", "How far the tool point is off over a box, before and after a calibration");
  CLI::Option* const id =
      volumetric->add_option("CALIBRATION", arguments->calibration, "of this calibration")->check(PositiveNumber());
  CLI::Option* const machine =
      volumetric->add_option("--machine", arguments->machine, "of all calibrations of this machine, newest first")
          ->excludes(id);
  CLI::Option* const box =
      volumetric->add_option("--box", arguments->box,
                             "a part's range of an axis, mm or deg: \"X -200 300\"; again for more (default: what the "
                             "calibration's sessions measured)");
  volumetric->add_option("--job", arguments->job, "over the box in which the program of this compensate job moves")
      ->check(PositiveNumber())
      ->needs(id)
      ->excludes(box);
  volumetric->add_option("--page-size", arguments->page_size, "calibrations per page (1 to 100, default 20)")
      ->check(CLI::Range(1, 100))
      ->needs(machine);
  volumetric->add_option("--page", arguments->page, "token of the next page")->needs(machine);
  volumetric->footer(
      "Work offset, tool length and tool centre are taken up: they are set anew before a part is cut.\n"
      "Examples: axiscal volumetric 12\n"
      "          axiscal volumetric 12 --box \"X 0 200\" --box \"Z -300 -100\"\n"
      "          axiscal volumetric --machine mt --json");
  SetAction(volumetric, context, [&context, arguments] { return RunVolumetric(context, *arguments); });
}

}  // namespace axiscal::cli
