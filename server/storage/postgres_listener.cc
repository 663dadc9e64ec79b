#include "server/storage/postgres_listener.h"

#include <libpq-fe.h>
#include <poll.h>
#include <sys/eventfd.h>
#include <unistd.h>

#include <chrono>

#include "absl/strings/str_cat.h"
#include "core/base/demand.h"
#include "server/storage/postgres_connection.h"

namespace axiscal::storage {
namespace {

constexpr std::chrono::milliseconds kConnectsAgain(1000);

// Whether `descriptor` or `end` can be read within the time; -1: no descriptor. True for `end`.
bool HasEnded(int descriptor, int end, std::chrono::milliseconds most) {
  pollfd both[] = {{end, POLLIN, 0}, {descriptor, POLLIN, 0}};
  poll(both, descriptor < 0 ? 1 : 2, static_cast<int>(most.count()));
  return both[0].revents != 0;
}

}  // namespace

PostgresListener::PostgresListener(std::string url, std::function<void(const std::string&)> heard)
    : url_(std::move(url)), heard_(std::move(heard)), end_(eventfd(0, EFD_CLOEXEC)) {
  DEMAND(end_ >= 0);
  thread_ = std::thread([this] { Loop(); });
}

PostgresListener::~PostgresListener() {
  eventfd_write(end_, 1);
  thread_.join();
  close(end_);
}

void PostgresListener::Loop() {
  while (true) {
    PGconn* const connection = ConnectToPostgres(url_);
    PQsetNoticeProcessor(
        connection, [](void*, const char*) {}, nullptr);
    PGresult* const listening = PQexec(connection, absl::StrCat("LISTEN ", kNewsChannel).c_str());
    const bool is_listening = PQresultStatus(listening) == PGRES_COMMAND_OK;
    PQclear(listening);
    if (is_listening) {
      heard_("");
      while (Hear(connection)) continue;
    }
    PQfinish(connection);
    if (HasEnded(-1, end_, kConnectsAgain)) return;
  }
}

bool PostgresListener::Hear(PGconn* connection) {
  const auto until = std::chrono::steady_clock::now() + kNewsWithin;
  while (true) {
    // Also what came with the answer to another question.
    while (PGnotify* const word = PQnotifies(connection)) {
      heard_(word->extra);
      PQfreemem(word);
    }
    const auto left = std::chrono::duration_cast<std::chrono::milliseconds>(until - std::chrono::steady_clock::now());
    if (left.count() <= 0) break;
    if (HasEnded(PQsocket(connection), end_, left)) return false;
    if (PQconsumeInput(connection) == 0) return false;
  }
  // A server that went away without a word shows only when it is asked.
  PGresult* const answer = PQexec(connection, "");
  const bool is_there = PQresultStatus(answer) == PGRES_EMPTY_QUERY;
  PQclear(answer);
  if (is_there) heard_("");
  return is_there;
}

}  // namespace axiscal::storage
