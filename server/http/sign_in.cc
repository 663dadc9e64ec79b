#include "server/http/sign_in.h"

#include <google/protobuf/struct.pb.h>
#include <google/protobuf/util/json_util.h>

#include <algorithm>

#include "absl/strings/ascii.h"
#include "core/base/error_detail.h"

namespace axiscal::http {
namespace {

// As long as a shift.
constexpr std::chrono::hours kLasts(12);
// More than a plant has people; beyond it the first one gives way.
constexpr size_t kMaxSignIns = 10'000;
// More than one token is used in browsers; beyond it the first of that token's gives way, so that nobody signs out
// others by signing in again and again.
constexpr size_t kMaxOfOneToken = 100;

// Browsers take a cookie of this prefix by TLS only, and from this very host.
std::string CookieName(const Request& request) { return request.peer.is_tls ? "__Host-axiscal" : "axiscal"; }

std::string SetCookie(const Request& request, const std::string& value, std::chrono::seconds lasts) {
  return absl::StrCat(CookieName(request), "=", value, "; Path=/; HttpOnly; SameSite=Strict; Max-Age=", lasts.count(),
                      request.peer.is_tls ? "; Secure" : "");
}

absl::Status Refused(const std::string& text) {
  return base::Error(absl::StatusCode::kPermissionDenied, text, {"ORIGIN_REFUSED", {}});
}

// "[::1]" of "[::1]:7480".
std::string WithoutPort(const std::string& host) {
  const size_t colon = host.rfind(':');
  const bool has_port = colon != std::string::npos && host.find(']', colon) == std::string::npos;
  return has_port ? host.substr(0, colon) : host;
}

bool IsLoopbackName(const std::string& name) {
  const bool is_v4 = name.rfind("127.", 0) == 0 && name.find_first_not_of("0123456789.") == std::string::npos;
  return is_v4 || name == "localhost" || name == "[::1]";
}

}  // namespace

bool SaysOwnOrigin(const Request& request) {
  if (const std::string site = request.Field("sec-fetch-site"); !site.empty()) return site == "same-origin";
  const std::string origin = absl::AsciiStrToLower(request.Field("origin"));
  return !origin.empty() &&
         origin == (request.peer.is_tls ? "https://" : "http://") + absl::AsciiStrToLower(request.Field("host"));
}

absl::Status CheckOrigin(const Request& request, bool asks, const std::string& own_host) {
  const std::string site = request.Field("sec-fetch-site");
  const bool is_from_page = (!site.empty() && site != "none") || request.fields.count("origin") > 0;
  if (is_from_page && !SaysOwnOrigin(request)) {
    return Refused("sent by a page of another origin (" + request.Field("origin") + "): only pages of " +
                   request.Field("host") + " may");
  }
  if (asks || request.peer.is_unix) return absl::OkStatus();
  const std::string name = absl::AsciiStrToLower(WithoutPort(request.Field("host")));
  if (IsLoopbackName(name) || (!name.empty() && name == absl::AsciiStrToLower(own_host))) return absl::OkStatus();
  return Refused("Host is '" + request.Field("host") +
                 "', must be localhost or a loopback address: this service asks nobody who he is");
}

std::string SignIns::Add(const std::string& authorization) {
  const std::string cookie = access::NewToken().substr(4);  // without the mark of a token
  const base::UtcTime now = clock_.UtcNow();
  const base::MutexLock lock(mutex_);
  std::erase_if(entries_, [&](const auto& entry) { return entry.second.ends_at <= now; });
  const auto is_of_token = [&](const auto& entry) { return entry.second.authorization == authorization; };
  const auto is_first = [](const auto& a, const auto& b) { return a.second.order < b.second.order; };
  if (static_cast<size_t>(std::count_if(entries_.begin(), entries_.end(), is_of_token)) >= kMaxOfOneToken) {
    entries_.erase(std::min_element(entries_.begin(), entries_.end(), [&](const auto& a, const auto& b) {
      return is_of_token(a) != is_of_token(b) ? is_of_token(a) : is_first(a, b);
    }));
  }
  if (entries_.size() >= kMaxSignIns) entries_.erase(std::min_element(entries_.begin(), entries_.end(), is_first));
  entries_[access::HashOfToken(cookie)] = {authorization, now + kLasts, next_order_++};
  return cookie;
}

std::optional<std::string> SignIns::Find(const std::string& cookie) const {
  const base::MutexLock lock(mutex_);
  const auto found = entries_.find(access::HashOfToken(cookie));
  if (found == entries_.end() || found->second.ends_at <= clock_.UtcNow()) return std::nullopt;
  return found->second.authorization;
}

void SignIns::Remove(const std::string& cookie) {
  const base::MutexLock lock(mutex_);
  entries_.erase(access::HashOfToken(cookie));
}

std::optional<std::string> CookieOf(const Request& request) {
  const std::string start = CookieName(request) + "=";
  for (const std::string& word : Words(request.Field("cookie"), ';')) {
    if (word.rfind(start, 0) == 0) return word.substr(start.size());
  }
  return std::nullopt;
}

absl::StatusOr<Answer> SignIn(const Request& request, const access::Gate& gate, SignIns& sign_ins) {
  if (!gate.asks()) {
    return base::Error(absl::StatusCode::kFailedPrecondition, "this service asks nobody who he is",
                       {"NOBODY_ASKED", {}});
  }
  google::protobuf::Struct body;
  const bool is_json = google::protobuf::util::JsonStringToMessage(request.body, &body).ok();
  const auto token = body.fields().find("token");
  if (!is_json || token == body.fields().end() || token->second.string_value().empty()) {
    return base::Error(absl::StatusCode::kInvalidArgument, "expected {\"token\": \"axt_...\"}",
                       {"MESSAGE_INVALID", {}});
  }
  access::Credentials credentials;
  credentials.authorization = "Bearer " + token->second.string_value();
  ASSIGN_OR_RETURN(const access::Identity identity, gate.Identify(credentials));
  // A name has letters, digits and marks that JSON writes as they are.
  return Answer{200,
                {{"Content-Type", "application/json"},
                 {"Set-Cookie", SetCookie(request, sign_ins.Add(*credentials.authorization), kLasts)}},
                "{\"name\":\"" + identity.name + "\"}"};
}

Answer SignOut(const Request& request, SignIns& sign_ins) {
  if (const std::optional<std::string> cookie = CookieOf(request)) sign_ins.Remove(*cookie);
  return {204, {{"Set-Cookie", SetCookie(request, "", std::chrono::seconds(0))}}, ""};
}

}  // namespace axiscal::http
