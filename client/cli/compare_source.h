// What `axiscal compare` compares, as the command line names it: a stored calibration by its number, a file
// (errors.json or a calibration's JSON), or session files and folders, which are fitted here.
#ifndef AXISCAL_CLIENT_CLI_COMPARE_SOURCE_H_
#define AXISCAL_CLIENT_CLI_COMPARE_SOURCE_H_

#include <Eigen/Core>
#include <optional>
#include <string>
#include <vector>

#include "client/cli/context.h"
#include "core/compare/compare.h"
#include "core/machine/machine.h"

namespace axiscal::cli {

struct Compared {
  compare::Side side;
  // Of the readings that it was fitted to, where they are at hand: what the axes covered, and the tool point.
  std::optional<predict::Box> measured;
  std::optional<Eigen::Vector3d> tip_mm;
  std::vector<std::string> notes;
};

// The description that a stored calibration was fitted with.
absl::StatusOr<machine::Machine> MachineOfCalibration(Context& context, int64_t calibration);

// `declared`: errors to fit to sessions in place of those that the machine declares. NOT_FOUND or INVALID_ARGUMENT with
// `name` in front, also for a calibration of a machine with other axes.
absl::StatusOr<Compared> ReadCompared(Context& context, const std::string& name, const machine::Machine& machine,
                                      const std::vector<std::string>& declared);

}  // namespace axiscal::cli

#endif  // AXISCAL_CLIENT_CLI_COMPARE_SOURCE_H_
