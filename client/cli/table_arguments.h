// The options of `table` as they are typed, in um, mm and deg, and what the engine takes.
#ifndef AXISCAL_CLIENT_CLI_TABLE_ARGUMENTS_H_
#define AXISCAL_CLIENT_CLI_TABLE_ARGUMENTS_H_

#include <optional>
#include <string>
#include <vector>

#include "core/compensate/tables/request.h"
#include "core/machine/machine.h"

namespace CLI {
class App;
}

namespace axiscal::cli {

struct TableArguments {
  std::string format;
  std::string tool_tip = "0 0 0";
  std::vector<std::string> axes;    // "X", "Y(X)"
  std::vector<std::string> ranges;  // "X=-300:300"
  std::string reference;            // "X=0 Z=100"
  double tolerance_um = 0.1;
  std::optional<int> max_points;
  std::optional<double> resolution, time_s, temperature_celsius;
};

void AddTableOptions(CLI::App& command, TableArguments& arguments);

// INVALID_ARGUMENT naming the option, its value and what was expected.
absl::StatusOr<tables::TableRequest> ToTableRequest(const TableArguments& arguments, const machine::Machine& machine);

}  // namespace axiscal::cli

#endif  // AXISCAL_CLIENT_CLI_TABLE_ARGUMENTS_H_
