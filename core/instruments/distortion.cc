#include "core/instruments/distortion.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <complex>
#include <numbers>

#include "absl/strings/str_cat.h"
#include "core/base/demand.h"
#include "core/instruments/motion.h"
#include "core/shapes/state.h"

namespace axiscal::instruments {
namespace {

using Eigen::Vector3d;

constexpr int kDegrees[] = {2, 3, 4};  // of a ball: what a run-out is not, up to five bumps around
constexpr int kLobeMultiples = 3;      // a lobe that is no cosine has multiples of its order

// Real harmonics of degrees 2 to 4 as polynomials of a unit vector, 5 + 7 + 9 of similar size.
void BallHarmonics(const Vector3d& d, double* out) {
  const double z = d.z();
  const std::complex<double> e(d.x(), d.y());
  std::complex<double> power(1.0, 0.0);
  // P_l^m(z) / (1 - z^2)^(m/2), m = 0 .. l, scaled to at most about 1.
  const double legendre[3][5] = {{1.5 * z * z - 0.5, 2.0 * z, 1.0, 0.0, 0.0},
                                 {2.5 * z * z * z - 1.5 * z, (5.0 * z * z - 1.0) * 0.75, 2.6 * z, 1.0, 0.0},
                                 {(35.0 * z * z * z * z - 30.0 * z * z + 3.0) / 8.0, (7.0 * z * z * z - 3.0 * z) * 0.75,
                                  (7.0 * z * z - 1.0) * 0.5, 3.0 * z, 1.0}};
  std::complex<double> powers[5];
  for (std::complex<double>& one : powers) {
    one = power;
    power *= e;
  }
  for (const int degree : kDegrees) {
    for (int m = 0; m <= degree; ++m) {
      *out++ = legendre[degree - 2][m] * powers[m].real();
      if (m > 0) *out++ = legendre[degree - 2][m] * powers[m].imag();
    }
  }
}

// From the middle of a time, of its half length.
double ShareOf(double from_s, double length_s, double time_s) {
  return length_s > 0.0 ? 2.0 * (time_s - from_s) / length_s - 1.0 : 0.0;
}

// The speed of an axis, and by how much it differs from that on the way to a reading and on the way from it.
void SpeedsAt(const MeasuringRun& run, int reading, int axis, double* speeds) {
  const double speed = run.AxisStatesOf(reading)[axis].speed;
  const auto on_the_way = [&](int from, int to) {
    if (from < 0 || to >= run.reading_count()) return speed;
    return SpeedOf(run.PositionsOf(to)[axis] - run.PositionsOf(from)[axis], run.time_s[to] - run.time_s[from]);
  };
  speeds[0] = speed;
  speeds[1] = on_the_way(reading - 1, reading) - speed;
  speeds[2] = on_the_way(reading, reading + 1) - speed;
}

bool ReadsBall(const MeasuringRun& run) { return run.kind == Kind::kBallbar || run.kind == Kind::kRtest; }

}  // namespace

bool CanHave(const MeasuringRun& run, const Distortion& distortion) {
  if (run.kind != distortion.instrument || run.path_readings != nullptr) return false;
  const bool reads_point = ReadsBall(run) || run.kind == Kind::kTracker;
  switch (distortion.kind) {
    case Distortion::kGain:
      return ReadsBall(run);
    case Distortion::kScale:
      return run.has_temperature && (run.kind == Kind::kBallbar || run.kind == Kind::kTracker);
    case Distortion::kBall:
    case Distortion::kLobes:
      // The sensors of an R-test stand on the table: they see the ball in the spindle from all sides as the table
      // turns.
      return run.kind == Kind::kBallbar || (run.kind == Kind::kRtest && distortion.carrier == Carrier::kTool);
    case Distortion::kGrowth:
    case Distortion::kMotion:
    case Distortion::kClock:
      return run.has_time && reads_point;
  }
  return false;
}

const char* WordOf(Distortion::Kind kind) {
  static const char* const kWords[] = {"gain", "scale", "ball", "lobes", "growth", "motion", "clock"};
  return kWords[kind];
}

std::string TextOf(const Distortion& one, base::Language language) {
  const bool is_german = language == base::Language::kGerman, is_tool = one.carrier == Carrier::kTool;
  const char* const where =
      is_german ? (is_tool ? "im Werkzeughalter" : "auf dem Tisch") : (is_tool ? "in the tool holder" : "on the table");
  switch (one.kind) {
    case Distortion::kGain:
      return is_german ? "die Verstärkung seiner Kanäle" : "the gain of its channels";
    case Distortion::kScale:
      return is_german ? "seine Länge, die mit der Temperatur wächst" : "its length, which grows with the temperature";
    case Distortion::kBall:
      return is_german ? absl::StrCat("seine Kugel ", where, ", die nicht rund ist")
                       : absl::StrCat("its ball ", where, ", which is not round");
    case Distortion::kLobes:
      return absl::StrCat(one.order, is_german ? " Wellen seiner Kugel " : " lobes of its ball ", where);
    case Distortion::kGrowth:
      return absl::StrCat(is_german ? "sein Wachsen nach dem Beginn jeder Messung, innerhalb von "
                                    : "its growth after each session's start, within ",
                          std::lround(one.tau_s), " s");
    case Distortion::kMotion:
      return is_german ? absl::StrCat("ein langsames Wandern dessen, was ", where, " steht")
                       : absl::StrCat("a slow motion of what stands ", where);
    case Distortion::kClock:
      return is_german ? "seine Uhr, die nicht die der Steuerung ist" : "its clock, which is not that of the control";
  }
  return "";
}

int AmplitudeCount(const Distortion& distortion, int row_count) {
  switch (distortion.kind) {
    case Distortion::kGain:
      return row_count * row_count;
    case Distortion::kScale:
      return 1;
    case Distortion::kClock:
      return kClockSpeeds;
    case Distortion::kBall:
      return 5 + 7 + 9;
    case Distortion::kLobes:
      return 2 * kLobeMultiples;
    case Distortion::kGrowth:
      return row_count;
    case Distortion::kMotion:
      return 3 * kMotionFunctions;
  }
  return 0;
}

std::vector<double> SpectrumOf(const Distortion& distortion, int row_count) {
  std::vector<double> spectrum(static_cast<size_t>(AmplitudeCount(distortion, row_count)), 1.0);
  if (distortion.kind == Distortion::kBall) {  // half as high with each degree
    for (size_t k = 5; k < spectrum.size(); ++k) spectrum[k] = k < 12 ? 0.25 : 0.0625;
  } else if (distortion.kind == Distortion::kLobes) {  // a quarter with each multiple: a rounded bump's
    for (size_t k = 2; k < spectrum.size(); ++k) spectrum[k] = k < 4 ? 1.0 / 16.0 : 1.0 / 256.0;
  } else if (distortion.kind == Distortion::kMotion) {  // slow before fast
    for (size_t k = 0; k < spectrum.size(); ++k) {
      const size_t function = k / 3 + 1;
      const double j = 0.5 * static_cast<double>(function);
      spectrum[k] = 1.0 / (1.0 + j * j);
    }
  } else if (distortion.kind == Distortion::kClock) {  // half of the delay
    std::fill(spectrum.begin() + 1, spectrum.end(), 0.25);
  }
  return spectrum;
}

double LargestSigmaMm(const Distortion& distortion) {
  constexpr double kGain = 0.05;             // an instrument that is off by more is not used
  constexpr double kOffMm = 0.05;            // what grows, moves or is not round
  constexpr double kScalePerKelvin = 50e-6;  // more than any material
  constexpr double kDelayS = 0.2;
  switch (distortion.kind) {
    case Distortion::kGain:
      return kGain * kGainReadingMm;
    case Distortion::kScale:
      return kScalePerKelvin * kScaleLengthMm;
    case Distortion::kClock:
      return kDelayS * kClockSpeedMmPerS;
    default:
      return kOffMm;
  }
}

int DistortionAmplitudes(const MeasuringRun& run) {
  int count = 0;
  for (const Distortion& one : run.distortions) count += AmplitudeCount(one, run.row_count);
  return count;
}

int OwnSetupCount(const MeasuringRun& run) {
  return static_cast<int>(run.setup.size() - 3 * run.slips.size()) - DistortionAmplitudes(run);
}

void TotalAmplitudes(const MeasuringRun& run, const double* setup, double* amplitudes) {
  const int own = OwnSetupCount(run), count = DistortionAmplitudes(run);
  for (int k = own; k < own + count; ++k) *amplitudes++ = setup[k] + run.setup[static_cast<size_t>(k)].centre;
}

void AddDistortion(const Distortion& distortion, MeasuringRun* run) {
  const int count = AmplitudeCount(distortion, run->row_count);
  DEMAND(CanHave(*run, distortion) && run->slips.empty() &&
         DistortionAmplitudes(*run) + count <= kMaxDistortionAmplitudes);
  run->distortions.push_back(distortion);
  const double sigma_mm =
      distortion.variance_mm2 > 0.0 ? std::sqrt(distortion.variance_mm2) : LargestSigmaMm(distortion);
  const std::vector<double> spectrum = SpectrumOf(distortion, run->row_count);
  const bool is_found = !distortion.amplitude_mm.empty();
  DEMAND(distortion.sigma_mm.size() == distortion.amplitude_mm.size() &&
         (!is_found || distortion.amplitude_mm.size() == spectrum.size()));
  for (int k = 0; k < count; ++k) {
    std::string name = WordOf(distortion.kind);
    if (distortion.kind == Distortion::kGain && count == 9) {
      absl::StrAppend(&name, "_", std::string(1, "xyz"[k / 3]), std::string(1, "xyz"[k % 3]));
    } else if (count > 1) {
      absl::StrAppend(&name, "_", k + 1);
    }
    // Not weak: an instrument that is in use is known to be off by no more, and that may separate errors from it.
    const auto at = static_cast<size_t>(k);
    run->setup.push_back({std::move(name), is_found ? distortion.sigma_mm[at] : sigma_mm * std::sqrt(spectrum[at]),
                          false, false, false, std::nullopt, is_found ? distortion.amplitude_mm[at] : 0.0});
  }
}

void AddDistortionsOf(const std::vector<MeasuringRun>& like, std::vector<MeasuringRun>* runs) {
  for (MeasuringRun& run : *runs) {
    const auto it = std::find_if(like.begin(), like.end(), [&](const MeasuringRun& other) {
      return other.kind == run.kind && !other.distortions.empty();
    });
    if (it == like.end() || !run.distortions.empty()) continue;
    for (const Distortion& one : it->distortions)
      if (CanHave(run, one)) AddDistortion(one, &run);
  }
}

void MotionWeights(const Distortion& motion, double time_s, double* weights) {
  const double share = 0.5 * (1.0 + ShareOf(motion.from_s, motion.length_s, time_s));
  for (int j = 0; j < kMotionFunctions; ++j) weights[j] = std::cos(std::numbers::pi * (j + 1) * share);
}

void ClockSpeeds(const Distortion& clock, const MeasuringRun& run, int reading, int axis, double* speeds) {
  SpeedsAt(run, reading, axis, speeds);
  speeds[kClockSpeeds - 1] = ShareOf(clock.from_s, clock.length_s, run.time_s[reading]) * speeds[0];
}

void DistortionBasis(const Distortion& distortion, const SoundRow& row, double* basis) {
  switch (distortion.kind) {
    case Distortion::kGain:
      std::fill(basis, basis + row.row_count * row.row_count, 0.0);
      for (int j = 0; j < row.row_count; ++j) basis[row.row * row.row_count + j] = row.sound_mm[j] / kGainReadingMm;
      return;
    case Distortion::kScale:
      basis[0] = row.warmer_kelvin * (row.sound_mm[row.row] + row.length_mm) / kScaleLengthMm;
      return;
    case Distortion::kBall:
      BallHarmonics(distortion.carrier == Carrier::kTool ? row.contact_in_tool : row.contact_in_table, basis);
      return;
    case Distortion::kLobes: {
      const Vector3d& d = distortion.carrier == Carrier::kTool ? row.contact_in_tool : row.contact_in_table;
      const double across = std::hypot(d.x(), d.y()), angle = across > 0.0 ? std::atan2(d.y(), d.x()) : 0.0;
      for (int m = 1; m <= kLobeMultiples; ++m) {
        *basis++ = across * std::cos(m * distortion.order * angle);
        *basis++ = across * std::sin(m * distortion.order * angle);
      }
      return;
    }
    case Distortion::kGrowth:
      std::fill(basis, basis + row.row_count, 0.0);
      basis[row.row] = -std::expm1(-row.since_start_s / distortion.tau_s);
      return;
    case Distortion::kMotion: {
      double weights[kMotionFunctions];
      MotionWeights(distortion, row.time_s, weights);
      const Eigen::RowVector3d& by = distortion.carrier == Carrier::kTool ? row.by_tool : row.by_table;
      for (int j = 0; j < kMotionFunctions; ++j) {
        for (int k = 0; k < 3; ++k) *basis++ = weights[j] * by[k];
      }
      return;
    }
    case Distortion::kClock:
      std::copy(row.by_clock, row.by_clock + kClockSpeeds - 1, basis);
      basis[kClockSpeeds - 1] = ShareOf(distortion.from_s, distortion.length_s, row.time_s) * row.by_clock[0];
      return;
  }
}

void FillMoment(const MeasuringRun& run, int reading, SoundRow* rows) {
  for (int i = 0; i < run.row_count; ++i) {
    rows[i].row = i;
    rows[i].row_count = run.row_count;
    rows[i].length_mm = run.bar_length_mm;
    rows[i].time_s = run.time_s[reading];
    rows[i].since_start_s = run.time_s[reading] - run.time_s[0];
    rows[i].warmer_kelvin = run.temperature_celsius[reading] - shapes::kReferenceTemperatureCelsius;
  }
}

void FillContact(const machine::Machine& machine, const MeasuringRun& run, int reading, SoundRow* rows) {
  if (!ReadsBall(run)) return;
  const machine::ChainPose<double> pose =
      machine::EvaluateChain<double>(machine, run.PositionsOf(reading), machine::JointErrors<double>());
  // x and y across the tool, z along it: lobes are counted about it.
  const Vector3d along = machine.tool_direction.normalized(), across = along.unitOrthogonal();
  Eigen::Matrix3d tool_from_home;
  tool_from_home << across.transpose(), along.cross(across).transpose(), along.transpose();
  for (int i = 0; i < run.row_count; ++i) {
    Vector3d from_table = pose.bed_from_table.rotation.col(i), from_tool = from_table;
    if (run.kind == Kind::kBallbar) {
      from_table = (pose.bed_from_tool * run.tip_mm - pose.bed_from_table * run.ball_mm).normalized();
      from_tool = -from_table;
    }
    rows[i].contact_in_table = pose.bed_from_table.rotation.transpose() * from_table;
    rows[i].contact_in_tool = tool_from_home * (pose.bed_from_tool.rotation.transpose() * from_tool);
  }
}

void FillSoundRows(const machine::Machine& machine, const MeasuringRun& run, int reading,
                   const machine::JointErrors<double>& errors, const Evaluation& sound, bool needs_contact,
                   SoundRow* rows) {
  FillMoment(run, reading, rows);
  if (needs_contact) FillContact(machine, run, reading, rows);
  const Eigen::Index tool = machine::kComponents * Eigen::Index{machine.tool_joint()};
  for (int i = 0; i < run.row_count; ++i) {
    for (int j = 0; j < run.row_count; ++j) rows[i].sound_mm[j] = sound.predicted_mm[j];
    rows[i].by_table = sound.by_setup.row(i).head<3>();
    rows[i].by_tool = sound.by_error.row(i).segment<3>(tool);
    std::fill(std::begin(rows[i].by_clock), std::end(rows[i].by_clock), 0.0);
    for (int axis = 0; axis < machine.axis_count(); ++axis) {
      const bool is_rotary = machine.axes[axis].kind == machine::AxisKind::kRotary;
      const machine::ErrorVector<double>& error = errors[axis];
      const Vector3d& direction = machine.axes[axis].direction;
      // A linear axis moves along the direction that its error turned.
      const Vector3d along =
          is_rotary ? direction : Vector3d(geometry::RotationXyz(error[3], error[4], error[5]) * direction);
      const double by_move = sound.by_error.row(i).segment<3>(machine::kComponents * axis + 3 * is_rotary).dot(along);
      double speeds[kClockSpeeds - 1];
      if (run.has_time) SpeedsAt(run, reading, axis, speeds);
      for (int j = 0; run.has_time && j < kClockSpeeds - 1; ++j)
        rows[i].by_clock[j] -= by_move * speeds[j] / kClockSpeedMmPerS;
    }
  }
}

}  // namespace axiscal::instruments
