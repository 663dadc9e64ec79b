#include "client/silence_grpc.h"

#include <grpc/support/log.h>

#include <cstdlib>

namespace axiscal::client {

void SilenceGrpc() {
  if (std::getenv("GRPC_VERBOSITY") == nullptr) gpr_set_log_function([](gpr_log_func_args*) {});
}

}  // namespace axiscal::client
