#include "client/cli/plan_certificate.h"

#include <cmath>
#include <filesystem>

#include "absl/strings/str_join.h"
#include "client/cli/box_words.h"
#include "core/base/units.h"
#include "core/instruments/covered.h"
#include "core/plan/certificate.h"
#include "core/plan/planned_run.h"
#include "core/plan/state_setups.h"
#include "core/plan/test.h"
#include "core/session/read_session.h"

namespace axiscal::cli {
namespace {

absl::StatusOr<std::vector<session::Session>> SessionsOf(const plan::Situation& situation,
                                                         const std::vector<std::string>& names) {
  std::vector<session::Session> sessions;
  for (const std::string& name : names) {
    std::error_code error;
    if (std::filesystem::is_regular_file(name, error)) {
      ASSIGN_OR_RETURN(session::Session session, session::ReadPlanFile(name));
      sessions.push_back(std::move(session));
      continue;
    }
    std::optional<plan::PlannedSession> planned = plan::FindPlanned(situation, name);
    if (!planned) {
      return absl::NotFoundError(absl::StrCat("--certify: '", name, "' is neither a file nor a test that machine ",
                                              situation.machine->id,
                                              " can run, expected a plan's file or a session of ", "--list"));
    }
    sessions.push_back(std::move(planned->session));
  }
  return sessions;
}

// The stated travel of each axis, else what the plan covers; what --box says goes first.
absl::StatusOr<predict::Workspace> WorkspaceOf(const machine::Machine& machine,
                                               const std::vector<session::Session>& sessions,
                                               const std::vector<std::string>& box) {
  instruments::Covered covered;
  std::vector<instruments::MeasuringRun> runs;
  for (const session::Session& session : sessions) {
    ASSIGN_OR_RETURN(instruments::MeasuringRun run, plan::PlannedRun(machine, session));
    runs.push_back(std::move(run));
  }
  instruments::Cover(runs, covered);
  predict::Workspace workspace;
  workspace.tip_mm = runs.front().tip_mm;
  for (int axis = 0; axis < machine.axis_count(); ++axis) {
    const machine::Axis& a = machine.axes[axis];
    const bool is_stated = a.min_position && a.max_position, is_covered = !covered.low.empty();
    workspace.box.low.push_back(is_stated ? *a.min_position : is_covered ? covered.low[axis] : 0.0);
    workspace.box.high.push_back(is_stated ? *a.max_position : is_covered ? covered.high[axis] : 0.0);
  }
  for (const std::string& text : box) RETURN_IF_ERROR(SetBoxRange(text, machine, &workspace.box));
  return workspace;
}

double Um(double mm) { return mm * base::kUmPerMm; }

Json LeftOverJson(const machine::Machine& machine, const plan::LeftOver& left) {
  return {{"rms_um", Um(left.chance.rms_mm)},
          {"max_um", Um(left.chance.max_mm)},
          {"least_certain_at", PoseJson(machine, left.positions)},
          {"sigma_um", VectorJson(left.sigma_mm)},
          {"by", left.by}};
}

std::string LeftOverText(const machine::Machine& machine, const std::string& what, const plan::LeftOver& left) {
  std::string text = absl::StrFormat(
      "%s: within %s um everywhere, %s um rms, in 95 of 100 cases\n"
      "  least certain at %s: sigma (%s %s %s) um",
      what, NumberText(Um(left.chance.max_mm)), NumberText(Um(left.chance.rms_mm)), PoseText(machine, left.positions),
      NumberText(Um(left.sigma_mm.x())), NumberText(Um(left.sigma_mm.y())), NumberText(Um(left.sigma_mm.z())));
  if (!left.by.empty()) absl::StrAppend(&text, ", mostly by ", absl::StrJoin(left.by, ", "));
  return text + "\n";
}

Json CertificateJson(const machine::Machine& machine, const plan::Certificate& certificate,
                     const predict::Workspace& workspace) {
  Json errors = Json::Array(), stated = Json::Array(), unseen = Json::Array();
  for (const identify::Estimate& error : certificate.errors) {
    errors.push_back({{"symbol", error.name},
                      {"identifiable", error.identifiable},
                      {"sigma", error.identifiable ? Json(error.sigma / error.factor) : Json()},
                      {"unit", error.unit}});
  }
  for (const identify::Result::Stated& fact : certificate.stated) {
    Json moves = Json::Object();
    for (size_t i = 0; i < certificate.errors.size(); ++i) {
      const double moved = fact.moved[static_cast<Eigen::Index>(i)] / certificate.errors[i].factor;
      if (std::isfinite(moved)) moves[certificate.errors[i].name] = moved;
    }
    stated.push_back({{"of", fact.of}, {"moves", moves}});
  }
  for (const plan::Unseen& one : certificate.unseen) {
    unseen.push_back({{"direction", one.direction},
                      {"per", "1 " + one.unit + " of " + one.of},
                      {"as_programmed_um", Um(one.as_programmed_mm)},
                      {"set_anew_um", Um(one.set_anew_mm)}});
  }
  return {{"sessions", certificate.sessions},
          {"readings", certificate.readings},
          {"seconds_with_mounting", certificate.seconds},
          {"errors", errors},
          {"stated", stated},
          {"not_seen", unseen},
          {"tool_point",
           {{"box", BoxJson(machine, workspace.box)},
            {"poses", certificate.poses},
            {"as_programmed", LeftOverJson(machine, certificate.as_programmed)},
            {"set_anew", LeftOverJson(machine, certificate.set_anew)}}}};
}

std::string CertificateText(const machine::Machine& machine, const plan::Certificate& certificate,
                            const predict::Workspace& workspace) {
  std::vector<std::vector<std::string>> rows = {{"error", "expected +-", ""}};
  for (const identify::Estimate& error : certificate.errors) {
    rows.push_back({error.name, error.identifiable ? NumberText(error.sigma / error.factor) : "no number",
                    error.identifiable ? error.unit : "the plan does not tell it"});
  }
  std::string text = absl::StrFormat("%d session%s, %d readings, about %.0f min with mounting\n", certificate.sessions,
                                     certificate.sessions == 1 ? "" : "s", certificate.readings,
                                     std::ceil(certificate.seconds / 60.0));
  absl::StrAppend(&text, Table(rows));
  for (const identify::Result::Stated& fact : certificate.stated)
    absl::StrAppend(&text, "part of these, however often it is measured: ", fact.of, "\n");
  absl::StrAppend(&text, "tool point over ", BoxText(machine, workspace.box), " (", certificate.poses,
                  " poses), corrected for what the plan finds:\n",
                  LeftOverText(machine, "as programmed", certificate.as_programmed),
                  LeftOverText(machine, "with work offset and tool data set anew", certificate.set_anew));
  for (const plan::Unseen& one : certificate.unseen) {
    absl::StrAppend(&text, "no reading shows ", one.direction, ": ");
    if (one.as_programmed_mm == 0.0) {
      absl::StrAppend(&text, "it does not move the tool point either\n");
    } else {
      absl::StrAppendFormat(&text, "1 %s of %s moves the tool point by up to %s um%s; in none of these figures\n",
                            one.unit, one.of, NumberText(Um(one.as_programmed_mm)),
                            one.set_anew_mm == 0.0
                                ? ", which setting offset and tool data anew takes up"
                                : absl::StrCat(" (", NumberText(Um(one.set_anew_mm)), " with them set anew)"));
    }
  }
  return text;
}

}  // namespace

absl::Status PrintCertificate(Context& context, const plan::Situation& situation, const machine::ErrorModel& model,
                              const CertificateArguments& arguments) {
  const machine::Machine& machine = *situation.machine;
  ASSIGN_OR_RETURN(std::vector<session::Session> sessions, SessionsOf(situation, arguments.sessions));
  std::vector<session::Session*> plan;
  for (session::Session& session : sessions) plan.push_back(&session);
  RETURN_IF_ERROR(base::Within("--setup", plan::StateSetups(machine, arguments.setups, plan)));
  ASSIGN_OR_RETURN(const predict::Workspace workspace, WorkspaceOf(machine, sessions, arguments.box));
  ASSIGN_OR_RETURN(const plan::Certificate certificate, plan::Certify(machine, model, sessions, workspace));
  context.Print(CertificateJson(machine, certificate, workspace), CertificateText(machine, certificate, workspace));
  return absl::OkStatus();
}

}  // namespace axiscal::cli
