#include "core/instruments/evaluation.h"

#include <Eigen/Geometry>
#include <algorithm>

#include "core/instruments/ballbar/ballbar_model.h"
#include "core/instruments/centres/centres_model.h"
#include "core/instruments/eccentricity/eccentricity_model.h"
#include "core/instruments/rtest/rtest_model.h"
#include "core/instruments/touch/touch_model.h"
#include "core/instruments/tracker/tracker_model.h"

namespace axiscal::instruments {
namespace {

// What a reading of a session in which something slipped or whose work offset was set anew is read with: the artefact
// is where the first three setup offsets put it, a probe that slipped is an error of the tool joint, and an axis that
// stands elsewhere than commanded has that error along itself.
template <typename Errors>
struct Moved {
  Errors errors;
  double setup[kMaxSetupParameters];
};

int OwnSetupCount(const MeasuringRun& run) {
  return static_cast<int>(run.setup.size() - run.free_datum.size() - 3 * run.slips.size());
}

void Shift(int joint, const Eigen::Vector3d& by_mm, machine::JointErrors<double>* errors) {
  (*errors)[joint].head<3>() += by_mm;
}

void Shift(int joint, const Eigen::Vector3d& by_mm, machine::JointTransforms* errors) {
  machine::ErrorVector<double> error = errors->ErrorOf(joint);
  error.head<3>() += by_mm;
  errors->Set(joint, error);
}

const machine::ErrorVector<double>& ErrorOf(const machine::JointErrors<double>& errors, int joint) {
  return errors[joint];
}
const machine::ErrorVector<double>& ErrorOf(const machine::JointTransforms& errors, int joint) {
  return errors.ErrorOf(joint);
}

// The motion of a linear axis stands behind its error: E(e, turn) J(q + d) = E(e + turn * direction d, turn) J(q).
template <typename Errors>
Eigen::Vector3d TurnedDirection(const machine::Machine& machine, int axis, const Errors& errors) {
  const machine::ErrorVector<double>& error = ErrorOf(errors, axis);
  return geometry::RotationXyz(error[3], error[4], error[5]) * machine.axes[axis].direction;
}

template <typename Errors>
Moved<Errors> AfterMoves(const machine::Machine& machine, const MeasuringRun& run, int reading, const Errors& errors,
                         const double* setup) {
  Moved<Errors> out{errors, {}};
  const int own = OwnSetupCount(run);
  std::copy(setup, setup + own, out.setup);
  const double* by_mm = setup + own;
  for (const int axis : run.free_datum) Shift(axis, *by_mm++ * TurnedDirection(machine, axis, errors), &out.errors);
  for (const Slip& slip : run.slips) {
    if (reading < slip.first_reading) {
      by_mm += 3;
      continue;
    }
    if (slip.carrier == Carrier::kTable) {
      for (int k = 0; k < 3; ++k) out.setup[k] += by_mm[k];
    } else {
      Shift(machine.tool_joint(), Eigen::Vector3d(by_mm[0], by_mm[1], by_mm[2]), &out.errors);
    }
    by_mm += 3;
  }
  return out;
}

bool IsMoved(const MeasuringRun& run) { return !run.slips.empty() || !run.free_datum.empty(); }

// Columns of the datum's constants, and what they add to the derivatives by the turns of their axes' errors: a constant
// of a millimetre is turned along.
void DifferentiateDatum(const machine::Machine& machine, const MeasuringRun& run,
                        const machine::JointErrors<double>& errors, const double* setup, Evaluation* out) {
  int column = OwnSetupCount(run);
  for (const int axis : run.free_datum) {
    const Eigen::Vector3d along = TurnedDirection(machine, axis, errors);
    const Eigen::Index first = machine::kComponents * Eigen::Index{axis};
    const Eigen::Matrix<double, Eigen::Dynamic, 3, Eigen::ColMajor, kMaxRows, 3> by_shift =
        out->by_error.middleCols<3>(first);
    out->by_setup.col(column) = by_shift * along;
    const double a = errors[axis][3], b = errors[axis][4];
    const Eigen::Matrix3d turned = geometry::RotationXyz(a, 0.0, 0.0), twice = geometry::RotationXyz(a, b, 0.0);
    const Eigen::Vector3d turns[3] = {Eigen::Vector3d::UnitX(), turned.col(1), twice.col(2)};
    for (int k = 0; k < 3; ++k) out->by_error.col(first + 3 + k) += by_shift * (setup[column] * turns[k].cross(along));
    ++column;
  }
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
  if (!IsMoved(run)) return PredictInstrument(machine, run, reading, errors, setup, predicted_mm);
  const auto moved = AfterMoves(machine, run, reading, errors, setup);
  PredictInstrument(machine, run, reading, moved.errors, moved.setup, predicted_mm);
}

}  // namespace

void Evaluate(const machine::Machine& machine, const MeasuringRun& run, int reading,
              const machine::JointErrors<double>& errors, const double* setup, Evaluation* out) {
  if (!IsMoved(run)) return EvaluateInstrument(machine, run, reading, errors, setup, out);
  const auto moved = AfterMoves(machine, run, reading, errors, setup);
  EvaluateInstrument(machine, run, reading, moved.errors, moved.setup, out);
  out->by_setup.conservativeResize(Eigen::NoChange, static_cast<Eigen::Index>(run.setup.size()));
  DifferentiateDatum(machine, run, errors, setup, out);
  Eigen::Index column = OwnSetupCount(run) + static_cast<Eigen::Index>(run.free_datum.size());
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
