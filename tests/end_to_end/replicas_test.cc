// Several axiscald on one database of PostgreSQL: any call may go to any of them, and what one alone has to do is done
// once.
#include <gmock/gmock.h>
#include <grpcpp/grpcpp.h>
#include <signal.h>

#include <algorithm>
#include <chrono>
#include <fstream>
#include <future>
#include <memory>
#include <set>
#include <thread>

#include "core/base/error_detail.h"
#include "server/access/gate.h"
#include "server/storage/testing/postgres_server.h"
#include "server/webhooks/testing/receiver.h"
#include "tests/end_to_end/testing/fixture.h"
#include "tests/end_to_end/testing/process.h"
#include "tests/end_to_end/testing/raw_upload.h"

namespace axiscal {
namespace {

using records::JobState;
using std::chrono::milliseconds;
using testing::BallbarSession;
using testing::MachineJson;
using testing::ServerProcess;

const storage::Caller kSetup = {"setup", ""};

class Replicas : public ::testing::Test {
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
    url_ = postgres_->MakeDatabase(false);
  }

  std::unique_ptr<ServerProcess> Start(const std::vector<std::string>& more = {}) {
    const std::string log = dir_.File(absl::StrCat("log", ++started_));
    absl::StatusOr<ServerProcess> server = ServerProcess::Start(url_, "127.0.0.1:0", log, more);
    EXPECT_TRUE(server.ok()) << server.status();
    return server.ok() ? std::make_unique<ServerProcess>(*std::move(server)) : nullptr;
  }
  static client::Client ClientOf(const ServerProcess& server, const client::Options& options = {}) {
    absl::StatusOr<client::Client> client = client::Client::Connect(server.address(), options);
    DEMAND(client.ok());
    return *std::move(client);
  }
  // The store as one more process has it.
  std::unique_ptr<storage::Database> OpenStore() {
    storage::PostgresOptions options;
    options.url = url_;
    absl::StatusOr<std::unique_ptr<storage::Database>> opened = storage::OpenPostgres(options);
    DEMAND(opened.ok());
    return *std::move(opened);
  }
  // A job that takes minutes, unless it is told to stop.
  static records::IdentifyParams Long(SessionId session) {
    records::IdentifyParams params{MachineId("mt"), {session}, {}};
    params.monte_carlo_runs = 100'000;
    return params;
  }
  static client::JobRecord WaitUntil(client::Client& client, JobId job, JobState state) {
    client::JobRecord last;
    static_cast<void>(client.WatchJob(job, [&](const client::JobRecord& record) {
      last = record;
      return record.state != state;
    }));
    EXPECT_EQ(last.state, state) << (last.error ? last.error->message : "");
    return last;
  }

  static inline std::unique_ptr<storage::PostgresServer> postgres_;
  testing::TempDir dir_;
  std::string url_;
  int started_ = 0;
};

TEST_F(Replicas, TwoThatStartAtOnceOnAnEmptyDatabaseMigrateItOnce) {
  std::vector<std::future<absl::StatusOr<ServerProcess>>> starting;
  for (int i = 0; i < 3; ++i) {
    starting.push_back(std::async(std::launch::async, [this, i] {
      return ServerProcess::Start(url_, "127.0.0.1:0", dir_.File(absl::StrCat("log", i)));
    }));
  }
  for (auto& start : starting) {
    const absl::StatusOr<ServerProcess> server = start.get();
    ASSERT_OK(server);
    client::Client client = ClientOf(*server);
    EXPECT_TRUE(client.ListMachines().ok());
  }
  auto looks = *storage::PostgresConnection::Open(url_, storage::Access::kReadOnly);
  auto rows = looks->Ask("SELECT count(*), count(DISTINCT version) FROM migration");
  ASSERT_TRUE(rows.ok() && *rows->Step());
  EXPECT_EQ(rows->Int(0), rows->Int(1));
}

TEST_F(Replicas, AnUploadGoesOnAtAnotherAndIsReadThereAtOnce) {
  const auto a = Start(), b = Start();
  client::Client at_a = ClientOf(*a), at_b = ClientOf(*b);
  ASSERT_OK(at_a.CreateMachine(MachineJson("mt")));
  const session::Session session = BallbarSession("mt", "BX", 20'000);
  const auto stub_a = v1::Ingest::NewStub(grpc::CreateChannel(a->address(), grpc::InsecureChannelCredentials()));
  const auto stub_b = v1::Ingest::NewStub(grpc::CreateChannel(b->address(), grpc::InsecureChannelCredentials()));
  v1::CreateSessionResponse created;
  {
    grpc::ClientContext context;
    ASSERT_TRUE(stub_a->CreateSession(&context, testing::CreateRequest("mt", "once", session), &created).ok());
  }
  const std::vector<v1::UploadRequest> all = testing::UploadMessages(created.session().session_id(), session, 1000);
  ASSERT_EQ(all.size(), 22u);
  // The header and eight chunks.
  const testing::RawResult begun = testing::SendAll(*stub_a, {all.begin(), all.begin() + 9});
  EXPECT_TRUE(begun.status.ok()) << begun.status.error_message();
  EXPECT_EQ(begun.next_seq(), 8);
  // The other one knows where it stands, and whoever begins the same session there gets this one.
  {
    grpc::ClientContext context;
    v1::CreateSessionResponse again;
    ASSERT_TRUE(stub_b->CreateSession(&context, testing::CreateRequest("mt", "once", session), &again).ok());
    EXPECT_EQ(again.session().session_id(), created.session().session_id());
    EXPECT_EQ(again.session().next_seq(), 8);
  }
  std::vector<v1::UploadRequest> rest = {all[0]};
  rest[0].mutable_header()->set_resume_from_seq(8);
  rest.insert(rest.end(), all.begin() + 9, all.end());
  const testing::RawResult ended = testing::SendAll(*stub_b, rest);
  EXPECT_TRUE(ended.completed()) << ended.status.error_message();
  // What one has acknowledged the other reads at once: a hundred times, so that luck does not do.
  const auto read = at_a.DownloadSession(SessionId(created.session().session_id()));
  ASSERT_OK(read);
  EXPECT_TRUE(*read == session);
  for (int i = 0; i < 100; ++i) {
    client::Client& writes = i % 2 == 0 ? at_a : at_b;
    client::Client& reads = i % 2 == 0 ? at_b : at_a;
    const std::string id = absl::StrCat("m", i);
    ASSERT_OK(writes.CreateMachine(MachineJson(id)));
    ASSERT_OK(reads.GetMachine(MachineId(id)));
  }
}

// Submitted and watched at one, it runs at another, which hears of a cancel before its next heartbeat; one whose
// replica is killed is taken over when its lease is over, while its watcher watches on.
TEST_F(Replicas, AJobIsWatchedCancelledAndTakenOverFromAnother) {
  const auto a = Start({"--workers", "1"});
  client::Client at_a = ClientOf(*a);
  ASSERT_OK(at_a.CreateMachine(MachineJson("mt")));
  const auto upload = at_a.Upload(MachineId("mt"), BallbarSession("mt", "BX", 3600));
  ASSERT_OK(upload);
  const SessionId session = upload->session.id;
  // It keeps the only worker of a: what is created from now on runs at b.
  const auto busy = at_a.CreateJob(Long(session), "busy");
  ASSERT_OK(busy);
  WaitUntil(at_a, busy->id, JobState::kRunning);
  auto b = Start({"--workers", "1"});

  const auto job = at_a.CreateJob(Long(session), "cancelled");
  ASSERT_OK(job);
  WaitUntil(at_a, job->id, JobState::kRunning);
  const auto asked = std::chrono::steady_clock::now();
  ASSERT_OK(at_a.CancelJob(job->id));
  WaitUntil(at_a, job->id, JobState::kCancelled);
  const auto took = std::chrono::duration_cast<milliseconds>(std::chrono::steady_clock::now() - asked);
  std::printf("cancelled at the other replica, seen here after %lld ms\n", static_cast<long long>(took.count()));
  // Of a heartbeat alone it would hear after 5 s.
  EXPECT_LT(took, milliseconds(4500));

  const auto lost = at_a.CreateJob(records::IdentifyParams{MachineId("mt"), {session}, {}}, "lost");
  const auto held = at_a.CreateJob(Long(session), "held");
  ASSERT_OK(lost);
  ASSERT_OK(held);
  WaitUntil(at_a, lost->id, JobState::kSucceeded);
  WaitUntil(at_a, held->id, JobState::kRunning);
  b->Signal(SIGKILL);
  b->Wait();
  ASSERT_OK(at_a.CancelJob(busy->id));
  // a takes it over; that it has begun again is told to whoever watches.
  std::set<int> attempts;
  static_cast<void>(at_a.WatchJob(held->id, [&](const client::JobRecord& record) {
    if (record.state == JobState::kRunning) attempts.insert(record.attempt);
    return record.attempt < 2 || record.state != JobState::kRunning;
  }));
  EXPECT_TRUE(attempts.contains(2));
  ASSERT_OK(at_a.CancelJob(held->id));
  WaitUntil(at_a, held->id, JobState::kCancelled);
  EXPECT_EQ(at_a.ListCalibrations()->rows.size(), 1u);
}

TEST_F(Replicas, WhoIsRevokedAtOneIsRefusedAtAll) {
  const std::string token = access::NewToken();
  int64_t id = 0;
  {
    const auto store = OpenStore();
    ASSERT_OK(store->CreatePrincipal("ann", "", kSetup));
    ASSERT_OK(store->ChangeRole("ann", {records::Role::kViewer, {records::Scope::Kind::kAll, ""}}, true, kSetup));
    const auto created = store->CreateToken({"ann", access::HashOfToken(token), "", {}}, kSetup);
    ASSERT_OK(created);
    id = created->id;
  }
  const auto a = Start({"--ask-identity"}), b = Start({"--ask-identity"});
  client::Options options;
  options.identity.token_file = dir_.File("token");
  std::ofstream(options.identity.token_file) << token << "\n";
  client::Client at_a = ClientOf(*a, options), at_b = ClientOf(*b, options);
  EXPECT_TRUE(at_a.ListMachines().ok());
  EXPECT_TRUE(at_b.ListMachines().ok());
  ASSERT_OK(OpenStore()->RevokeToken(id, kSetup));
  EXPECT_EQ(base::ErrorReason(at_a.ListMachines().status()), "TOKEN_INVALID");
  EXPECT_EQ(base::ErrorReason(at_b.ListMachines().status()), "TOKEN_INVALID");
}

// Of several replicas one sends; when it goes, another one goes on behind what was taken.
TEST_F(Replicas, ALetterIsSentOnce) {
  webhooks::Receiver receiver;
  receiver.Say(webhooks::Answer(204));
  const std::vector<std::string> flags = {"--webhooks-allowed", absl::StrCat("127.0.0.1:", receiver.port())};
  auto a = Start(flags), b = Start(flags), c = Start(flags);
  const auto store = OpenStore();
  const MachineId machine("mt");
  ASSERT_OK(store->CreateMachine(machine, MachineJson("mt"), kSetup));
  records::Webhook webhook;
  webhook.name = "mes";
  webhook.url = receiver.Url();
  webhook.scope = {records::Scope::Kind::kAll, ""};
  webhook.is_enabled = true;
  ASSERT_OK(store->PutWebhook(webhook, {"c2VjcmV0", false}, 0, kSetup));
  const auto raise = [&](const std::string& subject) {
    records::EventContent content;
    content.kind = records::EventKind::kSuspect;
    content.subject = subject;
    ASSERT_OK(store->ChangeEvents({.machine = machine, .raised = {content}}));
  };
  size_t count = 0;
  const auto raise_twenty = [&] {
    for (int i = 0; i < 20; ++i) raise(absl::StrCat("subject ", ++count));
  };
  const auto different = [&] {
    const std::vector<std::string> ids = receiver.Ids();
    return std::set<std::string>(ids.begin(), ids.end()).size();
  };
  const auto wait_for_all = [&] {
    for (size_t least = count; different() < count; ++least) receiver.WaitFor(least);
  };
  raise_twenty();
  wait_for_all();
  // The first that started has the role; it leaves in good order, and its follower is killed.
  a->Signal(SIGTERM);
  EXPECT_EQ(a->Wait(), 0);
  raise_twenty();
  wait_for_all();
  EXPECT_EQ(receiver.Ids().size(), count);
  b->Signal(SIGKILL);
  c->Signal(SIGKILL);
  b->Wait();
  c->Wait();
  const auto d = Start(flags);
  raise_twenty();
  wait_for_all();
  // That the last one was taken may not have been stored when its sender was killed: it is sent again, as any letter of
  // a sender that dies. No other is.
  const std::vector<std::string> ids = receiver.Ids();
  EXPECT_LE(ids.size(), count + 1);
  EXPECT_LE(std::count(ids.begin(), ids.end(), ids[39]), 2);
}

}  // namespace
}  // namespace axiscal
