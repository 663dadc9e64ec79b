// How a log is to be read, from what a command line names: --template, --plan, --session, --start-s.
#ifndef AXISCAL_CLIENT_CLI_LOG_FORM_H_
#define AXISCAL_CLIENT_CLI_LOG_FORM_H_

#include <optional>
#include <string>

#include "core/base/ids.h"
#include "core/base/status.h"
#include "core/records/log.h"

namespace CLI {
class App;
}

namespace axiscal::cli {

struct LogFormArguments {
  std::string log_template, plan, session;
  std::optional<double> start_s;
};

void AddLogFormOptions(CLI::App* command, LogFormArguments& arguments);

// With the texts of the files. NOT_FOUND, INVALID_ARGUMENT.
absl::StatusOr<records::LogForm> ReadLogForm(const LogFormArguments& arguments);

// The machine that plan or template names; INVALID_ARGUMENT where neither does.
absl::StatusOr<MachineId> MachineOf(const records::LogForm& form);

}  // namespace axiscal::cli

#endif  // AXISCAL_CLIENT_CLI_LOG_FORM_H_
