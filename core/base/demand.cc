#include "core/base/demand.h"

#include <cstdio>
#include <cstdlib>

namespace axiscal::base {

void DemandFailed(const char* condition, const char* file, int line) {
  std::fprintf(stderr, "%s:%d: demand failed: %s\n", file, line, condition);
  std::abort();
}

}  // namespace axiscal::base
