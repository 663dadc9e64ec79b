// axiscal toolsetter plan.
#ifndef AXISCAL_CLIENT_CLI_TOOLSETTER_PLAN_H_
#define AXISCAL_CLIENT_CLI_TOOLSETTER_PLAN_H_

namespace CLI {
class App;
}

namespace axiscal::cli {

struct Context;

void AddToolSetterPlan(CLI::App& toolsetter, Context& context);

}  // namespace axiscal::cli

#endif  // AXISCAL_CLIENT_CLI_TOOLSETTER_PLAN_H_
