#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <random>

#include "core/base/error_detail.h"
#include "server/storage/check.h"
#include "server/storage/testing/temp_database.h"

namespace axiscal::storage {
namespace {

using std::chrono::hours;

constexpr hours kDay(24);

class History : public testing::Test {
 protected:
  History() : start(database.clock.UtcNow()) { DEMAND(database->CreateMachine(MachineId("mt"), "{}", Cell("")).ok()); }
  CalibrationId Calibrate(UtcTime at, double ea0b_urad) {
    values.push_back({at, ea0b_urad});
    const auto made = database->CreateCalibration(TestCalibration(at, ea0b_urad));
    DEMAND(made.ok());
    return made->id;
  }
  DriftQuery Query(UtcTime from, UtcTime to, int max_points) {
    return {MachineId("mt"), {"EA0B"}, from, to, max_points};
  }
  // The slow way: every point of the answer against all estimates that lie in it, and nothing left over.
  void ExpectAgrees(const DriftQuery& query) {
    const auto drift = database->QueryDrift(query);
    ASSERT_TRUE(drift.ok()) << drift.status();
    ASSERT_EQ(drift->size(), 1u);
    const std::vector<DriftPoint>& points = (*drift)[0].points;
    EXPECT_LE(points.size(), static_cast<size_t>(query.max_points));
    int64_t total = 0;
    for (const DriftPoint& point : points) {
      std::vector<double> inside;
      for (const auto& [at, value] : values) {
        if (at >= point.first_at && at <= point.last_at) inside.push_back(value);
      }
      total += point.count;
      ASSERT_EQ(point.count, static_cast<int64_t>(inside.size()));
      EXPECT_EQ(point.min, *std::min_element(inside.begin(), inside.end()));
      EXPECT_EQ(point.max, *std::max_element(inside.begin(), inside.end()));
      double sum = 0.0;
      for (const double value : inside) sum += value;
      EXPECT_NEAR(point.mean, sum / static_cast<double>(inside.size()), 1e-9);
    }
    const int64_t expected = std::count_if(values.begin(), values.end(), [&](const auto& value) {
      return value.first >= query.from && value.first < query.to;
    });
    EXPECT_EQ(total, expected);
    EXPECT_EQ((*drift)[0].unit, EstimateUnit::kUrad);
    EXPECT_TRUE(database.damages.empty()) << database.damages[0];
  }
  // Behind the store.
  void Execute(const std::string& sql) {
    const absl::Status done = database.Beside()->Execute(sql);
    ASSERT_TRUE(done.ok()) << sql << ": " << done;
  }
  std::vector<std::string> Damages() {
    std::vector<std::string> named;
    for (const Damage& damage : database.Check().damages) named.push_back(damage.resource);
    return named;
  }

  TempDatabase database;
  UtcTime start;
  std::vector<std::pair<UtcTime, double>> values;
};

TEST_F(History, FewEstimatesAreGivenOneByOne) {
  for (int day = 0; day < 5; ++day) Calibrate(start + day * kDay, 10.0 * day);
  const auto drift = database->QueryDrift({MachineId("mt"), {}, start + kDay, start + 4 * kDay, 100});
  ASSERT_TRUE(drift.ok()) << drift.status();
  ASSERT_EQ(drift->size(), 3u);
  EXPECT_EQ((*drift)[0].symbol, "EA0B");
  EXPECT_EQ((*drift)[1].symbol, "EC0C");
  EXPECT_TRUE((*drift)[1].points.empty());  // never identifiable: no number
  EXPECT_EQ((*drift)[1].not_identifiable_count, 3);
  const std::vector<DriftPoint>& points = (*drift)[0].points;
  ASSERT_EQ(points.size(), 3u);
  EXPECT_EQ(points[0].mean, 10.0);
  EXPECT_EQ(points[0].sigma, 0.6);
  EXPECT_EQ(points[0].first_at, start + kDay);
  EXPECT_EQ(points[2].last_calibration.number(), 4);
}

TEST_F(History, ManyEstimatesAreMergedWithoutLosingOne) {
  std::mt19937 random(4);
  UtcTime at = start;
  for (int i = 0; i < 400; ++i) {
    at += std::chrono::minutes(random() % (3 * 24 * 60));
    Calibrate(at, static_cast<double>(random() % 1000) / 7.0);
  }
  for (const int max_points : {1, 2, 7, 30, 57, 100, 399, 400, 1000}) {
    ExpectAgrees(Query(start, at + kDay, max_points));
    ExpectAgrees(Query(start + 100 * kDay + hours(5), at - 50 * kDay, max_points));
    ExpectAgrees(Query(UtcTime(), at + 10000 * kDay, max_points));
  }
}

TEST_F(History, LateAndEqualTimesKeepTheNewestLast) {
  Calibrate(start + kDay, 1.0);
  Calibrate(start, 2.0);
  Calibrate(start + kDay, 3.0);
  const auto drift = database->QueryDrift(Query(start, start + 10 * kDay, 1));
  ASSERT_EQ((*drift)[0].points.size(), 1u);
  EXPECT_EQ((*drift)[0].points[0].last_calibration.number(), 3);
  EXPECT_EQ((*drift)[0].points[0].mean, 2.0);
}

// One by one, and in the sums over weeks.
TEST_F(History, ARejectedCandidateIsNoPoint) {
  const CalibrationId first = database->CreateCalibration(TestCalibration(start, 1.0))->id;
  ASSERT_TRUE(database->ApproveCalibration(first, 0, Cell("")).ok());
  const CalibrationId rejected = database->CreateCalibration(TestCalibration(start + hours(1), 900.0))->id;
  const CalibrationId last = database->CreateCalibration(TestCalibration(start + 100 * kDay, 3.0))->id;
  const auto seen = [&](int max_points) {
    std::string text;
    const auto drift = database->QueryDrift(Query(start - 30 * kDay, start + 200 * kDay, max_points));
    DEMAND(drift.ok());
    for (const DriftSeries& series : *drift) {
      for (const DriftPoint& point : series.points) {
        absl::StrAppend(&text, point.count, " from ", point.min, " to ", point.max, " of ",
                        point.last_calibration.number(), "; ");
      }
    }
    return text;
  };
  EXPECT_EQ(seen(100), "1 from 1 to 1 of 1; 1 from 900 to 900 of 2; 1 from 3 to 3 of 3; ");
  EXPECT_EQ(seen(2), "2 from 1 to 900 of 2; 1 from 3 to 3 of 3; ");
  EXPECT_EQ(seen(1), "3 from 1 to 900 of 3; ");
  ASSERT_TRUE(database->RetireCalibration(rejected, 0, Cell("")).ok());
  EXPECT_EQ(seen(100), "1 from 1 to 1 of 1; 1 from 3 to 3 of 3; ");
  EXPECT_EQ(seen(1), "2 from 1 to 3 of 3; ");
  EXPECT_TRUE(database->GetCalibration(rejected).ok());
  // What was in use is a point for good; what was rejected becomes one when it is approved after all.
  ASSERT_TRUE(database->ApproveCalibration(last, 0, Cell("")).ok());
  EXPECT_EQ(seen(1), "2 from 1 to 3 of 3; ");
  ASSERT_TRUE(database->ApproveCalibration(rejected, 0, Cell("")).ok());
  EXPECT_EQ(seen(1), "3 from 1 to 900 of 3; ");
  EXPECT_EQ(seen(100), "1 from 1 to 1 of 1; 1 from 900 to 900 of 2; 1 from 3 to 3 of 3; ");
}

// One number, one time, which error it is, or whether its calibration counts.
TEST_F(History, ADamagedEstimateIsLeftOutAndNamed) {
  for (int day = 0; day < 3; ++day) Calibrate(start + day * kDay, 10.0 * day);
  const DriftQuery query = Query(start, start + 10 * kDay, 100);
  const std::pair<std::string, std::string> damages[] = {
      {"UPDATE estimate SET estimated_um_urad = 10.5 WHERE calibration_id = 2 AND symbol = 'EA0B'",
       "UPDATE estimate SET estimated_um_urad = 10.0 WHERE calibration_id = 2 AND symbol = 'EA0B'"},
      {"UPDATE estimate SET sigma_um_urad = 0.1 WHERE calibration_id = 2 AND symbol = 'EA0B'",
       "UPDATE estimate SET sigma_um_urad = 0.6 WHERE calibration_id = 2 AND symbol = 'EA0B'"},
      {"UPDATE estimate SET unit = 1 WHERE calibration_id = 2 AND symbol = 'EA0B'",
       "UPDATE estimate SET unit = 2 WHERE calibration_id = 2 AND symbol = 'EA0B'"},
      {"UPDATE estimate SET measured_at_utc_us = measured_at_utc_us + 1 WHERE calibration_id = 2 AND symbol = 'EA0B'",
       "UPDATE estimate SET measured_at_utc_us = measured_at_utc_us - 1 WHERE calibration_id = 2 AND symbol = 'EA0B'"},
      {"UPDATE estimate SET crc32c = NULL WHERE calibration_id = 2 AND symbol = 'EA0B'", ""},
  };
  for (const auto& [damage, repair] : damages) {
    database.Close();  // told again of what it was told before
    database.Open();
    Execute(damage);
    database.damages.clear();
    for (int times = 0; times < 2; ++times) {
      const auto drift = database->QueryDrift(query);
      ASSERT_TRUE(drift.ok()) << drift.status();
      ASSERT_EQ(drift->at(0).points.size(), 2u) << damage;
      EXPECT_EQ(drift->at(0).points[0].mean, 0.0) << damage;
      EXPECT_EQ(drift->at(0).points[1].mean, 20.0) << damage;
      EXPECT_EQ(drift->at(0).unit, EstimateUnit::kUrad);
    }
    ASSERT_EQ(database.damages.size(), 1u) << damage;
    EXPECT_TRUE(absl::IsDataLoss(database.damages[0])) << database.damages[0];
    const auto detail = base::GetErrorDetail(database.damages[0]);
    EXPECT_EQ(detail->reason, "HISTORY_DAMAGED");
    EXPECT_EQ(detail->facts.at("machine"), "mt");
    EXPECT_EQ(detail->facts.at("symbol"), "EA0B");
    EXPECT_EQ(detail->facts.at("calibration"), "2");
    database.Close();
    EXPECT_THAT(Damages(), testing::Contains("machines/mt, history of EA0B, calibration 2")) << damage;
    database.Open();
    if (!repair.empty()) Execute(repair);
  }
}

TEST_F(History, TheFleetLeavesOutWhatIsDamaged) {
  for (int day = 0; day < 3; ++day) Calibrate(start + day * kDay, 10.0 * day);
  Execute("UPDATE estimate SET estimated_um_urad = 21.0 WHERE calibration_id = 3 AND symbol = 'EA0B'");
  const auto fleet = database->LatestFleet({}, {});
  ASSERT_TRUE(fleet.ok()) << fleet.status();
  ASSERT_EQ(fleet->rows[0].latest.size(), 2u);
  EXPECT_EQ(fleet->rows[0].latest[0].estimate.symbol, "EC0C");
  EXPECT_EQ(fleet->rows[0].latest[1].estimate.symbol, "EX0C");
  ASSERT_EQ(database.damages.size(), 1u);
}

// A candidate that the disk has made rejected, or the other way round.
TEST_F(History, WhoseCalibrationHasAnotherStateIsLeftOut) {
  for (int day = 0; day < 3; ++day) Calibrate(start + day * kDay, 10.0 * day);
  ASSERT_TRUE(database->RetireCalibration(CalibrationId(3), 0, Cell("")).ok());
  const DriftQuery query = Query(start, start + 10 * kDay, 100);
  EXPECT_EQ(database->QueryDrift(query)->at(0).points.size(), 2u);
  EXPECT_TRUE(database.damages.empty());
  Execute("UPDATE calibration SET state = 1, retired_at_utc_us = NULL WHERE id = 3");
  EXPECT_EQ(database->QueryDrift(query)->at(0).points.size(), 2u);
  EXPECT_EQ(database.damages.size(), 1u);
}

// The sums of a week: its estimates serve in their place, and whatever is added next makes them anew.
TEST_F(History, ADamagedWeekIsDrawnFromItsEstimates) {
  for (int day = 0; day < 200; ++day) Calibrate(start + day * kDay, 0.5 * day);
  const DriftQuery query = Query(start, start + 300 * kDay, 7);
  ExpectAgrees(query);
  const auto before = database->QueryDrift(query);
  const std::string third = "WHERE symbol = 'EA0B' AND week = (SELECT min(week) + 3 FROM estimate_week)";
  for (const std::string damage : {"sum_um_urad = sum_um_urad + 64", "max_um_urad = 1e9", "estimate_count = 9",
                                   "unit = 1", "last_calibration_id = 1", "crc32c = NULL"}) {
    Execute("UPDATE estimate_week SET " + damage + " " + third);
    database.damages.clear();
    const auto drift = database->QueryDrift(query);
    ASSERT_TRUE(drift.ok()) << drift.status();
    ASSERT_EQ(drift->at(0).points.size(), before->at(0).points.size()) << damage;
    for (size_t i = 0; i < before->at(0).points.size(); ++i) {
      const DriftPoint& was = before->at(0).points[i];
      const DriftPoint& is = drift->at(0).points[i];
      EXPECT_EQ(is.count, was.count) << damage;
      EXPECT_EQ(is.max, was.max) << damage;
      EXPECT_EQ(is.last_calibration, was.last_calibration) << damage;
      EXPECT_NEAR(is.mean, was.mean, 1e-9) << damage;
    }
    ASSERT_FALSE(database.damages.empty()) << damage;
    EXPECT_EQ(base::GetErrorDetail(database.damages[0])->facts.count("week"), 1u);
    database.Close();
    EXPECT_EQ(Damages().size(), 1u) << damage;
    database.Open();
    const CalibrationId added = Calibrate(start + 22 * kDay, 11.5);  // of that week
    database.damages.clear();
    ExpectAgrees(query);
    database.Close();
    EXPECT_THAT(Damages(), testing::IsEmpty()) << damage;
    database.Open();
    ASSERT_TRUE(database->RetireCalibration(added, 0, Cell("")).ok());
    values.pop_back();
  }
}

TEST_F(History, BadQueriesAreRefused) {
  EXPECT_EQ(base::ErrorReason(database->QueryDrift(Query(start, start, 10)).status()), "RANGE_INVALID");
  EXPECT_EQ(base::ErrorReason(database->QueryDrift(Query(start, start + kDay, 0)).status()), "RANGE_INVALID");
  DriftQuery unknown = Query(start, start + kDay, 10);
  unknown.machine = MachineId("none");
  EXPECT_EQ(base::ErrorReason(database->QueryDrift(unknown).status()), "MACHINE_NOT_FOUND");
  unknown.machine = MachineId("mt");
  EXPECT_TRUE(database->QueryDrift(unknown)->empty());
}

TEST_F(History, TheFleetShowsTheNewestOfEach) {
  Calibrate(start, 1.0);
  Calibrate(start + kDay, 2.0);
  ASSERT_TRUE(database->CreateMachine(MachineId("other"), "{}", Cell("")).ok());
  const auto all = database->LatestFleet({}, {1, ""});
  ASSERT_TRUE(all.ok()) << all.status();
  ASSERT_EQ(all->rows.size(), 1u);
  ASSERT_EQ(all->rows[0].latest.size(), 3u);
  EXPECT_EQ(all->rows[0].latest[0].estimate.value, 2.0);
  EXPECT_EQ(all->rows[0].latest[0].measured_at, start + kDay);
  EXPECT_FALSE(all->rows[0].latest[1].estimate.identifiable);
  const auto next = database->LatestFleet({}, {1, all->next_token});
  ASSERT_EQ(next->rows.size(), 1u);
  EXPECT_EQ(next->rows[0].machine.text(), "other");
  EXPECT_TRUE(next->rows[0].latest.empty());
  EXPECT_EQ(next->next_token, "");
  EXPECT_EQ(database->LatestFleet({"EX0C"}, {})->rows[0].latest.size(), 1u);
}

TEST_F(History, TheFleetShowsNothingThatWasRetired) {
  const auto shown = [&] { return database->LatestFleet({"EA0B"}, {})->rows.at(0).latest; };
  const auto calibrate = [&](int day, double ea0b_urad) {
    return database->CreateCalibration(TestCalibration(start + day * kDay, ea0b_urad))->id;
  };
  const CalibrationId first = calibrate(0, 1.0);
  ASSERT_TRUE(database->ApproveCalibration(first, 0, Cell("")).ok());
  const CalibrationId rejected = calibrate(1, 900.0);
  ASSERT_TRUE(database->RetireCalibration(rejected, 0, Cell("")).ok());
  ASSERT_EQ(shown().size(), 1u);
  EXPECT_EQ(shown()[0].calibration, first);
  EXPECT_EQ(shown()[0].state, CalibrationState::kApproved);
  const CalibrationId second = calibrate(2, 3.0);
  EXPECT_EQ(shown()[0].calibration, second);  // a candidate is the newest that is known
  EXPECT_EQ(shown()[0].state, CalibrationState::kCandidate);
  ASSERT_TRUE(database->ApproveCalibration(second, 0, Cell("")).ok());
  EXPECT_EQ(shown()[0].calibration, second);
  ASSERT_TRUE(database->ApproveCalibration(first, 0, Cell("")).ok());  // the way back
  EXPECT_EQ(shown()[0].calibration, first);
  ASSERT_TRUE(database->RetireCalibration(first, 0, Cell("")).ok());
  EXPECT_TRUE(shown().empty());
}

}  // namespace
}  // namespace axiscal::storage
