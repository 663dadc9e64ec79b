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
                 {x, Component::kB, shapes::Lag{x}, {1e-6, 0}}};
  const auto back = ReadErrors(WriteErrors(model, kMachine), kMachine);
  ASSERT_TRUE(back.ok()) << back.status();
  ASSERT_EQ(back->terms.size(), model.terms.size());
  for (size_t i = 0; i < model.terms.size(); ++i) {
    EXPECT_EQ(NameOf(kMachine, back->terms[i]), NameOf(kMachine, model.terms[i]));
    for (int k = 0; k < 2; ++k) EXPECT_NEAR(back->terms[i].amplitude[k], model.terms[i].amplitude[k], 1e-17);
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
