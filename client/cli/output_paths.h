// Which files a command may write.
#ifndef AXISCAL_CLIENT_CLI_OUTPUT_PATHS_H_
#define AXISCAL_CLIENT_CLI_OUTPUT_PATHS_H_

#include <string>
#include <utility>
#include <vector>

#include "core/base/status.h"

namespace axiscal::cli {

// An option and its path. Empty paths (the option was not given) and files that are not there are no obstacle.
using NamedPath = std::pair<std::string, std::string>;

// INVALID_ARGUMENT when an output is one of the inputs, under whatever name, or two outputs are one file: what the user
// brought would be lost.
absl::Status CheckOutputs(const std::vector<NamedPath>& inputs, const std::vector<NamedPath>& outputs);

}  // namespace axiscal::cli

#endif  // AXISCAL_CLIENT_CLI_OUTPUT_PATHS_H_
