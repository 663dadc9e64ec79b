// The loop's report for people.
#ifndef AXISCAL_CLIENT_CLI_LOOP_TEXT_H_
#define AXISCAL_CLIENT_CLI_LOOP_TEXT_H_

#include <string>

#include "core/reports/loop.h"

namespace axiscal::cli {

// From files or from a job: the verdict, one line per effect with what else it could be,
// what has no name, how the residual fell step by step, the rms before and after.
std::string LoopText(const reports::Loop& report);

// What was found and has no name, one line each; empty without.
std::string UnexplainedText(const reports::Loop& report);

}  // namespace axiscal::cli

#endif  // AXISCAL_CLIENT_CLI_LOOP_TEXT_H_
