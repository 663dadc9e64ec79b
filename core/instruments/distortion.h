// An instrument that is at fault. None of it is an error of the machine: amplitudes are setup offsets of each session,
// refitted with it and never compensated. With p the reading of a sound instrument at the pose (row i of 1 or 3):
//   gain    sum_j a_ij p_j / 50 um                 R-test and ball bar; on predicted readings: measured ones hold their
//                                                  own noise, which would then explain itself
//   scale   a (T - 20) (p + bar length) / 1 m      ball bar, tracker
//   ball    sum_lm a_lm Y_lm(d)                    d: unit direction of contact from the ball's centre, in the frame
//   lobes   |d across| sum_m a cos(m n f) + b sin  of the ball's carrier; f: its angle about the carrier's z (tool:
//   about
//                                                  the tool); real harmonics of degree l = 2 to 4, m = 1 to 3
//   growth  a_i (1 - exp(-t / tau))                t: since the session's first reading
//   motion  sum_j a_j cos(pi j (t - from) / length) of what the table or the tool holder carries, in its frame, j = 1
//   ..
//   clock   each axis is behind by sum_j a_j w_j /  w: its speed v; the speed of the way to this reading less v, that
//           (1 m/min)                               of the way from it less v, as the path between readings is not
//                                                   known; and v (2 (t - from) / length - 1), of clocks that run apart
// All amplitudes are mm: a gain's at a reading of 50 um, a scale's per K at 1 m, a clock's at 1 m/min.
#ifndef AXISCAL_CORE_INSTRUMENTS_DISTORTION_H_
#define AXISCAL_CORE_INSTRUMENTS_DISTORTION_H_

#include <array>
#include <string>
#include <vector>

#include "core/base/language.h"
#include "core/instruments/evaluation.h"

namespace axiscal::instruments {

inline constexpr double kGainReadingMm = 0.05;              // as R-tests and ball bars read
inline constexpr double kScaleLengthMm = 1000.0;            // 1 m
inline constexpr double kClockSpeedMmPerS = 1000.0 / 60.0;  // 1 m/min
inline constexpr int kMotionFunctions = 8;                  // as finely as half an eighth of the time
inline constexpr int kClockSpeeds = 4;

// Whether a session's instrument can have it, and its columns can show it.
bool CanHave(const MeasuringRun& run, const Distortion& distortion);

// "gain", "scale" ... ; "a gain of its channels" ... for a reader.
const char* WordOf(Distortion::Kind kind);
std::string TextOf(const Distortion& distortion, base::Language language = base::Language::kEnglish);

int AmplitudeCount(const Distortion& distortion, int row_count);
// Relative prior variance of each amplitude: the finer a harmonic, the smaller it is.
std::vector<double> SpectrumOf(const Distortion& distortion, int row_count);
// As large as an amplitude of spectrum 1 may be, mm, standard deviation.
double LargestSigmaMm(const Distortion& distortion);

// Adds it to a session, before any slip is added. DEMANDs that the session can have it.
void AddDistortion(const Distortion& distortion, MeasuringRun* run);
// Adds to each of `runs` what the sessions of the same instrument in `like` have.
void AddDistortionsOf(const std::vector<MeasuringRun>& like, std::vector<MeasuringRun>* runs);
// Amplitudes of all distortions of a session; setup offsets of its own and of the datum, before them.
int DistortionAmplitudes(const MeasuringRun& run);
int OwnSetupCount(const MeasuringRun& run);
// What the amplitudes are at these setup offsets: with what the sessions have in common.
void TotalAmplitudes(const MeasuringRun& run, const double* setup, double* amplitudes);

// What one row of a sound reading says of all distortions.
struct SoundRow {
  int row = 0, row_count = 1;
  double sound_mm[kMaxRows] = {};  // all rows of the reading
  double length_mm = 0.0;          // of the bar
  double since_start_s = 0.0, time_s = 0.0, warmer_kelvin = 0.0;
  // Unit, in the frame of the ball's carrier; zero where no ball is touched.
  Eigen::Vector3d contact_in_table = Eigen::Vector3d::Zero(), contact_in_tool = Eigen::Vector3d::Zero();
  // Derivatives of the row by shifts of what table and tool holder carry, and by a clock's amplitudes but the last.
  Eigen::RowVector3d by_table = Eigen::RowVector3d::Zero(), by_tool = Eigen::RowVector3d::Zero();
  double by_clock[kClockSpeeds - 1] = {};
};

// d(reading) / d(amplitude) of each amplitude.
void DistortionBasis(const Distortion& distortion, const SoundRow& row, double* basis);

// The weights of a motion's functions at a time; kMotionFunctions numbers.
void MotionWeights(const Distortion& motion, double time_s, double* weights);
// What a clock's amplitudes count of an axis at a reading, mm/s or rad/s; kClockSpeeds numbers.
void ClockSpeeds(const Distortion& clock, const MeasuringRun& run, int reading, int axis, double* speeds);

// The rows of a reading as a sound instrument would read it under these errors: `sound` is its evaluation.
void FillSoundRows(const machine::Machine& machine, const MeasuringRun& run, int reading,
                   const machine::JointErrors<double>& errors, const Evaluation& sound, bool needs_contact,
                   SoundRow* rows);
// The contact directions alone, on the nominal machine.
void FillContact(const machine::Machine& machine, const MeasuringRun& run, int reading, SoundRow* rows);
// What depends neither on errors nor on where balls are touched.
void FillMoment(const MeasuringRun& run, int reading, SoundRow* rows);

// Acts on the reading of a sound instrument; false: on what the axes or carriers do.
inline bool ActsOnReading(Distortion::Kind kind) { return kind != Distortion::kMotion && kind != Distortion::kClock; }
inline bool NeedsContact(Distortion::Kind kind) { return kind == Distortion::kBall || kind == Distortion::kLobes; }

}  // namespace axiscal::instruments

#endif  // AXISCAL_CORE_INSTRUMENTS_DISTORTION_H_
