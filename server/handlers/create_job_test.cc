#include "server/handlers/create_job.h"

#include <gtest/gtest.h>

#include "server/handlers/cancel_job.h"
#include "server/handlers/create_machine.h"
#include "server/handlers/list_jobs.h"
#include "server/handlers/testing/test_core.h"
#include "server/inputs/compensation.h"

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

// What the calibration's own report says against it goes with every program that it corrects.
TEST_F(CreateJobTest, ACompensationCarriesTheDoubtsOfItsCalibration) {
  storage::NewCalibration doubtful = storage::TestCalibration(database.clock.UtcNow(), 1.0);
  doubtful.model_json = R"({"EX0X": 0, "EZ0T": 3000})";
  doubtful.report_json = R"({"verdict": "extended", "warnings": [{"kind": "size", "text": "EZ0T at 3145 um"}],
    "causes": [{"kind": "nominal", "subject": "Z of tool_tip_mm", "evidence": 50, "correction": "add 3.1449 mm"}]})";
  const auto calibration = database->CreateCalibration(doubtful);
  ASSERT_TRUE(calibration.ok()) << calibration.status();
  records::CompensateParams params;
  params.machine = MachineId("mt");
  params.calibration = calibration->id;
  params.tool_tip_mm = {0, 0, -100};
  const auto compensation = inputs::CompensationFor(*database, params, "params");
  ASSERT_TRUE(compensation.ok()) << compensation.status();
  EXPECT_EQ(compensation->options.calibration_warns, (std::vector<std::string>{"size", "nominal"}));
  nc::RewriteReport report;
  compensation->AddTo(&report);
  const reports::Rewrite said = nc::ReportOf(report);
  ASSERT_EQ(said.calibration_warnings.size(), 1u);
  EXPECT_EQ(said.calibration_warnings[0].text, "EZ0T at 3145 um");
  ASSERT_EQ(said.calibration_causes.size(), 1u);
  EXPECT_EQ(said.calibration_causes[0].correction, "add 3.1449 mm");
}

// A program is read as the machine's profile says, where the request says nothing else.
TEST_F(CreateJobTest, ACompensationTakesWhatIsOpenFromTheMachinesProfile) {
  const auto program = database->BeginProgram({"nc", "O1", {"tester", "p"}});
  ASSERT_TRUE(program.ok() && database->AppendProgram(program->id, 0, "G01").ok());
  ASSERT_TRUE(database->FinishProgram(program->id, 3, "").ok());
  const auto calibration = database->CreateCalibration(storage::TestCalibration(database.clock.UtcNow(), 1.0));
  ASSERT_TRUE(calibration.ok()) << calibration.status();
  auto request = Parse<v1::CreateJobRequest>(R"(request_id: "c-1" params { compensate {
    machine_id: "mt" options {
      decimals_mm: 3 work_offsets { code: "G54" offsets { axis: "X" value_mm_or_rad: 9 } } } } })");
  v1::CompensateParams& compensate = *request.mutable_params()->mutable_compensate();
  compensate.set_program_id(program->id.number());
  compensate.set_calibration_id(calibration->id.number());
  EXPECT_EQ(FieldOf(CreateJob(core, call, request).status()), "params.compensate.tool_tip_mm");
  const auto describe = [&](const std::string& programs) {
    std::string json = kMachineJson;
    json.insert(json.rfind('}'), ", \"programs\": " + programs);
    return database->UpdateMachine(MachineId("mt"), 0, json, {"tester", ""}).status();
  };
  ASSERT_TRUE(describe(R"({"tool_tip": "0 0 -100", "dialect": "haas", "unit": "inch", "decimals": "4",
    "offsets": ["G54 X=1", "G55 C=90"], "tool_lengths": ["H7=120.5"], "harmless_m": "47"})")
                  .ok());
  const auto job = CreateJob(core, call, request);
  ASSERT_TRUE(job.ok()) << job.status();
  EXPECT_EQ(job->job().params().compensate().tool_tip_mm_size(), 0);

  storage::NewCalibration whole = storage::TestCalibration(database.clock.UtcNow(), 1.0);
  whole.model_json = R"({"EX0X": 0, "EZ0T": 30})";
  const auto used = database->CreateCalibration(whole);
  ASSERT_TRUE(used.ok()) << used.status();
  const auto filled = [&]() -> absl::StatusOr<inputs::Compensation> {
    v1::CompensateParams message = compensate;
    message.set_calibration_id(used->id.number());
    ASSIGN_OR_RETURN(const records::CompensateParams params, convert::FromProto(message, true));
    return inputs::CompensationFor(*database, params, "params.compensate");
  };
  auto compensation = filled();
  ASSERT_TRUE(compensation.ok()) << compensation.status();
  EXPECT_EQ(compensation->notes.back().text,
            "of the machine's profile: --tool-tip, --dialect, --unit, --harmless-m, --offset G55, --tool-length 7");
  const nc::RewriteOptions& options = compensation->options;
  EXPECT_EQ(options.dialect, "haas");
  EXPECT_EQ(options.unit, nc::ProgramUnit::kInch);
  EXPECT_EQ(options.decimals_mm, 3);
  ASSERT_EQ(options.work_offsets.size(), 2u);
  EXPECT_EQ(options.work_offsets[0].offsets[0].value, 9);
  EXPECT_EQ(options.tool_lengths.at(0).length_mm, 120.5);
  EXPECT_EQ(options.harmless_m.at(0), 47);

  // Asked again, as after an answer that was lost, it is the same job, whatever the profile says by then.
  ASSERT_TRUE(describe(R"({"tool_tip": "0 0 -200", "offsets": ["G54 X=1"]})").ok());
  const auto again = CreateJob(core, call, request);
  ASSERT_TRUE(again.ok()) << again.status();
  EXPECT_EQ(again->job().job_id(), job->job().job_id());

  request.set_request_id("c-2");
  compensate.set_without_profile(true);
  EXPECT_EQ(FieldOf(CreateJob(core, call, request).status()), "params.compensate.tool_tip_mm");
  for (const double value : {0.0, 0.0, -90.0}) compensate.add_tool_tip_mm(value);
  EXPECT_TRUE(CreateJob(core, call, request).ok());
  compensation = filled();
  ASSERT_TRUE(compensation.ok()) << compensation.status();
  EXPECT_EQ(compensation->options.work_offsets.size(), 1u);

  request.set_request_id("c-3");
  compensate.set_without_profile(false);
  ASSERT_TRUE(describe(R"({"offsets": ["G54 W=1"]})").ok());
  const absl::Status wrong = CreateJob(core, call, request).status();
  EXPECT_EQ(base::ErrorReason(wrong), "PROFILE_INVALID");
  EXPECT_NE(wrong.message().find("programs.offsets: 'W=1'"), std::string::npos) << wrong;
  ASSERT_TRUE(describe(R"({"offsets": ["G54 X=1 Y=2"]})").ok());
  EXPECT_EQ(FieldOf(CreateJob(core, call, request).status()), "params.compensate.options");
}

}  // namespace
}  // namespace axiscal::handlers
