#include "core/machine/error_map_json.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <nlohmann/json.hpp>

#include "core/base/units.h"
#include "core/machine/error_json.h"
#include "core/machine/testing/machines.h"

namespace axiscal::machine {
namespace {

using ::testing::HasSubstr;

const Machine kMachine = testing::TiltingTable();

constexpr char kMap[] = R"({"terms": [{"symbol": "EYC", "shape": "tabulated", "variable": "C",
    "nodes_deg": [0, 90, 180, 270], "zero_mean": true, "over": {"variable": "A", "nodes_deg": [-90, 0]},
    "values": [[1, 2, -4, 1], [3, -1, -1, -1]], "unit": "um"}]})";

double EycAt(const ErrorModel& model, double a_deg, double c_deg) {
  std::vector<shapes::AxisState> axes(kMachine.axis_count());
  axes[FindAxis(kMachine, "A")].position = a_deg * base::kRadPerDeg;
  axes[FindAxis(kMachine, "C")].position = c_deg * base::kRadPerDeg;
  shapes::State state;
  state.axes = axes;
  return ErrorsAt(kMachine, model, state)[FindJoint(kMachine, "C")][1] * base::kUmPerMm;
}

TEST(ErrorMap, IsItsValuesAtTheNodesAndLinearBetween) {
  const auto model = ReadErrors(kMap, kMachine);
  ASSERT_TRUE(model.ok()) << model.status();
  EXPECT_EQ(model->terms.size(), 6u);  // the last of each row is minus the others
  constexpr double kTolerance = 1e-12;
  const double values[2][4] = {{1, 2, -4, 1}, {3, -1, -1, -1}};
  for (int j = 0; j < 2; ++j) {
    for (int i = 0; i < 4; ++i) EXPECT_NEAR(EycAt(*model, j == 0 ? -90 : 0, 90 * i), values[j][i], kTolerance);
  }
  EXPECT_NEAR(EycAt(*model, -90, 45), 1.5, kTolerance);
  EXPECT_NEAR(EycAt(*model, -90, 315), 1.0, kTolerance);  // around, from 270 to 360 = 0
  EXPECT_NEAR(EycAt(*model, -90, -90), 1.0, kTolerance);
  EXPECT_NEAR(EycAt(*model, -45, 0), 2.0, kTolerance);    // between the rows
  EXPECT_NEAR(EycAt(*model, -120, 90), 2.0, kTolerance);  // beyond the last node of A, which does not go around
}

TEST(ErrorMap, IsWrittenAsItIsRead) {
  const ErrorModel model = ReadErrors(kMap, kMachine).value();
  const std::string text = WriteErrors(model, kMachine);
  const auto again = ReadErrors(text, kMachine);
  ASSERT_TRUE(again.ok()) << again.status();
  ASSERT_EQ(again->terms.size(), model.terms.size());
  for (const double a_deg : {-90.0, -30.0, 0.0}) {
    for (const double c_deg : {0.0, 77.0, 200.0, 333.0})
      EXPECT_NEAR(EycAt(*again, a_deg, c_deg), EycAt(model, a_deg, c_deg), 1e-12);
  }
  EXPECT_EQ(nlohmann::json::parse(text)["terms"].size(), 1u) << text;
  EXPECT_EQ(NameOf(kMachine, model.terms[1]), "EYC:tabulated(90,A -90)");
}

TEST(ErrorMap, SaysWhatIsWrong) {
  const auto message = [](const std::string& fields) {
    const std::string text = R"({"terms": [{"symbol": "EYA", "shape": "tabulated", )" + fields + "}]}";
    return std::string(ReadErrors(text, kMachine).status().message());
  };
  EXPECT_THAT(message(R"("nodes_deg": [0], "values": [1])"), HasSubstr("at least two numbers that rise"));
  EXPECT_THAT(message(R"("nodes_deg": [0, 1], "amplitude": 1)"), HasSubstr("a map has 'values'"));
  EXPECT_THAT(message(R"("nodes_deg": [0, 0], "values": [1, 2])"), HasSubstr("does not rise"));
  EXPECT_THAT(message(R"("nodes_mm": [0, 1], "values": [1, 2])"), HasSubstr("nodes_deg"));
  EXPECT_THAT(message(R"("nodes_deg": [0, 1], "values": [1])"), HasSubstr("2 numbers in each row"));
  EXPECT_THAT(message(R"("nodes_deg": [0, 1], "zero_mean": true, "values": [1, 2])"), HasSubstr("zero_mean expects 0"));
  EXPECT_THAT(message(R"("nodes_deg": [0, 1], "over": {"variable": "A", "nodes_deg": [0, 1]}, "values": [[1, 2]])"),
              HasSubstr("own variable"));
  EXPECT_THAT(message(R"("nodes_deg": [0, 1], "values": [1, 2], "unit": "urad")"), HasSubstr("expected 'um'"));
}

}  // namespace
}  // namespace axiscal::machine
