// axiscal toolsetter curve.
#ifndef AXISCAL_CLIENT_CLI_TOOLSETTER_CURVE_H_
#define AXISCAL_CLIENT_CLI_TOOLSETTER_CURVE_H_

namespace CLI {
class App;
}

namespace axiscal::cli {

struct Context;

void AddToolSetterCurve(CLI::App& toolsetter, Context& context);

}  // namespace axiscal::cli

#endif  // AXISCAL_CLIENT_CLI_TOOLSETTER_CURVE_H_
