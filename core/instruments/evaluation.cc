#include "core/instruments/evaluation.h"

#include "core/instruments/ballbar/ballbar_model.h"
#include "core/instruments/centres/centres_model.h"
#include "core/instruments/eccentricity/eccentricity_model.h"
#include "core/instruments/rtest/rtest_model.h"
#include "core/instruments/touch/touch_model.h"
#include "core/instruments/tracker/tracker_model.h"

namespace axiscal::instruments {

void Evaluate(const machine::Machine& machine, const MeasuringRun& run, int reading,
              const machine::JointErrors<double>& errors, const double* setup, Evaluation* out) {
  switch (run.kind) {
    case Kind::kBallbar:
      return ballbar::Evaluate(machine, run, reading, errors, setup, out);
    case Kind::kRtest:
      return rtest::Evaluate(machine, run, reading, errors, setup, out);
    case Kind::kCentres:
      return centres::Evaluate(machine, run, reading, errors, setup, out);
    case Kind::kTracker:
      return tracker::Evaluate(machine, run, reading, errors, setup, out);
    case Kind::kTouch:
      return touch::Evaluate(machine, run, reading, errors, setup, out);
    case Kind::kEccentricity:
      return eccentricity::Evaluate(machine, run, reading, errors, setup, out);
  }
}

void Predict(const machine::Machine& machine, const MeasuringRun& run, int reading,
             const machine::JointErrors<double>& errors, const double* setup, double* predicted_mm) {
  const double* positions = run.PositionsOf(reading);
  switch (run.kind) {
    case Kind::kBallbar:
      return ballbar::Predict<double>(machine, run, positions, errors, setup, predicted_mm);
    case Kind::kRtest:
      return rtest::Predict<double>(machine, run, positions, errors, setup, predicted_mm);
    case Kind::kCentres:
      return centres::Predict<double>(machine, run, positions, errors, setup, predicted_mm);
    case Kind::kTracker:
      return tracker::Predict<double>(machine, run, positions, errors, setup, predicted_mm);
    case Kind::kTouch:
      return touch::Predict<double>(machine, run, reading, positions, errors, setup, predicted_mm);
    case Kind::kEccentricity:
      return eccentricity::Predict<double>(machine, run, reading, errors, setup, predicted_mm);
  }
}

}  // namespace axiscal::instruments
