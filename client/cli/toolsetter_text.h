// The tool setter's reports as people read them.
#ifndef AXISCAL_CLIENT_CLI_TOOLSETTER_TEXT_H_
#define AXISCAL_CLIENT_CLI_TOOLSETTER_TEXT_H_

#include <string>

#include "core/reports/tool_setter.h"

namespace axiscal::cli {

std::string ToText(const reports::BeamReference& report);
std::string ToText(const reports::Wear& report);

}  // namespace axiscal::cli

#endif  // AXISCAL_CLIENT_CLI_TOOLSETTER_TEXT_H_
