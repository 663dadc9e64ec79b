#include "core/synthetic/fault.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <numbers>

#include "core/instruments/tracker/tracker_model.h"
#include "core/machine/chain.h"
#include "core/synthetic/forms.h"

namespace axiscal::synthetic {
namespace {

using Eigen::Vector3d;
using instruments::Carrier;
using instruments::Kind;
using instruments::MeasuringRun;

// Whether an instrument can have the fault; nothing is simulated for those that cannot.
bool CanHave(const MeasuringRun& run, const Fault& fault) {
  const bool reads_ball = run.kind == Kind::kBallbar || run.kind == Kind::kRtest;
  switch (fault.kind) {
    case FaultKind::kGain:
      return reads_ball;
    case FaultKind::kScale:
      return run.kind == Kind::kBallbar || run.kind == Kind::kTracker;
    case FaultKind::kBall:
    case FaultKind::kLobes:
      // The sensors of an R-test stand on the table: they see the ball in the spindle from all sides as the table
      // turns.
      return run.kind == Kind::kBallbar || (run.kind == Kind::kRtest && fault.carrier == Carrier::kTool);
    case FaultKind::kGrowth:
      return reads_ball || run.kind == Kind::kTracker;
    case FaultKind::kClock:
    case FaultKind::kLoggedLate:
      return reads_ball || run.kind == Kind::kTracker;
    case FaultKind::kMotion:
    case FaultKind::kSlip:
      return run.kind != Kind::kEccentricity;
  }
  return false;
}

bool IsNamed(const Fault& fault, const std::string& session) {
  return fault.sessions.empty() ||
         std::find(fault.sessions.begin(), fault.sessions.end(), session) != fault.sessions.end();
}

// The direction from the ball's centre to where row `row` touches it, in the frame of the ball's carrier; unit.
Vector3d ContactDirection(const machine::Machine& machine, const MeasuringRun& run, int reading, int row,
                          Carrier carrier) {
  const machine::ChainPose<double> pose =
      machine::EvaluateChain<double>(machine, run.PositionsOf(reading), machine::JointErrors<double>());
  Vector3d in_bed = pose.bed_from_table.rotation.col(row);
  if (run.kind == Kind::kBallbar) {
    in_bed = (pose.bed_from_tool * run.tip_mm - pose.bed_from_table * run.ball_mm).normalized();
    if (carrier == Carrier::kTool) in_bed = -in_bed;
  }
  const Eigen::Matrix3d& turned =
      carrier == Carrier::kTool ? pose.bed_from_tool.rotation : pose.bed_from_table.rotation;
  return turned.transpose() * in_bed;
}

// How far the ball's surface is off at a direction; no unit.
using Surface = std::function<double(const Vector3d& direction)>;

Vector3d AnyDirection(base::Random* random) {
  return Vector3d(random->Normal(), random->Normal(), random->Normal()).normalized();
}

// Own: spherical harmonics of second degree. Independent: six bumps.
Surface OutOfRound(Form form, base::Random* random) {
  if (form == Form::kOwn) {
    Eigen::Matrix<double, 5, 1> weights;
    for (double& weight : weights) weight = random->Normal();
    return [weights](const Vector3d& d) {
      return weights[0] * (d.x() * d.x() - d.y() * d.y()) / 2.0 + weights[1] * d.x() * d.y() +
             weights[2] * d.x() * d.z() + weights[3] * d.y() * d.z() +
             weights[4] * (3.0 * d.z() * d.z() - 1.0) / std::sqrt(12.0);
    };
  }
  std::vector<std::pair<Vector3d, double>> bumps(6);
  for (auto& [centre, height] : bumps) {
    centre = AnyDirection(random);
    height = random->Normal();
  }
  return [bumps](const Vector3d& d) {
    double sum = 0.0;
    for (const auto& [centre, height] : bumps) sum += height * std::exp(3.0 * (d.dot(centre) - 1.0));
    return sum;
  };
}

// Own: sin t cos(n f - phase). Independent: bumps in place of the cosine.
Surface Lobed(Form form, int order, const Vector3d& axis, base::Random* random) {
  const double phase = 2.0 * std::numbers::pi * random->Uniform();
  const Vector3d first = axis.unitOrthogonal(), second = axis.cross(first);
  return [=](const Vector3d& d) {
    const double x = d.dot(first), y = d.dot(second);
    const double wave = std::cos(order * std::atan2(y, x) - phase);
    return std::hypot(x, y) * (form == Form::kOwn ? wave : std::exp(wave));
  };
}

// Every number of a session's readings, or of all sessions.
class Offsets {
 public:
  explicit Offsets(const std::vector<MeasuringRun>& runs) {
    for (const MeasuringRun& run : runs)
      of_session_.push_back(Eigen::MatrixXd::Zero(run.row_count, run.reading_count()));
  }
  double& At(size_t session, int row, int reading) { return of_session_[session](row, reading); }
  // Adds all to the sessions' faults, scaled. False where they do not vary.
  bool AddTo(const std::vector<bool>& acts, double rms_mm, std::vector<SessionFaults>* faults) {
    std::vector<double> values;
    for (size_t s = 0; s < of_session_.size(); ++s) {
      if (acts[s]) values.insert(values.end(), of_session_[s].data(), of_session_[s].data() + of_session_[s].size());
    }
    const double rms = RmsAboutMean(values);
    if (!(rms > 1e-9)) return false;
    for (size_t s = 0; s < of_session_.size(); ++s) {
      if (!acts[s]) continue;
      Eigen::MatrixXd& offset = (*faults)[s].offset_mm;
      if (offset.size() == 0) offset.setZero(of_session_[s].rows(), of_session_[s].cols());
      offset += rms_mm / rms * of_session_[s];
    }
    return true;
  }

 private:
  std::vector<Eigen::MatrixXd> of_session_;
};

class Drawer {
 public:
  Drawer(const machine::Machine& machine, Form form, const std::vector<MeasuringRun>& runs, const History& plan)
      : machine_(machine), form_(form), runs_(runs), plan_(plan), out_(runs.size()) {}

  absl::Status Add(const Fault& fault, base::Random* random) {
    acts_.assign(runs_.size(), false);
    for (const std::string& name : fault.sessions) {
      const auto is_it = [&](const MeasuringRun& run) { return run.session == name; };
      if (std::none_of(runs_.begin(), runs_.end(), is_it))
        return absl::InvalidArgumentError(absl::StrCat("the plan has no session '", name, "'"));
    }
    for (size_t s = 0; s < runs_.size(); ++s) {
      acts_[s] = IsNamed(fault, runs_[s].session) && CanHave(runs_[s], fault);
      if (!acts_[s] && !fault.sessions.empty() && IsNamed(fault, runs_[s].session))
        return absl::InvalidArgumentError(
            absl::StrCat("the instrument of session '", runs_[s].session, "' cannot have this fault"));
    }
    if (std::none_of(acts_.begin(), acts_.end(), [](bool acts) { return acts; }))
      return absl::InvalidArgumentError("no session of the plan has an instrument with this fault");
    return Draw(fault, random);
  }
  std::vector<SessionFaults> Take() { return std::move(out_); }

 private:
  absl::Status Draw(const Fault& fault, base::Random* random) {
    switch (fault.kind) {
      case FaultKind::kGain:
        return DrawGain(fault, random);
      case FaultKind::kScale:
        return DrawScale(fault);
      case FaultKind::kBall:
        return DrawSurface(fault, OutOfRound(form_, random));
      case FaultKind::kLobes:
        return DrawSurface(
            fault, Lobed(form_, fault.order,
                         fault.carrier == Carrier::kTool ? machine_.tool_direction : Vector3d::UnitZ(), random));
      case FaultKind::kGrowth:
        return DrawGrowth(fault, random);
      case FaultKind::kMotion:
        return DrawMotion(fault, random);
      case FaultKind::kClock:
        return DrawClock(fault);
      case FaultKind::kLoggedLate:
        return DrawLog(fault);
      case FaultKind::kSlip:
        return DrawSlip(fault);
    }
    return absl::OkStatus();
  }

  absl::Status DrawGain(const Fault& fault, base::Random* random) {
    Eigen::Matrix3d gain = Eigen::Matrix3d::Identity();
    for (int i = 0; i < 3; ++i) {
      for (int j = 0; j < 3; ++j) {
        const double draw = 2.0 * random->Uniform() - 1.0;
        gain(i, j) += i == j ? std::copysign(fault.gain, draw) : fault.crosstalk * draw;
      }
    }
    constexpr double kSaturationMm = 0.05;  // a sensor that is set up is read within some tens of um
    for (size_t s = 0; s < runs_.size(); ++s) {
      if (!acts_[s]) continue;
      out_[s].gain = gain;
      out_[s].saturation_mm = form_ == Form::kOwn ? 0.0 : kSaturationMm;
    }
    return absl::OkStatus();
  }

  // Own: in proportion to T - 20. Independent: growing faster as it warms.
  absl::Status DrawScale(const Fault& fault) {
    for (size_t s = 0; s < runs_.size(); ++s) {
      if (!acts_[s]) continue;
      Eigen::VectorXd& scale = out_[s].scale;
      if (scale.size() == 0) scale.setZero(runs_[s].reading_count());
      for (int k = 0; k < runs_[s].reading_count(); ++k) {
        const double warmer = runs_[s].temperature_celsius[k] - shapes::kReferenceTemperatureCelsius;
        scale[k] += fault.scale + fault.scale_per_kelvin * warmer * (form_ == Form::kOwn ? 1.0 : 1.0 + 0.03 * warmer);
      }
    }
    return absl::OkStatus();
  }

  absl::Status DrawSurface(const Fault& fault, const Surface& surface) {
    Offsets offsets(runs_);
    for (size_t s = 0; s < runs_.size(); ++s) {
      if (!acts_[s]) continue;
      for (int k = 0; k < runs_[s].reading_count(); ++k) {
        for (int row = 0; row < runs_[s].row_count; ++row)
          offsets.At(s, row, k) = surface(ContactDirection(machine_, runs_[s], k, row, fault.carrier));
      }
    }
    if (!offsets.AddTo(acts_, fault.rms_mm, &out_))
      return absl::InvalidArgumentError("all readings touch the ball at one point, expected a plan that goes round it");
    return absl::OkStatus();
  }

  // Own: 1 - exp(-t / tau). Independent: t / (t + tau).
  absl::Status DrawGrowth(const Fault& fault, base::Random* random) {
    Offsets offsets(runs_);
    Vector3d along = AnyDirection(random);
    for (size_t s = 0; s < runs_.size(); ++s) {
      if (!acts_[s]) continue;
      for (int k = 0; k < runs_[s].reading_count(); ++k) {
        const double t = runs_[s].time_s[k] - runs_[s].time_s[0];
        const double grown = form_ == Form::kOwn ? 1.0 - std::exp(-t / fault.tau_s) : t / (t + fault.tau_s);
        for (int row = 0; row < runs_[s].row_count; ++row)
          offsets.At(s, row, k) = grown * (runs_[s].row_count == 1 ? 1.0 : along[row]);
      }
    }
    if (!offsets.AddTo(acts_, fault.rms_mm, &out_))
      return absl::InvalidArgumentError("the sessions take no time, expected t_s that runs on");
    return absl::OkStatus();
  }

  // A slow curve in time for each direction (and turn of a tracker).
  absl::Status DrawMotion(const Fault& fault, base::Random* random) {
    const Range range = RangeOf(plan_, -1);
    if (!(range.length() > 0.0)) return absl::InvalidArgumentError("the plan takes no time, expected t_s that runs on");
    std::vector<Function> moves;
    for (int i = 0; i < 6; ++i) {
      moves.push_back(form_ == Form::kOwn ? OwnFunction(range, range.length() / 4.0, false, random)
                                          : IndependentFunction(range, range.length() / 4.0, false, random));
    }
    std::vector<double> values;
    for (size_t s = 0; s < runs_.size(); ++s) {
      for (int k = 0; acts_[s] && k < runs_[s].reading_count(); ++k) {
        for (int i = 0; i < 3; ++i) values.push_back(moves[i](runs_[s].time_s[k]));
      }
    }
    const double factor = fault.rms_mm / RmsAboutMean(values);
    for (size_t s = 0; s < runs_.size(); ++s) {
      if (acts_[s]) Move(fault, moves, factor, s);
    }
    return absl::OkStatus();
  }

  void Move(const Fault& fault, const std::vector<Function>& moves, double factor, size_t s) {
    constexpr double kLeverMm = 1000.0;  // a tracker's stand turns by its shift over its height
    const MeasuringRun& run = runs_[s];
    const bool is_tracker = run.kind == Kind::kTracker && fault.carrier == Carrier::kTable;
    for (int k = 0; k < run.reading_count(); ++k) {
      Vector3d shift_mm, turn_rad;
      for (int i = 0; i < 3; ++i) {
        shift_mm[i] = factor * moves[i](run.time_s[k]);
        turn_rad[i] = factor / kLeverMm * moves[i + 3](run.time_s[k]);
      }
      if (!is_tracker) {
        MovedOf(fault.carrier, s).col(k) += shift_mm;
        continue;
      }
      Eigen::MatrixXd& offset = out_[s].offset_mm;
      if (offset.size() == 0) offset.setZero(3, run.reading_count());
      // The tracker's origin is where the scenario's set-up puts it: about the middle of what it sees.
      offset.col(k) += shift_mm + turn_rad.cross(run.tracker_from_machine * PlaceInBed(run, k));
    }
  }

  // Of the target that a tracker sees.
  Vector3d PlaceInBed(const MeasuringRun& run, int reading) const {
    const Vector3d& nominal_mm = tracker::NominalPlace(run, reading);
    if (run.targets.IsReference(reading)) return nominal_mm;
    return machine::EvaluateChain<double>(machine_, run.PositionsOf(reading), machine::JointErrors<double>())
               .bed_from_tool *
           nominal_mm;
  }

  Eigen::Matrix3Xd& MovedOf(Carrier carrier, size_t s) {
    Eigen::Matrix3Xd& moved = carrier == Carrier::kTable ? out_[s].table_mm : out_[s].tool_mm;
    if (moved.size() == 0) moved.setZero(3, runs_[s].reading_count());
    return moved;
  }

  // The moments of a session in the plan's history.
  size_t FirstMoment(size_t s) const { return plan_.session_begin[s]; }

  // Own: q - delay x speed, and the delay is constant. Independent: the path itself at the delayed time, and the two
  // clocks run apart by half of the delay over the plan.
  absl::Status DrawClock(const Fault& fault) {
    const Range range = RangeOf(plan_, -1);
    for (int axis = 0; axis < machine_.axis_count(); ++axis) {
      const Path path(plan_, axis);
      for (size_t s = 0; s < runs_.size(); ++s) {
        if (!acts_[s]) continue;
        std::vector<double>& read = out_[s].read_positions;
        if (read.empty()) read = runs_[s].positions;
        for (int k = 0; k < runs_[s].reading_count(); ++k) {
          const shapes::AxisState& state = plan_.AxisAt(FirstMoment(s) + k, axis);
          double off = -fault.delay_s * state.speed;
          if (form_ == Form::kIndependent) {
            const double t = runs_[s].time_s[k], share = range.length() > 0.0 ? (t - range.low) / range.length() : 0.0;
            const double from_s = runs_[s].time_s.front(), to_s = runs_[s].time_s.back();
            off = path.PositionAt(std::clamp(t - fault.delay_s * (0.75 + 0.5 * share), from_s, to_s)) - state.position;
          }
          read[static_cast<size_t>(k) * runs_[s].axis_count + axis] += off;
        }
      }
    }
    return absl::OkStatus();
  }

  // Own: q - delay x speed. Independent: a filter of first order that follows the path.
  absl::Status DrawLog(const Fault& fault) {
    for (int axis = 0; axis < machine_.axis_count(); ++axis) {
      const Path path(plan_, axis);
      for (size_t s = 0; s < runs_.size(); ++s) {
        if (!acts_[s]) continue;
        std::vector<double>& shown = out_[s].shown_positions;
        if (shown.empty()) shown = runs_[s].positions;
        const size_t first = FirstMoment(s);
        double off = -fault.delay_s * path.SpeedOf(first);
        for (int k = 0; k < runs_[s].reading_count(); ++k) {
          if (form_ == Form::kOwn) {
            off = -fault.delay_s * plan_.AxisAt(first + k, axis).speed;
          } else if (k > 0) {
            const double from_s = runs_[s].time_s[k - 1], elapsed_s = runs_[s].time_s[k] - from_s;
            const int steps =
                static_cast<int>(std::clamp(std::ceil(20.0 * elapsed_s / std::abs(fault.delay_s)), 1.0, 1e4));
            const double h = elapsed_s / steps, keeps = std::exp(-h / std::abs(fault.delay_s));
            for (int i = 0; i < steps; ++i) {
              const double speed = path.At(first + k - 1, from_s + (i + 0.5) * h).speed;
              off = off * keeps - fault.delay_s * speed * (1.0 - keeps);
            }
          }
          shown[static_cast<size_t>(k) * runs_[s].axis_count + axis] += off;
        }
      }
    }
    return absl::OkStatus();
  }

  absl::Status DrawSlip(const Fault& fault) {
    for (size_t s = 0; s < runs_.size(); ++s) {
      if (!acts_[s]) continue;
      const int first = static_cast<int>(std::lround(fault.at * runs_[s].reading_count()));
      // A tracker does not stand on the table: it is knocked itself, and all that it sees seems to go.
      if (runs_[s].kind == Kind::kTracker && fault.carrier == Carrier::kTable) {
        Eigen::MatrixXd& offset = out_[s].offset_mm;
        if (offset.size() == 0) offset.setZero(3, runs_[s].reading_count());
        for (int k = first; k < runs_[s].reading_count(); ++k) offset.col(k) += fault.moved_mm;
        continue;
      }
      for (int k = first; k < runs_[s].reading_count(); ++k) MovedOf(fault.carrier, s).col(k) += fault.moved_mm;
    }
    return absl::OkStatus();
  }

  const machine::Machine& machine_;
  const Form form_;
  const std::vector<MeasuringRun>& runs_;
  const History& plan_;
  std::vector<bool> acts_;
  std::vector<SessionFaults> out_;
};

}  // namespace

const char* const* FaultWords() {
  static const char* const kWords[] = {"gain",   "scale", "ball",        "lobes", "growth",
                                       "motion", "clock", "logged-late", "slip",  nullptr};
  return kWords;
}

absl::StatusOr<std::vector<SessionFaults>> DrawFaults(const machine::Machine& machine, const std::vector<Fault>& faults,
                                                      Form form, const std::vector<MeasuringRun>& runs,
                                                      const History& plan, uint64_t seed) {
  Drawer drawer(machine, form, runs, plan);
  for (size_t i = 0; i < faults.size(); ++i) {
    base::Random random(base::StreamSeed(seed, i));
    const absl::Status drawn = drawer.Add(faults[i], &random);
    if (!drawn.ok())
      return base::Within(absl::StrCat("faults[", i, "] (", FaultWords()[static_cast<int>(faults[i].kind)], ")"),
                          drawn);
  }
  return drawer.Take();
}

void Distort(const SessionFaults& faults, const MeasuringRun& run, int reading, double* reading_mm) {
  const int rows = run.row_count;
  Vector3d sound = Vector3d::Zero();
  for (int row = 0; row < rows; ++row) sound[row] = reading_mm[row];
  Vector3d felt = sound;
  if (faults.saturation_mm > 0.0) {
    for (double& value : felt) value = faults.saturation_mm * std::tanh(value / faults.saturation_mm);
  }
  const Vector3d added = (faults.gain - Eigen::Matrix3d::Identity()) * felt;
  for (int row = 0; row < rows; ++row) {
    reading_mm[row] += added[row];
    // What is scaled is the whole length: the bar with its change, or where the tracker sees the target.
    if (faults.scale.size() > 0) reading_mm[row] += faults.scale[reading] * (sound[row] + run.bar_length_mm);
    if (faults.offset_mm.size() > 0) reading_mm[row] += faults.offset_mm(row, reading);
  }
}

}  // namespace axiscal::synthetic
