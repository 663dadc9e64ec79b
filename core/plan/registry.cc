#include <cmath>

#include "absl/strings/numbers.h"
#include "core/base/units.h"
#include "core/plan/passes.h"
#include "core/plan/tests_internal.h"

namespace axiscal::plan {

const std::vector<Test>& Tests() {
  static const std::vector<Test>& tests = *new std::vector<Test>{
      {"ballbar-pattern", "a bar held at its length while B or C turns there and back (twelve patterns)",
       BallbarPatterns},
      {"ballbar-turn", "a bar along one direction while one rotary axis turns there and back", BallbarTurns},
      {"ballbar-swung-turn", "the same with another rotary axis swung out of its zero", BallbarSwungTurns},
      {"ballbar-circle", "a circle of two linear axes, counter-clockwise, then clockwise", BallbarCircles},
      {"rtest-grid", "an R-test over a grid of the rotary axes, there and back", RtestGrids},
      {"rtest-approach", "an R-test at a few poses, each approached by one axis at a time from both senses",
       RtestApproaches},
      {"other-sense", "a measured session run backwards", OtherSense},
      {"later", "a measured session repeated two hours later", Later},
      {"warmer", "a measured session or an R-test grid when the shop is four degrees warmer", Warmer},
      {"farther", "an R-test or a held bar over 30 degrees more of a rotary axis than so far, to either side",
       FartherTurned},
      {"finer", "a measured session repeated with three readings in place of one", Finer},
  };
  return tests;
}

const std::vector<Test>& FurtherTests() {
  static const std::vector<Test>& tests = *new std::vector<Test>{
      {"ballbar-linked", "X and C, or Y and C, move together at constant path speed so that the bar keeps its length",
       BallbarLinked},
      {"sphere-probing", "a sphere on the table probed at positions of one rotary axis, with two styli", SphereProbing},
      {"touch-sphere", "the same sphere touched nine times at each position, every touch a reading", TouchSpheres},
      {"touch-plate", "a flat plate touched at nine places at positions of one rotary axis", TouchPlates},
      {"touch-columns", "tops and sides of three square columns touched over a grid of the rotary axes", TouchColumns},
      {"touch-blocks", "outer faces and tops of four small blocks in pairs, at positions of each rotary axis",
       TouchBlockPairs},
      {"length-line", "an interferometer along each linear axis, five times there and back", LengthLines},
      {"straightness-line", "straightness across each linear axis, in two directions", StraightnessLines},
      {"direction-line", "turns of the tool along each linear axis: autocollimator, telescope, level", DirectionLines},
      {"direction-turn", "positioning of each rotary axis by an indexing table or a polygon", DirectionTurns},
      {"tracker-grid", "places of a target on the tool over the work space, in a tracker's frame", TrackerGrids},
      {"tracker-references",
       "the same, with three reference targets beside the machine measured in between: they show how the tracker moves",
       TrackerReferences},
      {"distance-grid", "distances of the tool from three anchors over the work space: draw wire, tracker",
       DistanceGrids},
  };
  return tests;
}

const Test* FindTest(const std::string& name) {
  for (const auto* tests : {&Tests(), &FurtherTests()}) {
    for (const Test& test : *tests) {
      if (test.name == name) return &test;
    }
  }
  return nullptr;
}

std::vector<std::string> TestNames() {
  std::vector<std::string> names;
  for (const auto* tests : {&Tests(), &FurtherTests()}) {
    for (const Test& test : *tests) names.push_back(test.name);
  }
  return names;
}

Reach ReachOf(const Situation& situation, const session::Session& session) {
  Reach reach;
  const machine::Machine& machine = *situation.machine;
  for (int axis = 0; axis < machine.axis_count(); ++axis) {
    const machine::Axis& a = machine.axes[axis];
    const bool is_rotary = a.kind == machine::AxisKind::kRotary;
    const session::Column* column = session::FindColumn(session, a.name + (is_rotary ? "_deg" : "_mm"));
    if (column == nullptr || column->values.empty()) continue;
    const auto [low, high] = std::minmax_element(column->values.begin(), column->values.end());
    const double unit = is_rotary ? base::kRadPerDeg : 1.0;
    constexpr double kRounding = 1e-3;
    if (a.min_position && *low * unit < *a.min_position - kRounding) reach.is_reachable = false;
    if (a.max_position && *high * unit > *a.max_position + kRounding) reach.is_reachable = false;
    if (situation.runs.empty()) continue;
    constexpr double kWorthSaying = 1.0;  // mm or degrees
    const Range range = {situation.ranges[axis].lowest / unit, situation.ranges[axis].highest / unit};
    const auto say = [&](const char* side, double to, double so_far) {
      const char* name = is_rotary ? "deg" : "mm";
      absl::StrAppend(&reach.text, reach.text.empty() ? "" : ", ",
                      absl::StrFormat("%s %s %.0f %s (so far %.0f %s)", a.name, side, to, name, so_far, name));
    };
    constexpr double kNudge = 2.5;  // what an approach leaves a rotary pose by goes without saying
    const double allowed = is_rotary ? kNudge : kWorthSaying;
    if (*low < range.lowest - allowed) say("down to", *low, range.lowest);
    if (*high > range.highest + allowed) say("up to", *high, range.highest);
    if (!is_rotary) reach.beyond_mm = std::max({reach.beyond_mm, range.lowest - *low, *high - range.highest});
  }
  return reach;
}

std::optional<PlannedSession> FindPlanned(const Situation& situation, const std::string& name) {
  for (const auto* tests : {&Tests(), &FurtherTests()}) {
    for (const Test& test : *tests) {
      for (PlannedSession& planned : test.plan(situation)) {
        if (test.name != name && session::FindHeader(planned.session, "session").value_or("") != name) continue;
        if (ReachOf(situation, planned.session).is_reachable) return std::move(planned);
      }
    }
  }
  // "CR-350-x4": four passes of CR-350.
  const size_t times = name.rfind("-x");
  int passes = 0;
  constexpr int kMostPasses = 100;
  if (times == std::string::npos || !absl::SimpleAtoi(name.substr(times + 2), &passes) || passes < 2 ||
      passes > kMostPasses)
    return std::nullopt;
  const std::optional<PlannedSession> once = FindPlanned(situation, name.substr(0, times));
  if (!once) return std::nullopt;
  return InPasses(*once, passes);
}

}  // namespace axiscal::plan
