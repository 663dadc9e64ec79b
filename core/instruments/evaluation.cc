#include "core/instruments/evaluation.h"

#include <Eigen/Geometry>
#include <algorithm>

#include "core/instruments/ballbar/ballbar_model.h"
#include "core/instruments/centres/centres_model.h"
#include "core/instruments/direction/direction_model.h"
#include "core/instruments/distortion.h"
#include "core/instruments/eccentricity/eccentricity_model.h"
#include "core/instruments/length/length_model.h"
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
  double setup[kMaxInstrumentParameters];
};

// Without the datum's.
int InstrumentSetupCount(const MeasuringRun& run) {
  return OwnSetupCount(run) - static_cast<int>(run.free_datum.size());
}

void Shift(int joint, const Eigen::Vector3d& by_mm, machine::JointErrors<double>* errors) {
  (*errors)[joint].head<3>() += by_mm;
}

void Shift(int joint, const Eigen::Vector3d& by_mm, machine::JointTransforms* errors) {
  machine::ErrorVector<double> error = errors->ErrorOf(joint);
  error.head<3>() += by_mm;
  errors->Set(joint, error);
}

void Turn(int joint, const Eigen::Vector3d& by_rad, machine::JointErrors<double>* errors) {
  (*errors)[joint].tail<3>() += by_rad;
}

void Turn(int joint, const Eigen::Vector3d& by_rad, machine::JointTransforms* errors) {
  machine::ErrorVector<double> error = errors->ErrorOf(joint);
  error.tail<3>() += by_rad;
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

// What moves while the instrument reads, or has moved on since it did.
template <typename Errors>
void Distort(const machine::Machine& machine, const MeasuringRun& run, int reading, const Distortion& distortion,
             const double* amplitude, Moved<Errors>* out) {
  if (distortion.kind == Distortion::kMotion) {
    double weights[kMotionFunctions];
    MotionWeights(distortion, run.time_s[reading], weights);
    Eigen::Vector3d moved_mm = Eigen::Vector3d::Zero();
    for (int j = 0; j < kMotionFunctions; ++j)
      moved_mm += weights[j] * Eigen::Map<const Eigen::Vector3d>(amplitude + 3 * j);
    if (distortion.carrier == Carrier::kTool) return Shift(machine.tool_joint(), moved_mm, &out->errors);
    for (int k = 0; k < 3; ++k) out->setup[k] += moved_mm[k];
  } else if (distortion.kind == Distortion::kClock) {
    for (int axis = 0; axis < machine.axis_count(); ++axis) {
      double speeds[kClockSpeeds], behind = 0.0;
      ClockSpeeds(distortion, run, reading, axis, speeds);
      for (int j = 0; j < kClockSpeeds; ++j) behind -= amplitude[j] / kClockSpeedMmPerS * speeds[j];
      if (machine.axes[axis].kind == machine::AxisKind::kLinear) {
        Shift(axis, behind * TurnedDirection(machine, axis, out->errors), &out->errors);
      } else {
        Turn(axis, behind * machine.axes[axis].direction, &out->errors);
      }
    }
  }
}

template <typename Errors>
Moved<Errors> AfterMoves(const machine::Machine& machine, const MeasuringRun& run, int reading, const Errors& errors,
                         const double* setup) {
  Moved<Errors> out{errors, {}};
  const int own = InstrumentSetupCount(run);
  std::copy(setup, setup + own, out.setup);
  const double* by_mm = setup + own;
  for (const int axis : run.free_datum) Shift(axis, *by_mm++ * TurnedDirection(machine, axis, errors), &out.errors);
  double amplitudes[kMaxDistortionAmplitudes];
  if (!run.distortions.empty()) TotalAmplitudes(run, setup, amplitudes);
  const double* amplitude = amplitudes;
  for (const Distortion& distortion : run.distortions) {
    Distort(machine, run, reading, distortion, amplitude, &out);
    amplitude += AmplitudeCount(distortion, run.row_count);
  }
  by_mm += amplitude - amplitudes;
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

bool IsMoved(const MeasuringRun& run) {
  return !run.slips.empty() || !run.free_datum.empty() || !run.distortions.empty();
}

// Columns of the datum's constants, and what they add to the derivatives by the turns of their axes' errors: a constant
// of a millimetre is turned along.
void DifferentiateDatum(const machine::Machine& machine, const MeasuringRun& run,
                        const machine::JointErrors<double>& errors, const double* setup, Evaluation* out) {
  int column = InstrumentSetupCount(run);
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
    case Kind::kLength:
      return length::Evaluate(machine, run, reading, errors, setup, out);
    case Kind::kDirection:
      return direction::Evaluate(machine, run, reading, errors, setup, out);
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
      return tracker::Predict<double>(machine, run, reading, positions, errors, setup, predicted_mm);
    case Kind::kTouch:
      return touch::Predict<double>(machine, run, reading, positions, errors, setup, predicted_mm);
    case Kind::kEccentricity:
      return eccentricity::Predict<double>(machine, run, reading, errors, setup, predicted_mm);
    case Kind::kLength:
      return length::Predict<double>(machine, run, positions, errors, setup, predicted_mm);
    case Kind::kDirection:
      return direction::Predict<double>(machine, run, positions, errors, setup, predicted_mm);
  }
}

bool NeedsContact(const MeasuringRun& run) {
  return std::any_of(run.distortions.begin(), run.distortions.end(),
                     [](const Distortion& one) { return NeedsContact(one.kind); });
}

bool IsReadWrong(const MeasuringRun& run) {
  return std::any_of(run.distortions.begin(), run.distortions.end(),
                     [](const Distortion& one) { return ActsOnReading(one.kind); });
}

// Adds what distortions make of a sound reading.
void Misread(const machine::Machine& machine, const MeasuringRun& run, int reading, const double* setup,
             double* reading_mm) {
  SoundRow rows[kMaxRows];
  FillMoment(run, reading, rows);
  if (NeedsContact(run)) FillContact(machine, run, reading, rows);
  double basis[kMaxDistortionAmplitudes], amplitudes[kMaxDistortionAmplitudes], added_mm[kMaxRows] = {};
  TotalAmplitudes(run, setup, amplitudes);
  const int row_count = std::min(run.row_count, kMaxRows);
  for (int i = 0; i < row_count; ++i) {
    for (int j = 0; j < row_count; ++j) rows[i].sound_mm[j] = reading_mm[j];
    const double* amplitude = amplitudes;
    for (const Distortion& one : run.distortions) {
      const int count = AmplitudeCount(one, run.row_count);
      if (ActsOnReading(one.kind)) {
        DistortionBasis(one, rows[i], basis);
        for (int k = 0; k < count; ++k) added_mm[i] += basis[k] * amplitude[k];
      }
      amplitude += count;
    }
  }
  for (int i = 0; i < row_count; ++i) reading_mm[i] += added_mm[i];
}

// The derivatives of a sound reading become those of the distorted one.
void DifferentiateDistortions(const machine::Machine& machine, const MeasuringRun& run, int reading,
                              const machine::JointErrors<double>& errors, const double* setup, Evaluation* out) {
  SoundRow rows[kMaxRows];
  FillSoundRows(machine, run, reading, errors, *out, NeedsContact(run), rows);
  const int rows_count = run.row_count;
  using Factor = Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::ColMajor, kMaxRows, kMaxRows>;
  Factor factor = Factor::Identity(rows_count, rows_count);  // d(reading) / d(sound reading)
  double amplitudes[kMaxDistortionAmplitudes];
  TotalAmplitudes(run, setup, amplitudes);
  const double* amplitude = amplitudes;
  for (const Distortion& one : run.distortions) {
    if (one.kind == Distortion::kGain) {
      for (int i = 0; i < rows_count; ++i) {
        for (int j = 0; j < rows_count; ++j) factor(i, j) += amplitude[i * rows_count + j] / kGainReadingMm;
      }
    } else if (one.kind == Distortion::kScale) {
      factor.diagonal().array() += amplitude[0] * rows[0].warmer_kelvin / kScaleLengthMm;
    }
    amplitude += AmplitudeCount(one, rows_count);
  }
  double basis[kMaxDistortionAmplitudes];
  for (int i = 0; i < rows_count; ++i) {
    Eigen::Index column = OwnSetupCount(run);
    for (const Distortion& one : run.distortions) {
      DistortionBasis(one, rows[i], basis);
      for (int k = 0; k < AmplitudeCount(one, rows_count); ++k) out->by_setup(i, column++) = basis[k];
    }
  }
  if (!IsReadWrong(run)) return;
  out->by_error = factor * out->by_error;
  Eigen::Index column = 0;
  const auto pass_on = [&](Eigen::Index count) {
    out->by_setup.middleCols(column, count) = factor * out->by_setup.middleCols(column, count);
    column += count;
  };
  pass_on(OwnSetupCount(run));
  for (const Distortion& one : run.distortions) {
    const Eigen::Index count = AmplitudeCount(one, rows_count);
    if (ActsOnReading(one.kind)) {
      column += count;
    } else {
      pass_on(count);
    }
  }
  pass_on(out->by_setup.cols() - column);
  Misread(machine, run, reading, setup, out->predicted_mm.data());
}

template <typename Errors>
void PredictAny(const machine::Machine& machine, const MeasuringRun& run, int reading, const Errors& errors,
                const double* setup, double* predicted_mm) {
  if (!IsMoved(run)) {
    PredictInstrument(machine, run, reading, errors, setup, predicted_mm);
  } else {
    const auto moved = AfterMoves(machine, run, reading, errors, setup);
    PredictInstrument(machine, run, reading, moved.errors, moved.setup, predicted_mm);
    if (IsReadWrong(run)) Misread(machine, run, reading, setup, predicted_mm);
  }
  for (int row = 0; run.stated_mm.size() > 0 && row < run.row_count; ++row)
    predicted_mm[row] += run.stated_mm(row, reading);
}

// Without what the header states.
void EvaluateUnstated(const machine::Machine& machine, const MeasuringRun& run, int reading,
                      const machine::JointErrors<double>& errors, const double* setup, Evaluation* out) {
  if (!IsMoved(run)) return EvaluateInstrument(machine, run, reading, errors, setup, out);
  const auto moved = AfterMoves(machine, run, reading, errors, setup);
  EvaluateInstrument(machine, run, reading, moved.errors, moved.setup, out);
  out->by_setup.conservativeResize(Eigen::NoChange, static_cast<Eigen::Index>(run.setup.size()));
  DifferentiateDatum(machine, run, errors, setup, out);
  Eigen::Index column = OwnSetupCount(run) + DistortionAmplitudes(run);
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
  if (!run.distortions.empty()) DifferentiateDistortions(machine, run, reading, moved.errors, setup, out);
}

}  // namespace

void Evaluate(const machine::Machine& machine, const MeasuringRun& run, int reading,
              const machine::JointErrors<double>& errors, const double* setup, Evaluation* out) {
  EvaluateUnstated(machine, run, reading, errors, setup, out);
  if (run.stated_mm.size() > 0) out->predicted_mm += run.stated_mm.col(reading);
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
