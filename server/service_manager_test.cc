// What the service manager hears: at sockets in a file and in the abstract namespace.
#include "server/service_manager.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <sys/socket.h>
#include <sys/un.h>
#include <unistd.h>

#include <atomic>
#include <cstddef>
#include <cstring>
#include <filesystem>

namespace axiscal::server {
namespace {

using ::testing::HasSubstr;

// Removed at the end.
class Folder {
 public:
  Folder() {
    std::string name = (std::filesystem::temp_directory_path() / "axiscal-XXXXXX").string();
    EXPECT_NE(mkdtemp(name.data()), nullptr);
    path_ = name;
  }
  ~Folder() { std::filesystem::remove_all(path_); }
  std::string File(const std::string& name) const { return (path_ / name).string(); }

 private:
  std::filesystem::path path_;
};

// A socket as systemd listens at.
class Manager {
 public:
  explicit Manager(std::string path) : socket_(socket(AF_UNIX, SOCK_DGRAM, 0)) {
    sockaddr_un address = {};
    address.sun_family = AF_UNIX;
    std::memcpy(address.sun_path, path.data(), path.size());
    if (path[0] == '@') address.sun_path[0] = '\0';
    const auto size = static_cast<socklen_t>(offsetof(sockaddr_un, sun_path) + path.size());
    EXPECT_EQ(bind(socket_, reinterpret_cast<const sockaddr*>(&address), size), 0) << std::strerror(errno);
  }
  ~Manager() { close(socket_); }
  std::string Hear() const {
    char buffer[200];
    const ssize_t size = recv(socket_, buffer, sizeof(buffer), 0);
    return size < 0 ? std::strerror(errno) : std::string(buffer, static_cast<size_t>(size));
  }

 private:
  const int socket_;
};

TEST(Notify, GoesToAFileAndToAName) {
  const Folder directory;
  for (const std::string& path : {directory.File("notify"), "@axiscal-test-" + std::to_string(getpid())}) {
    const Manager manager(path);
    EXPECT_TRUE(Notify(path.c_str(), "READY=1\nSTATUS=listens").ok());
    EXPECT_EQ(manager.Hear(), "READY=1\nSTATUS=listens");
  }
}

TEST(Notify, SaysWhyItCannot) {
  EXPECT_TRUE(Notify(nullptr, "READY=1").ok());
  EXPECT_TRUE(Notify("", "READY=1").ok());
  const Folder directory;
  EXPECT_THAT(std::string(Notify(directory.File("nobody").c_str(), "READY=1").message()), HasSubstr("nobody: No such"));
  EXPECT_THAT(std::string(Notify("relative", "READY=1").message()), HasSubstr("absolute path"));
  EXPECT_FALSE(Notify(("/" + std::string(108, 'x')).c_str(), "READY=1").ok());
}

TEST(WatchdogTime, IsOfThisProcessAlone) {
  const std::string own = std::to_string(getpid());
  EXPECT_EQ(WatchdogTime("60000000", own.c_str()), std::chrono::minutes(1));
  EXPECT_EQ(WatchdogTime("5", nullptr), std::chrono::microseconds(5));
  EXPECT_EQ(WatchdogTime("60000000", "1"), std::nullopt);
  for (const char* const wrong : {"", "0", "-5", "soon"}) EXPECT_EQ(WatchdogTime(wrong, nullptr), std::nullopt);
  EXPECT_EQ(WatchdogTime(nullptr, nullptr), std::nullopt);
}

TEST(Watchdog, PingsWhileTheCheckIsOkAndIsSilentAfterwards) {
  const Folder directory;
  const std::string path = directory.File("notify");
  const Manager manager(path);
  std::atomic<bool> answers = true;
  std::atomic<int> checks = 0, pings = 0, pings_without_answer = 0;
  base::Mutex mutex;
  base::CondVar changed;
  std::vector<std::string> told;
  const auto check = [&] {
    ++checks;
    return answers ? absl::OkStatus() : absl::UnavailableError("the store is silent");
  };
  const auto notify = [&](const std::string& state) {
    ++pings;
    if (!answers) ++pings_without_answer;
    return Notify(path.c_str(), state);
  };
  const auto tell = [&](const absl::Status& status) {
    const base::MutexLock lock(mutex);
    told.push_back(std::string(status.message()));
    changed.NotifyAll();
  };
  {
    const Watchdog watchdog(std::chrono::milliseconds(2), check, notify, tell);
    for (int i = 0; i < 3; ++i) EXPECT_EQ(manager.Hear(), "WATCHDOG=1");
    answers = false;
    const base::MutexLock lock(mutex);
    while (told.empty()) changed.Wait(mutex);
  }
  EXPECT_EQ(told, std::vector<std::string>{"the store is silent"});
  EXPECT_GT(checks, pings);
  EXPECT_LE(pings_without_answer, 1);  // a check that had its answer before
}

}  // namespace
}  // namespace axiscal::server
