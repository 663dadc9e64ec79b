#include "client/cli/simulate_history.h"

#include "client/cli/output.h"
#include "core/base/files.h"

namespace axiscal::cli {
namespace {

constexpr double kMostCalibrations = 5e6;  // about 1 GB of file: 1,000 machines daily for ten years are 3.3e6

absl::Status CheckHistory(const HistoryArguments& arguments) {
  RETURN_IF_ERROR(synthetic::Check(arguments.years));
  if (arguments.machines < 1)
    return absl::InvalidArgumentError(absl::StrCat("machines = ", arguments.machines, ", must be > 0"));
  const double calibrations = arguments.machines * arguments.years.years * 365.2425 / arguments.years.interval_days;
  if (calibrations > kMostCalibrations)
    return absl::InvalidArgumentError(absl::StrCat("machines, years and interval_days make ", calibrations,
                                                   " calibrations, must be at most ", kMostCalibrations));
  return absl::OkStatus();
}

}  // namespace

absl::Status SimulateHistory(Context& context, const HistoryArguments& arguments) {
  RETURN_IF_ERROR(CheckHistory(arguments));
  base::AtomicFile file;
  RETURN_IF_ERROR(file.Open(arguments.output));
  RETURN_IF_ERROR(file.Write(synthetic::HistoryHeader(arguments.years, arguments.machines)));
  int64_t calibrations = 0, steps = 0, outliers = 0;
  for (int number = 0; number < arguments.machines; ++number) {
    const synthetic::MachineYears machine = synthetic::DrawMachineYears(arguments.years, number);
    calibrations += static_cast<int64_t>(machine.calibrations.size());
    steps += static_cast<int64_t>(machine.steps.size());
    outliers += static_cast<int64_t>(machine.outliers.size());
    RETURN_IF_ERROR(file.Write(synthetic::HistoryLines(machine)));
  }
  RETURN_IF_ERROR(file.Commit());
  context.Print({{"file", arguments.output},
                 {"seed", arguments.years.seed},
                 {"machines", arguments.machines},
                 {"calibrations", calibrations},
                 {"steps", steps},
                 {"outliers", outliers}},
                absl::StrCat(arguments.output, ": seed ", arguments.years.seed, ", ", arguments.machines, " machines, ",
                             calibrations, " calibrations, ", steps, " steps, ", outliers, " outliers\n"));
  return absl::OkStatus();
}

}  // namespace axiscal::cli
