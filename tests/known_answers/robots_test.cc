// Two robot arms measured by laser tracker (P. Jacobi, serial_robots_datasets, MIT): a serial chain is a serial chain,
// the engine identifies them with no code of their own. The data is used in place where it is there, and not copied
// here.
#include <gtest/gtest.h>

#include <filesystem>

#include "core/base/testing/source_path.h"
#include "core/base/units.h"
#include "core/decide/close_loop.h"
#include "core/identify/identify.h"
#include "core/session/case.h"
#include "tests/known_answers/published.h"

namespace axiscal::known_answers {
namespace {

struct Robot {
  const char* name;
  int fit_poses, check_poses;
  double published_mm;  // mean error on the check poses by plain least squares with free joint location errors
  double closed_mm;     // at most, once the loop has added what the geometry lacks
  bool is_foretold;     // by the fit poses alone
  bool is_periodic;     // that is a periodic error of a joint (gears), otherwise backlash (cables)
};

// With one set-up in all sessions: the tracker stood where it stood.
std::vector<instruments::MeasuringRun> Bound(const session::Case& c, std::vector<session::Session> sessions) {
  for (session::Session& one : sessions) one.header.push_back({"setup", "tracker"});
  return identify::BindSessions(c.machine, sessions).value();
}

class Robots : public testing::TestWithParam<Robot> {};

double MeanDistanceMm(const Eigen::MatrixXd& residuals_mm) { return residuals_mm.colwise().norm().mean(); }

TEST_P(Robots, AreIdentifiedWithNoCodeOfTheirOwn) {
  const std::string folder = base::SourcePath("/../shared/data/robots/") + GetParam().name;
  if (!std::filesystem::exists(folder)) GTEST_SKIP() << folder << " is not here";
  const auto c = session::ReadCase(folder);
  ASSERT_TRUE(c.ok()) << c.status();
  const auto fit = identify::FitRuns(c->machine, identify::BindSessions(c->machine, c->fit).value(), {});
  ASSERT_TRUE(fit.ok()) << fit.status();
  EXPECT_EQ(fit->problem.runs[0].reading_count(), GetParam().fit_poses);
  const auto check =
      identify::CheckRuns(c->machine, identify::BindSessions(c->machine, c->check).value(), fit->result.model, {});
  ASSERT_TRUE(check.ok()) << check.status();
  EXPECT_EQ(check->problem.runs[0].reading_count(), GetParam().check_poses);

  // Every error is either a number, or part of a combination that is named.
  const int errors = static_cast<int>(c->machine.declared.size());
  EXPECT_EQ(fit->result.rank + static_cast<int>(fit->result.not_separable.size()), errors);
  EXPECT_LT(fit->result.rank, errors);
  for (const identify::Estimate& estimate : fit->result.estimates) {
    EXPECT_EQ(estimate.identifiable, std::isfinite(estimate.value)) << estimate.name;
  }
  for (const std::string& name : fit->result.not_separable) EXPECT_FALSE(name.empty());

  const double mean_mm = MeanDistanceMm(check->residuals_mm[0]);
  RecordProperty("rank", fit->result.rank);
  ExpectAtMost(mean_mm, GetParam().published_mm,
               absl::StrCat("Jacobi, serial_robots_datasets: mean error of unused poses, ", GetParam().name, ", mm"));
}

TEST_P(Robots, LackWhatTheirGearsAndCablesDo) {
  const std::string folder = base::SourcePath("/../shared/data/robots/") + GetParam().name;
  if (!std::filesystem::exists(folder)) GTEST_SKIP() << folder << " is not here";
  const auto c = session::ReadCase(folder);
  ASSERT_TRUE(c.ok()) << c.status();
  const auto report = decide::CloseLoop(c->machine, Bound(*c, c->fit), Bound(*c, c->check));
  ASSERT_TRUE(report.ok()) << report.status();
  EXPECT_EQ(report->is_check_fitted, !GetParam().is_foretold);
  const bool is_named = std::any_of(report->effects.begin(), report->effects.end(), [](const loop::Effect& effect) {
    return machine::IsAngle(effect.term.component) &&
           (GetParam().is_periodic ? std::holds_alternative<shapes::Harmonic>(effect.term.shape)
                                   : std::holds_alternative<shapes::Backlash>(effect.term.shape));
  });
  EXPECT_TRUE(is_named);
  const loop::SessionResiduals& check = report->residuals.back();
  ASSERT_TRUE(check.is_check);
  const double mean_mm = MeanDistanceMm(check.after_mm);
  RecordProperty("mean_mm", std::to_string(mean_mm));
  EXPECT_LE(mean_mm, GetParam().closed_mm);
  for (const loop::Proposal& proposal : report->next_measurement)
    EXPECT_TRUE(!proposal.test.empty() || !proposal.remaining.empty()) << "nothing is told from nothing";
}

INSTANTIATE_TEST_SUITE_P(Arms, Robots,
                         testing::Values(Robot{"ur5", 1000, 20, 0.098, 0.05, true, true},
                                         Robot{"wam", 216, 20, 3.03, 2.3, false, false}),
                         [](const auto& robot) { return std::string(robot.param.name); });

}  // namespace
}  // namespace axiscal::known_answers
