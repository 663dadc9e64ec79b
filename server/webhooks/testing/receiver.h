// A receiver of webhooks on this machine that answers as a test wants: takes, fails, leads elsewhere, hangs.
#ifndef AXISCAL_SERVER_WEBHOOKS_TESTING_RECEIVER_H_
#define AXISCAL_SERVER_WEBHOOKS_TESTING_RECEIVER_H_

#include <sys/socket.h>
#include <unistd.h>

#include <list>
#include <map>
#include <string>
#include <thread>
#include <vector>

#include "absl/strings/ascii.h"
#include "absl/strings/numbers.h"
#include "absl/strings/str_cat.h"
#include "absl/strings/str_split.h"
#include "core/base/demand.h"
#include "core/base/mutex.h"
#include "server/webhooks/testing/listening.h"

namespace axiscal::webhooks {

struct Received {
  std::string path, body;
  std::map<std::string, std::string> headers;  // names in lower case
};

inline std::string Answer(int status, const std::string& more = "") {
  return absl::StrCat("HTTP/1.1 ", status, " X\r\nContent-Length: 0\r\n", more, "\r\n");
}

class Receiver {
 public:
  Receiver() {
    thread_ = std::thread([this] { Accept(); });
  }
  ~Receiver() {
    {
      const base::MutexLock lock(mutex_);
      closing_ = true;
      changed_.NotifyAll();
    }
    listening_.Stop();
    thread_.join();
    for (std::thread& thread : connections_) thread.join();
  }
  int port() const { return listening_.port(); }
  std::string Url(const std::string& path = "/hook") const {
    return absl::StrCat("http://127.0.0.1:", listening_.port(), path);
  }

  // What is answered from now on; "hang" never ends.
  void Say(const std::string& answer) {
    const base::MutexLock lock(mutex_);
    answer_ = answer;
  }
  std::vector<Received> received() {
    const base::MutexLock lock(mutex_);
    return received_;
  }
  std::vector<std::string> Ids() {
    std::vector<std::string> ids;
    for (const Received& one : received()) ids.push_back(one.headers.at("webhook-id"));
    return ids;
  }
  void WaitFor(size_t count) {
    const base::MutexLock lock(mutex_);
    while (received_.size() < count)
      changed_.WaitUntil(mutex_, std::chrono::steady_clock::now() + std::chrono::seconds(1));
  }

 private:
  void Accept() {
    while (true) {
      const int connection = listening_.Accept();
      if (connection < 0) return;
      connections_.emplace_back([this, connection] { Serve(connection); });
    }
  }
  void Serve(int connection) {
    std::string text;
    char bytes[4096];
    size_t end = std::string::npos, length = 0;
    Received one;
    while (end == std::string::npos || text.size() < end + 4 + length) {
      const ssize_t count = recv(connection, bytes, sizeof(bytes), 0);
      if (count <= 0) {  // the sender was killed on the way: no request has come
        close(connection);
        return;
      }
      text.append(bytes, static_cast<size_t>(count));
      if (end != std::string::npos || (end = text.find("\r\n\r\n")) == std::string::npos) continue;
      const std::vector<std::string> lines = absl::StrSplit(text.substr(0, end), "\r\n");
      one.path = lines[0];
      for (size_t i = 1; i < lines.size(); ++i) {
        const std::pair<std::string, std::string> header = absl::StrSplit(lines[i], absl::MaxSplits(": ", 1));
        one.headers[absl::AsciiStrToLower(header.first)] = header.second;
      }
      DEMAND(absl::SimpleAtoi(one.headers["content-length"], &length));
    }
    one.body = text.substr(end + 4);
    std::string answer;
    {
      const base::MutexLock lock(mutex_);
      received_.push_back(one);
      changed_.NotifyAll();
      answer = answer_;
      while (answer == "hang" && !closing_)
        changed_.WaitUntil(mutex_, std::chrono::steady_clock::now() + std::chrono::seconds(1));
    }
    if (answer != "hang") send(connection, answer.data(), answer.size(), MSG_NOSIGNAL);
    close(connection);
  }

  Listening listening_;
  base::Mutex mutex_;
  base::CondVar changed_;
  bool closing_ AXISCAL_GUARDED_BY(mutex_) = false;
  std::string answer_ AXISCAL_GUARDED_BY(mutex_) = Answer(204);
  std::vector<Received> received_ AXISCAL_GUARDED_BY(mutex_);
  std::list<std::thread> connections_;
  std::thread thread_;
};

}  // namespace axiscal::webhooks

#endif  // AXISCAL_SERVER_WEBHOOKS_TESTING_RECEIVER_H_
