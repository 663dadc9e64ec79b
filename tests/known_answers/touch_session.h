// A session of touches on plane faces as a cell would plan it, without readings: the simulator moves the linear axes to
// where the probe triggers.
#ifndef AXISCAL_TESTS_KNOWN_ANSWERS_TOUCH_SESSION_H_
#define AXISCAL_TESTS_KNOWN_ANSWERS_TOUCH_SESSION_H_

#include <map>
#include <string>

#include "absl/strings/str_cat.h"
#include "absl/strings/str_format.h"
#include "core/base/demand.h"
#include "core/base/units.h"
#include "core/instruments/centres/centres_model.h"
#include "core/machine/chain.h"
#include "core/session/session.h"

namespace axiscal::known_answers {

struct Face {
  Eigen::Vector3d point_mm, normal;  // table frame at home; outward
};

class TouchSession {
 public:
  TouchSession(const machine::Machine& machine, const std::string& name, const Eigen::Vector3d& tip_mm,
               double stylus_radius_mm, double sigma_um)
      : machine_(machine), tip_mm_(tip_mm), stylus_radius_mm_(stylus_radius_mm) {
    session_.header = {{"machine", machine.id},       {"session", name},
                       {"instrument", "touch"},       {"sigma_um", absl::StrCat(sigma_um)},
                       {"tool_tip_mm", Text(tip_mm)}, {"stylus_radius_mm", absl::StrCat(stylus_radius_mm)}};
    session_.columns.push_back({"t_s", {}, {}});
    for (const machine::Axis& axis : machine.axes) {
      const bool is_linear = axis.kind == machine::AxisKind::kLinear;
      session_.columns.push_back({axis.name + (is_linear ? "_mm" : "_deg"), {}, {}});
    }
    for (const char* column : {"nx", "ny", "nz", "feature"}) session_.columns.push_back({column, {}, {}});
  }

  void Header(const std::string& key, const std::string& value) { session_.header.push_back({key, value}); }

  void AddFace(const std::string& name, const Face& face) {
    Header("plane " + name, absl::StrCat(Text(face.point_mm), " ", Text(face.normal)));
    faces_[name] = face;
  }

  // Touches the face `aside_mm` from its point, the rotary axes at `rotary_deg` (others at zero).
  void Touch(const std::string& name, const std::map<std::string, double>& rotary_deg,
             const Eigen::Vector3d& aside_mm = Eigen::Vector3d::Zero()) {
    const Face& face = faces_.at(name);
    std::vector<double> positions(machine_.axis_count(), 0.0);
    for (const auto& [axis, deg] : rotary_deg) positions[machine::FindAxis(machine_, axis)] = deg * base::kRadPerDeg;
    const Eigen::Vector3d stylus_mm = face.point_mm + aside_mm + stylus_radius_mm_ * face.normal;
    const absl::Status reached = centres::SolveNominalCommands(machine_, tip_mm_, stylus_mm, positions.data());
    DEMAND(reached.ok());
    const auto pose = machine::EvaluateChain<double>(machine_, positions.data(), {});
    const Eigen::Vector3d approach = -(pose.bed_from_table.rotation * face.normal);
    constexpr double kSecondsPerTouch = 10.0;
    size_t column = 0;
    session_.columns[column].values.push_back(kSecondsPerTouch * static_cast<double>(session_.reading_count()));
    for (int axis = 0; axis < machine_.axis_count(); ++axis) {
      const bool is_linear = machine_.axes[axis].kind == machine::AxisKind::kLinear;
      const auto commanded = rotary_deg.find(machine_.axes[axis].name);
      const double angle_deg = commanded == rotary_deg.end() ? 0.0 : commanded->second;
      session_.columns[++column].values.push_back(is_linear ? positions[axis] : angle_deg);
    }
    for (int i = 0; i < 3; ++i) session_.columns[++column].values.push_back(approach[i]);
    session_.columns[++column].texts.push_back(name);
  }

  const session::Session& planned() const { return session_; }

 private:
  static std::string Text(const Eigen::Vector3d& v) {
    return absl::StrFormat("%.10g %.10g %.10g", v.x(), v.y(), v.z());
  }

  const machine::Machine& machine_;
  const Eigen::Vector3d tip_mm_;
  const double stylus_radius_mm_;
  session::Session session_;
  std::map<std::string, Face> faces_;
};

}  // namespace axiscal::known_answers

#endif  // AXISCAL_TESTS_KNOWN_ANSWERS_TOUCH_SESSION_H_
