// What browsers may send, and how they sign in: a token is exchanged once for a cookie that scripts cannot read. The
// cookie stands for the token as long as that is good, and for 12 hours at most.
#ifndef AXISCAL_SERVER_HTTP_SIGN_IN_H_
#define AXISCAL_SERVER_HTTP_SIGN_IN_H_

#include <map>
#include <optional>
#include <string>

#include "core/base/clock.h"
#include "core/base/mutex.h"
#include "core/base/status.h"
#include "server/access/gate.h"
#include "server/http/exchange.h"

namespace axiscal::http {

// Whether a browser says that a page of this very service sent it. What browsers say, scripts cannot change.
bool SaysOwnOrigin(const Request& request);

// PERMISSION_DENIED ORIGIN_REFUSED for what a page of another origin sends. Where nobody is asked who he is (`asks`
// false), also for names in Host that do not mean this machine, unless it is `own_host`: a page may have its own name
// lead to a loopback address. Unix sockets, which no browser reaches, may have any name.
absl::Status CheckOrigin(const Request& request, bool asks, const std::string& own_host);

// In memory only: a restart signs everybody out. Safe from any thread.
class SignIns {
 public:
  explicit SignIns(base::Clock& clock = base::SystemClock()) : clock_(clock) {}

  // `authorization`: "Bearer TOKEN". The cookie's value: 256 bits of the system's generator. A token has 100 at a time:
  // one more takes the place of its first.
  std::string Add(const std::string& authorization);
  std::optional<std::string> Find(const std::string& cookie) const;
  void Remove(const std::string& cookie);

 private:
  struct Entry {
    std::string authorization;
    base::UtcTime ends_at;
    int64_t order = 0;  // in which they came
  };
  base::Clock& clock_;
  mutable base::Mutex mutex_;
  std::map<std::string, Entry> entries_ AXISCAL_GUARDED_BY(mutex_);  // by the hash of the cookie
  int64_t next_order_ AXISCAL_GUARDED_BY(mutex_) = 0;
};

// The value of our cookie, if the request has one.
std::optional<std::string> CookieOf(const Request& request);

// POST /sign-in with {"token": "axt_..."}: {"name": ...} and the cookie. The gate's errors; INVALID_ARGUMENT
// MESSAGE_INVALID; FAILED_PRECONDITION NOBODY_ASKED where the service asks nobody.
absl::StatusOr<Answer> SignIn(const Request& request, const access::Gate& gate, SignIns& sign_ins);
// POST /sign-out: forgets the cookie.
Answer SignOut(const Request& request, SignIns& sign_ins);

}  // namespace axiscal::http

#endif  // AXISCAL_SERVER_HTTP_SIGN_IN_H_
