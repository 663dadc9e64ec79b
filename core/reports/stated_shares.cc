#include "core/reports/stated_shares.h"

#include <algorithm>
#include <cmath>
#include <utility>

namespace axiscal::reports {

std::vector<StatedShares> StatedSharesOf(const Fitted& fitted) {
  constexpr double kWorthSaying = 0.1;
  std::vector<StatedShares> out;
  for (const StatedFact& fact : fitted.stated) {
    StatedShares one{fact.of, {}};
    for (const auto& [name, by] : fact.moves) {
      const auto error = std::find_if(fitted.errors.begin(), fitted.errors.end(),
                                      [&name = name](const Error& other) { return other.name == name; });
      if (error == fitted.errors.end() || !(std::abs(by) >= kWorthSaying * error->sigma)) continue;
      one.shares.push_back({name, error->unit, std::abs(by)});
    }
    if (!one.shares.empty()) out.push_back(std::move(one));
  }
  return out;
}

}  // namespace axiscal::reports
