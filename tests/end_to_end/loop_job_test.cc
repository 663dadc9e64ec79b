// Closing the loop as a job: what it stores, how it is watched and cancelled, what it refuses.
#include <nlohmann/json.hpp>

#include "core/base/error_detail.h"
#include "core/identify/testing/scenario.h"
#include "tests/end_to_end/testing/job_fixture.h"

namespace axiscal {
namespace {

using ballbar::Pattern;
using identify::testing::Measured;
using records::JobState;

class LoopJob : public testing::Job {
 protected:
  // Ball-bar patterns on a machine whose B has a backlash that its machine.json does not declare.
  std::vector<SessionId> UploadWithBacklash(const std::vector<Measured>& patterns) {
    const machine::Machine machine = machine::testing::MultiTasking();
    const machine::ErrorModel truth = identify::testing::Errors(
        machine, R"({"EX0C": 20, "terms": [{"symbol": "EBB", "shape": "backlash", "amplitude": 40}]})");
    std::vector<SessionId> ids;
    for (const session::Session& session : identify::testing::Measure(machine, truth, {}, patterns))
      ids.push_back(UploadSession(session));
    return ids;
  }
};

TEST_F(LoopJob, ACancelledLoopStoresNothing) {
  const records::CloseLoopParams params{MachineId("mt"), {UploadSession("a", 50'000)}, {UploadSession("b")}, {}};
  const auto job = client().CreateJob(params);
  ASSERT_OK(job);
  bool has_run = false;
  const auto ended = client().WatchJob(job->id, [&](const client::JobRecord& record) {
    if (!has_run && record.state == JobState::kRunning) {
      has_run = true;
      EXPECT_TRUE(client().CancelJob(job->id).ok());
    }
    return true;
  });
  ASSERT_OK(ended);
  EXPECT_TRUE(has_run);
  EXPECT_EQ(ended->state, JobState::kCancelled);
  EXPECT_TRUE(client().ListCalibrations()->rows.empty());
}

TEST_F(LoopJob, TheLoopReportsItsProgressAndRefusesWhatProvesNothing) {
  const SessionId fit = UploadSession("a"), check = UploadSession("b");
  const auto job = client().CreateJob(records::CloseLoopParams{MachineId("mt"), {fit}, {check}, 2});
  ASSERT_OK(job);
  double fraction = 0.0;
  std::string stages;
  const auto ended = client().WatchJob(job->id, [&](const client::JobRecord& record) {
    EXPECT_GE(record.progress.fraction, fraction);
    fraction = record.progress.fraction;
    absl::StrAppend(&stages, record.progress.stage, ";");
    return true;
  });
  ASSERT_OK(ended);
  ASSERT_EQ(ended->state, JobState::kSucceeded) << (ended->error ? ended->error->message : "");
  EXPECT_FALSE(stages.empty());
  EXPECT_EQ(ended->result, client().GetCalibration(*ended->calibration)->content.report_json);

  const auto field = [&](const records::CloseLoopParams& params) {
    const auto detail = base::GetErrorDetail(client().CreateJob(params).status());
    return detail.has_value() && detail->facts.count("field") > 0 ? detail->facts.at("field") : std::string("none");
  };
  const MachineId mt("mt");
  EXPECT_EQ(field({mt, {}, {check}, {}}), "params.close_loop.fit_session_ids");
  EXPECT_EQ(field({mt, {fit}, {check, fit}, {}}), "params.close_loop.check_session_ids[1]");
  EXPECT_EQ(field({mt, {fit}, {check, check}, {}}), "params.close_loop.check_session_ids[1]");
  EXPECT_EQ(field({mt, {fit}, {}, 51}), "params.close_loop.max_effects");
}

// Provenance: the sessions that the amplitudes come from.
TEST_F(LoopJob, ACalibrationListsTheSessionsThatItWasFittedTo) {
  const auto ids = UploadWithBacklash({{"CR", Pattern::kCR, 356.4},
                                       {"CA", Pattern::kCA, 356.4},
                                       {"CT", Pattern::kCT, 356.4},
                                       {"BX", Pattern::kBX, 356.4},
                                       {"BY", Pattern::kBY, 356.4}});
  const SessionId cr = ids.at(0), ca = ids.at(1), ct = ids.at(2), bx = ids.at(3), by = ids.at(4);
  const auto expect_from = [&](const std::vector<SessionId>& fit, const std::vector<SessionId>& check, bool is_fitted) {
    const client::JobRecord job = RunJob(records::CloseLoopParams{MachineId("mt"), fit, check, {}});
    ASSERT_EQ(job.state, JobState::kSucceeded) << (job.error ? job.error->message : "");
    const auto calibration = client().GetCalibration(*job.calibration);
    ASSERT_OK(calibration);
    const auto report = nlohmann::json::parse(calibration->content.report_json);
    EXPECT_EQ(report.at("effects").size(), 1u);
    EXPECT_EQ(report.at("check").at("fitted"), is_fitted);
    std::vector<SessionId> expected = fit;
    if (is_fitted) expected.insert(expected.end(), check.begin(), check.end());
    EXPECT_EQ(calibration->content.sessions, expected);
  };
  expect_from({cr, ca}, {ct, bx}, true);  // B rests in the fit sessions: the check sessions alone show its backlash
  expect_from({cr, ca, bx}, {ct, by}, false);
}

}  // namespace
}  // namespace axiscal
