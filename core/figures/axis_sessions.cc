#include "core/figures/axis_sessions.h"

#include <algorithm>
#include <cmath>
#include <set>

#include "absl/strings/str_cat.h"
#include "absl/strings/str_format.h"
#include "core/figures/axis_seen.h"
#include "core/figures/line.h"
#include "core/figures/noise.h"

namespace axiscal::figures {
namespace {

using instruments::Kind;
using instruments::MeasuringRun;

Positioning PositioningOf(const AxisSeen& seen, const std::vector<double>& along_mm) {
  std::vector<Approach> approaches;
  for (size_t i = 0; i < along_mm.size(); ++i) approaches.push_back({seen.positions[i], along_mm[i], seen.senses[i]});
  return PositioningOf(std::move(approaches));
}

void Add(const std::optional<double>& value, const std::string& symbol, const std::string& text,
         std::vector<Figure>* figures) {
  if (value) figures->push_back({symbol, text, *value});
}

void AddPositioning(const Positioning& of, std::vector<Figure>* figures) {
  Add(of.accuracy_mm, "A", "accuracy, bidirectional", figures);
  Add(of.up.accuracy_mm, "A(up)", "accuracy, approached upwards", figures);
  Add(of.down.accuracy_mm, "A(down)", "accuracy, approached downwards", figures);
  Add(of.repeatability_mm, "R", "repeatability, bidirectional", figures);
  Add(of.up.repeatability_mm, "R(up)", "repeatability, approached upwards", figures);
  Add(of.down.repeatability_mm, "R(down)", "repeatability, approached downwards", figures);
  Add(of.systematic_mm, "E", "systematic error, bidirectional", figures);
  Add(of.up.systematic_mm, "E(up)", "systematic error, approached upwards", figures);
  Add(of.down.systematic_mm, "E(down)", "systematic error, approached downwards", figures);
  Add(of.mean_mm, "M", "mean bidirectional error, range", figures);
  Add(of.reversal_mm, "B", "reversal, largest of a target", figures);
  Add(of.mean_reversal_mm, "B mean", "reversal, mean", figures);
}

// Of all stops and, where the axis came from both sides, of those of each side.
void AddRanges(const AxisSeen& seen, const Across& across, std::vector<Figure>* figures) {
  const auto add = [&](double sense, const std::string& suffix, const std::string& words) {
    std::vector<double> positions, values_mm;
    for (size_t i = 0; i < seen.positions.size(); ++i) {
      if (sense != 0.0 && seen.senses[i] != sense) continue;
      positions.push_back(seen.positions[i]);
      values_mm.push_back(across.values_mm[i]);
    }
    const std::set<double> different(positions.begin(), positions.end());
    constexpr size_t kFewest = 3;  // two have no deviation from their line
    if (different.size() < kFewest) return;
    const auto [low, high] = std::minmax_element(values_mm.begin(), values_mm.end());
    figures->push_back({across.symbol + suffix, across.text + words,
                        across.is_about_line ? StraightnessOf(positions, values_mm) : *high - *low});
  };
  add(0.0, "", "");
  if (std::all_of(seen.senses.begin(), seen.senses.end(), [&](double one) { return one == seen.senses[0]; })) return;
  add(1.0, "(up)", ", approached upwards");
  add(-1.0, "(down)", ", approached downwards");
}

std::vector<Figure> FiguresOf(const AxisSeen& seen, const Eigen::MatrixXd& readings_mm) {
  const Deviations deviations = seen.deviations_of(readings_mm);
  std::vector<Figure> figures;
  if (!deviations.along_mm.empty()) AddPositioning(PositioningOf(seen, deviations.along_mm), &figures);
  for (const Across& across : deviations.across) AddRanges(seen, across, &figures);
  return figures;
}

// Where the axis turns round, more readings than elsewhere, and nothing states from which side it came: it may have
// gone on beyond the target and come back.
bool TurnsUnseen(const MeasuringRun& run, int axis, const std::vector<Stop>& stops) {
  for (int k = 0; k < run.reading_count() && !run.stated_senses.empty(); ++k)
    if (run.stated_senses[static_cast<size_t>(k) * run.axis_count + axis] != 0.0) return false;
  if (stops.size() < 3) return false;
  std::vector<size_t> counts;
  for (const Stop& stop : stops) counts.push_back(stop.readings.size());
  std::nth_element(counts.begin(), counts.begin() + static_cast<std::ptrdiff_t>(counts.size() / 2), counts.end());
  const size_t usual = counts[counts.size() / 2];
  for (size_t i = 1; i + 1 < stops.size(); ++i) {
    const double before = stops[i].position - stops[i - 1].position;
    const double after = stops[i + 1].position - stops[i].position;
    if (before * after < 0.0 && stops[i].readings.size() >= 2 * usual) return true;
  }
  return false;
}

void AddNotes(const machine::Axis& axis, bool turns_unseen, MeasuredTest* test) {
  if (!test->positioning) return;
  constexpr int kAsked = 5;  // approaches of a target in each direction: *assumed* as ISO 230-2 asks for
  const int fewest = test->positioning->fewest_approaches;
  if (fewest < kAsked)
    test->notes.push_back(
        absl::StrFormat("targets were approached %d time%s, fewer than the %d that are usually asked for", fewest,
                        fewest == 1 ? "" : "s", kAsked));
  if (const int once = test->positioning->approached_once; once > 0)
    test->notes.push_back(
        absl::StrFormat("left out: %d target%s that %s approached once from one side while others were repeated", once,
                        once == 1 ? "" : "s", once == 1 ? "was" : "were"));
  if (turns_unseen)
    test->notes.push_back(absl::StrFormat(
        "where %s turns round it stood for twice as many readings as elsewhere, and all of them count as approached by "
        "its last move: if it went on beyond the target and came back, say so in a column %s_sense (docs/formats.md)",
        axis.name, axis.name));
  if (!test->positioning->reversal_mm)
    test->notes.push_back("no target was approached from both sides: no reversal, no bidirectional figures");
}

}  // namespace

std::vector<Stop> StopsOf(const MeasuringRun& run, int axis) {
  constexpr double kStill = 1e-6;  // mm or rad: the rounding of a log
  std::vector<Stop> stops;
  for (int k = 0; k < run.reading_count(); ++k) {
    const double position = run.PositionsOf(k)[axis];
    const double sense = run.AxisStatesOf(k)[axis].sense;
    if (stops.empty() || std::abs(stops.back().position - position) > kStill || stops.back().sense != sense)
      stops.push_back({position, sense, {}});
    stops.back().readings.push_back(k);
  }
  return stops;
}

absl::StatusOr<MeasuredTest> AxisTest(const machine::Machine& machine, const MeasuringRun& run, int axis) {
  const std::vector<Stop> stops = StopsOf(run, axis);
  ASSIGN_OR_RETURN(const AxisSeen seen, SeenOf(machine, run, axis, stops));
  const bool is_linear = machine.axes[axis].kind == machine::AxisKind::kLinear;
  MeasuredTest test;
  test.kind = is_linear ? "line" : "turn";
  if (run.kind == Kind::kDirection) test.unit = "urad";
  const auto [low, high] = std::minmax_element(seen.positions.begin(), seen.positions.end());
  test.what =
      absl::StrFormat("axis %s from %g to %g %s", machine.axes[axis].name, *low, *high, is_linear ? "mm" : "deg");
  test.sessions = {run.session};
  test.temperature_celsius = MeanTemperature({&run});
  const Deviations measured = seen.deviations_of(seen.measured_mm);
  if (!measured.along_mm.empty()) test.positioning = PositioningOf(seen, measured.along_mm);
  test.figures = WithNoise([&](const std::function<double()>& noise, bool is_alone) {
    Eigen::MatrixXd readings_mm = is_alone ? seen.perfect_mm : seen.measured_mm;
    if (seen.scale_sigma > 0.0)
      readings_mm.array() += seen.scale_sigma * noise() * (seen.perfect_mm.array() - seen.perfect_mm.mean());
    for (const Eigen::MatrixXd& stated_mm : seen.stated_mm) readings_mm += noise() * stated_mm;
    for (Eigen::Index i = 0; i < readings_mm.cols(); ++i)
      for (Eigen::Index row = 0; row < readings_mm.rows(); ++row)
        readings_mm(row, i) += seen.sigma_mm[static_cast<size_t>(i)] * noise();
    return FiguresOf(seen, readings_mm);
  });
  NoteStated({&run}, &test.notes);
  AddNotes(machine.axes[axis], TurnsUnseen(run, axis, stops), &test);
  return test;
}

}  // namespace axiscal::figures
