#include "server/grpc_log.h"

#include <grpc/support/log.h>

#include <atomic>
#include <cstdlib>

#include "absl/strings/str_cat.h"
#include "server/handlers/call_rates.h"
#include "server/log.h"

namespace axiscal::server {
namespace {

void Take(gpr_log_func_args* said) {
  constexpr int kLinesPerSecond = 1;
  static auto& lines = *new handlers::CallRates(kLinesPerSecond);
  static std::atomic<int64_t> left_out = 0;
  if (!lines.Take("log").ok()) {
    ++left_out;
    return;
  }
  LogFields fields = {{"text", said->message}};
  if (const int64_t count = left_out.exchange(0); count > 0) fields.push_back({"left_out", absl::StrCat(count)});
  Log(LogLevel::kWarning, "grpc", fields);
}

}  // namespace

void TakeGrpcLog() {
  if (std::getenv("GRPC_VERBOSITY") == nullptr) gpr_set_log_function(&Take);
}

}  // namespace axiscal::server
