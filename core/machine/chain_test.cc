#include "core/machine/chain.h"

#include <gtest/gtest.h>

#include "core/base/units.h"
#include "core/machine/testing/machines.h"

namespace axiscal::machine {
namespace {

using base::kMmPerUm;
using base::kRadPerDeg;
using base::kRadPerUrad;
using testing::MultiTasking;
using testing::TiltingTable;

// Ibaraki, Iritani, Matsushita (eqs 2-4): E_A Rx(A) E_C Rz(C) with E_A = (10,-5,8,20,-15,10), E_C = (4,6,-3,-12,25,8)
// um and urad; the table's pose error in machine axes, exact to the printed digits (computed apart). Rotations:
// half the antisymmetric part.
struct PoseError {
  double a_deg, c_deg;
  double expected_um[6];
};

TEST(Chain, TiltingTablePoseErrorsAreThoseOfIbaraki) {
  constexpr double kTolerance = 1e-5;  // um and urad: the digits given
  Machine machine = TiltingTable();
  machine.axes[FindAxis(machine, "A")].point_mm.setZero();
  const int a = FindAxis(machine, "A"), c = FindAxis(machine, "C");
  JointErrors<double> errors;
  errors[a] << 10 * kMmPerUm, -5 * kMmPerUm, 8 * kMmPerUm, 20 * kRadPerUrad, -15 * kRadPerUrad, 10 * kRadPerUrad;
  errors[c] << 4 * kMmPerUm, 6 * kMmPerUm, -3 * kMmPerUm, -12 * kRadPerUrad, 25 * kRadPerUrad, 8 * kRadPerUrad;
  for (const PoseError& known :
       {PoseError{-30, 60, {14.000047, -1.303696, 2.402058, 7.999939, 10.650497, 4.428066}},
        PoseError{-90, 240, {14.000120, -7.999840, 2.000000, 8.000173, -7.000060, -15.000208}}}) {
    std::vector<double> positions(machine.axis_count(), 0.0);
    positions[a] = known.a_deg * kRadPerDeg;
    positions[c] = known.c_deg * kRadPerDeg;
    const auto actual = EvaluateChain<double>(machine, positions.data(), errors).bed_from_table;
    const auto nominal = EvaluateChain<double>(machine, positions.data(), {}).bed_from_table;
    const auto delta = actual * nominal.Inverse();
    const Eigen::Matrix3d antisymmetric = 0.5 * (delta.rotation - delta.rotation.transpose());
    const double found[6] = {delta.translation_mm.x() / kMmPerUm, delta.translation_mm.y() / kMmPerUm,
                             delta.translation_mm.z() / kMmPerUm, antisymmetric(2, 1) / kRadPerUrad,
                             antisymmetric(0, 2) / kRadPerUrad,   antisymmetric(1, 0) / kRadPerUrad};
    for (int k = 0; k < 6; ++k)
      EXPECT_NEAR(found[k], known.expected_um[k], kTolerance) << "A " << known.a_deg << ' ' << k;
  }
}

TEST(Chain, APerfectMachinePutsTheToolWhereItIsCommanded) {
  const Machine machine = MultiTasking();
  std::vector<double> positions(machine.axis_count(), 0.0);
  positions[FindAxis(machine, "X")] = 100;
  positions[FindAxis(machine, "Z")] = 40;
  positions[FindAxis(machine, "B")] = 90 * kRadPerDeg;
  const auto pose = EvaluateChain<double>(machine, positions.data(), {});
  // The tool points to -Z at B = 0 and to -X at B = 90 (Yao 2022).
  EXPECT_LT((TipInTable(pose, {0, 0, -350}) - Eigen::Vector3d(100 - 350, 0, 40)).norm(), 1e-12);
  EXPECT_LT((ToolDirectionInTable(machine, pose) - Eigen::Vector3d(-1, 0, 0)).norm(), 1e-15);
}

TEST(Chain, ATableThatTurnsMovesTheToolTheOtherWayInTheWorkpiece) {
  const Machine machine = MultiTasking();
  std::vector<double> positions(machine.axis_count(), 0.0);
  positions[FindAxis(machine, "X")] = 100;
  positions[FindAxis(machine, "C")] = 90 * kRadPerDeg;
  const auto pose = EvaluateChain<double>(machine, positions.data(), {});
  EXPECT_LT((TipInTable(pose, {0, 0, 0}) - Eigen::Vector3d(0, -100, 0)).norm(), 1e-12);
}

TEST(Chain, ToolErrorsAreCarriedByTheSpindleAndTableErrorsByTheTable) {
  const Machine machine = MultiTasking();
  std::vector<double> positions(machine.axis_count(), 0.0);
  positions[FindAxis(machine, "B")] = 90 * kRadPerDeg;
  positions[FindAxis(machine, "C")] = 180 * kRadPerDeg;
  JointErrors<double> errors;
  errors[machine.tool_joint()][2] = 0.1;  // EZ0T: the point stands higher at home, towards +X at B = 90
  errors[machine.work_joint()][0] = 0.2;  // EX0W: the workpiece stands off to +X at home
  const Eigen::Vector3d moved = TipInTable(EvaluateChain<double>(machine, positions.data(), errors), {0, 0, -350}) -
                                TipInTable(EvaluateChain<double>(machine, positions.data(), {}), {0, 0, -350});
  EXPECT_LT((moved - Eigen::Vector3d(-0.1 - 0.2, 0, 0)).norm(), 1e-12);
}

}  // namespace
}  // namespace axiscal::machine
