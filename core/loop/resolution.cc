#include "core/loop/resolution.h"

#include <algorithm>
#include <numbers>

#include "core/identify/outliers.h"
#include "core/loop/dictionary.h"

namespace axiscal::loop {
namespace {

// A grid visits the positions of a rotary axis in any order: what counts is how far apart they are.
double GapOf(const instruments::MeasuringRun& run, int axis) {
  std::vector<double> positions, gaps;
  for (int k = 0; k < run.reading_count(); ++k) positions.push_back(run.PositionsOf(k)[axis]);
  std::sort(positions.begin(), positions.end());
  for (size_t k = 1; k < positions.size(); ++k) {
    if (positions[k] - positions[k - 1] > kStandsStillRad) gaps.push_back(positions[k] - positions[k - 1]);
  }
  return gaps.empty() ? 0.0 : identify::Median(&gaps);
}

}  // namespace

Resolution::Resolution(const Signatures& signatures) : seen_(signatures.SensitivitySquares()) {
  const identify::Problem& problem = signatures.problem();
  const int axes = problem.machine->axis_count();
  step_.resize(static_cast<Eigen::Index>(problem.runs.size()), axes);
  for (size_t i = 0; i < problem.runs.size(); ++i) {
    for (int axis = 0; axis < axes; ++axis) {
      double step = StepOf(*problem.machine, problem.runs[i], axis);
      if (problem.machine->axes[axis].kind == machine::AxisKind::kRotary && step > 0.0)
        step = std::min(step, GapOf(problem.runs[i], axis));
      step_(static_cast<Eigen::Index>(i), axis) = step;
    }
  }
}

bool Resolution::Resolves(const machine::ErrorTerm& term) const {
  const auto* harmonic = std::get_if<shapes::Harmonic>(&term.shape);
  if (harmonic == nullptr) return true;
  double seen = 0.0, resolved = 0.0;
  for (Eigen::Index run = 0; run < seen_.rows(); ++run) {
    const double step = step_(run, harmonic->axis);
    if (step == 0.0) continue;
    const double squares = seen_(run, machine::kComponents * term.joint + static_cast<int>(term.component));
    seen += squares;
    if (harmonic->frequency * step < kBelowNyquist * std::numbers::pi) resolved += squares;
  }
  constexpr double kEnough = 0.2;
  return resolved > kEnough * seen;
}

}  // namespace axiscal::loop
