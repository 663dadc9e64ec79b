#include "core/published/yao_compensation.h"

#include <Eigen/Geometry>
#include <Eigen/LU>
#include <cmath>
#include <utility>

#include "core/base/units.h"
#include "core/identify/problem.h"
#include "core/published/sources.h"
#include "core/published/yao_machine.h"

namespace axiscal::published {
namespace {

using machine::Machine;

constexpr char kXyz[] = "XYZ";

// Commands of X, Y, Z and what they do, at one pose of the rotary axes.
class PoseView {
 public:
  PoseView(const Machine& machine, const Eigen::Vector3d& tool_tip_mm, const compensate::Pose& pose)
      : machine_(machine), tool_tip_mm_(tool_tip_mm), pose_(pose) {
    for (int i = 0; i < 3; ++i) axis_[i] = machine::FindAxis(machine, std::string(1, kXyz[i]));
    nominal_mm_ = TipMm(Command(), {});
  }

  Eigen::Vector3d Command() const { return Of(pose_.position); }
  Eigen::Vector3d Of(const compensate::AxisValues& values) const {
    return {values[axis_[0]], values[axis_[1]], values[axis_[2]]};
  }
  // B's pivot to the tool point, machine axes.
  Eigen::Vector3d LeverMm() const {
    const int b = machine::FindAxis(machine_, "B");
    const Eigen::AngleAxisd turn(pose_.position[b], machine_.axes[b].direction);
    return turn * (tool_tip_mm_ - machine_.axes[b].point_mm);
  }
  // Of the tool point in the table's frame, against the programmed one.
  Eigen::Vector3d ErrorMm(const Eigen::Vector3d& command_mm, const machine::ErrorModel& errors) const {
    return TipMm(command_mm, errors) - nominal_mm_;
  }

 private:
  Eigen::Vector3d TipMm(const Eigen::Vector3d& command_mm, const machine::ErrorModel& errors) const {
    compensate::AxisValues at = pose_.position;
    for (int i = 0; i < 3; ++i) at[axis_[i]] = command_mm[i];
    std::array<shapes::AxisState, machine::kMaxAxes> axes;
    for (int i = 0; i < machine_.axis_count(); ++i) {
      axes[i].position = at[i];
      axes[i].sense = pose_.sense[i];
    }
    shapes::State state;
    state.axes = {axes.data(), static_cast<size_t>(machine_.axis_count())};
    const auto chain = machine::EvaluateChain<double>(machine_, at.data(), machine::ErrorsAt(machine_, errors, state));
    return machine::TipInTable(chain, tool_tip_mm_);
  }

  const Machine& machine_;
  const Eigen::Vector3d tool_tip_mm_;
  const compensate::Pose& pose_;
  int axis_[3] = {};
  Eigen::Vector3d nominal_mm_;
};

// Covariance of the tool point's error at a command, by that of the errors; NaN where one of them has none.
Eigen::Matrix3d TipCovariance(const PoseView& view, const Eigen::Vector3d& command_mm,
                              const identify::HeldErrors& errors) {
  const std::vector<identify::Parameter> parameters = identify::ListParameters(errors.model, true);
  Eigen::Matrix3Xd slope(3, parameters.size());  // per mm or rad
  for (size_t i = 0; i < parameters.size(); ++i) {
    const double sigma = errors.errors[i].sigma;
    if (!(sigma > 0.0)) return Eigen::Matrix3d::Constant(NAN);
    const auto moved = [&](double by) {
      machine::ErrorModel model = errors.model;
      identify::SetValue(parameters[i], identify::ValueOf(model, parameters[i]) + by, &model);
      return view.ErrorMm(command_mm, model);
    };
    slope.col(static_cast<Eigen::Index>(i)) = (moved(sigma) - moved(-sigma)) / (2.0 * sigma);
  }
  return slope * errors.covariance * slope.transpose();
}

absl::StatusOr<identify::Estimate> Tilt(const identify::HeldErrors& errors) {
  for (const identify::Estimate& error : errors.errors) {
    if (error.name == "EB0B") return error;
  }
  return absl::InvalidArgumentError("expected EB0B among the errors: it is all that the published rule corrects");
}

absl::StatusOr<Comparison> ByRule(const Machine& machine, const Program& program, double times, const char* formula) {
  RETURN_IF_ERROR(CheckYaoMachine(machine));
  ASSIGN_OR_RETURN(const identify::Estimate tilt, Tilt(program.errors));
  const double b = tilt.value;
  compensate::Options options;
  options.tool_tip_mm = program.tool_tip_mm;
  ASSIGN_OR_RETURN(const auto compensator, compensate::Compensator::Create(machine, program.errors.model, options));
  if (!compensator.not_carried().empty())
    return absl::InvalidArgumentError(compensator.not_carried()[0] + ": expected errors of axis positions only");
  Comparison out;
  double worst_mm = 0.0, before_mm = 0.0;
  for (const nc::ProgramPose& pose : program.poses) {
    const PoseView view(machine, program.tool_tip_mm, pose.pose);
    const auto correction = compensator.Correct(pose.pose);
    if (!correction.ok()) return base::Within(absl::StrCat("line ", pose.line), correction.status());
    const Eigen::Vector3d command_mm = view.Command(), lever_mm = view.LeverMm();
    const Eigen::Vector3d published_mm = YaoRule(command_mm, -b, times);  // printed with the other sign
    const Eigen::Vector3d corrected_mm = command_mm + (YaoRule(lever_mm, b) - lever_mm);
    const Eigen::Vector3d exact_mm = view.Of(correction->corrected);
    Eigen::Matrix3d tip_per_mm;
    for (int k = 0; k < 3; ++k) {
      const std::string& name = machine.axes[compensator.linear_axes()[k]].name;
      tip_per_mm.col(std::string(kXyz).find(name)) = correction->tip_per_mm[k];
    }
    const Eigen::Matrix3d of_tip = TipCovariance(view, exact_mm, program.errors), back = tip_per_mm.inverse();
    const Eigen::Matrix3d of_command = back * of_tip * back.transpose();
    struct Three {
      Eigen::Vector3d mm, sigma_mm;
    };
    const auto add = [&](const std::string& what, const Three& published, const Eigen::Vector3d& corrected,
                         const Three& exact) {
      for (int i = 0; i < 3; ++i) {
        Row& row = out.rows.emplace_back();
        row.quantity = absl::StrCat(what, " ", std::string(1, kXyz[i]), ", line ", pose.line);
        row.unit = "um";
        row.published = base::kUmPerMm * published.mm[i];
        row.published_sigma = base::kUmPerMm * published.sigma_mm[i];
        row.corrected = base::kUmPerMm * corrected[i];
        row.exact = base::kUmPerMm * exact.mm[i];
        row.sigma = base::kUmPerMm * exact.sigma_mm[i];
        row.formula = formula;
      }
    };
    const auto sigma_of = [](const Eigen::Matrix3d& covariance) -> Eigen::Vector3d {
      return covariance.diagonal().cwiseSqrt();
    };
    add("change of", {published_mm - command_mm, (YaoRule(command_mm, tilt.sigma, times) - command_mm).cwiseAbs()},
        corrected_mm - command_mm, {exact_mm - command_mm, sigma_of(of_command)});
    const Eigen::Vector3d left_mm = view.ErrorMm(published_mm, program.errors.model);
    add("left in", {left_mm, sigma_of(TipCovariance(view, published_mm, program.errors))},
        view.ErrorMm(corrected_mm, program.errors.model),
        {view.ErrorMm(exact_mm, program.errors.model), sigma_of(of_tip)});
    worst_mm = std::max(worst_mm, left_mm.norm());
    before_mm = std::max(before_mm, correction->before_mm);
  }
  out.notes.push_back(absl::StrFormat(
      "tool-point error, table frame: at most %.2f um without any correction, %.2f um with the published one",
      base::kUmPerMm * before_mm, base::kUmPerMm * worst_mm));
  out.notes.push_back(
      "corrected: b with the model's sign (printed wrong in Table 2.6) and the tool point from B's pivot for the "
      "command's place from the machine's origin; first order, EB0B alone");
  if (times != 1.0) out.notes.push_back("equation 3.13 corrects twice as printed");
  if (program.errors.model.terms.size() > 1)
    out.notes.push_back("the published rule knows EB0B alone; exact takes all errors that are given");
  return out;
}

}  // namespace

Eigen::Vector3d YaoRule(const Eigen::Vector3d& command_mm, double b_rad, double times) {
  const double b = times * b_rad;
  return {command_mm.x() - b * command_mm.z(), command_mm.y(), command_mm.z() + b * command_mm.x()};
}

absl::StatusOr<Comparison> YaoCompensation(const Machine& machine, const Program& program) {
  return ByRule(machine, program, 1.0, "X - b Z, Y, Z + b X, b = ezBX / R_B");
}

absl::StatusOr<Comparison> YaoEquation313(const Machine& machine, const Program& program) {
  return ByRule(machine, program, kTimesOfYao313, "X - 2 b Z, Y, Z + 2 b X, b = ezBX / R_B");
}

}  // namespace axiscal::published
