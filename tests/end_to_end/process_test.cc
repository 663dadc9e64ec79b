// The server as a process: orderly stop, kill -9 and restart, over a real port.
#include "tests/end_to_end/testing/process.h"

#include <gmock/gmock.h>
#include <grpcpp/create_channel.h>
#include <signal.h>
#include <sys/stat.h>
#include <sysexits.h>

#include <atomic>
#include <filesystem>
#include <fstream>
#include <functional>
#include <thread>
#include <utility>

#include "client/connection.h"
#include "core/base/error_detail.h"
#include "core/session/write_session.h"
#include "server/local_login.h"
#include "tests/end_to_end/testing/fixture.h"
#include "tests/end_to_end/testing/raw_upload.h"

namespace axiscal {
namespace {

using testing::BallbarSession;
using testing::MachineJson;
using testing::ServerProcess;

class Process : public ::testing::Test {
 protected:
  absl::StatusOr<ServerProcess> StartServer(const std::string& listen = "127.0.0.1:0") {
    return ServerProcess::Start(dir_.File("axiscal.db"), listen, dir_.File("log"));
  }
  std::string Log() {
    std::ifstream log(dir_.File("log"));
    return {std::istreambuf_iterator<char>(log), {}};
  }
  // A machine and sessions that a job needs some time for.
  records::IdentifyParams StoreMuchToIdentifyFrom(client::Client& client) {
    records::IdentifyParams params{MachineId("mt"), {}, {}};
    EXPECT_TRUE(client.CreateMachine(MachineJson("mt")).ok());
    for (const char* name : {"a", "b", "c"}) {
      const auto upload = client.Upload(MachineId("mt"), BallbarSession("mt", name, 100'000));
      EXPECT_TRUE(upload.ok()) << upload.status();
      if (upload.ok()) params.sessions.push_back(upload->session.id);
    }
    return params;
  }
  // SIGTERM while a job runs: the server exits with 0, and on the one that follows the job ends with one calibration.
  // What its watcher sees there, from the first sight to the end.
  std::vector<client::JobRecord> StopDuringAJob(const std::string& drain_seconds) {
    std::vector<client::JobRecord> seen;
    StopDuringAJob(drain_seconds, &seen);
    return seen;
  }
  void StopDuringAJob(const std::string& drain_seconds, std::vector<client::JobRecord>* seen) {
    absl::StatusOr<ServerProcess> server = ServerProcess::Start(dir_.File("axiscal.db"), "127.0.0.1:0",
                                                                dir_.File("log"), {"--drain-seconds", drain_seconds});
    ASSERT_OK(server);
    absl::StatusOr<client::Client> client = client::Client::Connect(server->address());
    ASSERT_OK(client);
    const auto job = client->CreateJob(StoreMuchToIdentifyFrom(*client), "once");
    ASSERT_OK(job);
    // Leaves at the first sight of it running: a watcher would hold the drain.
    static_cast<void>(client->WatchJob(
        job->id, [](const client::JobRecord& record) { return record.state != records::JobState::kRunning; }));
    server->Signal(SIGTERM);
    EXPECT_EQ(server->Wait(), 0);
    absl::StatusOr<ServerProcess> again = StartServer(server->address());
    ASSERT_OK(again);
    client = client::Client::Connect(again->address());
    ASSERT_OK(client);
    ASSERT_OK(client->WatchJob(job->id, [seen](const client::JobRecord& record) {
      seen->push_back(record);
      return true;
    }));
    const auto calibrations = client->ListCalibrations();
    ASSERT_OK(calibrations);
    EXPECT_EQ(calibrations->rows.size(), 1u);
  }
  void KillDuringAJob(const std::function<records::JobParams(client::Client&)>& store);

  testing::TempDir dir_;
};

TEST_F(Process, StopsInOrderOnSigterm) {
  absl::StatusOr<ServerProcess> server = StartServer();
  ASSERT_OK(server);
  absl::StatusOr<client::Client> client = client::Client::Connect(server->address());
  ASSERT_OK(client);
  ASSERT_TRUE(client->CheckHealth().ok());
  ASSERT_OK(client->CreateMachine(MachineJson("mt")));
  server->Signal(SIGTERM);
  EXPECT_EQ(server->Wait(), 0);
  const std::string log = Log();
  EXPECT_NE(log.find("method=Machines.CreateMachine"), std::string::npos) << log;
  EXPECT_NE(log.find("code=OK"), std::string::npos);
  EXPECT_NE(log.find("event=stopped"), std::string::npos);
  EXPECT_NE(log.find("event=start "), std::string::npos);
  EXPECT_NE(log.find("max_descriptors="), std::string::npos);
}

// An upload that is open would hold the drain for a minute.
TEST_F(Process, ASecondSignalEndsItAtOnce) {
  absl::StatusOr<ServerProcess> server =
      ServerProcess::Start(dir_.File("axiscal.db"), "127.0.0.1:0", dir_.File("log"), {"--drain-seconds", "60"});
  ASSERT_OK(server);
  absl::StatusOr<client::Client> client = client::Client::Connect(server->address());
  ASSERT_OK(client);
  ASSERT_OK(client->CreateMachine(MachineJson("mt")));
  const auto stub = v1::Ingest::NewStub(grpc::CreateChannel(server->address(), grpc::InsecureChannelCredentials()));
  v1::CreateSessionResponse created;
  {
    grpc::ClientContext context;
    ASSERT_TRUE(
        stub->CreateSession(&context, testing::CreateRequest("mt", "r-1", BallbarSession("mt", "BX", 10)), &created)
            .ok());
  }
  grpc::ClientContext context;
  v1::UploadOnceResponse response;
  const auto stream = stub->UploadOnce(&context, &response);
  v1::UploadRequest header;
  header.mutable_header()->set_session_id(created.session().session_id());
  ASSERT_TRUE(stream->Write(header));
  while (client->GetServerInfo()->open_uploads == 0) std::this_thread::yield();
  server->Signal(SIGTERM);
  while (Log().find("event=drain") == std::string::npos) std::this_thread::yield();
  server->Signal(SIGTERM);
  EXPECT_EQ(server->Wait(), 128 + SIGTERM);
  EXPECT_NE(Log().find("event=killed"), std::string::npos) << Log();
  EXPECT_FALSE(stream->Finish().ok());
}

TEST_F(Process, MoreWorkersThanCoresExistAreRefusedWithTheRule) {
  EXPECT_FALSE(
      ServerProcess::Start(dir_.File("axiscal.db"), "127.0.0.1:0", dir_.File("log"), {"--workers", "100000"}).ok());
  EXPECT_NE(Log().find("workers = 100000, must be 1 to 1024"), std::string::npos) << Log();
}

// Whoever reaches the port can approve a calibration.
TEST_F(Process, DoesNotListenWhereOtherMachinesReachIt) {
  for (const std::string address : {"0.0.0.0:0", "[::]:0"}) {
    EXPECT_FALSE(StartServer(address).ok()) << address;
    EXPECT_NE(Log().find(address + ", can be reached from other machines"), std::string::npos) << Log();
  }
  EXPECT_FALSE(std::filesystem::exists(dir_.File("axiscal.db")));
}

// Where nobody is asked, the audit has the login that the operating system tells, whatever the client states.
TEST_F(Process, WhoeverIsNotAskedIsTheUserOfTheOtherEnd) {
  for (const std::string& listen : std::vector<std::string>{"127.0.0.1:0", "[::1]:0", "unix:" + dir_.File("socket")}) {
    absl::StatusOr<ServerProcess> server = StartServer(listen);
    ASSERT_OK(server);
    auto client = client::Client::Connect(server->address(), {.user = "somebody-else"});
    ASSERT_OK(client);
    EXPECT_EQ(client->GetIdentity()->name, "local:" + server::LoginOfProcess()) << listen;
  }
}

TEST_F(Process, IsConfiguredByAFileThatFlagsOverride) {
  std::ofstream(dir_.File("axiscald.toml"))
      << "[server]\nlisten = \"unix:" << dir_.File("socket") << "\"\n[jobs]\nworkers = 7\n[limits]\nmax_uploads = 3\n";
  absl::StatusOr<ServerProcess> server =
      ServerProcess::Start(dir_.File("axiscal.db"), "127.0.0.1:0", dir_.File("log"),
                           {"--config", dir_.File("axiscald.toml"), "--workers", "1"});
  ASSERT_OK(server);
  EXPECT_EQ(server->address().rfind("127.0.0.1:", 0), 0u) << server->address();
  auto client = client::Client::Connect(server->address());
  ASSERT_OK(client);
  EXPECT_EQ(client->GetServerInfo()->max_uploads, 3);
  EXPECT_EQ(client->GetServerInfo()->workers, 1);
}

TEST_F(Process, CheckConfigTellsWhatHoldsAndTouchesNothing) {
  std::ofstream(dir_.File("axiscald.toml")) << "[store]\ndatabase = \"a.db\"\n[jobs]\nworkers = 7\n";
  std::string output;
  EXPECT_EQ(testing::RunProgram({AXISCALD_PATH, "--config", dir_.File("axiscald.toml"), "--check-config"}, &output), 0);
  EXPECT_NE(output.find("jobs.workers = 7 (" + dir_.File("axiscald.toml") + ":4)\n"), std::string::npos) << output;
  EXPECT_NE(output.find("limits.max_uploads = 500 (default)\n"), std::string::npos) << output;
  EXPECT_FALSE(std::filesystem::exists(dir_.File("a.db")));
  std::ofstream(dir_.File("axiscald.toml")) << "[jobs]\nwrkers = 7\n";
  EXPECT_EQ(testing::RunProgram({AXISCALD_PATH, "--config", dir_.File("axiscald.toml"), "--check-config"}, &output),
            EX_CONFIG);
}

TEST_F(Process, ADatabaseThatEverybodyMayReadIsNamedInTheLog) {
  ASSERT_OK(StartServer());
  EXPECT_EQ(Log().find("event=readable_by_others"), std::string::npos) << Log();
  ASSERT_EQ(chmod(dir_.File("axiscal.db").c_str(), 0644), 0);
  ASSERT_OK(StartServer());
  EXPECT_NE(Log().find("level=warning event=readable_by_others"), std::string::npos) << Log();
  EXPECT_NE(Log().find("/axiscal.db (0644)"), std::string::npos) << Log();
}

TEST_F(Process, ASecondServerOnTheSamePortOrFileIsRefused) {
  absl::StatusOr<ServerProcess> server = StartServer();
  ASSERT_OK(server);
  EXPECT_FALSE(ServerProcess::Start(dir_.File("other.db"), server->address(), dir_.File("log2")).ok());
  EXPECT_FALSE(StartServer().ok());
}

TEST_F(Process, NoServerIsSaidSo) {
  const auto client = client::Client::Connect("127.0.0.1:1", {.connect_deadline = std::chrono::milliseconds(200)});
  EXPECT_EQ(client.status().code(), absl::StatusCode::kUnavailable);
  EXPECT_EQ(base::ErrorReason(client.status()), "NO_CONNECTION");
}

// What gRPC and proxies say of a connection that broke off tells nobody what to do. What the service says stays as it
// is.
TEST_F(Process, AConnectionThatBrokeOffIsSaidSo) {
  const client::Connection connection(grpc::CreateChannel("127.0.0.1:1", grpc::InsecureChannelCredentials()),
                                      "mill:7410", {});
  for (const grpc::Status& status :
       {grpc::Status(grpc::StatusCode::UNKNOWN, "Stream removed"), grpc::Status(grpc::StatusCode::UNAVAILABLE, ""),
        grpc::Status(grpc::StatusCode::UNAVAILABLE, "Socket closed"),
        grpc::Status(grpc::StatusCode::CANCELLED, "Received RST_STREAM with error code 8")}) {
    const absl::Status told = connection.FromGrpc(status);
    EXPECT_TRUE(client::IsBroken(told)) << told;
    EXPECT_EQ(base::ErrorReason(told), "CONNECTION_LOST");
    EXPECT_THAT(std::string(told.message()), ::testing::HasSubstr("mill:7410"));
    EXPECT_THAT(std::string(told.message()), ::testing::HasSubstr("repeat the call"));
  }
  for (const grpc::Status& status :
       {grpc::Status(grpc::StatusCode::UNKNOWN, "else"), grpc::Status(grpc::StatusCode::CANCELLED, "by the caller"),
        grpc::Status(grpc::StatusCode::RESOURCE_EXHAUSTED, "Received RST_STREAM with error code 11")}) {
    EXPECT_EQ(base::ErrorReason(connection.FromGrpc(status)), "") << status.error_message();
  }
}

// Whoever watches a job goes on when the server is there again, and hears why where it does not come.
TEST_F(Process, AWatchWhoseServerWasKilledSaysSo) {
  absl::StatusOr<ServerProcess> server = StartServer();
  ASSERT_OK(server);
  absl::StatusOr<client::Client> client =
      client::Client::Connect(server->address(), {.give_up_after = std::chrono::milliseconds(500)});
  ASSERT_OK(client);
  const auto job = client->CreateJob(StoreMuchToIdentifyFrom(*client));
  ASSERT_OK(job);
  bool was_killed = false;
  const auto ended = client->WatchJob(job->id, [&](const client::JobRecord&) {
    if (!std::exchange(was_killed, true)) {
      server->Signal(SIGKILL);
      server->Wait();
    }
    return true;
  });
  EXPECT_TRUE(was_killed);
  EXPECT_TRUE(absl::IsUnavailable(ended.status())) << ended.status();
  EXPECT_EQ(base::ErrorReason(ended.status()), "CONNECTION_LOST");
}

TEST_F(Process, TheLineOfACallHasItsRequest) {
  absl::StatusOr<ServerProcess> server = StartServer();
  ASSERT_OK(server);
  absl::StatusOr<client::Client> client = client::Client::Connect(server->address());
  ASSERT_OK(client);
  ASSERT_OK(client->CreateMachine(MachineJson("mt")));
  ASSERT_OK(client->Upload(MachineId("mt"), BallbarSession("mt", "BX", 10)));
  ASSERT_OK(client->PutProgram("part.nc", "G1 X1 F100\n"));
  server->Signal(SIGTERM);
  EXPECT_EQ(server->Wait(), 0);
  // Of a message, and of the header that a stream begins with; a call without one has none.
  for (const char* event : {"method=Ingest.CreateSession [^\n]* request=[^ ]+ trace=",
                            "method=Programs.PutProgram [^\n]* request=[^ ]+ trace="}) {
    EXPECT_THAT(Log(), ::testing::ContainsRegex(event));
  }
  EXPECT_THAT(Log(), ::testing::Not(::testing::ContainsRegex("method=Machines.CreateMachine [^\n]* request=")));
}

TEST_F(Process, AnUploadSurvivesKillsOfTheServer) {
  absl::StatusOr<ServerProcess> started = StartServer();
  ASSERT_OK(started);
  auto server = std::make_unique<ServerProcess>(*std::move(started));
  const std::string address = server->address();
  absl::StatusOr<client::Client> client = client::Client::Connect(address);
  ASSERT_OK(client);
  ASSERT_OK(client->CreateMachine(MachineJson("mt")));

  constexpr int kReadings = 200'000;
  const session::Session session = BallbarSession("mt", "BX", kReadings);
  int kills = 0;
  int64_t acknowledged = 0;
  // On the client's own thread, between two chunks: the stream is open and chunks are under way.
  const auto upload = client->Upload(MachineId("mt"), session, [&](const client::TransferProgress& progress) {
    EXPECT_GE(progress.done, acknowledged) << "acknowledged readings were lost";
    acknowledged = progress.done;
    if (kills < 3 && progress.done > (kills + 1) * kReadings / 5) {
      server->Signal(SIGKILL);
      EXPECT_EQ(server->Wait(), 128 + SIGKILL);
      absl::StatusOr<ServerProcess> again = StartServer(address);
      ASSERT_OK(again);
      server = std::make_unique<ServerProcess>(*std::move(again));
      ++kills;
    }
  });
  ASSERT_OK(upload);
  EXPECT_EQ(kills, 3);
  EXPECT_GE(upload->interruptions, 3);
  EXPECT_EQ(upload->session.reading_count, kReadings);
  const auto back = client->DownloadSession(upload->session.id);
  ASSERT_OK(back);
  EXPECT_TRUE(*back == session);
  const auto all = client->ListSessions();
  ASSERT_OK(all);
  EXPECT_EQ(all->rows.size(), 1u);
}

// Kills the server when the job is first seen running: on the one that follows it runs once more and stores once.
void Process::KillDuringAJob(const std::function<records::JobParams(client::Client&)>& store) {
  absl::StatusOr<ServerProcess> started = StartServer();
  ASSERT_OK(started);
  auto server = std::make_unique<ServerProcess>(*std::move(started));
  const std::string address = server->address();
  absl::StatusOr<client::Client> client = client::Client::Connect(address);
  ASSERT_OK(client);
  const records::JobParams params = store(*client);
  const auto job = client->CreateJob(params, "once");
  ASSERT_OK(job);
  bool was_killed = false;
  const auto ended = client->WatchJob(job->id, [&](const client::JobRecord& record) {
    if (was_killed || record.state != records::JobState::kRunning) return true;
    was_killed = true;
    server->Signal(SIGKILL);
    server->Wait();
    absl::StatusOr<ServerProcess> again = StartServer(address);
    EXPECT_TRUE(again.ok()) << again.status();
    if (again.ok()) server = std::make_unique<ServerProcess>(*std::move(again));
    return true;
  });
  ASSERT_OK(ended);
  EXPECT_TRUE(was_killed);
  EXPECT_EQ(ended->state, records::JobState::kSucceeded);
  EXPECT_EQ(ended->attempt, 2);
  // Between the attempt and what became of it stand the request and its trace.
  for (const std::string event :
       {"event=call method=Jobs.CreateJob [^\n]*code=OK [^\n]*request=once trace=", "event=job_start job=1 kind=",
        "attempt=1 request=once[^\n]* outcome=RETRY reason=OWNER_LOST",
        "event=job_start [^\n]*machine=mt attempt=2 request=once", "attempt=2 request=once[^\n]* outcome=SUCCEEDED"}) {
    EXPECT_THAT(Log(), ::testing::ContainsRegex(event));
  }
  const auto again = client->CreateJob(params, "once");
  ASSERT_OK(again);
  EXPECT_EQ(again->id, job->id);
  const auto calibrations = client->ListCalibrations();
  ASSERT_OK(calibrations);
  EXPECT_EQ(calibrations->rows.size(), 1u);
}

TEST_F(Process, AJobSurvivesAKillOfTheServer) {
  KillDuringAJob([this](client::Client& client) { return StoreMuchToIdentifyFrom(client); });
}

TEST_F(Process, TheLoopSurvivesAKillOfTheServer) {
  KillDuringAJob([](client::Client& client) {
    records::CloseLoopParams params{MachineId("mt"), {}, {}, {}};
    EXPECT_TRUE(client.CreateMachine(MachineJson("mt")).ok());
    for (std::vector<SessionId>* sessions : {&params.fit, &params.check}) {
      const std::string name = sessions == &params.fit ? "fit" : "check";
      const auto upload = client.Upload(MachineId("mt"), BallbarSession("mt", name, 8'000));
      EXPECT_TRUE(upload.ok()) << upload.status();
      if (upload.ok()) sessions->push_back(upload->session.id);
    }
    return params;
  });
}

TEST_F(Process, AJobThatIsNotDoneWhenTheDrainTimeIsOverRunsAfterTheRestart) {
  const std::vector<client::JobRecord> seen = StopDuringAJob("0");
  ASSERT_FALSE(seen.empty());
  EXPECT_NE(seen.front().state, records::JobState::kSucceeded);
  EXPECT_EQ(seen.back().state, records::JobState::kSucceeded);
  EXPECT_EQ(seen.back().attempt, 1) << "a parked job loses no attempt";
  EXPECT_NE(Log().find("event=stopped"), std::string::npos) << Log();
}

TEST_F(Process, AJobThatRunsIsFinishedWithinTheDrainTime) {
  const std::vector<client::JobRecord> seen = StopDuringAJob("600");
  ASSERT_FALSE(seen.empty());
  EXPECT_EQ(seen.front().state, records::JobState::kSucceeded);
  EXPECT_EQ(seen.front().attempt, 1);
}

TEST_F(Process, TheExampleOfTheReadmeWorks) {
  absl::StatusOr<ServerProcess> server = StartServer();
  ASSERT_OK(server);
  absl::StatusOr<client::Client> client = client::Client::Connect(server->address());
  ASSERT_OK(client);
  ASSERT_OK(client->CreateMachine(MachineJson("mt")));
  const std::string path = dir_.File("BX.csv");
  ASSERT_TRUE(session::WriteSessionFile(BallbarSession("mt", "BX", 1500), path).ok());
  std::string output;
  EXPECT_EQ(testing::RunProgram({EXAMPLE_UPLOAD_PATH, server->address(), "mt", path}, &output), 0);
  EXPECT_NE(output.find("1500 of 1500 readings are on disk"), std::string::npos) << output;
  EXPECT_EQ(testing::RunProgram({EXAMPLE_UPLOAD_PATH, server->address(), "mt", path}, &output), 0);
  EXPECT_NE(output.find("was there already"), std::string::npos) << output;
}

TEST_F(Process, ALinkToTheDatabaseOpensNoSecondServer) {
  absl::StatusOr<ServerProcess> server = StartServer();
  ASSERT_OK(server);
  for (const std::string link : {"symbolic.db", "hard.db"}) {
    const std::string path = dir_.File(link);
    if (link == "hard.db") {
      std::filesystem::create_hard_link(dir_.File("axiscal.db"), path);
    } else {
      std::filesystem::create_symlink(dir_.File("axiscal.db"), path);
    }
    EXPECT_FALSE(ServerProcess::Start(path, "127.0.0.1:0", dir_.File("second log")).ok()) << link;
    std::ifstream log(dir_.File("second log"));
    const std::string text{std::istreambuf_iterator<char>(log), {}};
    EXPECT_NE(text.find("the database is in use"), std::string::npos) << link << ": " << text;
  }
}

}  // namespace
}  // namespace axiscal
