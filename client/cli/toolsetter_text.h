// The tool setter's reports as people read them.
#ifndef AXISCAL_CLIENT_CLI_TOOLSETTER_TEXT_H_
#define AXISCAL_CLIENT_CLI_TOOLSETTER_TEXT_H_

#include <string>

#include "client/cli/output.h"

namespace axiscal::cli {

// Of the JSON that core/toolsetter/evaluate.h gives.
std::string ReferenceText(const Json& report);
std::string WearText(const Json& report);

}  // namespace axiscal::cli

#endif  // AXISCAL_CLIENT_CLI_TOOLSETTER_TEXT_H_
