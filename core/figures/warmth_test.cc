// Figures at 20 deg C, by hand.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>

#include "core/figures/figures.h"
#include "core/machine/testing/machines.h"

namespace axiscal::figures {
namespace {

using ::testing::Contains;
using ::testing::HasSubstr;
using ::testing::IsEmpty;
using ::testing::SizeIs;

// An interferometer along X, 0 to 400 mm there and back, twice, at 25 deg C: the machine's glass scale of 8 um/(m K) is
// 400 x 8e-6 x 5 = 16 um too long at 400.
session::Session WarmLine(const std::vector<session::HeaderEntry>& keys) {
  session::Session session;
  session.header = {{"machine", "mt"},           {"session", "X"},  {"instrument", "length"},   {"sigma_um", "0.01"},
                    {"tool_tip_mm", "0 0 -150"}, {"beam", "1 0 0"}, {"scale_sigma_um", "0.001"}};
  session.header.insert(session.header.end(), keys.begin(), keys.end());
  std::vector<double> x_mm, senses;
  for (const double sense : {1.0, -1.0, 1.0, -1.0}) {
    for (int i = 0; i <= 4; ++i) {
      x_mm.push_back(sense > 0.0 ? 100.0 * i : 100.0 * (4 - i));
      senses.push_back(sense);
    }
  }
  for (const machine::Axis& axis : machine::testing::MultiTasking().axes)
    session.columns.push_back({axis.name + (axis.kind == machine::AxisKind::kLinear ? "_mm" : "_deg"),
                               axis.name == "X" ? x_mm : std::vector<double>(x_mm.size(), 0.0),
                               {}});
  session.columns.push_back({"X_sense", senses, {}});
  session.columns.push_back({"temp_C", std::vector<double>(x_mm.size(), 25.0), {}});
  std::vector<double> lengths_mm;
  for (const double x : x_mm) lengths_mm.push_back(x * (1.0 + 8e-6 * 5.0));
  session.columns.push_back({"L_mm", lengths_mm, {}});
  return session;
}

MeasuredTest TestOf(const std::vector<session::HeaderEntry>& keys) {
  const auto run = instruments::BindSession(WarmLine(keys), machine::testing::MultiTasking());
  EXPECT_TRUE(run.ok()) << run.status();
  const Figures figures = FiguresOf(machine::testing::MultiTasking(), {*run});
  EXPECT_THAT(figures.left_out, IsEmpty());
  EXPECT_THAT(figures.tests, SizeIs(1));
  return figures.tests[0];
}

Figure FigureOf(const MeasuredTest& test, const std::string& symbol) {
  for (const Figure& figure : test.figures)
    if (figure.symbol == symbol) return figure;
  ADD_FAILURE() << symbol;
  return {};
}

TEST(Warmth, AsItIsWithoutAWord) {
  const MeasuredTest test = TestOf({});
  EXPECT_NEAR(FigureOf(test, "E").value_mm, 16e-3, 1e-7);
  EXPECT_NEAR(FigureOf(test, "M").value_mm, 16e-3, 1e-7);
}

// The machine at 20 deg C has no error; its coefficient, known to 0.5, makes 400 x 0.5e-6 x 5 = 1 um.
TEST(Warmth, OfTheMachineAtReference) {
  const MeasuredTest test = TestOf({{"expansion scale X", "8 0.5"}});
  const Figure systematic = FigureOf(test, "E");
  EXPECT_NEAR(systematic.value_mm, 0.0, 1e-7);
  EXPECT_THAT(test.notes, Contains(HasSubstr("at 20 deg C, by what the sessions state: expansion of scale X, 8 +- "
                                             "0.5 um/(m K)")));
}

// A steel workpiece of 11.5 cut at 25 deg C is 400 x (8 - 11.5)e-6 x 5 = -7 um short when it is cold again.
TEST(Warmth, OfWhatIsCut) {
  const MeasuredTest test = TestOf({{"expansion workpiece", "11.5 0.5"}});
  const Figure systematic = FigureOf(test, "E");
  EXPECT_NEAR(systematic.value_mm, 7e-3, 1e-7);
  EXPECT_NEAR(systematic.sigma_mm, 1e-3, 0.25e-3);  // 100 draws
  ASSERT_TRUE(test.positioning.has_value());
  EXPECT_NEAR(test.positioning->targets.back().up->mean_mm - test.positioning->targets.front().up->mean_mm, -7e-3,
              1e-7);
}

}  // namespace
}  // namespace axiscal::figures
