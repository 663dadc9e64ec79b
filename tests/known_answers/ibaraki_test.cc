// Ibaraki, Iritani, Matsushita, "Error calibration on five-axis machine tools by on-the-machine measurement of
// artifacts using a touch-trigger probe": three square columns on a tilting rotary table.
#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <Eigen/QR>
#include <cmath>

#include "core/base/units.h"
#include "core/identify/identify.h"
#include "core/instruments/centres/centres_model.h"
#include "core/machine/testing/machines.h"
#include "core/synthetic/simulate.h"

namespace axiscal {
namespace {

using base::kMmPerUm;
using base::kRadPerDeg;
using base::kRadPerUrad;
using machine::testing::kOrigin;
using machine::testing::kX;
using machine::testing::kY;
using machine::testing::kZ;

constexpr double kTilts[] = {0, -30, -60, -90}, kTurns[] = {0, 60, 120, 180, 240, 300};
constexpr double kStylusMm = 3.0;

machine::Machine TiltingTableAc(const std::vector<std::string>& declared) {
  return machine::testing::Make("ac", {machine::testing::Linear("X", kX), machine::testing::Linear("Z", kZ)},
                                {machine::testing::Linear("Y", -kY), machine::testing::Rotary("A", kX, kOrigin),
                                 machine::testing::Rotary("C", kZ, kOrigin)},
                                declared);
}

// The errors of a joint in um and urad; joint of axis A is 3, of C 4 (order of Make).
constexpr int kA = 3, kC = 4;
machine::ErrorVector<double> Errors(const std::array<double, 6>& um_urad) {
  machine::ErrorVector<double> errors;
  for (int i = 0; i < 6; ++i) errors[i] = um_urad[i] * (i < 3 ? kMmPerUm : kRadPerUrad);
  return errors;
}

geometry::Rigid<double> TablePose(double a_deg, double c_deg, const machine::JointErrors<double>& errors) {
  const double positions[5] = {0, 0, 0, a_deg * kRadPerDeg, c_deg * kRadPerDeg};
  return machine::EvaluateChain<double>(TiltingTableAc({}), positions, errors).bed_from_table;
}

TEST(Ibaraki, ExactTablePoseErrors) {
  machine::JointErrors<double> errors;
  errors[kA] = Errors({10, -5, 8, 20, -15, 10});
  errors[kC] = Errors({4, 6, -3, -12, 25, 8});
  const struct {
    double a_deg, c_deg, expected[6];
  } rows[] = {{-30, 60, {14.000047, -1.303696, 2.402058, 7.999939, 10.650497, 4.428066}},
              {-90, 240, {14.000120, -7.999840, 2.000000, 8.000173, -7.000060, -15.000208}}};
  for (const auto& row : rows) {
    const geometry::Rigid<double> delta =
        TablePose(row.a_deg, row.c_deg, errors) * TablePose(row.a_deg, row.c_deg, {}).Inverse();
    const Eigen::Matrix3d& r = delta.rotation;
    const double turns[3] = {(r(2, 1) - r(1, 2)) / 2, (r(0, 2) - r(2, 0)) / 2, (r(1, 0) - r(0, 1)) / 2};
    for (int i = 0; i < 3; ++i) {
      EXPECT_NEAR(delta.translation_mm[i] / kMmPerUm, row.expected[i], 1e-5) << row.a_deg << ' ' << i;
      EXPECT_NEAR(turns[i] / kRadPerUrad, row.expected[3 + i], 1e-5) << row.a_deg << ' ' << i;
    }
  }
}

struct Face {
  Eigen::Vector3d point_mm, normal;  // table frame
};

// Fifteen touches on three columns 300 mm apart: tops, and two heights of two sides each.
std::vector<Face> Columns() {
  std::vector<Face> faces;
  for (int column = 0; column < 3; ++column) {
    const double at = column * 2.0 * M_PI / 3.0, away_mm = 300.0 / std::sqrt(3.0);
    const Eigen::Vector3d foot_mm(away_mm * std::cos(at), away_mm * std::sin(at), 0.0);
    faces.push_back({foot_mm + Eigen::Vector3d(0, 0, 120), kZ});
    for (const double height_mm : {40.0, 100.0}) {
      faces.push_back({foot_mm + Eigen::Vector3d(25, 0, height_mm), kX});
      faces.push_back({foot_mm + Eigen::Vector3d(0, 25, height_mm), kY});
    }
  }
  return faces;
}

// Steps 1 to 3 as published: the artefact is what was touched at A = C = 0; pose errors by least squares along the
// approach. Returns translations of the table's pose error at (a, c), um.
Eigen::Vector3d PublishedPoseErrorUm(double a_deg, double c_deg, const machine::JointErrors<double>& errors) {
  const std::vector<Face> faces = Columns();
  Eigen::MatrixXd rows(faces.size(), 6);
  Eigen::VectorXd along_mm(faces.size());
  for (size_t k = 0; k < faces.size(); ++k) {
    const geometry::Rigid<double> nominal = TablePose(a_deg, c_deg, {});
    const Eigen::Vector3d at_reference_mm = TablePose(0, 0, errors) * faces[k].point_mm;
    const Eigen::Vector3d expected_mm = nominal * at_reference_mm, n = nominal.rotation * faces[k].normal;
    rows.row(k) << n.transpose(), expected_mm.cross(n).transpose();
    along_mm[k] = n.dot(TablePose(a_deg, c_deg, errors) * faces[k].point_mm - expected_mm);
  }
  return Eigen::VectorXd(rows.colPivHouseholderQr().solve(along_mm)).head<3>() / kMmPerUm;
}

// The machine calibrates the artefact with its own error at A = C = 0: constant offsets come back as a once-per-turn
// error of C that is not there, and vanish from the map of A.
TEST(Ibaraki, ThePublishedMapsHoldTheErrorOfTheReferencePose) {
  machine::JointErrors<double> errors;
  errors[kA] = Errors({20, 10, 15, 0, 0, 0});
  const double dx_of_c[] = {-20.0, -1.3, 18.7, 20.0, 1.3, -18.7}, dy_of_c[] = {-10.0, -22.3, -12.3, 10.0, 22.3, 12.3};
  const double dy_of_a[] = {10, 2.5, -3.0, -5.0}, dz_of_a[] = {0, 2.0, 7.5, 15};
  constexpr double kToleranceUm = 0.051;  // one printed decimal
  for (int i = 0; i < 4; ++i) {
    Eigen::Vector3d map_of_a_um = Eigen::Vector3d::Zero();
    for (const double turn : kTurns) map_of_a_um += PublishedPoseErrorUm(kTilts[i], turn, errors) / 6.0;
    EXPECT_NEAR(map_of_a_um.y(), dy_of_a[i], kToleranceUm);
    EXPECT_NEAR(map_of_a_um.z(), dz_of_a[i], kToleranceUm);
    if (i > 0) continue;
    for (int j = 0; j < 6; ++j) {
      const Eigen::Vector3d map_of_c_um = PublishedPoseErrorUm(0, kTurns[j], errors) - map_of_a_um;
      EXPECT_NEAR(map_of_c_um.x(), dx_of_c[j], kToleranceUm);
      EXPECT_NEAR(map_of_c_um.y(), dy_of_c[j], kToleranceUm);
    }
  }
}

// All poses' touches as one planned session. `moved_mm`: how far the header's features stand from the real ones.
session::Session Planned(const machine::Machine& machine, const Eigen::Vector3d& moved_mm) {
  session::Session session;
  session.header = {{"machine", "ac"},     {"session", "columns"},     {"instrument", "touch"},
                    {"sigma_um", "0.175"}, {"tool_tip_mm", "0 0 200"}, {"stylus_radius_mm", absl::StrCat(kStylusMm)}};
  const std::vector<Face> faces = Columns();
  for (size_t k = 0; k < faces.size(); ++k) {
    const Eigen::Vector3d p = faces[k].point_mm + moved_mm, n = faces[k].normal;
    session.header.push_back({absl::StrCat("plane f", k), absl::StrFormat("%.17g %.17g %.17g %.17g %.17g %.17g", p.x(),
                                                                          p.y(), p.z(), n.x(), n.y(), n.z())});
  }
  for (const char* name : {"X_mm", "Z_mm", "Y_mm", "A_deg", "C_deg", "nx", "ny", "nz", "feature"})
    session.columns.push_back({name, {}, {}});
  for (const double a_deg : kTilts) {
    for (const double c_deg : kTurns) {
      for (size_t k = 0; k < faces.size(); ++k) {
        double positions[5] = {0, 0, 0, a_deg * kRadPerDeg, c_deg * kRadPerDeg};
        const Eigen::Vector3d stylus_mm = faces[k].point_mm + kStylusMm * faces[k].normal;
        EXPECT_TRUE(centres::SolveNominalCommands(machine, {0, 0, 200}, stylus_mm, positions).ok());
        const Eigen::Vector3d approach = -(TablePose(a_deg, c_deg, {}).rotation * faces[k].normal);
        const double row[] = {positions[0], positions[1], positions[2], a_deg,
                              c_deg,        approach.x(), approach.y(), approach.z()};
        for (int i = 0; i < 8; ++i) session.columns[i].values.push_back(row[i]);
        session.columns[8].texts.push_back(absl::StrCat("f", k));
      }
    }
  }
  return session;
}

const std::vector<std::string> kEight = {"EY0A", "EZ0A", "EB0A", "EC0A", "EX0C", "EY0C", "EA0C", "EB0C"};

TEST(Ibaraki, TheJointFitOfErrorsAndArtefactGivesTheTruth) {
  const machine::Machine machine = TiltingTableAc(kEight);
  machine::ErrorModel truth = machine::DeclaredModel(machine);
  for (size_t i = 0; i < truth.terms.size(); ++i)
    truth.terms[i].amplitude[0] =
        (i % 2 ? -1.0 : 1.0) * (10.0 + 3.0 * i) * 1e-6 * (i < 2 || i == 4 || i == 5 ? 1e3 : 1.0);
  synthetic::NoiseOptions exact;
  exact.sigma_scale = 0.0;
  exact.draw_setup = false;
  auto session = synthetic::Simulate(machine, truth, Planned(machine, Eigen::Vector3d::Zero()), exact);
  ASSERT_TRUE(session.ok()) << session.status();
  session->header = Planned(machine, {0.2, -0.1, 0.15}).header;  // mounted by hand
  const auto result = identify::Identify(machine, {*session});
  ASSERT_TRUE(result.ok()) << result.status();
  EXPECT_EQ(result->rank, 8);
  for (size_t i = 0; i < truth.terms.size(); ++i) {
    const bool is_angle = !(i < 2 || i == 4 || i == 5);
    EXPECT_NEAR(result->estimates[i].value, truth.terms[i].amplitude[0], is_angle ? 1e-9 : 1e-6)
        << result->estimates[i].name;
  }
  // Two more constants add no rank: EX0A is seen only with EX0C, EZ0C only with the artefact's height.
  std::vector<std::string> ten = kEight;
  ten.insert(ten.end(), {"EX0A", "EZ0C"});
  const auto wider = identify::Identify(TiltingTableAc(ten), {*session});
  ASSERT_TRUE(wider.ok()) << wider.status();
  EXPECT_EQ(wider->rank, 8);
}

}  // namespace
}  // namespace axiscal
