#include "core/instruments/repeated.h"

#include <algorithm>

namespace axiscal::instruments {
namespace {

// With the same tool, and along the same path where readings are taken along one.
bool IsTheSame(const MeasuringRun& one, const MeasuringRun& other) {
  if (one.kind != other.kind || one.tip_mm != other.tip_mm || one.time_s != other.time_s ||
      one.positions != other.positions || one.measured_mm != other.measured_mm)
    return false;
  if (one.path_readings == nullptr || other.path_readings == nullptr) return one.path_readings == other.path_readings;
  const auto &paths = one.path_readings->traces, &others = other.path_readings->traces;
  return std::equal(
      paths.begin(), paths.end(), others.begin(), others.end(),
      [](const MeasuringRun& a, const MeasuringRun& b) { return a.tip_mm == b.tip_mm && a.positions == b.positions; });
}

}  // namespace

absl::Status CheckRepeated(const std::vector<MeasuringRun>& fit, const std::vector<MeasuringRun>& check) {
  const auto run = [&](size_t i) -> const MeasuringRun& { return i < fit.size() ? fit[i] : check[i - fit.size()]; };
  const auto name = [&](size_t i) {
    return absl::StrCat(check.empty() ? "" : i < fit.size() ? "fit " : "check ", "session '", run(i).session, "'");
  };
  for (size_t i = 0; i < fit.size() + check.size(); ++i) {
    for (size_t k = 0; k < i; ++k) {
      if (!IsTheSame(run(i), run(k))) continue;
      if (check.empty() && run(i).session == run(k).session) continue;
      return absl::InvalidArgumentError(
          absl::StrCat(name(i), " holds the same readings as ", name(k),
                       i < fit.size() ? ": they would count twice" : ": what was fitted or checked proves nothing"));
    }
  }
  return absl::OkStatus();
}

}  // namespace axiscal::instruments
