#include "server/metrics/metrics.h"

#include <gmock/gmock.h>

namespace axiscal::metrics {
namespace {

using ::testing::HasSubstr;
using ::testing::Not;

class MetricsTest : public ::testing::Test {
 protected:
  Metrics metrics_{
      "1.2.3", {{"Jobs.GetJob"}, {"Jobs.WatchJob", false, true}, {"Ingest.Upload", true, true}}, {"IDENTIFY"}};
};

TEST_F(MetricsTest, EverySeriesOfCallsIsThereBeforeTheFirst) {
  const std::string text = metrics_.Text({});
  const std::string get = R"({grpc_method="GetJob",grpc_service="axiscal.v1.Jobs",grpc_type="unary"} 0)";
  EXPECT_THAT(text, HasSubstr("grpc_server_started_total" + get));
  EXPECT_THAT(text, HasSubstr(R"(grpc_server_handled_total{grpc_code="OK",grpc_method="GetJob",)"));
  EXPECT_THAT(text, HasSubstr(R"(grpc_server_handled_total{grpc_code="Internal",grpc_method="WatchJob",)"));
  EXPECT_THAT(text, HasSubstr(R"(axiscal_build_info{version="1.2.3"} 1)"));
  EXPECT_THAT(text, HasSubstr(R"(axiscal_job_attempts_total{kind="IDENTIFY",outcome="DEAD"} 0)"));
}

TEST_F(MetricsTest, CallsAreCountedByMethodAndCode) {
  metrics_.CallStarted("Jobs.GetJob");
  metrics_.CallStarted("Jobs.GetJob");
  metrics_.CallEnded("Jobs.GetJob", absl::StatusCode::kNotFound, std::chrono::milliseconds(30));
  metrics_.CallStarted("Nothing.Known");
  const std::string text = metrics_.Text({});
  const std::string get = R"(grpc_method="GetJob",grpc_service="axiscal.v1.Jobs",grpc_type="unary")";
  EXPECT_THAT(text, HasSubstr("grpc_server_started_total{" + get + "} 2"));
  EXPECT_THAT(text, HasSubstr(R"(grpc_server_handled_total{grpc_code="NotFound",)" + get + "} 1"));
  EXPECT_THAT(text, HasSubstr("grpc_server_handling_seconds_bucket{" + get + R"(,le="0.02"} 0)"));
  EXPECT_THAT(text, HasSubstr("grpc_server_handling_seconds_bucket{" + get + R"(,le="0.1"} 1)"));
  EXPECT_THAT(text, HasSubstr(R"(grpc_server_started_total{grpc_method="unknown",grpc_service="unknown")"));
}

TEST_F(MetricsTest, HowLongAStreamLastsIsNoLatency) {
  metrics_.CallEnded("Jobs.WatchJob", absl::StatusCode::kOk, std::chrono::hours(3));
  EXPECT_THAT(metrics_.Text({}), Not(HasSubstr(R"(grpc_server_handling_seconds_count{grpc_method="WatchJob")")));
}

TEST_F(MetricsTest, AMachineThatIsNotAmongTheWorstAnyMoreHasNoSeries) {
  EXPECT_THAT(metrics_.Text({}), Not(HasSubstr("axiscal_machine_open_events{")));
  Gauges gauges;
  gauges.machines = {{"mt", 3}, {"other", 1}};
  EXPECT_THAT(metrics_.Text(gauges), HasSubstr(R"(axiscal_machine_open_events{machine="other"} 1)"));
  gauges.machines = {{"mt", 2}};
  EXPECT_THAT(metrics_.Text(gauges), HasSubstr(R"(axiscal_machine_open_events{machine="mt"} 2)"));
  EXPECT_THAT(metrics_.Text(gauges), Not(HasSubstr("other")));
}

TEST_F(MetricsTest, CellsAndWebhooksAreCounted) {
  EXPECT_THAT(metrics_.Text({}), Not(HasSubstr("axiscal_cells{")));
  EXPECT_THAT(metrics_.Text({}), HasSubstr(R"(axiscal_webhook_letters_total{outcome="DEAD"} 0)"));
  Gauges gauges;
  gauges.cells = {.well = 5, .silent = 1, .waiting_files = 7};
  gauges.webhooks = {.webhooks = 2, .failing = 1, .dead_letters = 4};
  metrics_.LetterSent("TAKEN");
  const std::string text = metrics_.Text(gauges);
  EXPECT_THAT(text, HasSubstr(R"(axiscal_cells{state="silent"} 1)"));
  EXPECT_THAT(text, HasSubstr("axiscal_cells_waiting_files 7"));
  EXPECT_THAT(text, HasSubstr("axiscal_webhooks_failing 1"));
  EXPECT_THAT(text, HasSubstr("axiscal_webhook_dead_letters 4"));
  EXPECT_THAT(text, HasSubstr(R"(axiscal_webhook_letters_total{outcome="TAKEN"} 1)"));
}

TEST_F(MetricsTest, WhatIsNotKnownNowIsLeftOut) {
  EXPECT_THAT(metrics_.Text({}), Not(HasSubstr("axiscal_jobs{")));
  EXPECT_THAT(metrics_.Text({}), HasSubstr("axiscal_store_up 0"));
  Gauges gauges;
  gauges.is_store_up = true;
  gauges.queued_jobs = 3;
  gauges.oldest_queued = std::chrono::milliseconds(2500);
  gauges.disk_free_bytes = int64_t{1} << 40;
  gauges.streams = {{"upload", 2, 500}};
  gauges.certificates = {{"server.crt", std::chrono::hours(24)}};
  const std::string text = metrics_.Text(gauges);
  EXPECT_THAT(text, HasSubstr("axiscal_store_up 1"));
  EXPECT_THAT(text, HasSubstr(R"(axiscal_jobs{state="queued"} 3)"));
  EXPECT_THAT(text, HasSubstr("axiscal_oldest_queued_job_age_seconds 2.5"));
  EXPECT_THAT(text, HasSubstr("axiscal_disk_free_bytes 1099511627776"));
  EXPECT_THAT(text, HasSubstr(R"(axiscal_streams{kind="upload"} 2)"));
  EXPECT_THAT(text, HasSubstr(R"(axiscal_certificate_remaining_seconds{file="server.crt"} 86400)"));
  // Nor does what was known once stay what it was.
  const std::string later = metrics_.Text({});
  for (const char* name : {"axiscal_jobs{", "axiscal_oldest_queued_job_age_seconds ", "axiscal_disk_free_bytes "})
    EXPECT_THAT(later, Not(HasSubstr(std::string("\n") + name))) << name;
}

TEST_F(MetricsTest, JobsAreCountedByKindAndOutcome) {
  metrics_.JobEnded("IDENTIFY", "SUCCEEDED", std::chrono::seconds(3));
  metrics_.JobEnded("IDENTIFY", "DEAD", {});  // its worker was lost: nobody knows for how long it had worked
  metrics_.ReadingsStored(4096);
  metrics_.ReadingsStored(4);
  const std::string text = metrics_.Text({});
  EXPECT_THAT(text, HasSubstr(R"(axiscal_job_attempts_total{kind="IDENTIFY",outcome="SUCCEEDED"} 1)"));
  EXPECT_THAT(text, HasSubstr(R"(axiscal_job_attempts_total{kind="IDENTIFY",outcome="DEAD"} 1)"));
  EXPECT_THAT(text, HasSubstr(R"(axiscal_job_seconds_sum{kind="IDENTIFY"} 3)"));
  EXPECT_THAT(text, HasSubstr(R"(axiscal_job_seconds_count{kind="IDENTIFY"} 1)"));
  EXPECT_THAT(text, HasSubstr("axiscal_readings_stored_total 4100"));
}

TEST(Disk, IsAskedOfTheFileSystem) {
  EXPECT_GT(DiskFreeBytes("/"), 0);
  EXPECT_EQ(DiskFreeBytes("/no/such/folder"), std::nullopt);
  EXPECT_EQ(FileBytes("/no/such/file"), std::nullopt);
}

}  // namespace
}  // namespace axiscal::metrics
