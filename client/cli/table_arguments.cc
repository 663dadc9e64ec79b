#include "client/cli/table_arguments.h"

#include <CLI/CLI.hpp>
#include <sstream>

#include "core/base/units.h"
#include "core/session/text.h"

namespace axiscal::cli {
namespace {

// "X=-300:300" with `separator` ':', "X=12.5" without numbers to separate. mm of a linear axis, deg of a rotary one.
absl::StatusOr<std::pair<int, std::vector<double>>> ParseAxisNumbers(const std::string& option, const std::string& word,
                                                                     const machine::Machine& machine, size_t count) {
  const size_t equals = word.find('=');
  const int axis = equals == std::string::npos ? -1 : machine::FindAxis(machine, word.substr(0, equals));
  std::string text = equals == std::string::npos ? "" : word.substr(equals + 1);
  const size_t colon = text.find(':');
  const bool has_colon = colon != std::string::npos;
  if (has_colon) text[colon] = ' ';
  std::vector<double> numbers;
  if (axis < 0 || !session::ParseNumbers(text, &numbers) || numbers.size() != count || has_colon != (count == 2)) {
    return absl::InvalidArgumentError(absl::StrCat(
        option, ": '", word, "', expected an axis of machine ", machine.id,
        count == 2 ? " and its travel in mm or deg: X=-300:300" : " and its position in mm or deg: X=12.5"));
  }
  if (machine.axes[axis].kind == machine::AxisKind::kRotary) {
    for (double& number : numbers) number *= base::kRadPerDeg;
  }
  return std::make_pair(axis, numbers);
}

}  // namespace

void AddTableOptions(CLI::App& command, TableArguments& arguments) {
  command.add_option("--format", arguments.format, "the controller's format, see --list");
  command.add_option("--axis", arguments.axes,
                     "correct this axis only: X, or Y(X) for Y over the position of X; of the general table the axes "
                     "that are arguments of "
                     "one block; may be repeated");
  command.add_option("--range", arguments.ranges,
                     "travel of an axis in mm or deg, X=-300:300; may be repeated (default: travel of machine.json, in "
                     "the service else what the calibration's sessions cover)");
  command.add_option("--reference", arguments.reference,
                     "where corrections are zero and other axes stand, \"X=0 Z=100\" (default: zero)");
  command
      .add_option("--tool-tip", arguments.tool_tip,
                  "nominal tool point with all axes at zero, machine coordinates: \"X Y Z\" in mm")
      ->capture_default_str();
  command.add_option("--tolerance-um", arguments.tolerance_um, "what interpolation may leave, um (and urad)")
      ->capture_default_str();
  command.add_option("--points", arguments.max_points, "at most so many points, fewer than the controller takes");
  command.add_option("--resolution", arguments.resolution,
                     "the controller's least step, mm or deg, where it is a setting");
  command.add_option("--time-s", arguments.time_s, "s of the sessions' clock; needed for errors that drift");
  command.add_option("--temperature-c", arguments.temperature_celsius,
                     "at which temperature; needed for thermal errors");
}

absl::StatusOr<tables::TableRequest> ToTableRequest(const TableArguments& arguments, const machine::Machine& machine) {
  tables::TableRequest request;
  request.format = arguments.format;
  request.axes = arguments.axes;
  request.tolerance_mm = arguments.tolerance_um * base::kMmPerUm;
  request.max_points = arguments.max_points;
  request.resolution = arguments.resolution;
  request.state.time_s = arguments.time_s;
  request.state.temperature_celsius = arguments.temperature_celsius;
  std::vector<double> tip;
  if (!session::ParseNumbers(arguments.tool_tip, &tip) || tip.size() != 3) {
    return absl::InvalidArgumentError(
        absl::StrCat("--tool-tip: '", arguments.tool_tip, "', expected three numbers in mm: \"0 0 -350\""));
  }
  request.state.tool_tip_mm = Eigen::Vector3d(tip[0], tip[1], tip[2]);
  for (const std::string& word : arguments.ranges) {
    ASSIGN_OR_RETURN(const auto range, ParseAxisNumbers("--range", word, machine, 2));
    request.ranges.push_back({machine.axes[range.first].name, range.second[0], range.second[1]});
  }
  std::istringstream words(arguments.reference);
  for (std::string word; words >> word;) {
    ASSIGN_OR_RETURN(const auto position, ParseAxisNumbers("--reference", word, machine, 1));
    request.reference.push_back({machine.axes[position.first].name, position.second[0]});
  }
  return request;
}

}  // namespace axiscal::cli
