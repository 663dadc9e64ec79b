// The loop's report for people.
#ifndef AXISCAL_CLIENT_CLI_LOOP_TEXT_H_
#define AXISCAL_CLIENT_CLI_LOOP_TEXT_H_

#include <string>

#include "client/cli/output.h"

namespace axiscal::cli {

// Of a report of loop::ToJson, from files or from a job: the verdict, one line per effect with what else it could be,
// what has no name, how the residual fell step by step, the rms before and after.
std::string LoopText(const Json& report);

// What was found and has no name, one line each; empty without, and for other reports.
std::string UnexplainedText(const Json& report);

}  // namespace axiscal::cli

#endif  // AXISCAL_CLIENT_CLI_LOOP_TEXT_H_
