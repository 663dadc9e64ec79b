// A mail server on this machine that takes mails, or answers to a command as a test wants. It knows no TLS.
#ifndef AXISCAL_SERVER_WEBHOOKS_TESTING_MAIL_RECEIVER_H_
#define AXISCAL_SERVER_WEBHOOKS_TESTING_MAIL_RECEIVER_H_

#include <sys/socket.h>
#include <unistd.h>

#include <string>
#include <thread>
#include <vector>

#include "absl/strings/match.h"
#include "absl/strings/str_cat.h"
#include "core/base/demand.h"
#include "core/base/mutex.h"
#include "server/webhooks/testing/listening.h"

namespace axiscal::webhooks {

struct ReceivedMail {
  std::string from;
  std::vector<std::string> to;
  std::string message;
};

class MailReceiver {
 public:
  MailReceiver() {
    thread_ = std::thread([this] {
      for (int connection; (connection = listening_.Accept()) >= 0; close(connection)) Serve(connection);
    });
  }
  ~MailReceiver() {
    listening_.Stop();
    thread_.join();
  }
  std::string Url() const { return absl::StrCat("smtp://127.0.0.1:", listening_.port()); }
  // From now on the answer to commands that begin so: "RCPT", "451 try again".
  void Say(const std::string& command, const std::string& answer) {
    const base::MutexLock lock(mutex_);
    command_ = command;
    answer_ = answer;
  }
  std::vector<ReceivedMail> mails() {
    const base::MutexLock lock(mutex_);
    return mails_;
  }
  // All that was said to it.
  std::string said() {
    const base::MutexLock lock(mutex_);
    return said_;
  }

 private:
  static void Send(int connection, const std::string& line) {
    const std::string bytes = line + "\r\n";
    send(connection, bytes.data(), bytes.size(), MSG_NOSIGNAL);
  }
  // Without its line end; false: the caller has left.
  bool Line(int connection, std::string* line) {
    line->clear();
    for (char c; recv(connection, &c, 1, 0) == 1;) {
      if (c == '\n') {
        if (!line->empty() && line->back() == '\r') line->pop_back();
        const base::MutexLock lock(mutex_);
        absl::StrAppend(&said_, *line, "\n");
        return true;
      }
      line->push_back(c);
    }
    return false;
  }
  void Serve(int connection) {
    Send(connection, "220 mail.test");
    ReceivedMail mail;
    for (std::string line; Line(connection, &line);) {
      {
        const base::MutexLock lock(mutex_);
        if (!command_.empty() && absl::StartsWith(line, command_)) {
          Send(connection, answer_);
          continue;
        }
      }
      if (absl::StartsWith(line, "MAIL FROM:")) mail.from = line.substr(10);
      if (absl::StartsWith(line, "RCPT TO:")) mail.to.push_back(line.substr(8));
      if (line == "DATA") {
        Send(connection, "354 go on");
        while (Line(connection, &line) && line != ".") absl::StrAppend(&mail.message, line, "\r\n");
        const base::MutexLock lock(mutex_);
        mails_.push_back(mail);
      }
      Send(connection, line == "QUIT" ? "221 bye" : "250 ok");
      if (line == "QUIT") return;
    }
  }

  Listening listening_;
  base::Mutex mutex_;
  std::string command_ AXISCAL_GUARDED_BY(mutex_), answer_ AXISCAL_GUARDED_BY(mutex_), said_ AXISCAL_GUARDED_BY(mutex_);
  std::vector<ReceivedMail> mails_ AXISCAL_GUARDED_BY(mutex_);
  std::thread thread_;
};

}  // namespace axiscal::webhooks

#endif  // AXISCAL_SERVER_WEBHOOKS_TESTING_MAIL_RECEIVER_H_
