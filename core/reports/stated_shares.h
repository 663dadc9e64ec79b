// What stated facts (an expansion, a certified value, a thermometer) have in the sigmas of a fit, for people.
#ifndef AXISCAL_CORE_REPORTS_STATED_SHARES_H_
#define AXISCAL_CORE_REPORTS_STATED_SHARES_H_

#include <string>
#include <vector>

#include "core/reports/fitted.h"

namespace axiscal::reports {

struct StatedShares {
  struct Share {
    std::string error, unit;
    double by = 0.0;  // size of the error's move where the fact is off by one standard uncertainty, in `unit`
  };
  std::string of;  // the fact in words, as StatedFact::of
  std::vector<Share> shares;
};

// Facts in their order with the errors of which they make a tenth of the sigma or more; no fact without one.
std::vector<StatedShares> StatedSharesOf(const Fitted& fitted);

}  // namespace axiscal::reports

#endif  // AXISCAL_CORE_REPORTS_STATED_SHARES_H_
