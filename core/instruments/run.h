// A measuring session bound to its machine: what its columns mean, in core units, with the motion that led to each
// reading.
#ifndef AXISCAL_CORE_INSTRUMENTS_RUN_H_
#define AXISCAL_CORE_INSTRUMENTS_RUN_H_

#include <Eigen/Core>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "core/base/copy_on_write.h"
#include "core/geometry/rigid.h"
#include "core/instruments/eccentricity/eccentricity_run.h"
#include "core/instruments/touch/touch_run.h"
#include "core/instruments/tracker/tracker_run.h"
#include "core/machine/machine.h"
#include "core/session/session.h"
#include "core/session/stated_facts.h"
#include "core/shapes/state.h"
#include "core/shapes/temperatures.h"

namespace axiscal::instruments {

enum class Kind { kBallbar, kRtest, kCentres, kTracker, kTouch, kEccentricity, kLength, kDirection };

inline constexpr int kMaxRows = 3;           // readings that one line of a session holds
inline constexpr int kMaxSlips = 3;          // of one session
inline constexpr double kSlipSigmaMm = 0.1;  // weak prior of how far something slips
inline constexpr int kMaxDatumAxes = 6;      // of one session
// Weak prior of where a work offset that is set anew goes: wide beside what readings tell of it, narrow beside what
// they leave open, which stays where it is. It judges nothing (SetupParameter::is_placed).
inline constexpr double kDatumSigmaMm = 1.0;
inline constexpr int kMaxDistortionAmplitudes = 128;                    // of one session: four of the widest kinds
inline constexpr int kMaxInstrumentParameters = tracker::kMostOffsets;  // setup offsets that an instrument has itself
// Setup offsets of one session.
inline constexpr int kMaxSetupParameters =
    kMaxInstrumentParameters + kMaxDatumAxes + kMaxDistortionAmplitudes + 3 * kMaxSlips;

// One setup offset: refitted with its session, never taken for a machine error.
struct SetupParameter {
  std::string name;          // ball_x, run_out_x, bar_length, frame_a ...
  double prior_sigma = 0.0;  // mm or rad; infinite where nothing is known
  // A weak prior only keeps the offset sane ("mounted by hand"); one that is not weak is knowledge (a certificate), by
  // which errors may be separated.
  bool is_weak = true;
  bool is_angle = false;
  // False where nobody says where the offset is (a free datum, a slip): how far it goes is no misfit, and its prior,
  // which only keeps the fit steady, is no part of the fit's statistics.
  bool is_placed = true;
  // Known from elsewhere (the fit that its set-up was found with), mm or rad: not fitted.
  std::optional<double> held = std::nullopt;
  // Of an amplitude of a distortion, mm: what sessions have in common; the offset is the session's deviation from it.
  double centre = 0.0;
};

// Something in the setup slipped: from `first_reading` on the artefact on the table, or what the tool holder carries
// (probe, ball, target), stands elsewhere.
enum class Carrier { kTable, kTool };
struct Slip {
  Carrier carrier = Carrier::kTable;
  int first_reading = 0;
};

// A way in which an instrument is at fault (distortion.h): its sessions share it, each deviates by amplitudes of its
// own.
struct Distortion {
  enum Kind {
    kGain,    // channels that read too much or too little, and each other
    kScale,   // a length that grows with the temperature
    kBall,    // a ball that is not round
    kLobes,   // so many lobes about the tool (ball in the spindle) or about the table's z (ball on the table)
    kGrowth,  // it warms up after each session's start
    kMotion,  // what the table or the tool holder carries moves slowly
    kClock    // it reads late
  };
  Kind kind = kGain;
  instruments::Kind instrument = instruments::Kind::kRtest;
  Carrier carrier = Carrier::kTool;     // of kBall, kLobes: of the ball; of kMotion
  int order = 0;                        // of kLobes
  double tau_s = 0.0;                   // of kGrowth: time constant
  double from_s = 0.0, length_s = 0.0;  // of kMotion, kClock: the time over which it may change
  double variance_mm2 = 0.0;  // of an amplitude of spectrum 1, where it is known: then its prior, else a weak one

  // Once found: the amplitudes that all its sessions have in common, and how far one session's may be from them, mm.
  std::vector<double> amplitude_mm, sigma_mm;

  bool operator==(const Distortion&) const = default;
};

// Of a length (length/length_model.h): from the anchor MeasuringRun::ball_mm or along a beam, which stands on the bed
// or on the table.
struct Length {
  bool is_on_bed = false;
  bool is_beam = false;
  Eigen::Vector3d beam = Eigen::Vector3d::Zero();  // unit, machine axes at home
  double zero_mm = 0.0;                            // where the setup offset `zero` starts from
};

// Of a direction (direction/direction_model.h).
struct Direction {
  bool is_on_bed = false;
  Eigen::Vector3d about = Eigen::Vector3d::Zero();  // unit, machine axes at home
};

// What a stated fact (stated.h) adds to each reading, row_count x readings.
struct StatedEffect {
  std::string of;               // "expansion of bar, 11.5 +- 0.5 um/(m K)": the same in two sessions is one fact
  Eigen::MatrixXd mm;           // by the stated value
  Eigen::MatrixXd by_sigma_mm;  // where the fact is off by one standard uncertainty
  bool is_workpiece = false;    // of what is cut, not of what is read: no part of a prediction
  // The setup offset that it is known of, where there is one, and how well.
  std::string setup_offset;
  double setup_sigma_mm = 0.0;
};

struct MeasuringRun {
  std::string session;
  std::string setup_name;        // sessions with the same name share their setup offsets
  bool is_setup_stated = false;  // by `# setup:`; else the name is the session's own
  // The serial number of an instrument whose scale is known to a stated sigma: that scale (the setup offset `scale`) is
  // one in all its sessions. Empty: its own in each session or set-up.
  std::string scale_of;
  Kind kind = Kind::kBallbar;
  double sigma_mm = 0.0;                              // stated repeatability of one reading
  Eigen::Vector3d tip_mm = Eigen::Vector3d::Zero();   // nominal tool point or stylus centre at home, machine frame
  Eigen::Vector3d ball_mm = Eigen::Vector3d::Zero();  // nominal table ball at home, machine frame
  double bar_length_mm = 0.0;
  geometry::Rigid<double> tracker_from_machine;  // tracker only: where its setup offsets start from
  Length length;                                 // length only
  Direction direction;                           // direction only
  touch::Touches touches;                        // touch only
  tracker::Targets targets;                      // tracker only
  // Eccentricity only: a reading is taken along a path, not at a state; positions and states of this run are zero then.
  std::shared_ptr<const eccentricity::Eccentricities> path_readings;
  std::vector<SetupParameter> setup;
  // Linear axes whose work offset was set anew for this session (`# datum: free X Z`): the true position is the
  // commanded one plus a constant, mm, a setup offset each (datum_X ...) behind the instrument's own.
  std::vector<int> free_datum;
  // Faults of the instrument: their amplitudes are setup offsets behind the datum's.
  std::vector<Distortion> distortions;
  // How far each slip moved (x, y, z; table or tool frame, mm) is three more setup offsets, in this order behind the
  // instrument's own, the datum's and the distortions'. None for readings along a path.
  std::vector<Slip> slips;
  std::vector<size_t> bad_rows;  // reading * row_count + row: known to be bad, set aside in every fit

  // Where this is a part of a session: readings before it, so that messages count from the session's first.
  int readings_before = 0;
  int axis_count = 0;
  int row_count = 1;  // rows per reading: 1 or 3
  bool has_time = false, has_temperature = false;
  // Reading-major: entry k * axis_count + i.
  std::vector<double> positions;  // mm or rad
  // The same positions with sense, travel and speed: most of what a session holds.
  base::CopyOnWrite<std::vector<shapes::AxisState>> axis_states;
  std::vector<double> time_s;
  std::vector<double> temperature_celsius;
  // Further temperatures by name (`T_spindle_C`: "spindle"), a value per reading.
  struct Channel {
    std::string name;
    std::vector<double> celsius;
  };
  std::vector<Channel> temperatures;
  // All temperatures over all sessions that are looked at together (ShareTemperatures), and where this one begins in
  // it.
  std::shared_ptr<const shapes::Temperatures> history;
  int first_moment = 0;
  // What encoders showed beside the commands: as `positions`, NaN where an axis has no such column; empty without any.
  std::vector<double> encoder_positions;
  // From which side each axis came, where it is stated (X_sense): as `positions`, 1, -1 or 0; empty without any.
  std::vector<double> stated_senses;
  std::optional<double> payload_kg;                  // what the machine carried, where it is stated
  std::optional<Eigen::Vector3d> gravity_direction;  // unit, downwards, machine frame, where it is stated
  Eigen::MatrixXd measured_mm;                       // row_count x readings; column k = reading k
  std::vector<StatedEffect> stated;
  Eigen::MatrixXd stated_mm;  // their sum, added to every prediction; empty where there are none
  std::vector<session::Certificate> certificates;
  std::optional<base::UtcTime> started;  // where the header states it

  int reading_count() const { return static_cast<int>(measured_mm.cols()); }
  const double* PositionsOf(int reading) const { return positions.data() + static_cast<size_t>(reading) * axis_count; }
  const shapes::AxisState* AxisStatesOf(int reading) const {
    return axis_states->data() + static_cast<size_t>(reading) * axis_count;
  }
  shapes::State StateOf(int reading) const {
    return {{AxisStatesOf(reading), static_cast<size_t>(axis_count)},
            time_s[reading],
            temperature_celsius[reading],
            touches.approach_in_spindle.empty() ? shapes::Approach() : touches.approach_in_spindle[reading],
            history.get(),
            first_moment + reading};
  }
};

// INVALID_ARGUMENT naming session, key or column and the rule when the session does not fit the machine or its
// instrument. A part of a session begins after `readings_before`.
absl::StatusOr<MeasuringRun> BindSession(const session::Session& session, const machine::Machine& machine,
                                         size_t readings_before = 0);

// Gives sessions of one clock that have none yet their history of temperatures: what a machine remembers runs on from
// one to the next, with temperatures linear in between. Sessions whose times overlap, and those with other channels,
// have one each, as has a session that begins settled at its first temperature. Readings along a path have none.
void ShareTemperatures(const std::vector<std::vector<MeasuringRun>*>& sessions);

// The column of a temperature by its name.
inline std::string ColumnOf(const MeasuringRun::Channel& channel) { return "T_" + channel.name + "_C"; }

// Columns of the temperatures that a session recorded: "temp_C", "T_spindle_C".
inline std::vector<std::string> TemperatureColumns(const MeasuringRun& run) {
  std::vector<std::string> columns;
  if (run.has_temperature) columns.push_back(shapes::kTemperatureChannel);
  for (const MeasuringRun::Channel& channel : run.temperatures) columns.push_back(ColumnOf(channel));
  return columns;
}

// Frees the datum of a linear axis; before any distortion or slip is added.
void AddDatum(const machine::Machine& machine, int axis, MeasuringRun* run);

// Adds a slip with its offsets; a direction, which has no place, has none. A session with a slip no longer shares its
// setup: it gets a setup of its own.
void AddSlip(const Slip& slip, MeasuringRun* run);

// Fills run->axis_states from positions and times (motion.h).
void DeriveMotion(MeasuringRun* run);

}  // namespace axiscal::instruments

#endif  // AXISCAL_CORE_INSTRUMENTS_RUN_H_
