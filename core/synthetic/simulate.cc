#include "core/synthetic/simulate.h"

#include <cmath>
#include <random>

#include "core/instruments/evaluation.h"
#include "core/instruments/registry.h"
#include "core/instruments/run.h"

namespace axiscal::synthetic {
namespace {

// Standard normal draws that do not depend on the library's implementation of distributions (Box-Muller on a Mersenne
// twister).
class Gauss {
 public:
  explicit Gauss(uint64_t seed) : random_(seed) {}
  double Uniform() { return (static_cast<double>(random_() >> 11) + 0.5) * 0x1p-53; }
  double operator()() { return std::sqrt(-2.0 * std::log(Uniform())) * std::cos(2.0 * M_PI * Uniform()); }

 private:
  std::mt19937_64 random_;
};

}  // namespace

absl::StatusOr<session::Session> Simulate(const machine::Machine& machine, const machine::ErrorModel& truth,
                                          const session::Session& planned, const NoiseOptions& noise) {
  session::Session session = planned;
  const instruments::Instrument* instrument =
      instruments::FindInstrument(session::FindHeader(session, "instrument").value_or(""));
  if (instrument == nullptr)
    return absl::InvalidArgumentError("header key 'instrument' names no instrument that can be simulated");
  const size_t readings = session.reading_count();
  std::erase_if(session.columns, [&](const session::Column& column) {
    return std::find(instrument->reading_columns.begin(), instrument->reading_columns.end(), column.name) !=
           instrument->reading_columns.end();
  });
  for (const std::string& name : instrument->reading_columns)
    session.columns.push_back({name, std::vector<double>(readings, 0.0), {}});
  ASSIGN_OR_RETURN(const instruments::MeasuringRun run, instruments::BindSession(session, machine));

  Gauss gauss(noise.seed);
  std::vector<double> setup(instruments::kMaxSetupParameters, 0.0);
  for (size_t i = 0; i < run.setup.size(); ++i) {
    const double sigma = run.setup[i].prior_sigma;
    if (noise.draw_setup && std::isfinite(sigma)) setup[i] = sigma * gauss();
  }
  const double sigma_mm = noise.sigma_scale * run.sigma_mm;
  std::vector<double> ripple(run.row_count, 0.0);
  for (size_t k = 0; k < readings; ++k) {
    const machine::JointErrors<double> errors = machine::ErrorsAt(machine, truth, run.StateOf(static_cast<int>(k)));
    double predicted_mm[instruments::kMaxRows];
    instruments::Predict(machine, run, static_cast<int>(k), errors, setup.data(), predicted_mm);
    for (int row = 0; row < run.row_count; ++row) {
      const double fresh = gauss();
      ripple[row] = k == 0 ? fresh : noise.ar1 * ripple[row] + std::sqrt(1.0 - noise.ar1 * noise.ar1) * fresh;
      double reading_mm = predicted_mm[row] + sigma_mm * ripple[row];
      if (noise.bad_share > 0.0 && gauss.Uniform() < noise.bad_share) {
        reading_mm += (gauss.Uniform() < 0.5 ? -1.0 : 1.0) * (20.0 + 80.0 * gauss.Uniform()) * sigma_mm;
      }
      if (noise.resolution_mm > 0.0) reading_mm = std::round(reading_mm / noise.resolution_mm) * noise.resolution_mm;
      session.columns[session.columns.size() - run.row_count + row].values[k] = reading_mm;
    }
  }
  return session;
}

}  // namespace axiscal::synthetic
