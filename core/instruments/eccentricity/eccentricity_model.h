// Eccentricities of ball-bar runs, as a ball bar's own software reports them: the centre of the run's polar trace,
//   dL(q) = r0 + e . p(q)     least squares over the run. The radius r0 is free: if it were fixed, 1 um in it would put
//                             0.78 um into both components of a quarter turn (Yao 2022, ch. 2);
// p(q): PolarDirections of eccentricity_path.h. The reading is thus a sum of the ball bar's own readings along the path
// with weights that depend on the path alone: prediction and derivatives are those of the ball bar, summed. Setup: that
// of the ball bar; the bar's length moves no centre.
#ifndef AXISCAL_CORE_INSTRUMENTS_ECCENTRICITY_ECCENTRICITY_MODEL_H_
#define AXISCAL_CORE_INSTRUMENTS_ECCENTRICITY_ECCENTRICITY_MODEL_H_

#include "core/instruments/ballbar/ballbar_model.h"

namespace axiscal::eccentricity {

// With the same errors all along the path.
template <typename T, typename Errors = machine::JointErrors<T>>
void Predict(const machine::Machine& machine, const instruments::MeasuringRun& run, int reading,
             const Errors& errors, const T* setup, T* predicted_mm) {
  const Reading& of = run.path_readings->readings[reading];
  const instruments::MeasuringRun& trace = run.path_readings->traces[of.trace];
  predicted_mm[0] = T(0.0);
  for (int n = 0; n < trace.reading_count(); ++n) {
    const std::vector<T> positions(trace.PositionsOf(n), trace.PositionsOf(n) + trace.axis_count);
    T length_mm;
    ballbar::Predict<T>(machine, trace, positions.data(), errors, setup, &length_mm);
    predicted_mm[0] += of.weight[n] * length_mm;
  }
}

void Evaluate(const machine::Machine& machine, const instruments::MeasuringRun& run, int reading,
              const machine::JointErrors<double>& errors, const double* setup, instruments::Evaluation* out);

}  // namespace axiscal::eccentricity

#endif  // AXISCAL_CORE_INSTRUMENTS_ECCENTRICITY_ECCENTRICITY_MODEL_H_
