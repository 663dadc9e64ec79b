#include <algorithm>
#include <cmath>

#include "core/base/units.h"
#include "core/machine/chain.h"
#include "core/synthetic/scenario.h"

namespace axiscal::synthetic {
namespace {

using instruments::Kind;
using instruments::MeasuringRun;

// Streams of one seed: what one draws does not move the others.
enum class Stream : uint64_t {
  kSampling = 1,
  kEffects = 100,
  kFaults = 200,
  kSetups = 300,
  kNoise = 400,
  kBad = 500,
  kBox = 600,
  kStated = 700
};
uint64_t SeedOf(uint64_t seed, Stream stream) { return base::StreamSeed(seed, static_cast<uint64_t>(stream)); }

bool IsTemperature(const std::string& column) {
  return column == "temp_C" || (column.size() > 4 && column.starts_with("T_") && column.ends_with("_C"));
}

std::string SetupOf(const session::Session& session) {
  return session::FindHeader(session, "setup").value_or(session::FindHeader(session, "session").value_or(""));
}

// Every temperature that acts in all sessions, per session.
std::vector<std::map<std::string, std::vector<double>>> TemperaturesOf(const Scenario& scenario,
                                                                       const std::vector<session::Session>& sessions) {
  std::vector<std::map<std::string, std::vector<double>>> all(sessions.size());
  std::map<std::string, size_t> found;
  for (size_t s = 0; s < sessions.size(); ++s) {
    for (const session::Column& column : sessions[s].columns) {
      if (IsTemperature(column.name)) all[s][column.name] = column.values;
    }
    const std::vector<double>* times = TimesOf(sessions[s]);
    for (const Temperature& temperature : scenario.temperatures) {
      if (temperature.is_recorded || times == nullptr) continue;
      std::vector<double>& values = all[s][temperature.name];
      for (const double t : *times) values.push_back(temperature.At(t));
    }
    for (const auto& [name, values] : all[s]) ++found[name];
  }
  for (auto& of_session : all)
    std::erase_if(of_session, [&](const auto& entry) { return found[entry.first] < sessions.size(); });
  return all;
}

// Shown positions, as a control logs them: to 0.0001 mm or deg.
void ShowPositions(const machine::Machine& machine, const std::vector<double>& shown, session::Session* session) {
  for (int axis = 0; axis < machine.axis_count(); ++axis) {
    const bool is_rotary = machine.axes[axis].kind == machine::AxisKind::kRotary;
    session::Column* const column = ColumnIn(session, machine.axes[axis].name + (is_rotary ? "_deg" : "_mm"));
    for (size_t k = 0; column != nullptr && k < column->values.size(); ++k) {
      const double position = shown[k * machine.axis_count() + axis] * (is_rotary ? base::kDegPerRad : 1.0);
      column->values[k] = std::round(1e4 * position) / 1e4;
    }
  }
}

class Runner {
 public:
  Runner(const machine::Machine& machine, const Scenario& scenario, Form form, uint64_t seed)
      : machine_(machine), scenario_(scenario), form_(form), seed_(seed) {}

  absl::StatusOr<SimulatedCase> Run(const PlannedCase& planned) {
    sessions_ = planned.fit;
    sessions_.insert(sessions_.end(), planned.check.begin(), planned.check.end());
    if (sessions_.empty()) return absl::InvalidArgumentError("plan: no sessions, expected at least one");
    RETURN_IF_ERROR(Prepare());
    RETURN_IF_ERROR(DrawEffects());
    ASSIGN_OR_RETURN(
        faults_, DrawFaults(machine_, scenario_.faults, form_, runs_, out_.history, SeedOf(seed_, Stream::kFaults)));
    RETURN_IF_ERROR(CheckNames());
    out_.described = Misdescribe(machine_, scenario_.nominal);
    out_.truth.is_as_described = std::none_of(
        scenario_.nominal.begin(), scenario_.nominal.end(),
        [](const auto& fault) { return fault.kind == NominalKind::kDirection || fault.kind == NominalKind::kPivot; });
    if (const absl::Status valid = machine::Validate(out_.described); !valid.ok())
      return base::Within("nominal", valid);
    for (size_t s = 0; s < sessions_.size(); ++s) {
      auto measured = MeasureOne(s);
      if (!measured.ok()) return base::Within(absl::StrCat("session '", runs_[s].session, "'"), measured.status());
      RETURN_IF_ERROR(Misstate(scenario_.nominal, &*measured));
      (s < planned.fit.size() ? out_.measured.fit : out_.measured.check).push_back(*std::move(measured));
    }
    return std::move(out_);
  }

 private:
  absl::Status Prepare() {
    base::Random random(SeedOf(seed_, Stream::kSampling));
    std::vector<session::Session*> in_order;
    for (session::Session& session : sessions_) {
      Resample(scenario_.sampling, &random, &session);
      in_order.push_back(&session);
    }
    RunOn(scenario_.sampling.gap_s, in_order);
    for (session::Session& session : sessions_) {
      for (const Temperature& temperature : scenario_.temperatures) {
        if (temperature.is_recorded)
          SetTemperature(
              temperature.name, [&](double t) { return temperature.At(t); }, &session);
      }
      ASSIGN_OR_RETURN(session, WithReadingColumns(machine_, session));
      ASSIGN_OR_RETURN(MeasuringRun run, instruments::BindSession(session, machine_));
      runs_.push_back(std::move(run));
    }
    out_.truth.machine = machine_;
    out_.truth.errors = scenario_.errors;
    out_.truth.temperatures = scenario_.temperatures;
    out_.truth.tip_mm = runs_[0].tip_mm;
    const auto celsius = TemperaturesOf(scenario_, sessions_);
    for (size_t s = 0; s < runs_.size(); ++s) {
      if (runs_[s].kind == Kind::kEccentricity && !(scenario_.effects.empty() && scenario_.faults.empty()))
        return absl::InvalidArgumentError(absl::StrCat("session '", runs_[s].session,
                                                       "': eccentricities are simulated with errors only, expected no "
                                                       "effects and no faults"));
      Append(runs_[s], celsius[s], &out_.history);
    }
    return absl::OkStatus();
  }

  absl::Status DrawEffects() {
    for (size_t i = 0; i < scenario_.effects.size(); ++i) {
      base::Random random(base::StreamSeed(SeedOf(seed_, Stream::kEffects), i));
      auto drawn = DrawEffect(machine_, scenario_.surroundings, scenario_.effects[i], form_, out_.history, &random);
      if (!drawn.ok()) return base::Within(absl::StrCat("effects[", i, "]"), drawn.status());
      if (drawn->term) {
        AddTerm(*drawn->term);
      } else {
        out_.truth.effects.push_back({NameOf(machine_, scenario_.effects[i]), *std::move(drawn)});
      }
    }
    for (const Truth::NamedEffect& effect : out_.truth.effects) errors_.push_back(effect.drawn.Errors(out_.history));
    return absl::OkStatus();
  }

  // Errors of one shape are one error.
  void AddTerm(const machine::ErrorTerm& term) {
    for (machine::ErrorTerm& other : out_.truth.errors.terms) {
      if (other.joint != term.joint || other.component != term.component || !(other.shape == term.shape)) continue;
      for (size_t i = 0; i < term.amplitude.size(); ++i) other.amplitude[i] += term.amplitude[i];
      return;
    }
    out_.truth.errors.terms.push_back(term);
  }

  // Sessions that nominal faults name; those of faults were looked for already.
  absl::Status CheckNames() const {
    for (size_t i = 0; i < scenario_.nominal.size(); ++i) {
      for (const std::string& name : scenario_.nominal[i].sessions) {
        if (std::none_of(runs_.begin(), runs_.end(), [&](const MeasuringRun& run) { return run.session == name; }))
          return absl::InvalidArgumentError(absl::StrCat("nominal[", i, "]: the plan has no session '", name, "'"));
      }
    }
    return absl::OkStatus();
  }

  absl::StatusOr<session::Session> MeasureOne(size_t s) {
    const SessionFaults& faults = faults_[s];
    const size_t first = out_.history.session_begin[s];
    Measuring measuring;
    measuring.errors_at = [&, first](int k, const shapes::State& state) {
      machine::JointErrors<double> errors = machine::ErrorsAt(machine_, out_.truth.errors, state);
      for (size_t i = 0; i < errors_.size(); ++i) {
        const DrawnEffect& effect = out_.truth.effects[i].drawn;
        errors[effect.joint][static_cast<int>(effect.component)] += errors_[i][first + k];
      }
      if (faults.table_mm.size() > 0) errors[machine_.work_joint()].head<3>() += faults.table_mm.col(k);
      if (faults.tool_mm.size() > 0) errors[machine_.tool_joint()].head<3>() += faults.tool_mm.col(k);
      return errors;
    };
    measuring.read_positions = faults.read_positions;
    measuring.distort = [&](int k, double* reading_mm) { Distort(faults, runs_[s], k, reading_mm); };
    measuring.noise = scenario_.noise;
    measuring.noise.seed = base::StreamSeed(SeedOf(seed_, Stream::kNoise), s);
    size_t setup = 0;  // the first session with this set-up
    while (SetupOf(sessions_[setup]) != SetupOf(sessions_[s])) ++setup;
    measuring.noise.setup_seed = base::StreamSeed(SeedOf(seed_, Stream::kSetups), setup);
    if (scenario_.noise.draw_setup) measuring.noise.stated_seed = SeedOf(seed_, Stream::kStated);
    ASSIGN_OR_RETURN(session::Session session, Measure(machine_, measuring, sessions_[s]));
    if (!faults.shown_positions.empty()) ShowPositions(machine_, faults.shown_positions, &session);
    if (scenario_.bad_share > 0.0 && runs_[s].kind != Kind::kTouch && runs_[s].kind != Kind::kEccentricity) {
      base::Random random(base::StreamSeed(SeedOf(seed_, Stream::kBad), s));
      const std::vector<BadReading> bad =
          SpoilReadings(runs_[s], scenario_.bad_share, scenario_.noise.sigma_scale, &random, &session);
      out_.truth.bad.insert(out_.truth.bad.end(), bad.begin(), bad.end());
    }
    return session;
  }

  const machine::Machine& machine_;
  const Scenario& scenario_;
  const Form form_;
  const uint64_t seed_;
  std::vector<session::Session> sessions_;  // the fit's, then the check's; prepared, not measured
  std::vector<MeasuringRun> runs_;
  std::vector<SessionFaults> faults_;
  std::vector<std::vector<double>> errors_;  // of the truth's effects, at every moment
  SimulatedCase out_;
};

// The largest speed of every axis: what a servo does beyond it nobody measured.
std::vector<double> FastestOf(const History& history) {
  std::vector<double> fastest(history.axis_count, 0.0);
  for (size_t k = 0; k < history.size(); ++k) {
    for (int axis = 0; axis < history.axis_count; ++axis)
      fastest[axis] = std::max(fastest[axis], std::abs(history.AxisAt(k, axis).speed));
  }
  return fastest;
}

// The vector of a small rotation.
Eigen::Vector3d TurnOf(const Eigen::Matrix3d& rotation) {
  return 0.5 * Eigen::Vector3d(rotation(2, 1) - rotation(1, 2), rotation(0, 2) - rotation(2, 0),
                               rotation(1, 0) - rotation(0, 1));
}

}  // namespace

absl::StatusOr<SimulatedCase> RunScenario(const machine::Machine& machine, const Scenario& scenario,
                                          const PlannedCase& planned, Form form, uint64_t seed) {
  return Runner(machine, scenario, form, seed).Run(planned);
}

std::vector<ToolPointError> ErrorsAlong(const Truth& truth, const Eigen::Vector3d& tip_mm, const History& motion) {
  std::vector<std::vector<double>> of_effect;
  for (const Truth::NamedEffect& effect : truth.effects) of_effect.push_back(effect.drawn.Errors(motion));
  std::vector<ToolPointError> errors(motion.size());
  for (size_t k = 0; k < errors.size(); ++k) {
    machine::JointErrors<double> joints = machine::ErrorsAt(truth.machine, truth.errors, motion.StateOf(k));
    for (size_t i = 0; i < of_effect.size(); ++i) {
      const DrawnEffect& drawn = truth.effects[i].drawn;
      joints[drawn.joint][static_cast<int>(drawn.component)] += of_effect[i][k];
    }
    const auto pose = [&](const machine::JointErrors<double>& with) {
      return machine::EvaluateChain<double>(truth.machine, motion.PositionsOf(k), with);
    };
    const machine::ChainPose<double> actual = pose(joints), nominal = pose({});
    errors[k].shift_mm = machine::TipInTable(actual, tip_mm) - machine::TipInTable(nominal, tip_mm);
    errors[k].turn_rad = TurnOf(actual.bed_from_table.rotation.transpose() * actual.bed_from_tool.rotation *
                                nominal.bed_from_tool.rotation.transpose() * nominal.bed_from_table.rotation);
  }
  return errors;
}

History BoxPoses(const SimulatedCase& simulated, int count, uint64_t seed) {
  base::Random random(SeedOf(seed, Stream::kBox));
  const History& measured = simulated.history;
  const int axes = measured.axis_count;
  MeasuringRun run;
  run.axis_count = axes;
  run.has_time = true;
  run.measured_mm.setZero(1, count);
  constexpr double kStepS = 10.0, kPauseS = 100.0;
  const std::vector<double> fastest = FastestOf(measured);
  const auto anywhere = [&] {
    std::vector<double> target;
    for (int axis = 0; axis < axes; ++axis) {
      const Range range = RangeOf(measured, axis);
      target.push_back(range.low + range.length() * random.Uniform());
    }
    return target;
  };
  double time_s = std::ceil(measured.time_s.back()) + kPauseS;
  std::vector<double> from = anywhere();
  while (static_cast<int>(run.time_s.size()) < count) {
    const std::vector<double> to = anywhere();
    double needs_s = kStepS;
    for (int axis = 0; axis < axes; ++axis) {
      if (fastest[axis] > 0.0) needs_s = std::max(needs_s, std::ceil(std::abs(to[axis] - from[axis]) / fastest[axis]));
    }
    for (int k = 0; k < kPosesPerWay && static_cast<int>(run.time_s.size()) < count; ++k) {
      const double part = static_cast<double>(k) / kPosesPerWay;
      for (int axis = 0; axis < axes; ++axis) {
        const bool is_rotary = simulated.described.axes[axis].kind == machine::AxisKind::kRotary;
        const double unit = is_rotary ? base::kRadPerDeg : 1.0;
        const double position = from[axis] + part * (to[axis] - from[axis]);
        run.positions.push_back(std::round(1e6 * position / unit) / 1e6 * unit);
      }
      run.time_s.push_back(time_s + part * needs_s);
    }
    time_s += needs_s;
    from = to;
  }
  instruments::DeriveMotion(&run);
  std::map<std::string, std::vector<double>> celsius;
  for (const auto& [name, values] : measured.celsius) {
    std::vector<double>& at_poses = celsius[name];
    const auto given = std::find_if(simulated.truth.temperatures.begin(), simulated.truth.temperatures.end(),
                                    [&](const Temperature& one) { return one.name == name; });
    for (const double t : run.time_s) {
      const double value = given == simulated.truth.temperatures.end() ? values.back() : given->At(t);
      at_poses.push_back(std::round(1e3 * value) / 1e3);
    }
  }
  History motion;
  Append(run, celsius, &motion);
  return motion;
}

std::string WritePoses(const Truth& truth, const History& motion) {
  std::string text = "t_s";
  const machine::Machine& machine = truth.machine;
  for (const machine::Axis& axis : machine.axes)
    absl::StrAppend(&text, ",", axis.name, axis.kind == machine::AxisKind::kLinear ? "_mm" : "_deg");
  std::vector<const std::vector<double>*> recorded;
  for (const auto& [name, values] : motion.celsius) {
    const bool is_hidden = std::any_of(truth.temperatures.begin(), truth.temperatures.end(),
                                       [&](const Temperature& one) { return one.name == name && !one.is_recorded; });
    if (is_hidden) continue;
    absl::StrAppend(&text, ",", name);
    recorded.push_back(&values);
  }
  text += "\n";
  for (size_t k = 0; k < motion.size(); ++k) {
    absl::StrAppendFormat(&text, "%.10g", motion.time_s[k]);
    for (int axis = 0; axis < machine.axis_count(); ++axis) {
      const bool is_rotary = machine.axes[axis].kind == machine::AxisKind::kRotary;
      absl::StrAppendFormat(&text, ",%.10g", motion.PositionsOf(k)[axis] * (is_rotary ? base::kDegPerRad : 1.0));
    }
    for (const std::vector<double>* values : recorded) absl::StrAppendFormat(&text, ",%.10g", (*values)[k]);
    text += "\n";
  }
  return text;
}

std::string WriteTruthTable(const std::vector<ToolPointError>& errors) {
  std::string text = "ex_um,ey_um,ez_um,ea_urad,eb_urad,ec_urad\n";
  for (const ToolPointError& error : errors) {
    const Eigen::Vector3d um = base::kUmPerMm * error.shift_mm, urad = base::kUradPerRad * error.turn_rad;
    absl::StrAppendFormat(&text, "%.6f,%.6f,%.6f,%.6f,%.6f,%.6f\n", um.x(), um.y(), um.z(), urad.x(), urad.y(),
                          urad.z());
  }
  return text;
}

}  // namespace axiscal::synthetic
