// Which connections have half sent too much: messages that are not there in full, and calls whose message has not
// begun.
#ifndef AXISCAL_SERVER_HALF_SENT_H_
#define AXISCAL_SERVER_HALF_SENT_H_

#include <cstdint>
#include <functional>
#include <map>
#include <optional>
#include <set>
#include <string>

#include "server/listener.h"

namespace axiscal::server {

// Of one connection.
struct WaitingCalls {
  int32_t count = 0;      // calls whose message has not come
  bool was_none = false;  // at some time since it was asked before: what had come until then was heard
};

// By one thread.
class HalfSent {
 public:
  // Nothing of a connection of which no call has been heard.
  using WaitingOf = std::function<std::optional<WaitingCalls>(const std::string& peer)>;

  // All together may have `most_bytes`, of messages of at most `message_bytes`.
  HalfSent(int64_t most_bytes, int64_t message_bytes) : most_bytes_(most_bytes), message_bytes_(message_bytes) {}

  // Of the connections that are there those that have most, until the others are within the limit. What they had
  // brought at the first look after Rest() counts for nothing; of a connection that comes later all counts until it is
  // heard.
  std::set<std::string> TooMuch(const std::map<std::string, Traffic>& connections, const WaitingOf& waiting_of);
  // So few calls wait that nobody looks for a while.
  void Rest() { rests_ = true; }

 private:
  const int64_t most_bytes_, message_bytes_;
  bool rests_ = true;
  std::map<std::string, int64_t> heard_;  // by peer: of what it has brought, what was heard
};

}  // namespace axiscal::server

#endif  // AXISCAL_SERVER_HALF_SENT_H_
