#include "server/webhooks/addresses.h"

#include <arpa/inet.h>
#include <ifaddrs.h>
#include <netinet/in.h>

#include <algorithm>
#include <cstring>
#include <memory>
#include <optional>

#include "absl/strings/ascii.h"
#include "absl/strings/numbers.h"
#include "absl/strings/str_cat.h"
#include "absl/strings/str_split.h"
#include "absl/strings/string_view.h"

namespace axiscal::webhooks {
namespace {

constexpr int kV4Begin = 12, kV4PrefixBits = 96;

std::optional<Address> AddressOf(const std::string& text) {
  Address address = {};
  if (inet_pton(AF_INET6, text.c_str(), address.data()) == 1) return address;
  address = {0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0xff, 0xff};
  if (inet_pton(AF_INET, text.c_str(), address.data() + kV4Begin) == 1) return address;
  return std::nullopt;
}

bool IsIn(const Address& address, const Address& network, int bits) {
  for (int i = 0; i < bits; ++i) {
    const int mask = 0x80 >> (i % 8);
    if ((address[i / 8] & mask) != (network[i / 8] & mask)) return false;
  }
  return true;
}

struct Network {
  const char* address;
  int bits;
  const char* what;
};

// IPv4 addresses that stand within IPv6 ones are judged as themselves.
constexpr Network kRefused[] = {
    {"0.0.0.0", 8, "an address of this machine"},
    {"127.0.0.0", 8, "a loopback address"},
    {"169.254.0.0", 16, "a link-local address"},
    {"224.0.0.0", 4, "a multicast address"},
    {"240.0.0.0", 4, "a reserved address"},
    {"100.100.100.200", 32, "an address of cloud metadata"},
    {"168.63.129.16", 32, "an address of cloud metadata"},
    {"192.0.0.192", 32, "an address of cloud metadata"},
    {"::", 128, "an address of this machine"},
    {"::1", 128, "a loopback address"},
    {"fe80::", 10, "a link-local address"},
    {"ff00::", 8, "a multicast address"},
    {"fec0::", 10, "a site-local address"},
    {"64:ff9b:1::", 48, "an address that a translator of this network leads elsewhere"},
    {"::ffff:0:0:0", 96, "an address that a translator of this network leads elsewhere"},
    {"fd00:ec2::", 32, "an address of cloud metadata"},
    {"fd20:ce::254", 128, "an address of cloud metadata"},
};

// "10.0.0.7" or "10.0.0.7:80" or "::1" or "[::1]:80".
std::optional<std::pair<Address, int>> ReadEntry(absl::string_view text) {
  int port = 0;
  const size_t colon = text.rfind(':');
  const bool has_port =
      text.find('.') != absl::string_view::npos && text.find(']') == absl::string_view::npos
          ? colon != absl::string_view::npos && text.find(':') == colon
          : !text.empty() && text[0] == '[' && colon != absl::string_view::npos && colon > 0 && text[colon - 1] == ']';
  if (has_port) {
    if (!absl::SimpleAtoi(text.substr(colon + 1), &port) || port < 1 || port > 65535) return std::nullopt;
    text = text.substr(0, colon);
  }
  if (text.size() >= 2 && text.front() == '[' && text.back() == ']') text = text.substr(1, text.size() - 2);
  const std::optional<Address> address = AddressOf(std::string(text));
  if (!address) return std::nullopt;
  return std::pair(*address, port);
}

Address V4(const uint8_t* bytes) {
  Address address = {0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0xff, 0xff};
  std::copy(bytes, bytes + 4, address.begin() + kV4Begin);
  return address;
}

// NAT64, 6to4 and the old form of compatible addresses lead to an IPv4 address.
Address Within(const Address& address) {
  if (IsIn(address, *AddressOf("64:ff9b::"), 96)) return V4(address.data() + 12);
  if (IsIn(address, *AddressOf("2002::"), 16)) return V4(address.data() + 2);
  const bool is_compatible =
      IsIn(address, *AddressOf("::"), 96) && address != *AddressOf("::") && address != *AddressOf("::1");
  return is_compatible ? V4(address.data() + 12) : address;
}

std::string TextOf(const Address& address) {
  char text[INET6_ADDRSTRLEN] = "";
  const bool is_v4 = IsIn(address, *AddressOf("::ffff:0:0"), kV4PrefixBits);
  inet_ntop(is_v4 ? AF_INET : AF_INET6, address.data() + (is_v4 ? kV4Begin : 0), text, sizeof(text));
  return text;
}

}  // namespace

absl::StatusOr<AddressRule> AddressRule::Allowing(const std::string& list) {
  AddressRule rule;
  for (const absl::string_view part : absl::StrSplit(list, ',')) {
    const absl::string_view text = absl::StripAsciiWhitespace(part);
    if (text.empty() && list.find(',') == std::string::npos) break;
    const auto entry = ReadEntry(text);
    if (!entry) {
      return absl::InvalidArgumentError(
          absl::StrCat("'", text, "' is no address: expected as 127.0.0.1, 127.0.0.1:8080, ::1 or [::1]:8080"));
    }
    rule.allowed_.push_back({entry->first, entry->second});
  }
  return rule;
}

namespace {

// Of an address of the network; nothing of others.
std::optional<std::pair<Address, int>> Read(const sockaddr* address) {
  if (address->sa_family == AF_INET) {
    sockaddr_in v4;
    std::memcpy(&v4, address, sizeof(v4));
    uint8_t bytes[4];
    std::memcpy(bytes, &v4.sin_addr, sizeof(bytes));
    return std::pair(V4(bytes), ntohs(v4.sin_port));
  }
  if (address->sa_family != AF_INET6) return std::nullopt;
  sockaddr_in6 v6;
  std::memcpy(&v6, address, sizeof(v6));
  Address ip = {};
  std::memcpy(ip.data(), &v6.sin6_addr, ip.size());
  return std::pair(ip, ntohs(v6.sin6_port));
}

// Whether an interface of this machine has it now. What cannot be asked is taken for its own.
bool IsOfThisMachine(const Address& ip) {
  ifaddrs* found = nullptr;
  if (getifaddrs(&found) != 0) return true;
  const std::unique_ptr<ifaddrs, decltype(&freeifaddrs)> all(found, &freeifaddrs);
  for (const ifaddrs* one = all.get(); one != nullptr; one = one->ifa_next) {
    if (one->ifa_addr == nullptr) continue;
    const auto own = Read(one->ifa_addr);
    if (own && own->first == ip) return true;
  }
  return false;
}

}  // namespace

std::string AddressRule::WhyNot(const sockaddr* address) const {
  const auto read = Read(address);
  if (!read) return "no address of the network";
  return WhyNot(read->first, read->second);
}

std::string AddressRule::WhyNotHost(const std::string& host, int port) const {
  const bool has_brackets = host.size() >= 2 && host.front() == '[' && host.back() == ']';
  const std::optional<Address> ip = AddressOf(has_brackets ? host.substr(1, host.size() - 2) : host);
  return ip ? WhyNot(*ip, port) : "";
}

std::string AddressRule::WhyNot(const Address& ip, int port) const {
  for (const Allowed& one : allowed_)
    if (one.address == ip && (one.port == 0 || one.port == port)) return "";
  const auto refuse = [&](const char* what) {
    return absl::StrCat(TextOf(ip), " is ", what, ", which webhooks.allowed does not name");
  };
  const Address judged = Within(ip);
  const bool is_v4 = IsIn(judged, *AddressOf("::ffff:0:0"), kV4PrefixBits);
  for (const Network& network : kRefused) {
    const bool is_v4_network = std::strchr(network.address, '.') != nullptr;
    if (is_v4 != is_v4_network) continue;
    if (IsIn(judged, *AddressOf(network.address), network.bits + (is_v4_network ? kV4PrefixBits : 0)))
      return refuse(network.what);
  }
  return IsOfThisMachine(judged) ? refuse("an address of this machine") : "";
}

}  // namespace axiscal::webhooks
