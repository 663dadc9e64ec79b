// A server that tells an address of events and is killed with kill -9 again and again: every change comes, in order,
// and what comes twice has the same id. Webhooks are made and looked at with the command line.
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <signal.h>

#include "server/storage/sqlite_database.h"
#include "server/webhooks/testing/receiver.h"
#include "tests/end_to_end/testing/fixture.h"
#include "tests/end_to_end/testing/process.h"

namespace axiscal {
namespace {

using ::testing::HasSubstr;
using testing::ServerProcess;
using webhooks::Answer;

constexpr int kKills = 30;
const MachineId kMt("mt");
const storage::Caller kCaller = {"test", ""};

class WebhooksKill : public ::testing::Test {
 protected:
  // A machine and an event of it.
  void Store() {
    storage::SqliteOptions sqlite;
    sqlite.path = path_;
    auto opened = storage::OpenSqlite(sqlite);
    ASSERT_OK(opened);
    ASSERT_OK((*opened)->CreateMachine(kMt, testing::MachineJson("mt"), kCaller));
    records::EventContent content;
    content.kind = records::EventKind::kSuspect;
    ASSERT_OK((*opened)->ChangeEvents({.machine = kMt, .raised = {content}}));
    event_ = (*opened)->ListEvents({kMt, true}, {}, {})->rows.at(0).id;
  }
  void StartServer(const std::string& listen) {
    server_.reset();
    auto server = ServerProcess::Start(path_, listen, dir_.File("log"),
                                       {"--webhooks-allowed", absl::StrCat("127.0.0.1:", receiver_.port())});
    ASSERT_OK(server);
    server_ = std::make_unique<ServerProcess>(*std::move(server));
  }
  // Its exit status; what it printed is in out_.
  int Webhook(const std::vector<std::string>& words) {
    std::vector<std::string> arguments = {AXISCAL_PATH, "--server", server_->address(), "admin", "webhook"};
    arguments.insert(arguments.end(), words.begin(), words.end());
    return testing::RunProgram(arguments, &out_);
  }
  // The numbers of the changes that have come, each where it came first.
  std::vector<int64_t> Changes() {
    std::vector<int64_t> changes;
    for (const std::string& id : receiver_.Ids()) {
      int64_t change = 0;
      const std::string before = "webhook-1-change-";
      if (id.rfind(before, 0) != 0) continue;
      EXPECT_TRUE(absl::SimpleAtoi(id.substr(before.size()), &change)) << id;
      if (std::find(changes.begin(), changes.end(), change) == changes.end()) changes.push_back(change);
    }
    return changes;
  }

  testing::TempDir dir_;
  const std::string path_ = dir_.File("axiscal.db");
  EventId event_;
  webhooks::Receiver receiver_;
  std::unique_ptr<ServerProcess> server_;
  std::string out_;
};

TEST_F(WebhooksKill, LoseNothing) {
  ASSERT_NO_FATAL_FAILURE(Store());
  ASSERT_NO_FATAL_FAILURE(StartServer("127.0.0.1:0"));
  const std::string address = server_->address();
  ASSERT_EQ(Webhook({"put", "mes", "--url", receiver_.Url(), "-o", dir_.File("secret")}), 0) << out_;
  EXPECT_THAT(out_, HasSubstr("webhook mes: http://127.0.0.1:"));
  ASSERT_EQ(Webhook({"test", "mes"}), 0) << out_;
  EXPECT_THAT(out_, HasSubstr("taken: HTTP 204"));
  EXPECT_EQ(receiver_.received().at(0).body, "{\"type\":\"test\"}");
  ASSERT_EQ(testing::RunProgram({AXISCAL_PATH, "--server", address, "admin", "audit"}, &out_), 0) << out_;
  EXPECT_THAT(out_, HasSubstr("webhook.test"));
  size_t calls = 1;
  for (int kill = 0; kill < kKills; ++kill) {
    auto client = client::Client::Connect(address);
    ASSERT_OK(client);
    const auto tomorrow = base::SystemClock().UtcNow() + std::chrono::days(1);
    ASSERT_OK(client->ShelveEvent(event_, tomorrow));
    ASSERT_OK(client->ShelveEvent(event_, std::nullopt));
    // Before anything is sent, while it is sent, or after it.
    if (kill % 3 > 0) receiver_.WaitFor(calls + kill % 3);
    server_->Signal(SIGKILL);
    server_->Wait();
    calls = receiver_.received().size();
    ASSERT_NO_FATAL_FAILURE(StartServer(address));
  }
  std::vector<int64_t> all;
  for (int64_t change = 2; change <= 1 + 2 * kKills; ++change) all.push_back(change);
  const auto deadline = std::chrono::steady_clock::now() + std::chrono::minutes(1);
  while (Changes().size() < all.size() && std::chrono::steady_clock::now() < deadline)
    receiver_.WaitFor(std::min(receiver_.received().size() + 1, size_t{1} + 2 * kKills));
  EXPECT_EQ(Changes(), all);
  // At most the one under way came twice.
  EXPECT_LE(receiver_.Ids().size(), 1u + 2 * kKills + kKills);
  ASSERT_EQ(Webhook({"list"}), 0) << out_;
  EXPECT_THAT(out_, HasSubstr("webhook mes: "));
  EXPECT_EQ(Webhook({"dead", "mes"}), 0) << out_;
  EXPECT_NE(Webhook({"resend", "mes", "7"}), 0) << out_;
  receiver_.Say(Answer(401));
  EXPECT_NE(Webhook({"test", "mes"}), 0) << out_;
  EXPECT_EQ(Webhook({"remove", "mes"}), 0) << out_;
}

}  // namespace
}  // namespace axiscal
