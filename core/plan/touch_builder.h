// Writes a planned `touch` session touch by touch: which feature, where on it. Axis positions follow from the
// nominal chain. A touch that the stylus cannot begin and leave along the tool is left out.
#ifndef AXISCAL_CORE_PLAN_TOUCH_BUILDER_H_
#define AXISCAL_CORE_PLAN_TOUCH_BUILDER_H_

#include <set>
#include <string>
#include <vector>

#include "core/plan/situation.h"
#include "core/plan/test.h"

namespace axiscal::plan {

class TouchBuilder {
 public:
  TouchBuilder(const Situation& situation, const std::string& session, const Eigen::Vector3d& tip_mm);

  // Features, table frame at home. A box stands in the way of touches; its faces are named, "block+x".
  void AddSphere(const std::string& name, const Eigen::Vector3d& centre_mm, double radius_mm);
  void AddBox(const std::string& name, const Eigen::Vector3d& centre_mm, const Eigen::Vector3d& half_mm);

  // The artefact stands on a table whose surface faces `normal` (unit, table at home): no path goes through the table.
  void SetTable(const Eigen::Vector3d& normal) { table_normal_ = normal; }

  // The sphere from the side `outward` (unit, bed's axes), or the face of a box whose outward normal is `outward`
  // (unit, table at home) at `point_mm` on it. `rotary`: per axis, rad; linear ones do not count. False: left out.
  bool TouchSphere(const std::vector<double>& rotary, const std::string& name, const Eigen::Vector3d& outward);
  bool TouchFace(const std::vector<double>& rotary, const std::string& box, const Eigen::Vector3d& outward,
                 const Eigen::Vector3d& point_mm);

  // Towards the spindle at this pose, bed's axes.
  Eigen::Vector3d Up(const std::vector<double>& rotary) const;
  int touch_count() const { return static_cast<int>(session_.columns[0].values.size()); }
  // Positions of the rotary axes at which something is touched.
  int pose_count() const { return static_cast<int>(poses_.size()); }
  // Only the features that were touched.
  PlannedSession Finish(const std::string& text);

 private:
  struct Box {
    std::string name;
    Eigen::Vector3d centre_mm, half_mm;
  };

  struct Sphere {
    std::string name;
    Eigen::Vector3d centre_mm;
    double radius_mm;
  };

  bool IsFree(const Eigen::Vector3d& from_mm, const Eigen::Vector3d& up) const;
  bool Add(const std::vector<double>& rotary, const std::string& feature, const Eigen::Vector3d& contact_mm,
           const Eigen::Vector3d& outward);

  const Situation& situation_;
  const Eigen::Vector3d tip_mm_;
  session::Session session_;
  std::vector<session::HeaderEntry> features_;
  std::vector<Sphere> spheres_;
  std::vector<Box> boxes_;
  std::set<std::vector<double>> poses_;
  Eigen::Vector3d table_normal_ = Eigen::Vector3d::Zero();
};

}  // namespace axiscal::plan

#endif  // AXISCAL_CORE_PLAN_TOUCH_BUILDER_H_
