// A server that raises and clears events and a program that follows them, both killed with kill -9 a hundred times:
// every change is seen once, in order.
#include <gtest/gtest.h>
#include <signal.h>

#include <regex>
#include <set>

#include "server/storage/sqlite_database.h"
#include "tests/end_to_end/testing/fixture.h"
#include "tests/end_to_end/testing/process.h"

namespace axiscal {
namespace {

using testing::Child;
using testing::ServerProcess;

constexpr int kKills = 100, kErrors = 12;
const MachineId kMt("mt");
const storage::Caller kCaller = {"test", ""};

class EventsKill : public ::testing::Test {
 protected:
  // A machine whose errors all stand at 10 um, and an event of it.
  void Store() {
    storage::SqliteOptions sqlite;
    sqlite.path = path_;
    auto opened = storage::OpenSqlite(sqlite);
    ASSERT_OK(opened);
    storage::Database& database = **opened;
    ASSERT_OK(database.CreateMachine(kMt, testing::MachineJson("mt"), kCaller));
    storage::NewCalibration calibration;
    calibration.machine = kMt;
    calibration.machine_revision = 1;
    calibration.measured_at = base::SystemClock().UtcNow();
    calibration.options_json = calibration.report_json = calibration.model_json = "{}";
    for (int i = 0; i < kErrors; ++i)
      calibration.estimates.push_back({absl::StrCat("E", i), records::EstimateUnit::kUm, true, 10.0, 1.0});
    const auto stored = database.CreateCalibration(calibration);
    ASSERT_OK(stored);
    ASSERT_OK(database.ApproveCalibration(stored->id, 0, kCaller));
  }
  // All errors are out of their tolerance, or all but the first, which always is.
  static records::Expectations Expected(bool all_are_out) {
    records::Expectations expected;
    expected.machine = kMt;
    for (int i = 0; i < kErrors; ++i) {
      const double most = all_are_out || i == 0 ? 1 : 1000;
      expected.tolerances.push_back({absl::StrCat("E", i), -most, most});
    }
    return expected;
  }
  void StartServer(const std::string& listen) {
    server_.reset();
    auto server = ServerProcess::Start(path_, listen, dir_.File("log"));
    ASSERT_OK(server);
    server_ = std::make_unique<ServerProcess>(*std::move(server));
  }
  std::unique_ptr<Child> Follow() {
    return std::make_unique<Child>(
        std::vector<std::string>{AXISCAL_PATH, "--server", server_->address(), "events", "--follow", "--json",
                                 "--after", std::to_string(seen_.empty() ? 0 : seen_.back())},
        dir_.File("follower"));
  }
  // The number of the change in a line.
  void Take(const std::string& line) {
    static const std::regex change(R"re(\{ *"change": *([0-9]+),.*)re");
    std::smatch match;
    ASSERT_TRUE(std::regex_match(line, match, change)) << line;
    seen_.push_back(std::stoll(match[1]));
  }

  testing::TempDir dir_;
  const std::string path_ = dir_.File("axiscal.db");
  std::unique_ptr<ServerProcess> server_;
  std::vector<int64_t> seen_;
};

TEST_F(EventsKill, EachChangeIsSeenOnce) {
  ASSERT_NO_FATAL_FAILURE(Store());
  ASSERT_NO_FATAL_FAILURE(StartServer("127.0.0.1:0"));
  const std::string address = server_->address();
  for (int kill = 0; kill < kKills; ++kill) {
    auto client = client::Client::Connect(address);
    ASSERT_OK(client);
    const std::unique_ptr<Child> follower = Follow();
    // This one change is on the disk when the call returns; those that follow from the tolerances come as they come.
    ASSERT_OK(client->SetExpectations(Expected(kill % 2 == 0)));
    EventId first;
    while (first == EventId()) {
      const auto open = client->ListEvents({kMt, true});
      ASSERT_OK(open);
      for (const records::Event& event : open->rows) {
        if (event.content.subject == "E0") first = event.id;
      }
    }
    const auto tomorrow = base::SystemClock().UtcNow() + std::chrono::days(1);
    ASSERT_OK(client->ShelveEvent(first, kill % 2 == 0 ? std::optional(tomorrow) : std::nullopt));
    // Killed as soon as something has come, with more under way; the follower first or the server.
    const std::optional<std::string> line = follower->ReadLine();
    ASSERT_TRUE(line.has_value()) << "the follower has ended";
    ASSERT_NO_FATAL_FAILURE(Take(*line));
    if (kill % 2 == 0) server_->Signal(SIGKILL);
    follower->Kill();
    while (const std::optional<std::string> read = follower->ReadLine()) ASSERT_NO_FATAL_FAILURE(Take(*read));
    ASSERT_NO_FATAL_FAILURE(StartServer(address));
  }
  // All that there is, from a watch that nobody kills, as far as it was when it began.
  auto client = client::Client::Connect(address);
  ASSERT_OK(client);
  int64_t up_to = 0;
  ASSERT_OK(client->WatchEvents({}, {}, [&](const records::EventNews& news) {
    up_to = news.up_to;
    return false;
  }));
  std::vector<int64_t> all;
  ASSERT_OK(client->WatchEvents({}, 0, [&](const records::EventNews& news) {
    if (news.change) all.push_back(news.change->id);
    return news.up_to < up_to;
  }));
  const std::unique_ptr<Child> follower = Follow();
  while (seen_.empty() || seen_.back() < up_to) {
    const std::optional<std::string> read = follower->ReadLine();
    ASSERT_TRUE(read.has_value());
    ASSERT_NO_FATAL_FAILURE(Take(*read));
  }
  seen_.resize(std::min(seen_.size(), all.size()));
  EXPECT_EQ(seen_, all);
  EXPECT_GE(static_cast<int>(all.size()), kKills);
  // Raised once: of each error at most one stands.
  const auto open = client->ListEvents({kMt, true}, {1000, ""});
  ASSERT_OK(open);
  std::set<std::string> subjects;
  for (const records::Event& event : open->rows) EXPECT_TRUE(subjects.insert(event.content.subject).second);
  EXPECT_TRUE(subjects.contains("E0"));
}

}  // namespace
}  // namespace axiscal
