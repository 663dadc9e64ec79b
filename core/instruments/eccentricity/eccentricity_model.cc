#include "core/instruments/eccentricity/eccentricity_model.h"

namespace axiscal::eccentricity {

void Evaluate(const machine::Machine& machine, const instruments::MeasuringRun& run, int reading,
              const machine::JointErrors<double>& errors, const double* setup, instruments::Evaluation* out) {
  instruments::EvaluateAlongPath(
      machine, run, reading, [&](const shapes::State&) -> const machine::JointErrors<double>& { return errors; }, setup,
      out, [](const shapes::State&, const instruments::Evaluation&, double) {});
}

}  // namespace axiscal::eccentricity
