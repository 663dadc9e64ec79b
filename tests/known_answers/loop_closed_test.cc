// The loop on the cases of another simulator (tests/data/loop), each with effects that its machine does not declare.
#include <gtest/gtest.h>

#include <algorithm>

#include "core/base/units.h"
#include "core/decide/close_loop.h"
#include "core/identify/identify.h"
#include "tests/known_answers/loop_truth.h"

namespace axiscal::known_answers {
namespace {

using nlohmann::json;

class LoopClosed : public testing::TestWithParam<std::string> {
 protected:
  void SetUp() override {
    case_ = loop_truth::ReadCase(GetParam());
    truth_ = loop_truth::ReadTruth(GetParam());
    const auto report = decide::CloseLoop(case_.machine, identify::BindSessions(case_.machine, case_.fit).value(),
                                          identify::BindSessions(case_.machine, case_.check).value());
    ASSERT_TRUE(report.ok()) << report.status();
    report_ = *report;
  }
  static bool IsNamed(const loop::Effect& effect, const machine::ErrorTerm& term) {
    return loop::IsSameEffect(effect.term, term) ||
           std::any_of(effect.equivalent.begin(), effect.equivalent.end(),
                       [&](const machine::ErrorTerm& one) { return loop::IsSameEffect(one, term); });
  }

  session::Case case_;
  json truth_;
  loop::Report report_;
};

TEST_P(LoopClosed, NamesWhatIsThereAndFitsAsIfItKnew) {
  size_t named = 0;
  for (const json& effect : truth_["effects"]) {
    const std::optional<machine::ErrorTerm> term = loop_truth::TermOf(effect, case_.machine);
    if (!term) {  // a local defect: its axis and range
      ASSERT_EQ(report_.unexplained.size(), 1u);
      const loop::Unexplained& structure = report_.unexplained[0];
      EXPECT_EQ(report_.verdict, loop::Verdict::kUnexplained);
      EXPECT_EQ(structure.kind, loop::Unexplained::kLocal);
      EXPECT_EQ(structure.variable, effect["var"].get<std::string>());
      EXPECT_LT(structure.from, effect["at"].get<double>());
      EXPECT_GT(structure.to, effect["at"].get<double>());
      continue;
    }
    ++named;
    EXPECT_TRUE(std::any_of(report_.effects.begin(), report_.effects.end(), [&](const loop::Effect& found) {
      return IsNamed(found, *term);
    })) << effect.dump();
  }
  EXPECT_EQ(report_.effects.size(), named);
  if (named == truth_["effects"].size()) {
    EXPECT_TRUE(report_.unexplained.empty());
    EXPECT_EQ(report_.verdict, named > 0 ? loop::Verdict::kExtended : loop::Verdict::kAdequate);
  }
  // As well as a fit that is told what went in; how far it leans towards bad readings, which count in these figures, is
  // its own choice. Of the check sessions only the set-ups are fitted.
  const double worse = loop_truth::IsDirty(truth_) ? 1.05 : 1.02;
  EXPECT_LT(base::kUmPerMm * report_.fit_after.rms_mm, worse * truth_["oracle"]["fit_after_um"].get<double>());
  EXPECT_LT(base::kUmPerMm * report_.check_after.rms_mm, worse * truth_["oracle"]["check_after_um"].get<double>());
}

INSTANTIATE_TEST_SUITE_P(Cases, LoopClosed, testing::ValuesIn(loop_truth::CaseNames()), loop_truth::NameOf);

// Two hundred chi-square units tell EXB:harmonic(2) from what stands in for it in the fit sessions, once the check
// sessions are fitted with them; under the errors of the fit sessions alone another member does as well.
TEST(LoopClosed, CheckSessionsTellTheMembersOfAClassApart) {
  const session::Case one = loop_truth::ReadCase("case-012");
  const auto report = decide::CloseLoop(one.machine, identify::BindSessions(one.machine, one.fit).value(),
                                        identify::BindSessions(one.machine, one.check).value());
  ASSERT_TRUE(report.ok()) << report.status();
  std::vector<std::string> names;
  for (const loop::Effect& effect : report->effects) names.push_back(machine::NameOf(one.machine, effect.term));
  std::sort(names.begin(), names.end());
  const auto reversal =
      std::find_if(names.begin(), names.end(), [](const auto& name) { return name.ends_with("reversal"); });
  ASSERT_NE(reversal, names.end());
  std::rotate(names.begin(), reversal, reversal + 1);
  // EAY:reversal and EYY:reversal are one class.
  ASSERT_EQ(names.size(), 4u);
  EXPECT_THAT(names[0], testing::AnyOf("EAY:reversal", "EYY:reversal"));
  names.erase(names.begin());
  EXPECT_EQ(names, (std::vector<std::string>{"EBB:backlash", "EXB:harmonic(2)", "EZT:drift"}));
}

}  // namespace
}  // namespace axiscal::known_answers
