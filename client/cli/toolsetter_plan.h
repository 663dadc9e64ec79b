// What to measure in a laser tool setter: `axiscal toolsetter plan`, and `axiscal plan` for its two tests.
#ifndef AXISCAL_CLIENT_CLI_TOOLSETTER_PLAN_H_
#define AXISCAL_CLIENT_CLI_TOOLSETTER_PLAN_H_

#include <string>

#include "core/plan/program.h"
#include "core/toolsetter/plan.h"

namespace CLI {
class App;
}

namespace axiscal::cli {

struct Context;

struct ToolSetterPlan {
  std::string file;     // a cutter.json, or a tool-setter session whose rods are meant
  std::string machine;  // the id in the header of a cutter's session
  std::string output, turn, session = "planned";
  int starts = 12, holders = 12, readouts = 3;
  double sigma_um = 1.0;
  plan::ProgramOptions program;  // where the output is a program: of `axiscal plan` alone
};

// All of the struct but file, machine and output.
void AddToolSetterOptions(CLI::App& command, ToolSetterPlan& plan);

// Writes the session to be filled in and prints what it will tell. INVALID_ARGUMENT naming the option, or file and
// place.
absl::Status PlanToolSetter(Context& context, const ToolSetterPlan& plan);
// The same as a test of this machine. Also FAILED_PRECONDITION where the machine cannot feed a tool along itself, and
// INVALID_ARGUMENT where the file is another test's or another machine's.
absl::Status PlanToolSetterTest(Context& context, const machine::Machine& machine,
                                const toolsetter::PlannableTest& test, const ToolSetterPlan& plan);

void AddToolSetterPlan(CLI::App& toolsetter, Context& context);

}  // namespace axiscal::cli

#endif  // AXISCAL_CLIENT_CLI_TOOLSETTER_PLAN_H_
