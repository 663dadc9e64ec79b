// What happened to a machine, told over the wire from its calibrations.
#include <gmock/gmock.h>
#include <grpcpp/grpcpp.h>

#include "axiscal/v1/history_service.grpc.pb.h"
#include "core/base/error_detail.h"
#include "server/storage/sqlite_database.h"
#include "tests/end_to_end/testing/job_fixture.h"
#include "tests/end_to_end/testing/raw_upload.h"

namespace axiscal {
namespace {

using ::testing::AllOf;
using ::testing::HasSubstr;

constexpr int kWeeks = 60, kJumpAt = 40;
constexpr double kJumpUm = 20;
const base::UtcTime kFirst = base::FromUtcUs(1'735'689'600'000'000);  // 2025-01-01

base::UtcTime WeekOf(int week) { return kFirst + std::chrono::days(7 * week); }

class Drift : public testing::Job {
 protected:
  // Weekly calibrations of one session each, which scatter as they state (1 um) and whose EX0C and EY0C are correlated;
  // both jump before week kJumpAt. All are approved, but for what is said.
  void StoreHistory() {
    for (int week = 0; week < kWeeks; ++week) sessions_.push_back(UploadSession("S" + std::to_string(week), 20));
    embedded_.reset();
    storage::SqliteOptions sqlite;
    sqlite.path = dir_.File("axiscal.db");
    auto opened = storage::OpenSqlite(sqlite);
    ASSERT_OK(opened);
    database_ = *std::move(opened);
    uint32_t seed = 1;
    // Near enough to normal: mean 0, variance 1.
    const auto normal = [&] {
      double sum = -6;
      for (int i = 0; i < 12; ++i) sum += static_cast<double>((seed = seed * 1664525 + 1013904223) >> 8) / (1 << 24);
      return sum;
    };
    for (int week = 0; week < kWeeks; ++week) {
      const double x = normal(), y = 0.6 * x + 0.8 * normal(), jump = week >= kJumpAt ? kJumpUm : 0;
      const CalibrationId id = Store(week, 10 + jump + x, -5 - 0.6 * jump + y);
      if (week < kWeeks - 1) ASSERT_OK(database_->ApproveCalibration(id, 0, kCaller));
      // A trial with other options of sessions whose calibration is approved: it is no point of the history.
      if (week == 20) Store(week, 500, 500);
    }
    database_.reset();
    Restart();
  }
  CalibrationId Store(int week, double ex0c, double ey0c) {
    storage::NewJob job;
    job.kind = records::kIdentify;
    job.machine = MachineId("mt");
    job.caller = kCaller;
    EXPECT_TRUE(database_->CreateJob(job, 10).ok());
    const auto claimed = database_->ClaimJob(std::chrono::seconds(30));
    EXPECT_TRUE(claimed.ok());
    storage::NewCalibration calibration;
    calibration.machine = MachineId("mt");
    calibration.machine_revision = 1;
    calibration.sessions = {sessions_[static_cast<size_t>(week)]};
    calibration.measured_at = WeekOf(week);
    calibration.options_json = calibration.report_json = "{}";
    calibration.model_json = absl::StrFormat(R"({"EX0C": %.3f, "EY0C": %.3f, "covariance": {"of": ["EX0C", "EY0C"],
        "sigma": [1, 1], "correlation": [[], [0.6]]}})",
                                             ex0c, ey0c);
    calibration.estimates = {{"EX0C", records::EstimateUnit::kUm, true, ex0c, 1.0},
                             {"EY0C", records::EstimateUnit::kUm, true, ey0c, 1.0},
                             {"EA0C", records::EstimateUnit::kUrad, false, {}, {}}};
    calibration.created_by = "test";
    const auto done = database_->SucceedJob(storage::ClaimOf(**claimed), {"{}", calibration, {}});
    EXPECT_TRUE(done.ok()) << done.status();
    return *done->calibration;
  }
  grpc::Status Find(const v1::FindDriftRequest& request, v1::FindDriftResponse* response) {
    const auto stub = v1::History::NewStub(channel());
    grpc::ClientContext context;
    return stub->FindDrift(&context, request, response);
  }

  static inline const storage::Caller kCaller = {"test", ""};
  std::vector<SessionId> sessions_;
  std::unique_ptr<storage::Database> database_;
};

TEST_F(Drift, AStepIsToldInWordsAndWhatWasNotApprovedDoesNotCount) {
  StoreHistory();
  v1::FindDriftRequest request;
  request.set_machine_id("mt");
  const std::vector<std::tuple<std::string, double, double>> limits = {
      {"EX0C", -100, 20}, {"EX0C", -500, 500}, {"EC0C", -1, 1}};
  for (const auto& [symbol, low, high] : limits) {
    v1::DriftLimit& limit = *request.add_limits();
    limit.set_symbol(symbol);
    limit.set_low(low);
    limit.set_high(high);
  }
  v1::FindDriftResponse found;
  ASSERT_TRUE(Find(request, &found).ok());
  EXPECT_EQ(found.calibrations(), kWeeks + 1);
  EXPECT_EQ(found.calibration_ids_size(), kWeeks - 1);  // neither the trial nor the last candidate
  EXPECT_EQ(found.not_counted_size(), 0);
  std::vector<v1::DriftFinding> steps;
  for (const v1::DriftFinding& finding : found.findings()) {
    if (finding.kind() == v1::DRIFT_FINDING_KIND_STEP && !finding.is_revision()) steps.push_back(finding);
  }
  ASSERT_EQ(steps.size(), 1u) << found.DebugString();
  EXPECT_EQ(steps[0].after_utc_us(), base::ToUtcUs(WeekOf(kJumpAt - 1)));
  EXPECT_EQ(steps[0].by_utc_us(), base::ToUtcUs(WeekOf(kJumpAt)));
  EXPECT_GT(steps[0].certainty(), 0.9);
  ASSERT_EQ(steps[0].amounts_size(), 2);
  for (const v1::DriftAmount& amount : steps[0].amounts()) {
    EXPECT_NEAR(amount.size(), amount.symbol() == "EX0C" ? kJumpUm : -0.6 * kJumpUm, 4 * amount.sigma());
    EXPECT_EQ(amount.unit(), v1::ESTIMATE_UNIT_UM);
  }
  EXPECT_THAT(steps[0].text(), AllOf(HasSubstr("between 1 and 8 October 2025"), HasSubstr("EX0C"), HasSubstr("EY0C"),
                                     HasSubstr("jumped together"), HasSubstr(" um")));
  // It stands at 30 um now.
  ASSERT_EQ(found.limits_size(), 3);
  EXPECT_GT(found.limits(0).probability_now(), 0.95);
  EXPECT_THAT(found.limits(0).text(), HasSubstr("EX0C is outside -100 .. 20 um now with a probability of 100 %"));
  EXPECT_LT(found.limits(1).probability_within_year(), 0.05);
  EXPECT_FALSE(found.limits(2).has_probability_now());
  EXPECT_THAT(found.limits(2).text(), HasSubstr("no forecast"));
}

TEST_F(Drift, EachErrorIsForetoldWhereItIsAskedFor) {
  StoreHistory();
  v1::FindDriftRequest request;
  request.set_machine_id("mt");
  v1::FindDriftResponse found;
  ASSERT_TRUE(Find(request, &found).ok());
  EXPECT_EQ(found.forecasts_size(), 0);
  request.set_forecast_days(180);
  ASSERT_TRUE(Find(request, &found).ok());
  std::map<std::string, v1::ErrorForecast> forecasts;
  for (const v1::ErrorForecast& forecast : found.forecasts()) forecasts[forecast.symbol()] = forecast;
  ASSERT_TRUE(forecasts.contains("EX0C"));
  const auto& points = forecasts["EX0C"].points();
  ASSERT_GT(points.size(), 2);
  const base::UtcTime last = WeekOf(kWeeks - 2);  // the last that counts
  EXPECT_EQ(points[0].at_utc_us(), base::ToUtcUs(last));
  EXPECT_EQ(points[points.size() - 1].at_utc_us(), base::ToUtcUs(last + std::chrono::days(180)));
  for (const v1::ForecastPoint& point : points) {
    EXPECT_LT(point.low(), point.value());
    EXPECT_GT(point.high(), point.value());
    EXPECT_NEAR(point.value(), 10 + kJumpUm, 5);
  }
  const auto width = [](const v1::ForecastPoint& point) { return point.high() - point.low(); };
  EXPECT_GT(width(points[points.size() - 1]), width(points[0]));  // it knows less of later
  EXPECT_EQ(forecasts["EX0C"].text(), "");
  EXPECT_EQ(forecasts["EX0C"].unit(), v1::ESTIMATE_UNIT_UM);
  for (const int days : {-1, 1827}) {
    request.set_forecast_days(days);
    EXPECT_EQ(Find(request, &found).error_code(), grpc::StatusCode::INVALID_ARGUMENT) << days;
  }
}

TEST_F(Drift, CandidatesCountWhereTheyAreAskedFor) {
  StoreHistory();
  v1::FindDriftRequest request;
  request.set_machine_id("mt");
  request.set_counts_candidates(true);
  v1::FindDriftResponse found;
  ASSERT_TRUE(Find(request, &found).ok());
  EXPECT_EQ(found.calibration_ids_size(), kWeeks);
}

// What the client library and the command line show.
TEST_F(Drift, TheClientHandsOutTheSame) {
  StoreHistory();
  records::DriftSearch search{MachineId("mt"), {{"EX0C", -100, 20}}, true};
  const auto report = client().FindDrift(search);
  ASSERT_OK(report);
  EXPECT_EQ(report->calibrations, kWeeks + 1);
  EXPECT_EQ(report->counted.size(), static_cast<size_t>(kWeeks));
  const auto step = std::find_if(report->findings.begin(), report->findings.end(),
                                 [](const auto& finding) { return finding.kind == records::DriftKind::kStep; });
  ASSERT_NE(step, report->findings.end());
  EXPECT_EQ(step->after, WeekOf(kJumpAt - 1));
  EXPECT_EQ(step->by, WeekOf(kJumpAt));
  EXPECT_THAT(step->text, HasSubstr("jumped together"));
  EXPECT_EQ(step->amounts.size(), 2u);
  ASSERT_EQ(report->limits.size(), 1u);
  EXPECT_EQ(report->limits[0].limit.high, 20);
  EXPECT_GT(report->limits[0].probability_now.value_or(0), 0.95);
  EXPECT_TRUE(report->limits[0].median.has_value());
}

// A person says when the machine was hit: the errors start anew there, and nothing is told of what differs afterwards.
TEST_F(Drift, AMarkEndsWhatStoodBefore) {
  StoreHistory();
  const records::NewMark collision{MachineId("mt"),
                                   WeekOf(kJumpAt) - std::chrono::days(2),
                                   records::MarkKind::kCollision,
                                   {"EX0C", "EY0C"},
                                   "hit the chuck"};
  const auto put = client().PutMark(collision, "mark-1");
  ASSERT_OK(put);
  EXPECT_EQ(client().PutMark(collision, "mark-1")->id, put->id);
  const auto steps_of = [&] {
    const auto report = client().FindDrift({MachineId("mt"), {}, false});
    EXPECT_TRUE(report.ok()) << report.status();
    return std::count_if(report->findings.begin(), report->findings.end(),
                         [](const auto& finding) { return finding.kind == records::DriftKind::kStep; });
  };
  EXPECT_EQ(steps_of(), 0);
  const auto report = client().FindDrift({MachineId("mt"), {}, false});
  ASSERT_EQ(report->marks.size(), 1u);
  EXPECT_EQ(report->marks[0].content.note, "hit the chuck");
  ASSERT_OK(client().WithdrawMark(put->id));
  EXPECT_GE(steps_of(), 1);
  EXPECT_TRUE(client().FindDrift({MachineId("mt"), {}, false})->marks.empty());
  EXPECT_TRUE(client().ListMarks(MachineId("mt"))->rows.at(0).withdrawn_at.has_value());

  // One that stands behind every calibration changes nothing that was told.
  records::NewMark late = collision;
  late.at = WeekOf(kWeeks + 1);
  ASSERT_OK(client().PutMark(late));
  EXPECT_GE(steps_of(), 1);
  // A misspelt error would end nothing.
  late.symbols = {"EX0C", "EXOC"};
  const absl::Status misspelt = client().PutMark(late).status();
  EXPECT_EQ(base::ErrorReason(misspelt), "FIELD_INVALID");
  EXPECT_THAT(misspelt.message(), AllOf(HasSubstr("symbols[1]"), HasSubstr("EXOC")));
  EXPECT_EQ(base::ErrorReason(client().PutMark({MachineId("none"), WeekOf(1), late.kind, {}, ""}).status()),
            "MACHINE_NOT_FOUND");
}

TEST_F(Drift, WhatCannotBeAskedIsRefused) {
  v1::FindDriftResponse found;
  v1::FindDriftRequest request;
  EXPECT_EQ(testing::ReasonOf(Find(request, &found)), "FIELD_INVALID");
  request.set_machine_id("none");
  EXPECT_EQ(testing::ReasonOf(Find(request, &found)), "MACHINE_NOT_FOUND");
  request.set_machine_id("mt");
  EXPECT_TRUE(Find(request, &found).ok());
  EXPECT_EQ(found.findings_size(), 0);
  v1::DriftLimit& limit = *request.add_limits();
  limit.set_symbol("EX0C");
  limit.set_low(1);
  limit.set_high(1);
  const grpc::Status status = Find(request, &found);
  EXPECT_EQ(testing::ReasonOf(status), "FIELD_INVALID");
  EXPECT_THAT(status.error_message(), HasSubstr("limits[0].low"));
}

}  // namespace
}  // namespace axiscal
