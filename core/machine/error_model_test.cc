#include "core/machine/error_model.h"

#include <gtest/gtest.h>

#include <numbers>

#include "core/machine/testing/machines.h"

namespace axiscal::machine {
namespace {

TEST(ErrorModel, TermsOfOneComponentAddUp) {
  const Machine machine = testing::MultiTasking();
  const int x = FindAxis(machine, "X");
  ErrorModel model;
  model.terms.push_back({x, Component::kX, shapes::Linear{x, shapes::Linear::kReferenceMm}, {0.010, 0}});
  model.terms.push_back({x, Component::kX, shapes::Backlash{x}, {0.004, 0}});
  model.terms.push_back({machine.tool_joint(), Component::kZ, shapes::Constant{}, {0.030, 0}});
  std::vector<shapes::AxisState> axes(machine.axis_count());
  axes[x] = {500.0, -1.0, 1.0, 0.0};
  shapes::State state;
  state.axes = axes;
  const JointErrors<double> errors = ErrorsAt(machine, model, state);
  EXPECT_DOUBLE_EQ(errors[x][0], 0.005 - 0.002);
  EXPECT_DOUBLE_EQ(errors[machine.tool_joint()][2], 0.030);
  EXPECT_EQ(errors[machine.work_joint()].norm(), 0.0);
}

TEST(ErrorModel, NamesSayAxisComponentAndShape) {
  const Machine machine = testing::MultiTasking();
  const int b = FindAxis(machine, "B"), x = FindAxis(machine, "X"), z = FindAxis(machine, "Z");
  EXPECT_EQ(NameOf(machine, ConstantTerm(machine, *ParseErrorSymbol("EX0C"))), "EX0C");
  EXPECT_EQ(NameOf(machine, {b, Component::kB, shapes::Harmonic{b, 45}, {}}), "EBB:harmonic(45)");
  EXPECT_EQ(NameOf(machine, {x, Component::kX, shapes::Backlash{x}, {}}), "EXX:backlash");
  EXPECT_EQ(NameOf(machine, {x, Component::kX, shapes::Harmonic{x, 2 * std::numbers::pi / 10}, {}}),
            "EXX:harmonic(10mm)");
  EXPECT_EQ(NameOf(machine, {machine.tool_joint(), Component::kZ, shapes::Thermal{}, {}}), "EZT:thermal");
  EXPECT_EQ(NameOf(machine, {x, Component::kB, shapes::Linear{z, 1000}, {}}), "EBX:linear(Z)");
}

// A curve that was fitted without a prior is as unknown far away as it is large, not known to be zero.
TEST(ErrorModel, BeyondItsSpanACurveIsUnknownByPriorOrSize) {
  const Machine machine = testing::MultiTasking();
  const int x = FindAxis(machine, "X");
  shapes::Curve curve;
  curve.axis = x;
  curve.span = {0.0, 100.0, false};
  curve.functions = 2;
  ErrorTerm term{x, Component::kY, curve, {0.003, 0.004}};
  std::vector<shapes::AxisState> axes(machine.axis_count());
  shapes::State state;
  state.axes = axes;
  axes[x].position = 50.0;
  EXPECT_EQ(UnknownAt(term, state), 0.0);
  axes[x].position = 1000.0;
  EXPECT_NEAR(UnknownAt(term, state), 0.005, 1e-9);
  term.prior_sigma = 0.002;
  EXPECT_NEAR(UnknownAt(term, state), 0.002, 1e-9);
}

TEST(ErrorModel, TheDeclaredModelHoldsTheMachinesConstants) {
  const Machine machine = testing::SwivelHead();
  const ErrorModel model = DeclaredModel(machine);
  ASSERT_EQ(model.terms.size(), machine.declared.size());
  EXPECT_EQ(NameOf(machine, model.terms[0]), "EZ0T");
  EXPECT_FALSE(DependsOnMoreThanPosition(model.terms[0]));
  EXPECT_TRUE(DependsOnMoreThanPosition({0, Component::kX, shapes::Backlash{0}, {}}));
}

}  // namespace
}  // namespace axiscal::machine
