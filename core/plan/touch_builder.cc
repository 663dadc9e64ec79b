#include "core/plan/touch_builder.h"

#include <algorithm>
#include <cmath>

#include "core/base/demand.h"
#include "core/base/units.h"
#include "core/instruments/centres/centres_model.h"
#include "core/machine/chain.h"
#include "core/plan/probing_program.h"
#include "core/plan/session_builder.h"

namespace axiscal::plan {
namespace {

constexpr double kSigmaMm = 1e-3;  // of one touch
constexpr double kSecondsPerTouch = 6.0;

std::string Numbers(const std::vector<double>& numbers) {
  std::string text;
  for (const double number : numbers) absl::StrAppend(&text, text.empty() ? "" : " ", absl::StrFormat("%.10g", number));
  return text;
}

std::string FaceName(const std::string& box, const Eigen::Vector3d& outward) {
  int along = 0;
  outward.cwiseAbs().maxCoeff(&along);
  return absl::StrCat(box, outward[along] < 0.0 ? "-" : "+", std::string(1, "xyz"[along]));
}

}  // namespace

TouchBuilder::TouchBuilder(const Situation& situation, const std::string& session, const Eigen::Vector3d& tip_mm)
    : situation_(situation), tip_mm_(tip_mm) {
  session_.header = {{"machine", situation.machine->id},
                     {"session", session},
                     {"instrument", "touch"},
                     {"sigma_um", Numbers({kSigmaMm * base::kUmPerMm})},
                     {"tool_tip_mm", Numbers({tip_mm.x(), tip_mm.y(), tip_mm.z()})},
                     {"stylus_radius_mm", Numbers({situation.stylus_radius_mm})}};
  session_.columns = ColumnsOf(situation);
  for (const char* name : {"nx", "ny", "nz", "feature"}) session_.columns.push_back({name, {}, {}});
}

void TouchBuilder::AddSphere(const std::string& name, const Eigen::Vector3d& centre_mm, double radius_mm) {
  spheres_.push_back({name, centre_mm, radius_mm});
  features_.push_back({"sphere " + name, Numbers({centre_mm.x(), centre_mm.y(), centre_mm.z(), radius_mm})});
}

void TouchBuilder::AddBox(const std::string& name, const Eigen::Vector3d& centre_mm, const Eigen::Vector3d& half_mm) {
  boxes_.push_back({name, centre_mm, half_mm});
  for (int along = 0; along < 3; ++along) {
    for (const double sign : {1.0, -1.0}) {
      const Eigen::Vector3d n = sign * Eigen::Vector3d::Unit(along), p = centre_mm + half_mm.cwiseProduct(n);
      features_.push_back({"plane " + FaceName(name, n), Numbers({p.x(), p.y(), p.z(), n.x(), n.y(), n.z()})});
    }
  }
}

Eigen::Vector3d TouchBuilder::Up(const std::vector<double>& rotary) const {
  const auto pose = machine::EvaluateChain<double>(*situation_.machine, rotary.data(), {});
  return -(pose.bed_from_tool.rotation * situation_.machine->tool_direction);
}

bool TouchBuilder::TouchSphere(const std::vector<double>& rotary, const std::string& name,
                               const Eigen::Vector3d& outward) {
  const auto sphere =
      std::find_if(spheres_.begin(), spheres_.end(), [&](const Sphere& one) { return one.name == name; });
  DEMAND(sphere != spheres_.end());
  const auto pose = machine::EvaluateChain<double>(*situation_.machine, rotary.data(), {});
  const Eigen::Vector3d n = pose.bed_from_table.rotation.transpose() * outward;
  return Add(rotary, name, sphere->centre_mm + sphere->radius_mm * n, n);
}

bool TouchBuilder::TouchFace(const std::vector<double>& rotary, const std::string& box, const Eigen::Vector3d& outward,
                             const Eigen::Vector3d& point_mm) {
  return Add(rotary, FaceName(box, outward), point_mm, outward);
}

// The stylus on its way up from `from_mm` (table at home) meets neither the table nor a box.
bool TouchBuilder::IsFree(const Eigen::Vector3d& from_mm, const Eigen::Vector3d& up) const {
  if (up.dot(table_normal_) < -1e-6) return false;
  constexpr double kSparedMm = 1.0;
  return std::none_of(boxes_.begin(), boxes_.end(), [&](const Box& box) {
    const Eigen::Vector3d half_mm = box.half_mm.array() + situation_.stylus_radius_mm + kSparedMm;
    double enter_mm = 0.0, leave_mm = INFINITY;  // along the way, within all three pairs of planes
    for (int i = 0; i < 3; ++i) {
      const double off_mm = from_mm[i] - box.centre_mm[i];
      if (std::abs(up[i]) < 1e-9) {
        if (std::abs(off_mm) > half_mm[i]) return false;
        continue;
      }
      const double a = (-half_mm[i] - off_mm) / up[i], b = (half_mm[i] - off_mm) / up[i];
      enter_mm = std::max(enter_mm, std::min(a, b));
      leave_mm = std::min(leave_mm, std::max(a, b));
    }
    return enter_mm <= leave_mm;
  });
}

bool TouchBuilder::Add(const std::vector<double>& rotary, const std::string& feature, const Eigen::Vector3d& contact_mm,
                       const Eigen::Vector3d& outward) {
  const machine::Machine& machine = *situation_.machine;
  const auto pose = machine::EvaluateChain<double>(machine, rotary.data(), {});
  const Eigen::Vector3d up = pose.bed_from_table.rotation.transpose() * Up(rotary);
  if (outward.dot(up) < -1e-6) return false;  // from below, where the stylus' stem would be in the way
  const Eigen::Vector3d stylus_mm = contact_mm + situation_.stylus_radius_mm * outward;
  if (!IsFree(stylus_mm + ProbingOptions().clearance_mm * outward, up)) return false;
  std::vector<double> commands = rotary;
  if (!centres::SolveNominalCommands(machine, tip_mm_, stylus_mm, commands.data()).ok()) return false;
  std::vector<session::Column>& columns = session_.columns;
  const double count = static_cast<double>(touch_count());
  columns[0].values.push_back(Rounded(situation_.start_s + count * kSecondsPerTouch));
  size_t column = 1;
  for (int axis = 0; axis < machine.axis_count(); ++axis) {
    const bool is_rotary = machine.axes[axis].kind == machine::AxisKind::kRotary;
    columns[column++].values.push_back(Rounded(commands[axis] * (is_rotary ? base::kDegPerRad : 1.0)));
  }
  if (situation_.has_temperature) columns[column++].values.push_back(Rounded(situation_.temperature_celsius));
  constexpr double kPerUnit = 1e6;
  const Eigen::Vector3d approach = -(pose.bed_from_table.rotation * outward);
  for (int i = 0; i < 3; ++i) columns[column++].values.push_back(std::round(approach[i] * kPerUnit) / kPerUnit + 0.0);
  columns[column].texts.push_back(feature);
  poses_.insert(rotary);
  return true;
}

PlannedSession TouchBuilder::Finish(const std::string& text) {
  const std::vector<std::string>& touched = session_.columns.back().texts;
  for (const session::HeaderEntry& feature : features_) {
    const std::string name = feature.key.substr(feature.key.find(' ') + 1);
    if (std::find(touched.begin(), touched.end(), name) != touched.end()) session_.header.push_back(feature);
  }
  return {std::move(session_), text};
}

}  // namespace axiscal::plan
