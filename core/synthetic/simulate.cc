#include "core/synthetic/simulate.h"

#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <map>

#include "core/base/crc32c.h"
#include "core/base/units.h"
#include "core/instruments/centres/centres_model.h"
#include "core/instruments/eccentricity/eccentricity_bind.h"
#include "core/instruments/evaluation.h"
#include "core/instruments/length/length_model.h"
#include "core/instruments/registry.h"
#include "core/instruments/run.h"

namespace axiscal::synthetic {
namespace {

void WritePositions(const machine::Machine& machine, const instruments::MeasuringRun& run, session::Session* session) {
  for (int axis = 0; axis < run.axis_count; ++axis) {
    if (machine.axes[axis].kind == machine::AxisKind::kRotary) continue;
    for (session::Column& column : session->columns) {
      if (column.name != machine.axes[axis].name + "_mm") continue;
      for (int k = 0; k < run.reading_count(); ++k) column.values[k] = run.PositionsOf(k)[axis];
    }
  }
}

// A touch has no reading of its own: the positions at which the probe triggers are measured. Moves the linear
// axes along the approach until the gap is `gap_mm`, with the errors of where they are then: an artefact that stands
// 5 mm off is touched 5 mm further on. INVALID_ARGUMENT when the stylus passes the feature by.
absl::Status MoveToContact(const machine::Machine& machine, const Measuring& measuring, const double* setup,
                           int reading, double gap_mm, instruments::MeasuringRun* run) {
  const size_t first = static_cast<size_t>(reading) * run->axis_count;
  double* positions = run->positions.data() + first;
  const Eigen::Matrix3Xd directions = centres::LinearDirections(machine, positions);
  const Eigen::Matrix3d reach = directions * directions.transpose();
  const Eigen::VectorXd along = directions.transpose() * (reach.inverse() * run->touches.approach[reading]);
  const std::vector<int> linear = centres::LinearAxes(machine);
  const auto gap_after = [&](double step_mm) {
    for (size_t i = 0; i < linear.size(); ++i) {
      positions[linear[i]] += step_mm * along[i];
      run->axis_states.Own()[first + linear[i]].position = positions[linear[i]];
    }
    double predicted_mm = NAN;
    instruments::Predict(machine, *run, reading, measuring.errors_at(reading, run->StateOf(reading)), setup,
                         &predicted_mm);
    return predicted_mm - gap_mm;
  };
  double gap = gap_after(0.0);
  constexpr int kMaxSteps = 50;
  for (int step = 0; step < kMaxSteps; ++step) {
    if (std::abs(gap) < 1e-9) return absl::OkStatus();
    constexpr double kProbeMm = 1e-4;
    const double probed = gap_after(kProbeMm), slope = (probed - gap) / kProbeMm;
    if (!(slope < -0.1)) break;
    gap = gap_after(-probed / slope);
  }
  return absl::InvalidArgumentError(absl::StrCat("session '", run->session, "': reading ", reading + 1,
                                                 ": the approach passes its feature by on this machine"));
}

void WriteEccentricity(const eccentricity::Reading& reading, double reading_mm, session::Session* session) {
  const char* const names[] = {"ex_um", "ey_um", "ez_um"};
  for (session::Column& column : session->columns) {
    if (column.name == names[reading.component]) column.values[reading.row] = reading_mm * base::kUmPerMm;
  }
}

// Off by 20 to 100, to either side.
double BadOffset(base::Random* random) {
  const double side = random->Uniform() < 0.5 ? -1.0 : 1.0;
  return side * (20.0 + 80.0 * random->Uniform());
}

// Variance 1, in the options' colours.
class Noise {
 public:
  Noise(const NoiseOptions& options, int rows)
      : options_(options), ripple_(rows, base::RippleNoise(options.ar1, options.white_share)) {}

  double Next(int row, const double* positions, int axis_count, base::Random* random) {
    double value = ripple_[row].Next(*random);
    if (options_.student_degrees > 2) value *= StudentFactor(random);
    if (options_.heavy_share > 0.0 && random->Uniform() < options_.heavy_share) value *= 5.0;
    if (options_.pose_share > 0.0) {
      std::vector<double> pose(positions, positions + axis_count);
      pose.push_back(row);
      const auto [common, is_new] = of_pose_.try_emplace(std::move(pose), 0.0);
      if (is_new) common->second = random->Normal();
      value = std::sqrt(1.0 - options_.pose_share) * value + std::sqrt(options_.pose_share) * common->second;
    }
    return value;
  }

 private:
  // A normal value becomes one of Student's t, scaled to variance 1.
  double StudentFactor(base::Random* random) const {
    double chi_square = 0.0;
    for (int i = 0; i < options_.student_degrees; ++i) {
      const double normal = random->Normal();
      chi_square += normal * normal;
    }
    return std::sqrt((options_.student_degrees - 2.0) / chi_square);
  }

  const NoiseOptions& options_;
  std::vector<base::RippleNoise> ripple_;
  std::map<std::vector<double>, double> of_pose_;
};

// What one seed for all sessions draws of the thing that is called so.
double DrawOf(uint64_t seed, const std::string& thing) {
  return base::Random(base::StreamSeed(seed, base::Crc32c(0, thing.data(), thing.size()))).Normal();
}

std::vector<double> DrawSetup(const instruments::MeasuringRun& run, const NoiseOptions& noise, base::Random* random) {
  std::vector<double> setup(instruments::kMaxSetupParameters, 0.0);
  for (size_t i = 0; i < run.setup.size(); ++i) {
    const double sigma = run.setup[i].prior_sigma;
    if (std::isfinite(sigma)) setup[i] = sigma * random->Normal();
    if (noise.stated_seed && !run.scale_of.empty() && run.setup[i].name == length::kScaleName)
      setup[i] = sigma * DrawOf(*noise.stated_seed, "scale of instrument " + run.scale_of);
    if (run.setup[i].held) setup[i] = *run.setup[i].held;
  }
  return setup;
}

// What stated facts that are off add to the readings, row_count x readings; empty where they are as stated.
Eigen::MatrixXd DrawStated(const instruments::MeasuringRun& run, const NoiseOptions& noise) {
  Eigen::MatrixXd off_mm;
  if (!noise.stated_seed) return off_mm;
  for (const instruments::StatedEffect& effect : run.stated) {
    if (effect.is_workpiece) continue;
    if (off_mm.size() == 0) off_mm.setZero(effect.mm.rows(), effect.mm.cols());
    off_mm += DrawOf(*noise.stated_seed, effect.of) * effect.by_sigma_mm;
  }
  return off_mm;
}

}  // namespace

absl::StatusOr<session::Session> WithReadingColumns(const machine::Machine& machine, const session::Session& planned) {
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
  if (instrument->kind == instruments::Kind::kEccentricity)
    RETURN_IF_ERROR(eccentricity::AddReadingColumns(machine, &session));
  return session;
}

absl::StatusOr<session::Session> Measure(const machine::Machine& machine, const Measuring& measuring,
                                         const session::Session& planned) {
  const NoiseOptions& noise = measuring.noise;
  ASSIGN_OR_RETURN(session::Session session, WithReadingColumns(machine, planned));
  ASSIGN_OR_RETURN(instruments::MeasuringRun run, instruments::BindSession(session, machine));
  run.length.zero_mm = 0.0;  // of readings that are not there yet; sessions of one set-up count from one place
  instruments::MeasuringRun read = run;
  if (!measuring.read_positions.empty()) read.positions = measuring.read_positions;

  base::Random random(noise.seed), of_setup(noise.setup_seed.value_or(0));
  std::vector<double> setup(instruments::kMaxSetupParameters, 0.0);
  if (noise.draw_setup) setup = DrawSetup(run, noise, noise.setup_seed ? &of_setup : &random);
  const Eigen::MatrixXd stated_mm = DrawStated(run, noise);
  const double sigma_mm = noise.sigma_scale * run.sigma_mm;
  Noise noises(noise, run.row_count);
  for (int k = 0; k < run.reading_count(); ++k) {
    machine::JointErrors<double> errors;
    double predicted_mm[instruments::kMaxRows];
    instruments::PredictWith(
        machine, read, k,
        [&](const shapes::State& state) -> const machine::JointErrors<double>& {
          return errors = measuring.errors_at(k, state);
        },
        setup.data(), predicted_mm);
    if (measuring.distort) measuring.distort(k, predicted_mm);
    for (int row = 0; stated_mm.size() > 0 && row < run.row_count; ++row) predicted_mm[row] += stated_mm(row, k);
    for (int row = 0; row < run.row_count; ++row) {
      double reading_mm = predicted_mm[row] + sigma_mm * noises.Next(row, run.PositionsOf(k), run.axis_count, &random);
      if (noise.bad_share > 0.0 && random.Uniform() < noise.bad_share) reading_mm += BadOffset(&random) * sigma_mm;
      if (noise.resolution_mm > 0.0) reading_mm = std::round(reading_mm / noise.resolution_mm) * noise.resolution_mm;
      if (run.kind == instruments::Kind::kTouch) {
        // The gap by what is stated, where the real one is noise alone.
        const double off_mm = stated_mm.size() > 0 ? stated_mm(row, k) : 0.0;
        RETURN_IF_ERROR(
            MoveToContact(machine, measuring, setup.data(), k, reading_mm - predicted_mm[row] - off_mm, &run));
        continue;
      }
      if (run.kind == instruments::Kind::kEccentricity) {
        WriteEccentricity(run.path_readings->readings[k], reading_mm, &session);
        continue;
      }
      session.columns[session.columns.size() - run.row_count + row].values[k] = reading_mm;
    }
  }
  if (run.kind == instruments::Kind::kTouch) WritePositions(machine, run, &session);
  return session;
}

absl::StatusOr<session::Session> Simulate(const machine::Machine& machine, const machine::ErrorModel& truth,
                                          const session::Session& planned, const NoiseOptions& noise) {
  Measuring measuring;
  measuring.errors_at = [&](int, const shapes::State& state) { return machine::ErrorsAt(machine, truth, state); };
  measuring.noise = noise;
  return Measure(machine, measuring, planned);
}

std::vector<BadReading> SpoilReadings(const instruments::MeasuringRun& run, double share, double sigma_scale,
                                      base::Random* random, session::Session* session) {
  std::vector<BadReading> bad;
  for (int k = 0; k < run.reading_count(); ++k) {
    for (int row = 0; row < run.row_count; ++row) {
      if (random->Uniform() >= share) continue;
      session->columns[session->columns.size() - run.row_count + row].values[k] +=
          BadOffset(random) * sigma_scale * run.sigma_mm;
      bad.push_back({run.session, k + 1, row});
    }
  }
  return bad;
}

}  // namespace axiscal::synthetic
