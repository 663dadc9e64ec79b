// A server that is killed with kill -9 while a routine works: each set of sessions has one run with one job and one
// calibration.
#include <gtest/gtest.h>
#include <signal.h>

#include <set>

#include "tests/end_to_end/testing/process.h"
#include "tests/end_to_end/testing/routine_fixture.h"

namespace axiscal {
namespace {

using records::RoutineRun;
using records::RunState;

constexpr int kKills = 16;
const MachineId kMt("mt");

class RoutinesKill : public ::testing::Test {
 protected:
  void StartServer(const std::string& listen) {
    server_.reset();
    auto server = testing::ServerProcess::Start(dir_.File("axiscal.db"), listen, dir_.File("log"));
    ASSERT_OK(server);
    server_ = std::make_unique<testing::ServerProcess>(*std::move(server));
  }
  // Until the run has come as far as the number says; a faster one may have ended already.
  static void WaitFor(client::Client& client, size_t count, int stage) {
    while (stage > 0) {
      const auto runs = client.ListRoutineRuns();
      ASSERT_OK(runs);
      if (runs->rows.size() < count) continue;
      const RoutineRun& run = runs->rows[0];
      if (stage == 1 || (stage == 2 && run.job)) return;
      if (run.job && records::IsTerminal(client.GetJob(*run.job)->state)) return;
    }
  }

  testing::TempDir dir_;
  std::unique_ptr<testing::ServerProcess> server_;
};

TEST_F(RoutinesKill, EachSetHasOneRunOneJobAndOneCalibration) {
  ASSERT_NO_FATAL_FAILURE(StartServer("127.0.0.1:0"));
  const std::string address = server_->address();
  {
    auto client = client::Client::Connect(address);
    ASSERT_OK(client);
    ASSERT_OK(client->CreateMachine(testing::MachineJson("mt")));
    ASSERT_OK(client->CreatePrincipal("night"));
    ASSERT_OK(client->ChangeRole("night", {records::Role::kTechnician, {records::Scope::Kind::kMachine, "mt"}}, true));
    records::Routine routine;
    routine.name = "nightly";
    routine.scope = {records::Scope::Kind::kMachine, "mt"};
    routine.principal = "night";
    routine.sessions = {"BX", "BY"};
    ASSERT_OK(client->PutRoutine(routine));
  }
  for (unsigned kill = 0; kill < kKills; ++kill) {
    auto client = client::Client::Connect(address);
    ASSERT_OK(client);
    ASSERT_OK(client->Upload(kMt, testing::ScatteredSession("BX", 2 * kill)));
    ASSERT_OK(client->Upload(kMt, testing::ScatteredSession("BY", 2 * kill + 1)));
    ASSERT_NO_FATAL_FAILURE(WaitFor(*client, kill + 1, static_cast<int>(kill % 4)));
    server_->Signal(SIGKILL);
    server_->Wait();
    ASSERT_NO_FATAL_FAILURE(StartServer(address));
    const RoutineRun run = testing::WaitForRun(*client, kill + 1);
    EXPECT_EQ(run.state, RunState::kProposed) << run.text;
  }
  auto client = client::Client::Connect(address);
  ASSERT_OK(client);
  std::set<JobId> jobs;
  std::set<CalibrationId> calibrations;
  std::set<SessionId> sessions;
  const auto runs = client->ListRoutineRuns({}, {1000, ""});
  ASSERT_OK(runs);
  for (const RoutineRun& run : runs->rows) {
    ASSERT_TRUE(run.job && run.calibration);
    EXPECT_TRUE(jobs.insert(*run.job).second);
    EXPECT_TRUE(calibrations.insert(*run.calibration).second);
    for (const SessionId id : run.sessions) EXPECT_TRUE(sessions.insert(id).second);
  }
  EXPECT_EQ(jobs.size(), static_cast<size_t>(kKills));
  EXPECT_EQ(sessions.size(), static_cast<size_t>(2 * kKills));
  EXPECT_EQ(client->ListJobs({}, {1000, ""})->rows.size(), jobs.size());
  EXPECT_EQ(client->ListCalibrations({}, {1000, ""})->rows.size(), calibrations.size());
}

}  // namespace
}  // namespace axiscal
