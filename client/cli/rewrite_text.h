// The screen at the end of `axiscal compensate`.
#ifndef AXISCAL_CLIENT_CLI_REWRITE_TEXT_H_
#define AXISCAL_CLIENT_CLI_REWRITE_TEXT_H_

#include <string>

#include "core/reports/rewrite.h"

namespace axiscal::cli {

// `output`: the file that was written; `dialect`: how the program was read, in words.
std::string RewriteReportText(const reports::Rewrite& report, const std::string& output, const std::string& dialect);

}  // namespace axiscal::cli

#endif  // AXISCAL_CLIENT_CLI_REWRITE_TEXT_H_
