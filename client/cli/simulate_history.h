// axiscal simulate --history: calibrations of many machines over years, with what truly happened to them, as one file.
#ifndef AXISCAL_CLIENT_CLI_SIMULATE_HISTORY_H_
#define AXISCAL_CLIENT_CLI_SIMULATE_HISTORY_H_

#include <string>

#include "client/cli/context.h"
#include "core/synthetic/machine_years.h"

namespace axiscal::cli {

struct HistoryArguments {
  std::string output;
  int machines = 10;
  synthetic::YearsToDraw years;
};

// Writes the file whole or not at all. INVALID_ARGUMENT names option, value and rule.
absl::Status SimulateHistory(Context& context, const HistoryArguments& arguments);

}  // namespace axiscal::cli

#endif  // AXISCAL_CLIENT_CLI_SIMULATE_HISTORY_H_
