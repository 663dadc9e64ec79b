#include "core/machine/error_json.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>

#include "core/base/units.h"
#include "core/machine/testing/machines.h"

namespace axiscal::machine {
namespace {

using ::testing::HasSubstr;

const Machine kMachine = testing::MultiTasking();

TEST(ErrorJson, TheProbesPreTravelIsRoundTripped) {
  const Machine machine = testing::MultiTasking();
  const char* const text =
      R"({"terms": [{"symbol": "ERT", "shape": "lobe", "variable": "approach", "order": 3, "amplitude": 3.0,
                     "phase_deg": 40.0},
                    {"symbol": "ERT", "shape": "pre-travel", "amplitude": 4.0, "unit": "um"}]})";
  const auto model = ReadErrors(text, machine);
  ASSERT_TRUE(model.ok()) << model.status();
  ASSERT_EQ(model->terms.size(), 2u);
  EXPECT_EQ(NameOf(machine, model->terms[0]), "ERT:lobe(3)");
  EXPECT_EQ(NameOf(machine, model->terms[1]), "ERT:pre-travel");
  const auto again = ReadErrors(WriteErrors(*model, machine), machine);
  ASSERT_TRUE(again.ok()) << again.status();
  EXPECT_EQ(NameOf(machine, again->terms[0]), "ERT:lobe(3)");
  EXPECT_NEAR(again->terms[0].amplitude[1], 3e-3 * std::sin(40.0 * base::kRadPerDeg), 1e-12);
  // It moves the tool back along the approach, and nothing where nothing is touched.
  shapes::State state;
  EXPECT_TRUE(ErrorsAt(machine, *model, state)[machine.tool_joint()].isZero(0.0));
  state.approach = {true, {0.0, 0.0, -1.0}, 0.0, 0.0};
  EXPECT_NEAR(ErrorsAt(machine, *model, state)[machine.tool_joint()][2], 4e-3, 1e-15);
  for (const char* bad :
       {R"({"terms": [{"symbol": "ERT", "shape": "harmonic", "order": 3, "amplitude": 3, "phase_deg": 0}]})",
        R"({"terms": [{"symbol": "ERT", "shape": "lobe", "order": 2.5, "amplitude": 3, "phase_deg": 0}]})",
        R"({"terms": [{"symbol": "EXT", "shape": "lobe", "order": 3, "amplitude": 3, "phase_deg": 0}]})",
        R"({"ERT": 3})"})
    EXPECT_FALSE(ReadErrors(bad, machine).ok()) << bad;
}

// What has more than two amplitudes, and what remembers temperatures.
TEST(ErrorJson, FreeCurvesAndLateWarmthComeBackAsTheyWereWritten) {
  const int x = FindAxis(kMachine, "X"), b = FindAxis(kMachine, "B"), c = FindAxis(kMachine, "C");
  const int tool = kMachine.tool_joint();
  ErrorModel model;
  shapes::ThermalLag lag{"T_spindle_C", 900.0};
  lag.from_celsius = 19.5;
  lag.to_celsius = 31.0;
  model.terms = {
      {tool, Component::kZ, lag, {0.002}},
      {tool, Component::kZ, shapes::ThermalLag{"T_spindle_C", 4000.0}, {-0.001}},  // a second one of its name
      {x, Component::kX, shapes::ThermalLag{"temp_C", 0.0, x, 1000.0}, {0.011}},
      {x, Component::kY, shapes::Curve{x, {-300.0, 200.0}, 3}, {0.001, -0.002, 0.003}, 0.004},
      {c, Component::kA, shapes::Curve{c, {.is_turn = true}, 4}, {1e-6, 2e-6, 3e-6, 4e-6}, 5e-6},
      {b, Component::kX, shapes::Curve{b, {-1.0, 0.5}, 2}, {0.001, 0.002}},
      {tool, Component::kX, shapes::TimeCurve{{10.0, 7000.0}, 2}, {0.001, 0.0005}, 0.001},
      {x, Component::kZ, shapes::Crossed{x, c, {-300.0, 200.0}, {.is_turn = true}, 1}, {1e-3, 2e-3, 3e-3}, 2e-3},
      {x,
       Component::kZ,
       shapes::Crossed{x, b, {-300.0, 200.0}, {-1.0, 0.5}, 2, false},
       {1e-3, 2e-3, 3e-3, 4e-3},
       2e-3}};
  const std::string text = WriteErrors(model, kMachine);
  const auto again = ReadErrors(text, kMachine);
  ASSERT_TRUE(again.ok()) << again.status() << text;
  ASSERT_EQ(again->terms.size(), model.terms.size());
  std::vector<shapes::AxisState> axes(kMachine.axes.size());
  for (size_t i = 0; i < axes.size(); ++i) axes[i].position = 0.3 + 0.1 * static_cast<double>(i);
  shapes::State state{axes, 500.0, 25.0};
  const auto before = ErrorsAt(kMachine, model, state), after = ErrorsAt(kMachine, *again, state);
  for (int joint = 0; joint < kMachine.joint_count(); ++joint)
    EXPECT_LT((before[joint] - after[joint]).norm(), 1e-15) << joint;
  for (size_t i = 0; i < model.terms.size(); ++i)
    EXPECT_NEAR(again->terms[i].prior_sigma, model.terms[i].prior_sigma, 1e-15) << i;
  EXPECT_EQ(std::get<shapes::ThermalLag>(again->terms[0].shape), lag);
  EXPECT_THAT(NamesOf(kMachine, *again),
              ::testing::ElementsAre("EZT:thermal-lag(T_spindle_C)", "EZT:thermal-lag(T_spindle_C)#2",
                                     "EXX:thermal-lag(X,temp_C)", "EYX:curve", "EAC:curve", "EXB:curve",
                                     "EXT:time-curve", "EZX:crossed(C)", "EZX:crossed(B)"));
  for (const size_t i : {7, 8}) EXPECT_EQ(again->terms[i].shape, model.terms[i].shape) << i;
  // Asked for, with no amplitudes yet.
  const auto asked = ReadAskedError(R"({"symbol": "EYX", "shape": "curve", "from_mm": -300, "to_mm": 200})", kMachine);
  ASSERT_TRUE(asked.ok()) << asked.status();
  EXPECT_EQ(shapes::BasisCount(asked->terms[0].shape), 16);
  for (const auto& [bad, why] : std::vector<std::pair<const char*, const char*>>{
           {R"({"symbol": "EYX", "shape": "curve", "from_mm": 3, "to_mm": 3, "amplitudes": [1]})", "'to_mm' = 3"},
           {R"({"symbol": "EYX", "shape": "curve", "amplitudes": [1]})", "'from_mm' is missing"},
           {R"({"symbol": "EBC", "shape": "curve", "from_mm": 0, "to_mm": 90, "amplitudes": [1]})",
            "'from_mm', expected 'from_deg' and 'to_deg'"},
           {R"({"symbol": "EYX", "shape": "curve", "from_mm": 0, "to_mm": 3, "amplitude": 2})", "'amplitudes'"},
           {R"({"symbol": "EYX", "shape": "curve", "from_mm": 0, "to_mm": 3, "amplitudes": []})", "1 to 48"},
           {R"({"symbol": "EYX", "shape": "linear", "amplitude": 3, "prior_sigma": 3})", "'prior_sigma'"},
           {R"({"symbol": "EYX", "shape": "crossed", "over": "X", "from_mm": 0, "to_mm": 3, "amplitudes": [1]})",
            "over 'X'"},
           {R"({"symbol": "EYX", "shape": "crossed", "over": "C", "from_mm": 0, "to_mm": 3, "amplitudes": [1, 2]})",
            "2 numbers"},
           {R"({"symbol": "EZT", "shape": "drift", "from_s": 10, "to_s": 5, "amplitude": 1})", "'to_s' = 5"},
           {R"({"symbol": "EZT", "shape": "drift", "to_s": 5, "amplitude": 1})", "from_s"},
           {R"({"symbol": "EZT", "shape": "thermal-lag", "tau_s": -1, "amplitude": 1})", "'tau_s' = -1"},
           {R"({"symbol": "EZT", "shape": "time-curve", "from_s": 0, "amplitudes": [1]})", "'to_s' is missing"}}) {
    const auto refused = ReadErrors(std::string(R"({"terms": [)") + bad + "]}", kMachine);
    EXPECT_THAT(std::string(refused.status().message()), HasSubstr(why)) << bad;
  }
}

TEST(ErrorJson, ConstantsAreMicrometresAndMicroradians) {
  const auto model = ReadErrors(R"({"EA0B": -101.2, "X0C": 53.1})", kMachine);
  ASSERT_TRUE(model.ok()) << model.status();
  ASSERT_EQ(model->terms.size(), 2u);
  EXPECT_EQ(NameOf(kMachine, model->terms[0]), "EA0B");
  EXPECT_DOUBLE_EQ(model->terms[0].amplitude[0], -101.2e-6);
  EXPECT_EQ(NameOf(kMachine, model->terms[1]), "EX0C");
  EXPECT_DOUBLE_EQ(model->terms[1].amplitude[0], 53.1e-3);
}

TEST(ErrorJson, EveryShapeComesBackAsItWasWritten) {
  const int x = FindAxis(kMachine, "X"), b = FindAxis(kMachine, "B"), tool = kMachine.tool_joint();
  ErrorModel model;
  model.terms = {ConstantTerm(kMachine, *ParseErrorSymbol("EX0C"), 0.0531),
                 {x, Component::kX, shapes::Linear{x, 1000}, {0.012, 0}},
                 {x, Component::kY, shapes::Quadratic{x, 250}, {0.028, 0}},
                 {b, Component::kB, shapes::Harmonic{b, 45}, {2e-5, -1e-5}},
                 {x, Component::kX, shapes::Harmonic{x, 0.628}, {2e-3, 1e-3}},
                 {x, Component::kX, shapes::Backlash{x}, {-0.003, 0}},
                 {b, Component::kX, shapes::Reversal{b, 0.05}, {0.004, 0}},
                 {tool, Component::kZ, shapes::Drift{}, {-0.12, 0}},
                 {tool, Component::kZ, shapes::DriftExp{1200}, {0.03, 0}},
                 {tool, Component::kX, shapes::Thermal{}, {0.02, 0}},
                 {x, Component::kX, shapes::Acceleration{x}, {-4e-5, 0}},
                 {x, Component::kX, shapes::Play{x, 0.25}, {-0.003, 0}},
                 {b, Component::kB, shapes::LastMove{b, 0.5}, {2e-5, 0}},
                 {x, Component::kX, shapes::BacklashCurve{{x, {-100, 300}, 2}}, {0.002, -0.001}},
                 {b, Component::kB, shapes::BacklashCurve{{b, {.is_turn = true}, 2}}, {2e-6, 1e-6}},
                 {x, Component::kX, shapes::DriftExp{900, TimesPositionOf(kMachine, x)}, {0.05, 0}},
                 {b, Component::kZ, shapes::ThermalLag{"T_bed_C", 300, TimesPositionOf(kMachine, b)}, {0.001, 0}},
                 {x, Component::kX, shapes::TimeCurve{{0, 7200}, 2, TimesPositionOf(kMachine, x)}, {0.004, 0.002}},
                 {x, Component::kB, shapes::Lag{x}, {1e-6, 0}}};
  const auto back = ReadErrors(WriteErrors(model, kMachine), kMachine);
  ASSERT_TRUE(back.ok()) << back.status();
  ASSERT_EQ(back->terms.size(), model.terms.size());
  for (size_t i = 0; i < model.terms.size(); ++i) {
    EXPECT_EQ(NameOf(kMachine, back->terms[i]), NameOf(kMachine, model.terms[i]));
    EXPECT_EQ(shapes::VariableAxis(back->terms[i].shape), shapes::VariableAxis(model.terms[i].shape));
    for (int k = 0; k < 2; ++k) EXPECT_NEAR(back->terms[i].amplitude[k], model.terms[i].amplitude[k], 1e-17);
  }
}

TEST(ErrorJson, WhatIsAskedForIsReadAsStrictlyAsAFile) {
  for (const std::string& text : {std::string("EZ\x82T"), std::string(R"({"symbol": "EBB", "shape": )"),
                                  std::string(R"({"symbol": "EBB", "symbol": "EAB", "shape": "backlash"})"),
                                  R"({"symbol": )" + std::string(100'000, '[')}) {
    const absl::Status status = ReadAskedError(text, testing::MultiTasking()).status();
    EXPECT_TRUE(absl::IsInvalidArgument(status)) << text.substr(0, 100) << ": " << status;
  }
}

TEST(ErrorJson, BadInputNamesTheEntryAndTheRule) {
  const std::vector<std::pair<std::string, std::string>> cases = {
      {"", "errors: is empty"},
      {"[1]", "expected an object"},
      {R"({"EA0B": -101.2)", "errors: line 1"},
      {R"({"EA0Q": 1})", "machine 'mt' has no axis Q"},
      {R"({"A0B": "1"})", "expected a finite number"},
      {R"({"EA0B": 1e999})", "errors:"},
      {R"({"EA0B": 1, "EA0B": 2})", "is there twice"},
      {R"({"EA0B": 1, "A0B": 2})", "is there twice"},
      {R"({"EXX": 1})", "is not constant"},
      {R"({"terms": 3})", "expected an array"},
      {R"({"terms": [{"symbol": "EXX", "shape": "cubic", "amplitude": 1}]})", "unknown shape 'cubic'"},
      {R"({"terms": [{"symbol": "EXX", "shape": "backlash"}]})", "terms[0]: 'amplitude' is missing"},
      {R"({"terms": [{"symbol": "EBB", "shape": "harmonic", "order": 0, "amplitude": 1, "phase_deg": 0}]})",
       "must be > 0"},
      {R"({"terms": [{"symbol": "EX0X", "shape": "backlash", "amplitude": 1}]})", "a 0 in the symbol means constant"},
      {R"({"terms": [{"symbol": "EXX", "shape": "backlash", "amplitude": 1, "unit": "mm"}]})",
       "unit 'mm', expected 'um'"},
      {R"({"terms": [{"symbol": "EXX", "shape": "backlash", "amplitude": 1, "amp": 2}]})", "unknown field 'amp'"},
  };
  for (const auto& [text, expected] : cases) {
    const auto model = ReadErrors(text, kMachine);
    ASSERT_FALSE(model.ok()) << text;
    EXPECT_EQ(model.status().code(), absl::StatusCode::kInvalidArgument);
    EXPECT_THAT(std::string(model.status().message()), HasSubstr(expected)) << text;
  }
}

}  // namespace
}  // namespace axiscal::machine
