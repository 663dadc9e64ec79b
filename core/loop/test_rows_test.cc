#include "core/loop/test_rows.h"

#include <gtest/gtest.h>

#include "core/identify/identify.h"
#include "core/identify/testing/scenario.h"

namespace axiscal::loop {
namespace {

using identify::testing::Errors;

const machine::Machine kMachine = machine::testing::MultiTasking();

// What is assembled from all rows anew.
TEST(TestRows, SayWhatAnAssemblyOfAllColumnsSays) {
  const auto sessions = identify::testing::Measure(kMachine, {}, {}, {{"BX", ballbar::Pattern::kBX, 356.4}});
  const identify::Problem problem =
      identify::MakeProblem(kMachine, *identify::BindSessions(kMachine, sessions)).value();
  machine::ErrorModel model = Errors(kMachine, R"({"EA0B": 40, "EX0C": -20})");
  const int b = machine::FindAxis(kMachine, "B");
  model.terms.push_back({b, machine::Component::kX, shapes::Harmonic{b, 2.0}, {3e-3, 1e-3}});
  const TestRows rows(problem, model);
  model.terms.push_back({b, machine::Component::kB, shapes::Backlash{b}, {}});
  model.terms.push_back({kMachine.work_joint(), machine::Component::kX, shapes::Constant{}, {}});
  constexpr double kSmallMm = 1e-6;  // as large as Rivals has them: so that the decay length shows
  model.terms.push_back({b, machine::Component::kX, shapes::Reversal{b, 0.2}, {kSmallMm}});
  const Information fast = rows.InformationOf(model);
  const Information slow =
      InformationOf(problem, identify::StartingPoint(problem, model), identify::ListParameters(model, true));
  ASSERT_EQ(fast.matrix.rows(), slow.matrix.rows());
  const Eigen::VectorXd scale = slow.norm2.cwiseSqrt().cwiseInverse();
  ASSERT_TRUE(scale.allFinite());
  constexpr double kTolerance = 1e-7;  // what a nanometre's reversal turns
  EXPECT_LT((scale.asDiagonal() * (fast.matrix - slow.matrix) * scale.asDiagonal()).cwiseAbs().maxCoeff(), kTolerance);
  EXPECT_LT(((fast.norm2 - slow.norm2).array() / slow.norm2.array()).abs().maxCoeff(), kTolerance);
}

}  // namespace
}  // namespace axiscal::loop
