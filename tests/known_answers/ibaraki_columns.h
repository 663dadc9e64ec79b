// Three square columns on a tilting rotary table (Ibaraki, Iritani, Matsushita): where they are touched, and what the
// table does with them. Frames: machine = table at home, its origin where A and C meet.
#ifndef AXISCAL_TESTS_KNOWN_ANSWERS_IBARAKI_COLUMNS_H_
#define AXISCAL_TESTS_KNOWN_ANSWERS_IBARAKI_COLUMNS_H_

#include <Eigen/Geometry>
#include <Eigen/QR>
#include <array>
#include <vector>

#include "core/base/units.h"
#include "core/machine/chain.h"
#include "tests/known_answers/published_machine.h"
#include "tests/known_answers/touch_session.h"

namespace axiscal::known_answers {

inline constexpr double kTiltsDeg[] = {0, -30, -60, -90}, kTurnsDeg[] = {0, 60, 120, 180, 240, 300};
inline constexpr int kJointA = 3, kJointC = 4;  // order of the branches: X Z | Y A C

using Pose = machine::ErrorVector<double>;  // three displacements, three turns: um and urad
using PoseByIndex = std::array<std::array<Pose, 6>, 4>;

inline const machine::Machine& TiltingTableAc() {
  static const auto& machine = *new machine::Machine(PublishedMachine("ibaraki-columns/machine.json"));
  return machine;
}

inline machine::ErrorVector<double> FromUmUrad(const Pose& um_urad) {
  machine::ErrorVector<double> errors;
  errors << um_urad.head<3>() * base::kMmPerUm, um_urad.tail<3>() * base::kRadPerUrad;
  return errors;
}

inline geometry::Rigid<double> TablePose(double a_deg, double c_deg, const machine::JointErrors<double>& errors) {
  const double positions[5] = {0, 0, 0, a_deg * base::kRadPerDeg, c_deg * base::kRadPerDeg};
  return machine::EvaluateChain<double>(TiltingTableAc(), positions, errors).bed_from_table;
}

// Of a small displacement; turns are half the antisymmetric part.
inline Pose ToUmUrad(const geometry::Rigid<double>& delta) {
  const Eigen::Matrix3d& r = delta.rotation;
  Pose pose;
  pose << delta.translation_mm / base::kMmPerUm,
      Eigen::Vector3d(r(2, 1) - r(1, 2), r(0, 2) - r(2, 0), r(1, 0) - r(0, 1)) / (2.0 * base::kRadPerUrad);
  return pose;
}

// Displacement of the table against the nominal machine, machine axes.
inline Pose TablePoseError(double a_deg, double c_deg, const machine::JointErrors<double>& errors) {
  return ToUmUrad(TablePose(a_deg, c_deg, errors) * TablePose(a_deg, c_deg, {}).Inverse());
}

// Fifteen touches: top and four sides of each column. Where the columns stood is not printed: 300 mm apart across X and
// 160 mm behind, tops at 150 mm.
inline std::vector<Face> Columns() {
  std::vector<Face> faces;
  for (const auto& foot_mm : {Eigen::Vector3d(-150, 0, 0), Eigen::Vector3d(150, 0, 0), Eigen::Vector3d(0, 160, 0)}) {
    const Eigen::Vector3d x = Eigen::Vector3d::UnitX(), y = Eigen::Vector3d::UnitY(), z = Eigen::Vector3d::UnitZ();
    faces.push_back({foot_mm + 150.0 * z, z});
    for (const Eigen::Vector3d& n : {x, Eigen::Vector3d(-x), y, Eigen::Vector3d(-y)})
      faces.push_back({foot_mm + 25.0 * n + 75.0 * z, n});
  }
  return faces;
}

// Equation 9: least squares of the table's six displacements from what each touch is off along its approach; `p1` are
// the points as expected from the reference pose (6).
inline Eigen::Matrix<double, 6, Eigen::Dynamic> PublishedSolve(double a_deg, double c_deg) {
  const std::vector<Face> faces = Columns();
  Eigen::MatrixXd rows(faces.size(), 6);
  const geometry::Rigid<double> nominal = TablePose(a_deg, c_deg, {});
  for (size_t k = 0; k < faces.size(); ++k) {
    const Eigen::Vector3d p1_mm = nominal * faces[k].point_mm, n = nominal.rotation * faces[k].normal;
    rows.row(k) << n.transpose(), p1_mm.cross(n).transpose();
  }
  return rows.completeOrthogonalDecomposition().pseudoInverse();
}

// Steps 1 and 2 as published: what was touched at A = C = 0 is the artefact. mm and rad in, um and urad out.
inline Pose PublishedPoseError(double a_deg, double c_deg, const machine::JointErrors<double>& errors,
                               const machine::JointErrors<double>& errors_at_reference) {
  const std::vector<Face> faces = Columns();
  Eigen::VectorXd along_mm(faces.size());
  const geometry::Rigid<double> nominal = TablePose(a_deg, c_deg, {}), actual = TablePose(a_deg, c_deg, errors),
                                reference = TablePose(0, 0, errors_at_reference);
  for (size_t k = 0; k < faces.size(); ++k) {
    const Eigen::Vector3d off_mm = actual * faces[k].point_mm - nominal * (reference * faces[k].point_mm);
    along_mm[k] = (nominal.rotation * faces[k].normal).dot(off_mm);
  }
  const Eigen::VectorXd solved = PublishedSolve(a_deg, c_deg) * along_mm;
  Pose pose;
  pose << solved.head<3>() / base::kMmPerUm, solved.tail<3>() / base::kRadPerUrad;
  return pose;
}

struct Maps {
  std::array<Pose, 4> of_a;
  PoseByIndex of_c;
};

// Step 3 as published: A's map is the mean over C (12), C's map the rest, turned back by A (13).
inline Maps PublishedMaps(const PoseByIndex& poses) {
  Maps maps;
  for (int i = 0; i < 4; ++i) {
    maps.of_a[i].setZero();
    for (const Pose& pose : poses[i]) maps.of_a[i] += pose / 6.0;
    const Eigen::Matrix3d back = TablePose(kTiltsDeg[i], 0, {}).rotation.transpose();
    for (int j = 0; j < 6; ++j) {
      const Pose rest = poses[i][j] - maps.of_a[i];
      maps.of_c[i][j] << back * rest.head<3>(), back * rest.tail<3>();
    }
  }
  return maps;
}

inline const std::vector<std::string>& EightLocationErrors() {
  static const auto& eight =
      *new std::vector<std::string>{"EY0A", "EZ0A", "EB0A", "EC0A", "EX0C", "EY0C", "EA0C", "EB0C"};
  return eight;
}

// Every face at every A and C as one session, without readings; the columns stand `placed_mm` away from where Columns()
// says.
inline session::Session ColumnsSession(const std::string& name, const std::vector<double>& tilts_deg,
                                       const std::vector<double>& turns_deg, const Eigen::Vector3d& placed_mm) {
  constexpr double kStylusMm = 3.0, kSigmaUm = 0.175;  // "0.35 um at 2 sigma"
  TouchSession session(TiltingTableAc(), name, {0, 0, 200}, kStylusMm, kSigmaUm);
  std::vector<Face> faces = Columns();
  const auto face_name = [](size_t k) {
    static const char* const kSides[] = {"top", "+x", "-x", "+y", "-y"};
    return absl::StrCat("column", k / 5 + 1, kSides[k % 5]);
  };
  for (size_t k = 0; k < faces.size(); ++k) {
    faces[k].point_mm += placed_mm;
    session.AddFace(face_name(k), faces[k]);
  }
  // A runs through its positions at each C: were it the other way round, a drift would look like an error over A.
  for (const double c_deg : turns_deg) {
    for (const double a_deg : tilts_deg) {
      for (size_t k = 0; k < faces.size(); ++k) session.Touch(face_name(k), {{"A", a_deg}, {"C", c_deg}});
    }
  }
  return session.planned();
}

inline session::Session ColumnsSession(const Eigen::Vector3d& placed_mm = Eigen::Vector3d::Zero()) {
  return ColumnsSession("columns", {std::begin(kTiltsDeg), std::end(kTiltsDeg)},
                        {std::begin(kTurnsDeg), std::end(kTurnsDeg)}, placed_mm);
}

}  // namespace axiscal::known_answers

#endif  // AXISCAL_TESTS_KNOWN_ANSWERS_IBARAKI_COLUMNS_H_
