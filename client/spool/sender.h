// What waits in a spool goes to the server, in order.
#ifndef AXISCAL_CLIENT_SPOOL_SENDER_H_
#define AXISCAL_CLIENT_SPOOL_SENDER_H_

#include <optional>
#include <set>
#include <string>

#include "client/client.h"
#include "client/spool/spool.h"

namespace axiscal::spool {

// What an answer means for the file that was sent.
enum class Fate {
  kSent,
  kRefused,     // it is wrong, and stays so
  kNotAllowed,  // the caller is: certificate or token; every other file would fare alike
  kNotHere,     // the caller may not bring what this machine measured; other machines' files are not held up by it
  kLater,       // the server is not there, or has no room now
  kOurBug,      // what nobody has thought of
};
Fate FateOf(const absl::Status& status);

struct Attempt {
  int64_t number = 0;
  std::string name;  // of the file
  Fate fate = Fate::kSent;
  absl::Status status;             // of the server, or of the file where it cannot be read
  records::SessionRecord session;  // where it was sent
  bool was_there = false;
};

class Sender {
 public:
  // Both must outlive it.
  Sender(Spool& spool, client::Client& client) : spool_(spool), client_(client) {}

  // The first that waits; nothing where none does. A refused one has left the row then; the others stay first in it.
  // What fails by our bug is refused at the fifth time in a row, so that it does not stop all others. After kNotHere
  // the files of that machine are passed over until TryAllAgain(). An error is the disk's.
  absl::StatusOr<std::optional<Attempt>> SendNext();
  void TryAllAgain();
  // Whether files were passed over since.
  bool holds() const { return !held_.empty(); }

 private:
  absl::StatusOr<std::optional<int64_t>> FirstThatMay();
  absl::Status Send(const Entry& entry, const std::string& bytes, Attempt& attempt);

  Spool& spool_;
  client::Client& client_;
  int64_t failing_ = 0;  // the number that failed last by our bug, and how often in a row
  int failures_ = 0;
  std::set<std::string> held_;     // machines
  std::set<int64_t> passed_over_;  // entries of theirs
};

}  // namespace axiscal::spool

#endif  // AXISCAL_CLIENT_SPOOL_SENDER_H_
