#include "client/cli/error_model_source.h"

#include <filesystem>

#include "core/base/files.h"
#include "core/base/json_limits.h"
#include "core/machine/error_json.h"
#include "core/machine/machine_json.h"

namespace axiscal::cli {

absl::StatusOr<MachineWithErrors> ReadModelFiles(const std::string& machine_path, const std::string& errors_path) {
  ASSIGN_OR_RETURN(MachineWithKnownErrors known, ReadKnownFiles(machine_path, errors_path));
  return MachineWithErrors{std::move(known.machine), std::move(known.errors.model)};
}

absl::StatusOr<MachineWithKnownErrors> ReadKnownFiles(const std::string& machine_path, const std::string& errors_path) {
  if (!std::filesystem::exists(machine_path)) {
    return absl::NotFoundError(machine_path + ": no such file; with --errors, --machine is a machine.json");
  }
  MachineWithKnownErrors known;
  ASSIGN_OR_RETURN(known.machine, machine::ReadMachineFile(machine_path));
  ASSIGN_OR_RETURN(const std::string text, base::ReadFile(errors_path, base::kMaxJsonBytes));
  auto errors = machine::ReadKnownErrors(text, known.machine);
  if (!errors.ok()) return base::Within(errors_path, errors.status());
  known.errors = *std::move(errors);
  return known;
}

absl::StatusOr<MachineWithCalibration> FetchCalibration(Context& context, const std::string& machine,
                                                        int64_t calibration) {
  ASSIGN_OR_RETURN(client::Client * client, context.Connect());
  const MachineId id(machine);
  CalibrationId calibration_id(calibration);
  if (calibration == 0) {
    ASSIGN_OR_RETURN(const records::CalibrationRecord approved, client->GetApprovedCalibration(id));
    calibration_id = approved.id;
  }
  MachineWithCalibration from;
  ASSIGN_OR_RETURN(from.calibration, client->GetCalibration(calibration_id));
  const records::CalibrationRecord& record = from.calibration;
  if (record.content.machine != id) {
    return absl::InvalidArgumentError(absl::StrCat("--calibration: ", calibration_id.number(), " is of machine ",
                                                   record.content.machine.text(), ", expected one of ", machine));
  }
  ASSIGN_OR_RETURN(const records::MachineRecord described,
                   client->GetMachineRevision(id, record.content.machine_revision));
  ASSIGN_OR_RETURN(from.machine, machine::MachineFromJson(described.description_json));
  return from;
}

absl::StatusOr<MachineWithErrors> FetchModel(Context& context, const std::string& machine, int64_t calibration) {
  ASSIGN_OR_RETURN(MachineWithKnownErrors known, FetchKnown(context, machine, calibration));
  return MachineWithErrors{std::move(known.machine), std::move(known.errors.model)};
}

absl::StatusOr<MachineWithKnownErrors> FetchKnown(Context& context, const std::string& machine, int64_t calibration) {
  ASSIGN_OR_RETURN(const MachineWithCalibration from, FetchCalibration(context, machine, calibration));
  MachineWithKnownErrors known;
  known.machine = from.machine;
  ASSIGN_OR_RETURN(known.errors, machine::ReadKnownErrors(from.calibration.content.model_json, known.machine));
  return known;
}

std::vector<std::string> SplitErrors(const std::vector<std::string>& words) {
  std::vector<std::string> errors;
  for (const std::string& word : words) {
    errors.emplace_back();
    int depth = 0;
    for (const char c : word) {
      depth += c == '{' || c == '[' ? 1 : c == '}' || c == ']' ? -1 : 0;
      if (c == ',' && depth == 0) {
        errors.emplace_back();
      } else {
        errors.back().push_back(c);
      }
    }
  }
  return errors;
}

}  // namespace axiscal::cli
