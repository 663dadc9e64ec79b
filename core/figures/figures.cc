#include "core/figures/figures.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <set>

#include "absl/strings/str_cat.h"
#include "absl/strings/str_join.h"
#include "core/figures/axis_sessions.h"
#include "core/figures/circle_sessions.h"
#include "core/figures/eccentricities.h"
#include "core/figures/rotary_sessions.h"

namespace axiscal::figures {
namespace {

using instruments::Kind;
using instruments::MeasuringRun;

std::vector<int> MovingAxes(const MeasuringRun& run) {
  constexpr double kStill = 1e-6;  // mm or rad: the rounding of a log
  std::vector<int> axes;
  for (int i = 0; i < run.axis_count; ++i) {
    double low = INFINITY, high = -INFINITY;
    for (int k = 0; k < run.reading_count(); ++k) {
      low = std::min(low, run.PositionsOf(k)[i]);
      high = std::max(high, run.PositionsOf(k)[i]);
    }
    if (high - low > kStill) axes.push_back(i);
  }
  return axes;
}

// As it would read at 20 deg C by what its header states; how uncertain that is stays in `stated`.
MeasuringRun AtReference(MeasuringRun run) {
  for (const instruments::StatedEffect& effect : run.stated) run.measured_mm -= effect.mm;
  run.stated_mm.resize(0, 0);
  return run;
}

}  // namespace

void NoteStated(const std::vector<const MeasuringRun*>& runs, std::vector<std::string>* notes) {
  std::set<std::string> stated;
  for (const MeasuringRun* run : runs)
    for (const instruments::StatedEffect& effect : run->stated) stated.insert(effect.of);
  if (!stated.empty()) notes->push_back("at 20 deg C, by what the sessions state: " + absl::StrJoin(stated, "; "));
}

std::optional<double> MeanTemperature(const std::vector<const MeasuringRun*>& runs) {
  double sum = 0.0, count = 0.0;
  for (const MeasuringRun* run : runs) {
    if (!run->has_temperature) continue;
    for (const double one : run->temperature_celsius) sum += one;
    count += static_cast<double>(run->temperature_celsius.size());
  }
  return count > 0.0 ? std::optional<double>(sum / count) : std::nullopt;
}

Figures FiguresOf(const machine::Machine& machine, const std::vector<MeasuringRun>& measured) {
  Figures out;
  std::vector<MeasuringRun> runs;
  for (const MeasuringRun& run : measured) runs.push_back(AtReference(run));
  std::map<std::string, Circle> circles;
  const auto leave_out = [&](const MeasuringRun& run, const std::string& why) {
    out.left_out.push_back(absl::StrCat("session ", run.session, ": ", why));
  };
  for (const MeasuringRun& run : runs) {
    const std::vector<int> moving = run.path_readings == nullptr ? MovingAxes(run) : std::vector<int>();
    std::vector<int> turning;
    for (const int axis : moving)
      if (machine.axes[axis].kind == machine::AxisKind::kRotary) turning.push_back(axis);
    if (run.kind == Kind::kBallbar && !moving.empty() && (turning.size() > 0 || moving.size() == 2)) {
      const auto why = turning.empty() ? AddCircle(machine, run, &circles) : AddCone(machine, run, &circles);
      // A bar that is held while one axis turns draws a polar trace, whether it goes round in the table's eyes or not.
      const auto found = turning.size() == 1 ? EccentricitiesOf(machine, run)
                                             : absl::StatusOr<RunEccentricities>(absl::InvalidArgumentError(""));
      if (found.ok()) out.tests.push_back(EccentricityTest(machine, run, *found));
      if (why && !found.ok()) leave_out(run, *why);
    } else if (run.kind == Kind::kRtest && turning.size() == 1) {
      auto test = RotaryTest(machine, run, turning[0]);
      if (test.ok()) {
        out.tests.push_back(*std::move(test));
      } else {
        leave_out(run, std::string(test.status().message()));
      }
    } else if (run.kind != Kind::kBallbar && moving.size() == 1) {
      auto test = AxisTest(machine, run, moving[0]);
      if (test.ok()) {
        out.tests.push_back(*std::move(test));
      } else {
        leave_out(run, std::string(test.status().message()));
      }
    } else {
      leave_out(run,
                "figures are known of ball-bar circles and cones, of an R-test with one rotary axis, and of one axis "
                "that moves alone");
    }
  }
  for (const auto& [key, circle] : circles) out.tests.push_back(CircleTest(circle));
  return out;
}

}  // namespace axiscal::figures
