// Which addresses webhooks may call. Whoever may make webhooks shall not reach by them what trusts this machine: its
// own services, those of its cable, or what a cloud tells its machines. Judged by the address that a connection is made
// to, whatever name led there.
#ifndef AXISCAL_SERVER_WEBHOOKS_ADDRESSES_H_
#define AXISCAL_SERVER_WEBHOOKS_ADDRESSES_H_

#include <sys/socket.h>

#include <array>
#include <cstdint>
#include <string>
#include <vector>

#include "core/base/status.h"

namespace axiscal::webhooks {

// IPv6, and IPv4 as ::ffff:a.b.c.d.
using Address = std::array<uint8_t, 16>;

class AddressRule {
 public:
  // Refuses all of them: this machine's own addresses, link-local and multicast ones, those of cloud metadata.
  AddressRule() = default;
  // But those of a list: "127.0.0.1:8080, 10.0.0.7, [::1]:80", with a port that one alone. INVALID_ARGUMENT names what
  // is none.
  static absl::StatusOr<AddressRule> Allowing(const std::string& list);

  // Why it may not be called; empty: it may.
  std::string WhyNot(const sockaddr* address) const;
  // The same of a URL's host and port, where the host is an address; a name is judged by where it leads when it is
  // called, here by "".
  std::string WhyNotHost(const std::string& host, int port) const;

 private:
  std::string WhyNot(const Address& ip, int port) const;

  struct Allowed {
    Address address;
    int port = 0;  // 0: any
  };
  std::vector<Allowed> allowed_;
};

}  // namespace axiscal::webhooks

#endif  // AXISCAL_SERVER_WEBHOOKS_ADDRESSES_H_
