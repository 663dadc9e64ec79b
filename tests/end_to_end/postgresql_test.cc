// axiscald on a database of PostgreSQL: `--db postgresql://...`, on a server that the test starts for itself.
#include <gmock/gmock.h>
#include <signal.h>

#include <fstream>
#include <memory>
#include <thread>

#include "core/base/error_detail.h"
#include "server/storage/postgres_connection.h"
#include "server/storage/testing/postgres_server.h"
#include "tests/end_to_end/testing/fixture.h"
#include "tests/end_to_end/testing/process.h"

namespace axiscal {
namespace {

using testing::BallbarSession;
using ::testing::HasSubstr;
using testing::MachineJson;
using ::testing::Not;
using testing::ServerProcess;

constexpr char kPassword[] = "only-for-its-owner";

class OnPostgres : public ::testing::Test {
 protected:
  static void SetUpTestSuite() {
    absl::StatusOr<std::unique_ptr<storage::PostgresServer>> server = storage::PostgresServer::Start();
    if (absl::IsNotFound(server.status())) return;
    ASSERT_OK(server);
    postgres_ = *std::move(server);
  }
  static void TearDownTestSuite() { postgres_.reset(); }
  void SetUp() override {
    if (postgres_ == nullptr) GTEST_SKIP() << "PostgreSQL is not installed: deploy/install-deps --tests";
    // No password is asked for there; that none is shown is tested.
    url_ = absl::StrCat(postgres_->MakeDatabase(false), "&password=", kPassword);
  }
  absl::StatusOr<ServerProcess> StartServer(const std::string& listen = "127.0.0.1:0") {
    return ServerProcess::Start(url_, listen, dir_.File("log"));
  }
  std::string Log() {
    std::ifstream log(dir_.File("log"));
    return {std::istreambuf_iterator<char>(log), {}};
  }

  static inline std::unique_ptr<storage::PostgresServer> postgres_;
  testing::TempDir dir_;
  std::string url_;
};

TEST_F(OnPostgres, WhatCameIsThereAfterARestart) {
  absl::StatusOr<ServerProcess> server = StartServer();
  ASSERT_OK(server);
  absl::StatusOr<client::Client> client = client::Client::Connect(server->address());
  ASSERT_OK(client);
  ASSERT_OK(client->CreateMachine(MachineJson("mt")));
  const session::Session session = BallbarSession("mt", "BX", 20'000);
  const auto upload = client->Upload(MachineId("mt"), session);
  ASSERT_OK(upload);
  const auto job = client->CreateJob(records::IdentifyParams{MachineId("mt"), {upload->session.id}, {}}, "once");
  ASSERT_OK(job);
  const auto ended = client->WatchJob(job->id, [](const client::JobRecord&) { return true; });
  ASSERT_OK(ended);
  EXPECT_EQ(ended->state, records::JobState::kSucceeded) << (ended->error ? ended->error->message : "");
  server->Signal(SIGTERM);
  EXPECT_EQ(server->Wait(), 0);

  absl::StatusOr<ServerProcess> again = StartServer();
  ASSERT_OK(again);
  client = client::Client::Connect(again->address());
  ASSERT_OK(client);
  const auto back = client->DownloadSession(upload->session.id);
  ASSERT_OK(back);
  EXPECT_TRUE(*back == session);
  EXPECT_EQ(client->ListCalibrations()->rows.size(), 1u);
  EXPECT_EQ(client->CreateJob(records::IdentifyParams{MachineId("mt"), {upload->session.id}, {}}, "once")->id, job->id);
}

TEST_F(OnPostgres, AJobOfAServerThatWasKilledIsDoneOnceByTheNext) {
  absl::StatusOr<ServerProcess> started = StartServer();
  ASSERT_OK(started);
  auto server = std::make_unique<ServerProcess>(*std::move(started));
  const std::string address = server->address();
  absl::StatusOr<client::Client> client = client::Client::Connect(address);
  ASSERT_OK(client);
  ASSERT_OK(client->CreateMachine(MachineJson("mt")));
  const auto upload = client->Upload(MachineId("mt"), BallbarSession("mt", "BX", 100'000));
  ASSERT_OK(upload);
  const auto job = client->CreateJob(records::IdentifyParams{MachineId("mt"), {upload->session.id}, {}}, "once");
  ASSERT_OK(job);
  bool was_killed = false;
  const auto ended = client->WatchJob(job->id, [&](const client::JobRecord& record) {
    if (was_killed || record.state != records::JobState::kRunning) return true;
    was_killed = true;
    server->Signal(SIGKILL);
    server->Wait();
    // The database lets the next one in when it has seen that the connection is gone.
    absl::StatusOr<ServerProcess> again = StartServer(address);
    EXPECT_TRUE(again.ok()) << again.status() << Log();
    if (again.ok()) server = std::make_unique<ServerProcess>(*std::move(again));
    return true;
  });
  ASSERT_OK(ended);
  EXPECT_TRUE(was_killed);
  EXPECT_EQ(ended->state, records::JobState::kSucceeded);
  EXPECT_EQ(ended->attempt, 2);
  EXPECT_EQ(client->ListCalibrations()->rows.size(), 1u);
}

// Others have brought the tables to a version that it does not know while its connections were lost.
TEST_F(OnPostgres, AServerThatIsTooOldByNowIsNotReadyAndSaysWhy) {
  absl::StatusOr<ServerProcess> server = StartServer();
  ASSERT_OK(server);
  absl::StatusOr<client::Client> client = client::Client::Connect(server->address());
  ASSERT_OK(client);
  EXPECT_TRUE(client->CheckHealth().ok());
  const auto change = [&](const std::string& sql) {
    const auto other = storage::PostgresConnection::Open(url_, storage::Access::kWrite, storage::Hold::kShared);
    ASSERT_OK(other);
    ASSERT_OK((*other)->Execute(
        sql +
        "; SELECT pg_terminate_backend(pid) FROM pg_stat_activity WHERE pid <> pg_backend_pid() AND datname = "
        "current_database()"));
  };
  const auto wait_for_health = [&](bool is_good) {
    while (client->CheckHealth().ok() != is_good) std::this_thread::sleep_for(std::chrono::milliseconds(50));
  };
  change(
      "INSERT INTO migration VALUES (9999, 'newer', 'x', 1); UPDATE given_number SET seq = 9999 WHERE name = "
      "'oldest_program'");
  wait_for_health(false);
  EXPECT_EQ(base::ErrorReason(client->CreateMachine(MachineJson("mt")).status()), "SCHEMA_NEWER");
  EXPECT_THAT(Log(), HasSubstr("SCHEMA_NEWER"));
  change("DELETE FROM migration WHERE version = 9999");
  wait_for_health(true);
  ASSERT_OK(client->CreateMachine(MachineJson("mt")));
}

// Whoever copies it, here with nothing in it, wants it alone.
TEST_F(OnPostgres, AServerIsRefusedWhereSomebodyHasItAlone) {
  const auto alone = storage::PostgresConnection::Open(url_, storage::Access::kWrite);
  ASSERT_OK(alone);
  EXPECT_FALSE(ServerProcess::Start(url_, "127.0.0.1:0", dir_.File("log2")).ok());
  std::ifstream log(dir_.File("log2"));
  EXPECT_THAT(std::string(std::istreambuf_iterator<char>(log), {}), HasSubstr("another process"));
}

// A file's commands and backup say whose business it is, the doctor asks for no file, and nobody reads the password.
TEST_F(OnPostgres, WhatIsTheDatabaseServersIsSaidSo) {
  absl::StatusOr<ServerProcess> server = StartServer();
  ASSERT_OK(server);
  absl::StatusOr<client::Client> client = client::Client::Connect(server->address());
  ASSERT_OK(client);
  const auto backup = client->MakeBackup();
  EXPECT_EQ(base::ErrorReason(backup.status()), "STORE_HAS_OTHER_BACKUPS") << backup.status();
  const auto diagnosis = client->Diagnose();
  ASSERT_OK(diagnosis);
  std::string told;
  for (const records::Finding& finding : diagnosis->findings) {
    EXPECT_NE(finding.state, records::FindingState::kFailed) << finding.what << ": " << finding.text;
    absl::StrAppend(&told, finding.what, ": ", finding.text, " ", finding.advice, "\n");
  }
  EXPECT_THAT(told, HasSubstr("disk: the database is PostgreSQL's"));
  EXPECT_THAT(told, HasSubstr("pg_dump"));
  server->Signal(SIGTERM);
  EXPECT_EQ(server->Wait(), 0);
  EXPECT_THAT(Log(), HasSubstr("password=***"));
  EXPECT_THAT(Log(), Not(HasSubstr(kPassword)));

  std::string output;
  EXPECT_EQ(testing::RunProgram({AXISCALD_PATH, "compact", url_}, &output), 1) << output;
  EXPECT_EQ(testing::RunProgram({AXISCALD_PATH, "check", url_}, &output), 0) << output;
  EXPECT_THAT(output, Not(HasSubstr(kPassword)));
  EXPECT_EQ(testing::RunProgram({AXISCALD_PATH, "--db", url_, "--check-config"}, &output), 0);
  EXPECT_THAT(output, HasSubstr("store.database = postgresql://"));
  EXPECT_THAT(output, Not(HasSubstr(kPassword)));
}

TEST_F(OnPostgres, AServerThatIsNotThereIsSaidSo) {
  EXPECT_FALSE(
      ServerProcess::Start("postgresql://nobody@/x?host=" + dir_.File("nowhere"), "127.0.0.1:0", dir_.File("log"))
          .ok());
  EXPECT_THAT(Log(), HasSubstr("nowhere"));
}

}  // namespace
}  // namespace axiscal
