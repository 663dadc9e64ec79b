#include "client/cli/compare_source.h"

#include <algorithm>
#include <filesystem>

#include "absl/strings/numbers.h"
#include "absl/strings/str_split.h"
#include "core/base/files.h"
#include "core/base/json_limits.h"
#include "core/identify/identify.h"
#include "core/instruments/covered.h"
#include "core/machine/error_json.h"
#include "core/machine/machine_json.h"
#include "core/session/case.h"

namespace axiscal::cli {
namespace {

constexpr size_t kMaxCalibrationBytes = size_t{256} << 20;  // correlations of many errors are long

void CoverPositions(const std::vector<instruments::MeasuringRun>& runs, Compared* compared) {
  instruments::Covered covered;
  instruments::Cover(runs, covered);
  compared->tip_mm = covered.tip_mm;
  if (!covered.low.empty()) compared->measured = predict::Box{covered.low, covered.high};
}

// The axes must be the same, or the errors are not those of the same joints.
absl::Status CheckAxes(const machine::Machine& of, const machine::Machine& machine, Compared* compared) {
  const auto differ = [&](const std::string& what) {
    return absl::InvalidArgumentError(absl::StrCat("it is of machine ", of.id, ", whose ", what,
                                                   " not that of machine ", machine.id, ", expected the same axes"));
  };
  if (of.axes.size() != machine.axes.size() || of.tool_branch != machine.tool_branch ||
      of.work_branch != machine.work_branch)
    return differ("order of axes is");
  constexpr double kSame = 1e-6;  // of a unit vector, as machine.json asks for
  for (size_t i = 0; i < of.axes.size(); ++i) {
    const machine::Axis &one = of.axes[i], &other = machine.axes[i];
    if (one.name != other.name || one.kind != other.kind || (one.direction - other.direction).norm() > kSame)
      return differ(absl::StrCat("axis ", one.name, " is"));
    const double moved_mm = (one.point_mm - other.point_mm).norm();
    if (moved_mm > 0.0)
      compared->notes.push_back(
          absl::StrFormat("%s: its description puts the point of %s %g mm from where the other's "
                          "has it; its errors act about that other point",
                          compared->side.label, one.name, moved_mm));
  }
  return absl::OkStatus();
}

absl::Status ReadStored(Context& context, int64_t id, const machine::Machine& machine, Compared* compared) {
  ASSIGN_OR_RETURN(client::Client * client, context.Connect());
  ASSIGN_OR_RETURN(const records::CalibrationRecord record, client->GetCalibration(CalibrationId(id)));
  ASSIGN_OR_RETURN(const machine::Machine described, MachineOfCalibration(context, id));
  RETURN_IF_ERROR(CheckAxes(described, machine, compared));
  compare::Side& side = compared->side;
  ASSIGN_OR_RETURN(side.errors, machine::ReadKnownErrors(record.content.model_json, machine));
  ASSIGN_OR_RETURN(const reports::CalibrationReport report, reports::ReadCalibrationReport(record.content.report_json));
  compare::AddReport(report, &side);
  side.sessions.clear();
  std::vector<session::Session> sessions;
  for (const SessionId& session : record.content.sessions) {
    side.sessions.push_back(absl::StrCat("session ", session.number()));
    // Readings go by age (retention); the comparison does not need them.
    auto readings = client->DownloadSession(session);
    if (readings.ok()) sessions.push_back(*std::move(readings));
  }
  const auto runs = identify::BindSessions(machine, sessions);
  if (runs.ok()) CoverPositions(*runs, compared);
  return absl::OkStatus();
}

// Session files of a list of files and folders; of a case folder those of fit/.
std::vector<std::string> FilesOf(const std::string& name) {
  std::vector<std::string> files;
  for (const std::string& path : std::vector<std::string>(absl::StrSplit(name, ','))) {
    std::error_code error;
    if (!std::filesystem::is_directory(path, error)) {
      files.push_back(path);
      continue;
    }
    const std::string fit = (std::filesystem::path(path) / "fit").string();
    const auto found = session::SessionFiles(std::filesystem::is_directory(fit, error) ? fit : path);
    files.insert(files.end(), found.begin(), found.end());
  }
  return files;
}

absl::Status FitHere(const std::string& name, const machine::Machine& machine, const std::vector<std::string>& declared,
                     Compared* compared) {
  const std::vector<std::string> files = FilesOf(name);
  if (files.empty()) return absl::NotFoundError("no session file (*.csv) there");
  std::vector<session::Session> sessions;
  for (const std::string& file : files) {
    ASSIGN_OR_RETURN(sessions.emplace_back(), session::ReadSessionFileOf(file, machine));
    compared->side.sessions.push_back(session::FindHeader(sessions.back(), "session").value_or(""));
  }
  identify::Options options;
  options.model = machine::DeclaredModel(machine);
  if (!declared.empty()) options.model->terms.clear();
  for (const std::string& error : declared) {
    auto asked = machine::ReadAskedError(error, machine);
    if (!asked.ok()) return base::Within("--declare", asked.status());
    options.model->terms.insert(options.model->terms.end(), asked->terms.begin(), asked->terms.end());
  }
  if (options.model->terms.empty())
    return absl::InvalidArgumentError("machine.json declares no error: expected --declare with the errors to fit");
  ASSIGN_OR_RETURN(const identify::Fit fit, identify::FitSessions(machine, sessions, options));
  const identify::Result& result = fit.result;
  compare::Side& side = compared->side;
  side.errors.model = result.model;
  ASSIGN_OR_RETURN(side.errors.covariance, machine::CovarianceOf(result.covariance, machine, result.model));
  side.has_report = true;
  side.not_separable = result.not_separable;
  for (const identify::Estimate& estimate : result.estimates)
    if (!estimate.identifiable) side.without_number.push_back(estimate.name);
  side.coverage_factor = result.coverage_factor;
  CoverPositions(fit.problem.runs, compared);
  return absl::OkStatus();
}

absl::Status ReadSource(Context& context, const std::string& name, const machine::Machine& machine,
                        const std::vector<std::string>& declared, Compared* compared) {
  compared->side.label = name;
  if (int64_t id = 0; absl::SimpleAtoi(name, &id)) return ReadStored(context, id, machine, compared);
  if (!name.ends_with(".json")) return FitHere(name, machine, declared, compared);
  ASSIGN_OR_RETURN(const std::string text, base::ReadFile(name, kMaxCalibrationBytes));
  ASSIGN_OR_RETURN(compared->side, compare::ReadSide(text, machine));
  compared->side.label = name;
  return absl::OkStatus();
}

}  // namespace

absl::StatusOr<machine::Machine> MachineOfCalibration(Context& context, int64_t calibration) {
  ASSIGN_OR_RETURN(client::Client * client, context.Connect());
  ASSIGN_OR_RETURN(const records::CalibrationRecord record, client->GetCalibration(CalibrationId(calibration)));
  ASSIGN_OR_RETURN(const records::MachineRecord described,
                   client->GetMachineRevision(record.content.machine, record.content.machine_revision));
  return machine::MachineFromJson(described.description_json);
}

absl::StatusOr<Compared> ReadCompared(Context& context, const std::string& name, const machine::Machine& machine,
                                      const std::vector<std::string>& declared) {
  Compared compared;
  const absl::Status status = ReadSource(context, name, machine, declared, &compared);
  // Messages of files begin with their paths already.
  if (!status.ok() && std::string(status.message()).rfind(name, 0) != 0) return base::Within(name, status);
  RETURN_IF_ERROR(status);
  return compared;
}

}  // namespace axiscal::cli
