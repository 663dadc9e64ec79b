// What callers who do nothing, or next to nothing, do to a cell that works beside them: connections that are idle,
// callers who never read their answer, and writers of one byte a second, over gRPC and by HTTP.
//   crowd [CONNECTIONS]     idle ones, half of them by HTTP; 10000 without it
// Prints a table, and fails where a limit is not held: the cell sees no error, the server takes at most 512 MB and a
// thread for each reader and writer, and is as before within a minute after they have left.
#include <arpa/inet.h>
#include <netinet/in.h>
#include <sys/resource.h>
#include <sys/socket.h>
#include <unistd.h>

#include <algorithm>
#include <atomic>
#include <chrono>
#include <cstdio>
#include <cstdlib>
#include <thread>
#include <vector>

#include "core/base/demand.h"
#include "tests/end_to_end/testing/fixture.h"
#include "tests/end_to_end/testing/process.h"
#include "tests/end_to_end/testing/raw_http2.h"

namespace axiscal {
namespace {

using std::chrono::steady_clock;
using testing::RawConnection;
using testing::ServerProcess;

constexpr int kReaders = 200, kWriters = 200;
constexpr int64_t kMostMemory = int64_t{512} << 20;
// Beside a thread for each reader and writer: what the server has without them, and gRPC's own pools.
constexpr int64_t kMoreThreads = 100;
// What may stay: readers of the store, which are opened as calls need them.
constexpr int64_t kMoreDescriptors = 50;
constexpr std::chrono::seconds kWork(10), kComes(60), kLeaves(60);
constexpr char kMachine[] = "mt";

// One connection by HTTP that is kept open; closed when it goes.
class HttpIdler {
 public:
  explicit HttpIdler(int port) : socket_(socket(AF_INET, SOCK_STREAM | SOCK_CLOEXEC, 0)) {
    sockaddr_in to = {};
    to.sin_family = AF_INET;
    to.sin_port = htons(static_cast<uint16_t>(port));
    to.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
    DEMAND(socket_ >= 0 && connect(socket_, reinterpret_cast<sockaddr*>(&to), sizeof(to)) == 0);
  }
  HttpIdler(HttpIdler&& other) noexcept : socket_(std::exchange(other.socket_, -1)) {}
  HttpIdler& operator=(HttpIdler&&) = delete;
  ~HttpIdler() {
    if (socket_ >= 0) close(socket_);
  }
  void Send(const std::string& bytes) const {
    if (send(socket_, bytes.data(), bytes.size(), MSG_NOSIGNAL | MSG_DONTWAIT) < 0) return;
  }

 private:
  int socket_;
};

struct Stand {
  size_t uploads = 0;
  double p50_ms = 0, p99_ms = 0;
  int64_t memory_mb = 0, threads = 0, descriptors = 0;
  int errors = 0;
};

// What the cell meets, and what the server takes meanwhile.
Stand Work(const ServerProcess& server, const std::string& when) {
  Stand stand;
  std::vector<double> took_ms;
  auto client = client::Client::Connect(server.address());
  DEMAND(client.ok());
  const auto end = steady_clock::now() + kWork;
  for (int n = 0; steady_clock::now() < end; ++n) {
    const auto start = steady_clock::now();
    const auto done =
        client->Upload(MachineId(kMachine), testing::BallbarSession(kMachine, absl::StrCat(when, n), 5000));
    if (!done.ok()) {
      ++stand.errors;
      std::fprintf(stderr, "%s: %s\n", when.c_str(), done.status().ToString().c_str());
    }
    took_ms.push_back(std::chrono::duration<double, std::milli>(steady_clock::now() - start).count());
    stand.memory_mb = std::max(stand.memory_mb, server.MemoryBytes() >> 20);
    stand.threads = std::max(stand.threads, server.ThreadCount());
    stand.descriptors = std::max(stand.descriptors, server.DescriptorCount());
  }
  std::sort(took_ms.begin(), took_ms.end());
  stand.uploads = took_ms.size();
  stand.p50_ms = took_ms[took_ms.size() / 2];
  stand.p99_ms = took_ms[took_ms.size() * 99 / 100];
  std::printf("CROWD %-10s %8zu %9.1f ms %9.1f ms %8lld %8lld %12lld %7d\n", when.c_str(), stand.uploads, stand.p50_ms,
              stand.p99_ms, static_cast<long long>(stand.memory_mb), static_cast<long long>(stand.threads),
              static_cast<long long>(stand.descriptors), stand.errors);
  std::fflush(stdout);
  return stand;
}

// The port that a server without one of its own choice gets by HTTP: one that is free now.
int FreePort() {
  const int probe = socket(AF_INET, SOCK_STREAM | SOCK_CLOEXEC, 0);
  sockaddr_in at = {};
  at.sin_family = AF_INET;
  at.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
  socklen_t size = sizeof(at);
  DEMAND(probe >= 0 && bind(probe, reinterpret_cast<sockaddr*>(&at), size) == 0 &&
         getsockname(probe, reinterpret_cast<sockaddr*>(&at), &size) == 0);
  close(probe);
  return ntohs(at.sin_port);
}

// All that are there until it goes.
class Crowd {
 public:
  Crowd(const ServerProcess& server, int http_port, int connections) {
    for (int i = 0; i < connections / 2; ++i) {
      idle_.emplace_back(server.address());
      DEMAND(idle_.back().is_connected());
      idle_.back().Greet();
      idle_by_http_.emplace_back(http_port);
    }
    for (int i = 0; i < kReaders; ++i) {
      RawConnection& reader = readers_.emplace_back(server.address());
      reader.TakeNoMessages();
      reader.Begin("/axiscal.v1.Machines/ListMachines", {}, {""});
    }
    for (int i = 0; i < kWriters / 2; ++i) {
      RawConnection& writer = writers_.emplace_back(server.address());
      writer.Begin("/axiscal.v1.Jobs/CreateJob", {}, {}, false);
      writer.SendPart(std::string("\0\0\x40\0\0", 5));  // a message of 4 MB
      writers_by_http_.emplace_back(http_port).Send(
          "POST /axiscal.v1.Jobs/CreateJob HTTP/1.1\r\nHost: localhost\r\nContent-Type: application/proto\r\n"
          "Content-Length: 4000000\r\n\r\n");
    }
    // The system says that they are connected before the server has taken them.
    const auto give_up_at = steady_clock::now() + kComes;
    while (server.DescriptorCount() < connections && steady_clock::now() < give_up_at)
      std::this_thread::sleep_for(std::chrono::milliseconds(100));
    thread_ = std::thread([this] {
      while (!has_left_) {
        for (RawConnection& writer : writers_) writer.SendPart("\x12");
        for (const HttpIdler& writer : writers_by_http_) writer.Send("\x12");
        std::this_thread::sleep_for(std::chrono::seconds(1));
      }
    });
  }
  ~Crowd() {
    has_left_ = true;
    thread_.join();
  }

 private:
  std::vector<RawConnection> idle_, readers_, writers_;
  std::vector<HttpIdler> idle_by_http_, writers_by_http_;
  std::atomic<bool> has_left_ = false;
  std::thread thread_;
};

int Run(int connections) {
  rlimit limit = {};
  DEMAND(getrlimit(RLIMIT_NOFILE, &limit) == 0);
  limit.rlim_cur = limit.rlim_max;
  DEMAND(setrlimit(RLIMIT_NOFILE, &limit) == 0);
  const testing::TempDir folder;
  const int http_port = FreePort();
  absl::StatusOr<ServerProcess> server = ServerProcess::Start(
      folder.File("axiscal.db"), "127.0.0.1:0", folder.File("log"), {"--http", absl::StrCat("127.0.0.1:", http_port)});
  DEMAND(server.ok());
  DEMAND(client::Client::Connect(server->address())->CreateMachine(testing::MachineJson(kMachine)).ok());
  std::printf("CROWD %-10s %8s %12s %12s %8s %8s %12s %7s\n", "", "uploads", "p50", "p99", "MB", "threads",
              "descriptors", "errors");
  const Stand before = Work(*server, "before");
  Stand beside;
  {
    const Crowd crowd(*server, http_port, connections);
    beside = Work(*server, "beside");
  }
  const auto left_at = steady_clock::now();
  while (server->DescriptorCount() > before.descriptors + kMoreDescriptors && steady_clock::now() < left_at + kLeaves)
    std::this_thread::sleep_for(std::chrono::milliseconds(100));
  const double gone_s = std::chrono::duration<double>(steady_clock::now() - left_at).count();
  const Stand after = Work(*server, "after");
  const bool is_well =
      after.descriptors <= before.descriptors + kMoreDescriptors && after.threads <= before.threads + 10;
  const bool is_small = server->PeakMemoryBytes() <= kMostMemory;
  const bool has_few_threads = beside.threads <= kReaders + kWriters + kMoreThreads;
  const int errors = before.errors + beside.errors + after.errors;
  std::printf(
      "CROWD %d idle connections, %d readers that never read, %d writers of a byte a second: errors of the cell %d; "
      "peak memory %lld MB, at most %lld: %s; threads: %s; as before %.1f s after they left: %s\n",
      connections, kReaders, kWriters, errors, static_cast<long long>(server->PeakMemoryBytes() >> 20),
      static_cast<long long>(kMostMemory >> 20), is_small ? "held" : "NOT HELD", has_few_threads ? "held" : "NOT HELD",
      gone_s, is_well ? "held" : "NOT HELD");
  return errors == 0 && is_well && is_small && has_few_threads ? 0 : 1;
}

}  // namespace
}  // namespace axiscal

int main(int argc, char** argv) { return axiscal::Run(argc > 1 ? std::max(2, std::atoi(argv[1])) : 10'000); }
