// What waits in a spool goes to the server, in order.
#ifndef AXISCAL_CLIENT_SPOOL_SENDER_H_
#define AXISCAL_CLIENT_SPOOL_SENDER_H_

#include <optional>

#include "client/client.h"
#include "client/spool/spool.h"

namespace axiscal::spool {

// What an answer means for the file that was sent.
enum class Fate {
  kSent,
  kRefused,     // it is wrong, and stays so
  kNotAllowed,  // the caller is: certificate, token or role; every other file would fare alike
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
  // What fails by our bug is refused at the fifth time in a row, so that it does not stop all others. An error is the
  // disk's.
  absl::StatusOr<std::optional<Attempt>> SendNext();

 private:
  absl::Status Send(const Entry& entry, const std::string& bytes, Attempt& attempt);

  Spool& spool_;
  client::Client& client_;
  int64_t failing_ = 0;  // the number that failed last by our bug, and how often in a row
  int failures_ = 0;
};

}  // namespace axiscal::spool

#endif  // AXISCAL_CLIENT_SPOOL_SENDER_H_
