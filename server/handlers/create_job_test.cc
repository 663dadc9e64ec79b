#include "server/handlers/create_job.h"

#include <gtest/gtest.h>

#include "server/handlers/cancel_job.h"
#include "server/handlers/create_machine.h"
#include "server/handlers/list_jobs.h"
#include "server/handlers/testing/test_core.h"

namespace axiscal::handlers {
namespace {

class CreateJobTest : public ::testing::Test, protected TestCore {
 protected:
  void SetUp() override {
    v1::CreateMachineRequest machine;
    machine.set_description_json(kMachineJson);
    ASSERT_TRUE(CreateMachine(core, call, machine).ok());
    storage::NewSession session = storage::TestSession("s");
    session_ = database->CreateSession(session)->id;
    ASSERT_TRUE(storage::Append(*database, session_, 0, Columns()).ok());
    request_ = Parse<v1::CreateJobRequest>(R"(request_id: "j-1" params { identify { machine_id: "mt" } })");
    request_.mutable_params()->mutable_identify()->add_session_ids(session_.number());
  }
  void Finish() {
    const uint32_t crc = session::ChunkCrc32c(Columns());
    ASSERT_TRUE(database->FinishSession(session_, {1, 10, session::SessionHash({crc})}).ok());
  }
  static std::vector<session::Column> Columns() { return storage::TestColumns(0, 10); }

  SessionId session_;
  v1::CreateJobRequest request_;
};

TEST_F(CreateJobTest, QueuesOncePerRequestIdUntilTheQueueIsFull) {
  EXPECT_EQ(base::ErrorReason(CreateJob(core, call, request_).status()), "SESSION_NOT_COMPLETE");
  Finish();
  const auto job = CreateJob(core, call, request_);
  ASSERT_TRUE(job.ok()) << job.status();
  EXPECT_EQ(job->job().state(), v1::JOB_STATE_QUEUED);
  EXPECT_EQ(job->job().params().identify().session_ids(0), session_.number());
  EXPECT_EQ(CreateJob(core, call, request_)->job().job_id(), job->job().job_id());
  request_.set_request_id("j-2");
  ASSERT_TRUE(CreateJob(core, call, request_).ok());
  request_.set_request_id("j-3");
  const absl::Status full = CreateJob(core, call, request_).status();
  EXPECT_EQ(full.code(), absl::StatusCode::kResourceExhausted);
  EXPECT_EQ(base::ErrorReason(full), "QUEUE_FULL");

  v1::CancelJobRequest cancel;
  cancel.set_job_id(job->job().job_id());
  EXPECT_EQ(CancelJob(core, call, cancel)->job().state(), v1::JOB_STATE_CANCELLED);
  const auto waiting = ListJobs(core, call, Parse<v1::ListJobsRequest>("state: JOB_STATE_QUEUED"));
  EXPECT_EQ(waiting->jobs_size(), 1);
}

TEST_F(CreateJobTest, NamesTheFieldThatIsWrong) {
  Finish();
  request_.mutable_params()->mutable_identify()->add_declared_errors("EX0C");
  request_.mutable_params()->mutable_identify()->add_declared_errors(R"({"symbol": "EXX", "shape": "wavy"})");
  EXPECT_EQ(FieldOf(CreateJob(core, call, request_).status()), "params.identify.declared_errors[1]");
  request_.clear_params();
  EXPECT_EQ(FieldOf(CreateJob(core, call, request_).status()), "params.kind");
}

TEST_F(CreateJobTest, WhatIsHeldIsCheckedBeforeAnythingRuns) {
  Finish();
  v1::IdentifyParams& identify = *request_.mutable_params()->mutable_identify();
  identify.add_declared_errors("EY0C");
  identify.set_held_errors_json(R"({"EX0C": 12.5})");
  EXPECT_TRUE(CreateJob(core, call, request_).ok());
  request_.set_request_id("j-2");
  identify.set_held_errors_json(R"({"EX0Q": 12.5})");
  EXPECT_EQ(FieldOf(CreateJob(core, call, request_).status()), "params.identify.held_errors_json");
  identify.set_held_errors_json(R"({"EY0C": 12.5})");
  EXPECT_EQ(FieldOf(CreateJob(core, call, request_).status()), "params.identify.declared_errors");
  identify.set_held_calibration_id(1);
  EXPECT_EQ(FieldOf(CreateJob(core, call, request_).status()), "params.identify.held_errors_json");  // one of the two
  identify.clear_held_errors_json();
  EXPECT_EQ(base::ErrorReason(CreateJob(core, call, request_).status()), "CALIBRATION_NOT_FOUND");
  identify.set_held_calibration_id(-1);
  EXPECT_EQ(FieldOf(CreateJob(core, call, request_).status()), "params.identify.held_calibration_id");
  EXPECT_EQ(ListJobs(core, call, Parse<v1::ListJobsRequest>("state: JOB_STATE_QUEUED"))->jobs_size(), 1);
}

}  // namespace
}  // namespace axiscal::handlers
