#include "core/instruments/evaluation.h"

#include <algorithm>

#include "core/instruments/ballbar/ballbar_model.h"
#include "core/instruments/centres/centres_model.h"
#include "core/instruments/eccentricity/eccentricity_model.h"
#include "core/instruments/rtest/rtest_model.h"
#include "core/instruments/touch/touch_model.h"
#include "core/instruments/tracker/tracker_model.h"

namespace axiscal::instruments {
namespace {

// What a reading of a session in which something slipped is read with: the artefact is where the first three setup
// offsets put it, and a probe that slipped is an error of the tool joint.
template <typename Errors>
struct Slipped {
  Errors errors;
  double setup[kMaxSetupParameters];
};

int OwnSetupCount(const MeasuringRun& run) {
  return static_cast<int>(run.setup.size()) - 3 * static_cast<int>(run.slips.size());
}

void Shift(int joint, const double* by_mm, machine::JointErrors<double>* errors) {
  for (int k = 0; k < 3; ++k) (*errors)[joint][k] += by_mm[k];
}

void Shift(int joint, const double* by_mm, machine::JointTransforms* errors) {
  machine::ErrorVector<double> error = errors->ErrorOf(joint);
  for (int k = 0; k < 3; ++k) error[k] += by_mm[k];
  errors->Set(joint, error);
}

template <typename Errors>
Slipped<Errors> AfterSlips(const machine::Machine& machine, const MeasuringRun& run, int reading, const Errors& errors,
                           const double* setup) {
  Slipped<Errors> out{errors, {}};
  const int own = OwnSetupCount(run);
  std::copy(setup, setup + own, out.setup);
  const double* by_mm = setup + own;
  for (const Slip& slip : run.slips) {
    if (reading < slip.first_reading) {
      by_mm += 3;
      continue;
    }
    if (slip.carrier == Carrier::kTable) {
      for (int k = 0; k < 3; ++k) out.setup[k] += by_mm[k];
    } else {
      Shift(machine.tool_joint(), by_mm, &out.errors);
    }
    by_mm += 3;
  }
  return out;
}

void EvaluateInstrument(const machine::Machine& machine, const MeasuringRun& run, int reading,
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

template <typename Errors>
void PredictInstrument(const machine::Machine& machine, const MeasuringRun& run, int reading, const Errors& errors,
                       const double* setup, double* predicted_mm) {
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

template <typename Errors>
void PredictAny(const machine::Machine& machine, const MeasuringRun& run, int reading, const Errors& errors,
                const double* setup, double* predicted_mm) {
  if (run.slips.empty()) return PredictInstrument(machine, run, reading, errors, setup, predicted_mm);
  const auto slipped = AfterSlips(machine, run, reading, errors, setup);
  PredictInstrument(machine, run, reading, slipped.errors, slipped.setup, predicted_mm);
}

}  // namespace

void Evaluate(const machine::Machine& machine, const MeasuringRun& run, int reading,
              const machine::JointErrors<double>& errors, const double* setup, Evaluation* out) {
  if (run.slips.empty()) return EvaluateInstrument(machine, run, reading, errors, setup, out);
  const auto slipped = AfterSlips(machine, run, reading, errors, setup);
  EvaluateInstrument(machine, run, reading, slipped.errors, slipped.setup, out);
  int column = OwnSetupCount(run);
  out->by_setup.conservativeResize(Eigen::NoChange, static_cast<Eigen::Index>(run.setup.size()));
  for (const Slip& slip : run.slips) {
    if (reading < slip.first_reading) {
      out->by_setup.middleCols<3>(column).setZero();
    } else if (slip.carrier == Carrier::kTable) {
      out->by_setup.middleCols<3>(column) = out->by_setup.leftCols<3>();
    } else {
      out->by_setup.middleCols<3>(column) =
          out->by_error.middleCols<3>(machine::kComponents * Eigen::Index{machine.tool_joint()});
    }
    column += 3;
  }
}

void Predict(const machine::Machine& machine, const MeasuringRun& run, int reading,
             const machine::JointErrors<double>& errors, const double* setup, double* predicted_mm) {
  PredictAny(machine, run, reading, errors, setup, predicted_mm);
}

void Predict(const machine::Machine& machine, const MeasuringRun& run, int reading,
             const machine::JointTransforms& errors, const double* setup, double* predicted_mm) {
  PredictAny(machine, run, reading, errors, setup, predicted_mm);
}

}  // namespace axiscal::instruments
