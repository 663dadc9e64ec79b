// The service with the machine "mt", whose jobs are run and awaited.
#ifndef AXISCAL_TESTS_END_TO_END_TESTING_JOB_FIXTURE_H_
#define AXISCAL_TESTS_END_TO_END_TESTING_JOB_FIXTURE_H_

#include <string>

#include "tests/end_to_end/testing/fixture.h"

namespace axiscal::testing {

class Job : public EndToEnd {
 protected:
  void SetUp() override {
    EndToEnd::SetUp();
    ASSERT_OK(client().CreateMachine(MachineJson("mt")));
  }

  SessionId UploadSession(const session::Session& session) {
    const auto upload = client().Upload(MachineId("mt"), session);
    EXPECT_TRUE(upload.ok()) << upload.status();
    return upload.ok() ? upload->session.id : SessionId();
  }
  SessionId UploadSession(const std::string& name, int readings = 720) {
    return UploadSession(BallbarSession("mt", name, readings));
  }
  client::JobRecord RunJob(const records::JobParams& params) {
    const auto job = client().CreateJob(params);
    EXPECT_TRUE(job.ok()) << job.status();
    if (!job.ok()) return {};
    const auto ended = client().WatchJob(job->id, nullptr);
    EXPECT_TRUE(ended.ok()) << ended.status();
    return ended.ok() ? *ended : client::JobRecord{};
  }
  CalibrationId Identify() {
    const client::JobRecord job = RunJob(records::IdentifyParams{MachineId("mt"), {UploadSession("BX")}, {}});
    EXPECT_EQ(job.state, records::JobState::kSucceeded) << (job.error ? job.error->message : "");
    return job.calibration.value_or(CalibrationId());
  }
};

}  // namespace axiscal::testing

#endif  // AXISCAL_TESTS_END_TO_END_TESTING_JOB_FIXTURE_H_
