// An error's limits as they are typed.
#ifndef AXISCAL_CLIENT_CLI_DRIFT_LIMIT_H_
#define AXISCAL_CLIENT_CLI_DRIFT_LIMIT_H_

#include <string>

#include "client/client.h"

namespace axiscal::cli {

// "EX0C=-20..20". INVALID_ARGUMENT naming `option`.
absl::StatusOr<records::DriftLimit> ReadDriftLimit(const std::string& option, const std::string& text);

}  // namespace axiscal::cli

#endif  // AXISCAL_CLIENT_CLI_DRIFT_LIMIT_H_
