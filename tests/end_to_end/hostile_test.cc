// What a hostile or broken client does to the server as a process, over a real port: others must not feel it.
#include <signal.h>
#include <sqlite3.h>

#include <algorithm>
#include <atomic>
#include <fstream>
#include <memory>
#include <thread>

#include "axiscal/v1/ingest_service.grpc.pb.h"
#include "axiscal/v1/jobs_service.grpc.pb.h"
#include "axiscal/v1/machines_service.grpc.pb.h"
#include "axiscal/v1/programs_service.grpc.pb.h"
#include "grpc/health/v1/health.grpc.pb.h"
#include "server/access/gate.h"
#include "server/local_login.h"
#include "server/server.h"
#include "server/storage/sqlite_database.h"
#include "tests/end_to_end/testing/fixture.h"
#include "tests/end_to_end/testing/process.h"
#include "tests/end_to_end/testing/raw_http2.h"
#include "tests/end_to_end/testing/raw_upload.h"

namespace axiscal {
namespace {

using testing::BallbarSession;
using testing::MachineJson;
using testing::RawConnection;
using testing::ServerProcess;

class Hostile : public ::testing::Test {
 protected:
  void StartServer(const std::vector<std::string>& flags = {}, int max_descriptors = 0) {
    absl::StatusOr<ServerProcess> started =
        ServerProcess::Start(dir_.File("axiscal.db"), "127.0.0.1:0", dir_.File("log"), flags, max_descriptors);
    ASSERT_OK(started);
    server_ = std::make_unique<ServerProcess>(*std::move(started));
    Connect();
  }
  void Connect() {
    absl::StatusOr<client::Client> client = client::Client::Connect(server_->address());
    ASSERT_OK(client);
    client_ = std::make_unique<client::Client>(*std::move(client));
  }
  std::shared_ptr<grpc::Channel> Channel() {
    return grpc::CreateChannel(server_->address(), grpc::InsecureChannelCredentials());
  }

  // Before the server is started: an admin, whose token is in the file "token".
  void AddAdmin() {
    const std::string token = access::NewToken();
    storage::SqliteOptions options;
    options.path = dir_.File("axiscal.db");
    const auto database = storage::OpenSqlite(options);
    ASSERT_OK(database);
    ASSERT_OK((*database)->CreatePrincipal("ann", "", {"setup", ""}));
    ASSERT_OK((*database)->ChangeRole("ann", {records::Role::kAdmin, {}}, true, {"setup", ""}));
    ASSERT_OK((*database)->CreateToken({"ann", access::HashOfToken(token), "", {}}, {"setup", ""}));
    std::ofstream(dir_.File("token")) << token << "\n";
  }
  void ExpectServed() {
    client::Options options;
    options.identity.token_file = dir_.File("token");
    auto client = client::Client::Connect(server_->address(), options);
    ASSERT_OK(client);
    // What was queued before strangers were ended has the threads for a while.
    constexpr int kTries = 600;
    absl::Status created;
    for (int i = 0; i < kTries && (i == 0 || absl::IsResourceExhausted(created)); ++i) {
      if (i > 0) std::this_thread::sleep_for(std::chrono::milliseconds(100));
      created = client->CreateMachine(MachineJson("mt")).status();
    }
    EXPECT_TRUE(created.ok()) << created;
  }

  testing::TempDir dir_;
  std::unique_ptr<ServerProcess> server_;
  std::unique_ptr<client::Client> client_;
};

// What a caller says in metadata is written to the log, and nobody is who he says.
TEST_F(Hostile, AUserThatIsNoUtf8IsRefusedAndSpoilsNoList) {
  StartServer();
  ASSERT_OK(client_->CreateMachine(MachineJson("mt")));
  const auto create = [this](const std::string& user, const std::string& request_id) {
    RawConnection connection(server_->address());
    return connection.Call(
        "/axiscal.v1.Ingest/CreateSession", {{"axiscal-user", user}},
        testing::CreateRequest("mt", request_id, BallbarSession("mt", "BX", 100)).SerializeAsString());
  };
  for (const std::string user : {"cell\xFF", "caf\xE9", "\xC3", "\xED\xA0\x80", ""}) {
    EXPECT_NE(create(user, "r-1").find("axiscal-user: "), std::string::npos) << user;
  }
  ASSERT_OK(client_->ListSessions());
  EXPECT_TRUE(client_->ListSessions()->rows.empty());
  EXPECT_EQ(create("M\xC3\xBCller", "r-1").find("axiscal-user: "), std::string::npos);
  const auto sessions = client_->ListSessions();
  ASSERT_OK(sessions);
  ASSERT_EQ(sessions->rows.size(), 1u);
  EXPECT_EQ(sessions->rows[0].created_by, "local:" + server::LoginOfProcess());
}

// Written by a version that took any bytes.
TEST_F(Hostile, TextsThatAreStoredAndNoUtf8SpoilNoList) {
  StartServer();
  ASSERT_OK(client_->CreateMachine(MachineJson("mt")));
  ASSERT_OK(client_->Upload(MachineId("mt"), BallbarSession("mt", "BX", 100)));
  server_->Signal(SIGTERM);
  ASSERT_EQ(server_->Wait(), 0);
  sqlite3* db = nullptr;
  ASSERT_EQ(sqlite3_open(dir_.File("axiscal.db").c_str(), &db), SQLITE_OK);
  EXPECT_EQ(sqlite3_exec(db, "UPDATE session SET created_by = CAST(x'63616665FF' AS TEXT)", nullptr, nullptr, nullptr),
            SQLITE_OK)
      << sqlite3_errmsg(db);
  sqlite3_close(db);
  StartServer();
  const auto sessions = client_->ListSessions();
  ASSERT_OK(sessions);
  ASSERT_EQ(sessions->rows.size(), 1u);
  EXPECT_EQ(sessions->rows[0].created_by, "cafe\xEF\xBF\xBD");
}

// gRPC decompresses a message before it compares its size with the limit: 64 KB of gzip are 64 MB of blanks.
TEST_F(Hostile, CompressedMessagesAreRefusedBeforeTheyGrow) {
  StartServer();
  const int64_t peak_bytes = server_->PeakMemoryBytes();
  const auto stub = v1::Machines::NewStub(Channel());
  for (const grpc_compression_algorithm algorithm : {GRPC_COMPRESS_GZIP, GRPC_COMPRESS_DEFLATE}) {
    grpc::ClientContext context;
    context.set_compression_algorithm(algorithm);
    v1::CreateMachineRequest request;
    request.set_description_json(std::string(64 << 20, ' '));
    v1::CreateMachineResponse response;
    const grpc::Status status = stub->CreateMachine(&context, request, &response);
    EXPECT_EQ(status.error_code(), grpc::StatusCode::UNIMPLEMENTED) << status.error_message();
  }
  EXPECT_LT(server_->PeakMemoryBytes(), peak_bytes + (32 << 20));
  ASSERT_OK(client_->CreateMachine(MachineJson("mt")));
}

// 4 MB of parts that hold nothing, in messages of calls and of streams: 100 bytes each in memory.
TEST_F(Hostile, EmptyPartsAreRefusedBeforeTheyGrow) {
  StartServer();
  constexpr int kParts = 2'000'000;
  v1::CreateJobRequest job;
  for (int i = 0; i < kParts; ++i) job.mutable_params()->mutable_compensate()->mutable_options()->add_work_offsets();
  v1::UploadRequest chunk;
  for (int i = 0; i < kParts; ++i) chunk.mutable_chunk()->add_columns();
  const int64_t peak_bytes = server_->PeakMemoryBytes();
  const std::shared_ptr<grpc::Channel> channel = Channel();
  {
    grpc::ClientContext context;
    v1::CreateJobResponse response;
    const grpc::Status status = v1::Jobs::NewStub(channel)->CreateJob(&context, job, &response);
    EXPECT_EQ(status.error_code(), grpc::StatusCode::RESOURCE_EXHAUSTED) << status.error_message();
    EXPECT_NE(status.error_message().find("parts"), std::string::npos) << status.error_message();
  }
  grpc::ClientContext context;
  v1::UploadOnceResponse response;
  const auto stream = v1::Ingest::NewStub(channel)->UploadOnce(&context, &response);
  stream->Write(chunk);
  EXPECT_FALSE(stream->Finish().ok());
  EXPECT_LT(server_->PeakMemoryBytes(), peak_bytes + (64 << 20));
  ASSERT_OK(client_->CreateMachine(MachineJson("mt")));
}

// Calls whose message never comes to its end wait where no handler sees them, and for ever. The server ends them when
// there is too much of it; how far it goes beyond meanwhile hangs on how fast they send.
TEST_F(Hostile, WhatIsHalfSentBeyondItsLimitIsEnded) {
  StartServer({"--waiting-bytes", absl::StrCat(32 << 20)});
  constexpr int kConnections = 8, kCalls = 100;
  constexpr int64_t kBytes = 3'900'000, kMost = kConnections * kCalls * kBytes / 2;
  std::atomic<int> ended = 0;
  std::atomic<bool> is_over = false;
  int64_t memory = 0;
  std::thread watch([&] {
    while (!is_over) memory = std::max(memory, server_->MemoryBytes());
  });
  std::vector<std::thread> callers;
  for (int i = 0; i < kConnections; ++i) {
    callers.emplace_back([&] {
      RawConnection connection(server_->address());
      ended += connection.SendHalf("/axiscal.v1.Jobs/CreateJob", kCalls, kBytes).ended;
    });
  }
  for (std::thread& caller : callers) caller.join();
  is_over = true;
  watch.join();
  EXPECT_GT(ended, (kConnections - 1) * kCalls);
  EXPECT_LT(memory, kMost);
  ASSERT_OK(client_->CreateMachine(MachineJson("mt")));
  ASSERT_OK(client_->Upload(MachineId("mt"), BallbarSession("mt", "BX", 5'000)));
}

// The caller is known; his calls are within the limit of calls, but never begin their message.
TEST_F(Hostile, HeadsOfWhoIsKnownBeyondTheLimitAreEnded) {
  StartServer({"--waiting-bytes", absl::StrCat(16 << 20)});
  RawConnection connection(server_->address());
  connection.Call("/axiscal.v1.Machines/ListMachines", {}, "");
  EXPECT_TRUE(connection.BeginHeads("/axiscal.v1.Machines/ListMachines", {}, 10'000));
  EXPECT_TRUE(connection.WaitForClose());
  ASSERT_OK(client_->CreateMachine(MachineJson("mt")));
}

// HTTP/2 rapid reset (CVE-2023-44487): the calls are none of those that a connection may have at a time, and each gets
// a thread.
TEST_F(Hostile, CallsThatAreTakenBackAtOnceEndTheConnectionAndMakeNoThreads) {
  AddAdmin();
  StartServer({"--ask-identity"});
  const int64_t most_threads = server_->ThreadCount() + 3'000;
  constexpr int kConnections = 4, kCalls = 1'000;
  std::atomic<int> ended = 0;
  std::vector<std::thread> floods;
  for (int i = 0; i < kConnections; ++i) {
    floods.emplace_back([&] {
      RawConnection connection(server_->address());
      const bool is_ended = connection.BeginAndReset("/axiscal.v1.Machines/ListMachines", kCalls) < kCalls;
      ended += is_ended || connection.WaitForClose() ? 1 : 0;
    });
  }
  std::atomic<bool> is_over = false;
  int64_t threads = 0;
  std::thread watch([&] {
    while (!is_over) threads = std::max(threads, server_->ThreadCount());
  });
  for (std::thread& flood : floods) flood.join();
  is_over = true;
  watch.join();
  EXPECT_EQ(ended, kConnections);
  EXPECT_LT(threads, most_threads);
  ExpectServed();
}

// Calls whose message never comes: no handler hears of them, and gRPC holds nobody to its limit of calls who does not
// acknowledge it.
TEST_F(Hostile, CallsOfStrangersThatAreHeadsAloneAreFew) {
  AddAdmin();
  StartServer({"--ask-identity"});
  constexpr int kCalls = 100, kLeft = 4;
  for (const std::string method : {"/axiscal.v1.Machines/ListMachines", "/grpc.health.v1.Health/Check"}) {
    RawConnection connection(server_->address());
    connection.Greet();
    EXPECT_TRUE(connection.BeginHeads(method, {}, kCalls));
    std::string seen;
    EXPECT_EQ(connection.CountEnded(kCalls - kLeft, &seen), kCalls - kLeft) << method;
    const bool is_health = method.find("health") != std::string::npos;
    EXPECT_NE(seen.find(is_health ? "has shown no identity" : "who calls must show"), std::string::npos) << seen;
  }
  ExpectServed();
}

// Some at a time: all heads that one read of the server brings begin their calls before it looks at the first.
TEST_F(Hostile, CallsOfStrangersThatAreHeadsAloneTakeNoMemory) {
  AddAdmin();
  StartServer({"--ask-identity"});
  const int64_t peak_bytes = server_->PeakMemoryBytes();
  constexpr int kConnections = 4, kCalls = 10'000, kTogether = 200, kLeft = 4;
  std::vector<RawConnection> connections;
  for (int i = 0; i < kConnections; ++i) connections.emplace_back(server_->address()).Greet();
  for (int begun = 0; begun < kCalls; begun += kTogether) {
    for (RawConnection& connection : connections) {
      std::string seen;
      if (!connection.BeginHeads("/axiscal.v1.Machines/ListMachines", {}, kTogether)) continue;
      const int ended = connection.CountEnded(kTogether - kLeft, &seen);
      ASSERT_TRUE(ended == kTogether - kLeft || connection.IsClosed()) << ended << " of those after " << begun;
    }
  }
  EXPECT_LT(server_->PeakMemoryBytes(), peak_bytes + (64 << 20));
  ExpectServed();
}

// All at once: gRPC begins the calls of a whole read before it looks at the first head. The allocator would keep their
// memory for good.
TEST_F(Hostile, WhatABurstOfHeadsTookIsGivenBack) {
  AddAdmin();
  StartServer({"--ask-identity"});
  const int64_t before_bytes = server_->MemoryBytes();
  constexpr int kConnections = 400, kCalls = 900;
  {
    std::vector<std::thread> bursts;
    for (int i = 0; i < kConnections; ++i) {
      bursts.emplace_back([this] {
        RawConnection connection(server_->address());
        connection.Greet();
        connection.BeginHeads("/axiscal.v1.Machines/ListMachines", {}, kCalls);
        connection.WaitForClose();
      });
    }
    for (std::thread& burst : bursts) burst.join();
  }
  constexpr int64_t kLeft = 48 << 20;  // threads and connections of gRPC itself
  const auto give_up_at = std::chrono::steady_clock::now() + std::chrono::minutes(2);
  while (server_->MemoryBytes() > before_bytes + kLeft && std::chrono::steady_clock::now() < give_up_at)
    std::this_thread::sleep_for(std::chrono::milliseconds(100));
  EXPECT_LE(server_->MemoryBytes(), before_bytes + kLeft);
  ExpectServed();
  if (server_->PeakMemoryBytes() < before_bytes + kLeft) GTEST_SKIP() << "so quick that there was nothing to give back";
}

// Too slow for a flood. What a stranger is told and does not take waits in gRPC's memory.
TEST_F(Hostile, StrangersThatTakeNoRefusalsAreEnded) {
  AddAdmin();
  StartServer({"--ask-identity"});
  RawConnection connection(server_->address(), 4096);
  connection.Greet();
  constexpr int kTogether = 8, kMost = 40'000;  // a minute of them: the server looks twice a second
  int begun = 0;
  while (begun < kMost && connection.BeginHeads("/axiscal.v1.Machines/ListMachines", {}, kTogether)) {
    begun += kTogether;
    std::this_thread::sleep_for(std::chrono::milliseconds(10));
  }
  EXPECT_LT(begun, kMost);
  ExpectServed();
}

// Whoever shows an identity with the head has just come and begins much together.
TEST_F(Hostile, CallsOfWhoIsKnownWaitForTheirMessage) {
  AddAdmin();
  StartServer({"--ask-identity"});
  std::string token;
  std::ifstream(dir_.File("token")) >> token;
  RawConnection connection(server_->address());
  connection.Greet();
  EXPECT_TRUE(connection.BeginHeads("/axiscal.v1.Machines/ListMachines", {{"authorization", "Bearer " + token}}, 50));
  EXPECT_TRUE(connection.BeginHeads("/none", {}, 1));  // answered without a message, and after what came before it
  std::string seen;
  EXPECT_EQ(connection.CountEnded(1, &seen), 1);
  EXPECT_EQ(seen.find("who calls must show"), std::string::npos) << seen;
}

// A balancer asks for the health as long as it lives, and never shows who it is.
TEST_F(Hostile, HealthIsToldToStrangersAFewCallsAtATime) {
  AddAdmin();
  StartServer({"--ask-identity"});
  const auto health = grpc::health::v1::Health::NewStub(Channel());
  const auto check = [&] {
    grpc::ClientContext context;
    grpc::health::v1::HealthCheckResponse response;
    return health->Check(&context, {}, &response);
  };
  for (int i = 0; i < 50; ++i) EXPECT_TRUE(check().ok()) << i;
  std::vector<std::unique_ptr<grpc::ClientContext>> contexts;
  std::vector<std::unique_ptr<grpc::ClientReader<grpc::health::v1::HealthCheckResponse>>> watches;
  constexpr int kMost = 4, kTries = 600;
  for (int i = 0; i < kMost; ++i) {
    contexts.push_back(nullptr);
    watches.push_back(nullptr);
    grpc::health::v1::HealthCheckResponse response;
    bool is_heard = false;
    // The place of the last check is free a moment after its answer.
    for (int k = 0; k < kTries && !is_heard; ++k) {
      watches[i].reset();
      contexts[i] = std::make_unique<grpc::ClientContext>();
      watches[i] = health->Watch(contexts[i].get(), {});
      is_heard = watches[i]->Read(&response);
      if (!is_heard) {
        EXPECT_EQ(watches[i]->Finish().error_code(), grpc::StatusCode::RESOURCE_EXHAUSTED);
        std::this_thread::sleep_for(std::chrono::milliseconds(100));
      }
    }
    EXPECT_TRUE(is_heard) << i;
  }
  EXPECT_EQ(check().error_code(), grpc::StatusCode::RESOURCE_EXHAUSTED);
  for (int i = 0; i < kMost; ++i) {
    contexts[i]->TryCancel();
    watches[i]->Finish();
  }
  for (int i = 0; i < kTries && !check().ok(); ++i) std::this_thread::sleep_for(std::chrono::milliseconds(100));
  EXPECT_TRUE(check().ok());
}

// Connections that have shown nobody: beyond what they may have the first give way, and nobody's who is known.
TEST_F(Hostile, StrangersCannotHoldAllConnections) {
  AddAdmin();
  server::ServerOptions options;
  options.database_path = dir_.File("axiscal.db");
  options.listen_address = "127.0.0.1:0";
  options.asks_identity = true;
  options.strangers = 4;
  auto server = server::Server::Start(options);
  ASSERT_OK(server);
  const std::string address = absl::StrCat("127.0.0.1:", (*server)->port());
  client::Options as_ann;
  as_ann.identity.token_file = dir_.File("token");
  auto known = client::Client::Connect(address, as_ann);
  ASSERT_OK(known);
  ASSERT_OK(known->CreateMachine(MachineJson("mt")));
  std::vector<RawConnection> strangers;
  for (int i = 0; i < 10; ++i) {
    strangers.emplace_back(address);
    strangers.back().Greet();
  }
  const auto is_closed = [](RawConnection& stranger) { return stranger.IsClosed(); };
  constexpr int kTries = 600;
  ptrdiff_t closed = 0;
  for (int i = 0; i < kTries && closed < 6; ++i) {
    std::this_thread::sleep_for(std::chrono::milliseconds(100));
    closed = std::count_if(strangers.begin(), strangers.end(), is_closed);
  }
  EXPECT_EQ(closed, 6);
  EXPECT_FALSE(strangers.back().IsClosed());
  ASSERT_OK(known->CreateMachine(MachineJson("mt2")));
}

// As many keys as a message can hold are answered while the caller waits.
TEST_F(Hostile, JsonOfDistinctKeysIsAnswered) {
  StartServer();
  std::string json = "{";
  for (int i = 0; json.size() < 3'900'000; ++i) absl::StrAppend(&json, i == 0 ? "" : ",", "\"k", i, "\":0");
  json += "}";
  const auto created = client_->CreateMachine(json);
  EXPECT_EQ(created.status().code(), absl::StatusCode::kInvalidArgument) << created.status();
  EXPECT_NE(created.status().message().find("k0: unknown field"), std::string::npos) << created.status();
}

// Connections that nobody uses, more of them than the server has descriptors for.
TEST_F(Hostile, MoreConnectionsThanDescriptorsAreSurvived) {
  constexpr int kDescriptors = 128;
  StartServer({}, kDescriptors);
  {
    std::vector<RawConnection> idle;
    for (int i = 0; i < 2 * kDescriptors; ++i) {
      idle.emplace_back(server_->address());
      ASSERT_TRUE(idle.back().is_connected()) << i;
      idle.back().Greet();
    }
    EXPECT_TRUE(idle.back().WaitForClose());  // beyond what the server has room for
    // Who was there before is served, with files and connections of the server's own.
    ASSERT_OK(client_->CreateMachine(MachineJson("mt")));
    ASSERT_OK(client_->Upload(MachineId("mt"), BallbarSession("mt", "BX", 5'000)));
  }
  Connect();  // who comes afterwards, too
  const auto sessions = client_->ListSessions();
  ASSERT_OK(sessions);
  EXPECT_EQ(sessions->rows.size(), 1u);
}

TEST_F(Hostile, ConnectionsThatNobodyUsesAreClosed) {
  StartServer({"--idle-seconds", "1"});
  std::vector<RawConnection> idle;
  for (int i = 0; i < 20; ++i) {
    idle.emplace_back(server_->address());
    idle.back().Greet();
  }
  for (RawConnection& connection : idle) EXPECT_TRUE(connection.WaitForClose());
  ASSERT_OK(client_->CreateMachine(MachineJson("mt")));  // over a new connection
}

// Streams that were begun and say nothing more, before their header and after it.
TEST_F(Hostile, StreamsThatSayNothingAreCutOff) {
  StartServer({"--silence-seconds", "1"});
  ASSERT_OK(client_->CreateMachine(MachineJson("mt")));
  const std::shared_ptr<grpc::Channel> channel = Channel();
  const auto ingest = v1::Ingest::NewStub(channel);
  const auto programs = v1::Programs::NewStub(channel);
  v1::CreateSessionResponse created;
  {
    grpc::ClientContext context;
    ASSERT_TRUE(
        ingest->CreateSession(&context, testing::CreateRequest("mt", "r-1", BallbarSession("mt", "BX", 10)), &created)
            .ok());
  }
  v1::UploadRequest header;
  header.mutable_header()->set_session_id(created.session().session_id());
  v1::PutProgramRequest program;
  program.mutable_header()->set_name("O1.nc");
  program.mutable_header()->set_size_bytes(1000);
  program.mutable_header()->set_sha256(std::string(64, '0'));
  program.mutable_header()->set_request_id("r-2");
  for (const bool with_header : {false, true}) {
    v1::UploadOnceResponse once_response;
    v1::PutProgramResponse put_response;
    grpc::ClientContext once_context, upload_context, put_context, rewrite_context;
    const auto once = ingest->UploadOnce(&once_context, &once_response);
    const auto upload = ingest->Upload(&upload_context);
    const auto put = programs->PutProgram(&put_context, &put_response);
    const auto rewrite = programs->RewriteProgram(&rewrite_context);
    if (with_header) {
      EXPECT_TRUE(once->Write(header) && upload->Write(header) && put->Write(program));
    }
    EXPECT_EQ(once->Finish().error_code(), grpc::StatusCode::CANCELLED);
    v1::UploadResponse upload_response;
    while (upload->Read(&upload_response)) {
    }
    EXPECT_EQ(upload->Finish().error_code(), grpc::StatusCode::CANCELLED);
    EXPECT_EQ(put->Finish().error_code(), grpc::StatusCode::CANCELLED);
    v1::RewriteProgramResponse rewrite_response;
    EXPECT_FALSE(rewrite->Read(&rewrite_response));
    EXPECT_EQ(rewrite->Finish().error_code(), grpc::StatusCode::CANCELLED);
  }
  const auto info = client_->GetServerInfo();
  ASSERT_OK(info);
  EXPECT_EQ(info->open_uploads, 0);
}

// A call that asks for a program to be rewritten and sends nothing, until it is cancelled or refused.
class SilentRewrite {
 public:
  explicit SilentRewrite(v1::Programs::Stub& programs) : stream_(programs.RewriteProgram(&context_)) {
    reader_ = std::thread([this] {
      v1::RewriteProgramResponse response;
      while (stream_->Read(&response)) {
      }
      status_ = stream_->Finish();
      ended_ = true;
    });
  }
  ~SilentRewrite() { Cancel(); }
  bool ended() const { return ended_; }
  grpc::Status Cancel() {
    context_.TryCancel();
    if (reader_.joinable()) reader_.join();
    return status_;
  }

 private:
  grpc::ClientContext context_;
  std::unique_ptr<grpc::ClientReaderWriter<v1::RewriteProgramRequest, v1::RewriteProgramResponse>> stream_;
  grpc::Status status_;
  std::atomic<bool> ended_ = false;
  std::thread reader_;
};

// A program that is rewritten takes a core, so there are as many places as workers; who sends nothing has one too, and
// none of the places for uploads.
TEST_F(Hostile, WhoSendsNothingToRewriteHasAPlaceOfItsOwnKind) {
  StartServer({"--workers", "1"});
  const auto programs = v1::Programs::NewStub(Channel());
  const auto ask = [&] {
    grpc::ClientContext context;
    const auto stream = programs->RewriteProgram(&context);
    v1::RewriteProgramRequest request;
    request.mutable_header()->set_size_bytes(-1);
    stream->Write(request);
    v1::RewriteProgramResponse response;
    while (stream->Read(&response)) {
    }
    return stream->Finish();
  };
  constexpr int kTries = 1000;  // until the first call has reached its handler, and later has left it
  // Nothing says when the silent call has its place; one that finds it taken by `ask` is refused, and begun again.
  auto silent = std::make_unique<SilentRewrite>(*programs);
  grpc::Status refused = ask();
  for (int i = 0; i < kTries && refused.error_code() != grpc::StatusCode::RESOURCE_EXHAUSTED; ++i) {
    if (silent->ended()) silent = std::make_unique<SilentRewrite>(*programs);
    refused = ask();
  }
  EXPECT_EQ(refused.error_code(), grpc::StatusCode::RESOURCE_EXHAUSTED) << refused.error_message();
  EXPECT_EQ(refused.error_message(), "more than 1 programs are rewritten at a time");
  const auto info = client_->GetServerInfo();
  ASSERT_OK(info);
  EXPECT_EQ(info->open_uploads, 0);
  EXPECT_EQ(silent->Cancel().error_code(), grpc::StatusCode::CANCELLED);
  grpc::Status taken = ask();
  for (int i = 0; i < kTries && taken.error_code() == grpc::StatusCode::RESOURCE_EXHAUSTED; ++i) taken = ask();
  EXPECT_EQ(taken.error_code(), grpc::StatusCode::INVALID_ARGUMENT) << taken.error_message();
}

// Uploads whose callers take no acknowledgement: one that leaves the session open, one that completes it, one that is
// wrong. Each holds a place for uploads until it is cut off.
TEST_F(Hostile, UploadsThatTakeNoAcknowledgementAreCutOff) {
  StartServer({"--silence-seconds", "1"});
  ASSERT_OK(client_->CreateMachine(MachineJson("mt")));
  const session::Session session = BallbarSession("mt", "BX", 10);
  v1::CreateSessionResponse created;
  grpc::ClientContext context;
  ASSERT_TRUE(v1::Ingest::NewStub(Channel())
                  ->CreateSession(&context, testing::CreateRequest("mt", "r-1", session), &created)
                  .ok());
  std::vector<std::string> whole;
  for (const auto& message : testing::UploadMessages(created.session().session_id(), session, 10)) {
    whole.push_back(message.SerializeAsString());
  }
  for (const std::vector<std::string>& messages : {std::vector{whole[0]}, {whole[0], whole[0]}, whole}) {
    RawConnection connection(server_->address());
    connection.TakeNoMessages();
    connection.Begin("/axiscal.v1.Ingest/Upload", {}, messages);
    ASSERT_TRUE(connection.WaitForEnd()) << messages.size() << " messages";
    const auto info = client_->GetServerInfo();
    ASSERT_OK(info);
    EXPECT_EQ(info->open_uploads, 0) << messages.size() << " messages";
  }
}

// A reply holds a thread until its caller has taken it.
TEST_F(Hostile, RepliesThatNobodyTakesAreCutOff) {
  StartServer({"--silence-seconds", "1"});
  for (const std::string method : {"Admin/GetServerInfo", "Machines/ListMachines", "Ingest/ListSessions"}) {
    RawConnection connection(server_->address());
    connection.TakeNoMessages();
    connection.Begin("/axiscal.v1." + method, {}, {""});
    EXPECT_TRUE(connection.WaitForEnd()) << method;
  }
  ASSERT_OK(client_->CreateMachine(MachineJson("mt")));
}

// A stream that no service of ours has: server reflection is off.
TEST_F(Hostile, AStreamOfNoServiceThatAsksNothingEnds) {
  StartServer();
  RawConnection connection(server_->address());
  constexpr bool kIsHalfClosed = false;
  connection.Begin("/grpc.reflection.v1alpha.ServerReflection/ServerReflectionInfo", {}, {}, kIsHalfClosed);
  EXPECT_TRUE(connection.WaitForEnd());
}

}  // namespace
}  // namespace axiscal
