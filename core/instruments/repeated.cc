#include "core/instruments/repeated.h"

namespace axiscal::instruments {

absl::Status CheckRepeated(const std::vector<MeasuringRun>& fit, const std::vector<MeasuringRun>& check) {
  const auto run = [&](size_t i) -> const MeasuringRun& { return i < fit.size() ? fit[i] : check[i - fit.size()]; };
  const auto name = [&](size_t i) {
    return absl::StrCat(check.empty() ? "" : i < fit.size() ? "fit " : "check ", "session '", run(i).session, "'");
  };
  for (size_t i = 0; i < fit.size() + check.size(); ++i) {
    for (size_t k = 0; k < i; ++k) {
      if (run(i).kind != run(k).kind || run(i).time_s != run(k).time_s || run(i).positions != run(k).positions ||
          run(i).measured_mm != run(k).measured_mm)
        continue;
      return absl::InvalidArgumentError(
          absl::StrCat(name(i), " holds the same readings as ", name(k),
                       i < fit.size() ? ": they would count twice" : ": what was fitted or checked proves nothing"));
    }
  }
  return absl::OkStatus();
}

}  // namespace axiscal::instruments
