#include "core/machine/sensitivity.h"

#include <ceres/jet.h>
#include <gtest/gtest.h>

#include <random>

#include "core/machine/joint_transforms.h"
#include "core/machine/testing/machines.h"

namespace axiscal::machine {
namespace {

constexpr int kMaxColumns = kComponents * 7;
using Jet = ceres::Jet<double, kMaxColumns>;

// The slow obvious twin: automatic derivatives of the templated chain.
Eigen::Matrix<double, 3, kMaxColumns> Autodiff(const Machine& machine, const std::vector<double>& positions,
                                               const JointErrors<double>& errors, const Eigen::Vector3d& tip_mm,
                                               const Eigen::Vector3d& ball_mm) {
  JointErrors<Jet> jets;
  for (int joint = 0; joint < machine.joint_count(); ++joint) {
    for (int k = 0; k < kComponents; ++k) jets[joint][k] = Jet(errors[joint][k], kComponents * joint + k);
  }
  const std::vector<Jet> jet_positions(positions.begin(), positions.end());
  const auto pose = EvaluateChain<Jet>(machine, jet_positions.data(), jets);
  const geometry::Vector3<Jet> difference = pose.bed_from_tool * geometry::Vector3<Jet>(tip_mm.cast<Jet>()) -
                                            pose.bed_from_table * geometry::Vector3<Jet>(ball_mm.cast<Jet>());
  Eigen::Matrix<double, 3, kMaxColumns> derivative;
  for (int row = 0; row < 3; ++row) derivative.row(row) = difference[row].v.transpose();
  return derivative;
}

// A machine at one state after another: some positions change, and some errors, to zero and back.
struct Walk {
  explicit Walk(const Machine& of) : machine(of), positions(of.axis_count()) {}

  double Uniform() { return std::uniform_real_distribution<double>(-1.0, 1.0)(random); }
  bool IsChosen() { return Uniform() < 0.0; }
  void Go() {
    for (int i = 0; i < machine.axis_count(); ++i) {
      if (IsChosen()) positions[i] = Uniform() * (machine.axes[i].kind == AxisKind::kLinear ? 300.0 : 3.0);
    }
    for (int joint = 0; joint < machine.joint_count(); ++joint) {
      for (int k = 0; k < kComponents; ++k) {
        if (IsChosen() && IsChosen()) errors[joint][k] = IsChosen() ? 1e-4 * Uniform() : 0.0;
      }
    }
  }

  const Machine& machine;
  std::vector<double> positions;
  JointErrors<double> errors;
  std::mt19937 random{20261122};
};

TEST(Sensitivity, WhatIsKeptBetweenCallsChangesNothing) {
  const Eigen::Vector3d tip(3, -4, -350), ball(50, 7, 65);
  RelativePoint kept;  // of all machines in turn
  for (const Machine& machine : {testing::MultiTasking(), testing::TiltingTable(), testing::SwivelHead()}) {
    Walk walk(machine);
    for (int step = 0; step < 200; ++step) {
      walk.Go();
      RelativePoint fresh;
      EvaluateRelativePoint(machine, walk.positions.data(), walk.errors, tip, ball, &fresh);
      EvaluateRelativePoint(machine, walk.positions.data(), walk.errors, tip, ball, &kept);
      EXPECT_EQ(kept.sensitivity, fresh.sensitivity);
      EXPECT_EQ(kept.tip_in_bed_mm, fresh.tip_in_bed_mm);
      EXPECT_EQ(kept.ball_in_bed_mm, fresh.ball_in_bed_mm);
    }
  }
}

TEST(JointTransforms, GiveTheChainOfTheErrorsThatWereSetLast) {
  for (const Machine& machine : {testing::MultiTasking(), testing::TiltingTable(), testing::SwivelHead()}) {
    Walk walk(machine);
    JointTransforms transforms(machine);
    for (int step = 0; step < 200; ++step) {
      const auto pose = EvaluateChain<double>(machine, walk.positions.data(), walk.errors);
      const auto same = EvaluateChain<double>(machine, walk.positions.data(), transforms);
      EXPECT_EQ(same.bed_from_tool.rotation, pose.bed_from_tool.rotation);
      EXPECT_EQ(same.bed_from_tool.translation_mm, pose.bed_from_tool.translation_mm);
      EXPECT_EQ(same.bed_from_table.rotation, pose.bed_from_table.rotation);
      EXPECT_EQ(same.bed_from_table.translation_mm, pose.bed_from_table.translation_mm);
      walk.Go();
      transforms.Set(walk.errors);
    }
  }
}

TEST(Sensitivity, AgreesWithAutomaticDerivativesAtZeroTypicalAndLargeErrors) {
  constexpr double kTolerance = 1e-10;  // mm per rad: levers of 1e3 mm times rounding of 1e-16, a few times
  std::mt19937 random(20261120);
  std::uniform_real_distribution<double> uniform(-1.0, 1.0);
  for (const Machine& machine : {testing::MultiTasking(), testing::TiltingTable(), testing::SwivelHead()}) {
    for (const double scale : {0.0, 1e-4, 0.1}) {
      std::vector<double> positions(machine.axis_count());
      for (int i = 0; i < machine.axis_count(); ++i) {
        positions[i] = uniform(random) * (machine.axes[i].kind == AxisKind::kLinear ? 300.0 : 3.0);
      }
      JointErrors<double> errors;
      for (int joint = 0; joint < machine.joint_count(); ++joint) {
        for (int k = 0; k < kComponents; ++k) errors[joint][k] = scale * uniform(random);
      }
      const Eigen::Vector3d tip(3, -4, -350), ball(50, 7, 65);
      RelativePoint point;
      EvaluateRelativePoint(machine, positions.data(), errors, tip, ball, &point);
      const auto reference = Autodiff(machine, positions, errors, tip, ball);
      EXPECT_LT((point.sensitivity - reference.leftCols(point.sensitivity.cols())).cwiseAbs().maxCoeff(), kTolerance)
          << machine.id << ' ' << scale;
      const auto pose = EvaluateChain<double>(machine, positions.data(), errors);
      EXPECT_LT((point.tip_in_bed_mm - pose.bed_from_tool * tip).norm(), 1e-10);
      EXPECT_LT((point.ball_in_bed_mm - pose.bed_from_table * ball).norm(), 1e-10);
    }
  }
}

}  // namespace
}  // namespace axiscal::machine
