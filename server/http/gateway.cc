#include "server/http/gateway.h"

#include "absl/strings/numbers.h"
#include "core/base/error_detail.h"
#include "core/session/line_reader.h"
#include "server/http/connect.h"
#include "server/http/errors.h"
#include "server/http/messages.h"

namespace axiscal::http {
namespace {

// Of a file, which is held in memory until it is stored.
constexpr int64_t kMostFileBytes = session::kMaxSessionBytes;
// What signs in, and what is sent by who has not shown who he is, so that 10,000 of them are no more than 40 MB.
constexpr int64_t kMostOtherBytes = 4 << 10;
constexpr char kSignIn[] = "/sign-in", kSignOut[] = "/sign-out";

// The words of a plain file's path, decoded: {"machines", "mt", "sessions"} of "/v1/machines/mt/sessions". Empty for
// other paths.
std::vector<std::string> PlaceOf(const std::string& path) {
  if (path == "/metrics") return {"metrics"};  // where monitoring systems look when they are told no path
  constexpr char kStart[] = "/v1/";
  if (path.rfind(kStart, 0) != 0) return {};
  std::vector<std::string> place;
  for (const std::string& word : Words(path.substr(sizeof(kStart) - 1), '/')) {
    const std::optional<std::string> decoded = PercentDecoded(word);
    if (!decoded || decoded->empty()) return {};
    place.push_back(*decoded);
  }
  return place;
}

enum class Plain { kNone, kMetrics, kLogs, kSessions, kSession, kPrograms, kProgram, kRewrite, kSheet };

Plain PlainOf(const std::vector<std::string>& place) {
  if (place.size() == 1 && place[0] == "metrics") return Plain::kMetrics;
  if (place.size() == 3 && place[0] == "machines" && place[2] == "sessions") return Plain::kSessions;
  if (place.size() == 3 && place[0] == "machines" && place[2] == "logs") return Plain::kLogs;
  if (place.size() == 3 && place[0] == "machines" && place[2] == "rewrite") return Plain::kRewrite;
  if (place.size() < 2) return Plain::kNone;
  int64_t id = 0;
  const bool is_number =
      place[1].find_first_not_of("0123456789") == std::string::npos && absl::SimpleAtoi(place[1], &id);
  if (place.size() == 3 && place[0] == "calibrations" && is_number && place[2] == "report") return Plain::kSheet;
  if (place.size() != 2) return Plain::kNone;
  if (place[0] == "sessions" && is_number) return Plain::kSession;
  // A program is put under its name, and read by its number.
  if (place[0] == "programs") return is_number ? Plain::kProgram : Plain::kPrograms;
  return Plain::kNone;
}

Answer NotFound(const Request& request) {
  Answer answer = ErrorAnswer(
      base::Error(absl::StatusCode::kUnimplemented, "nothing has the path " + request.path, {"METHOD_UNKNOWN", {}}));
  answer.status = 404;
  return answer;
}

Answer NotAllowed(const std::string& allow) { return {405, {{"Allow", allow}}, ""}; }

// What signs in must be sent as JSON, which a page of another origin cannot send without being asked first.
bool IsJson(const Request& request) {
  const std::optional<ContentType> type = ContentTypeOf(request.Field("content-type"));
  return type && type->codec == Codec::kJson && !type->is_stream;
}

// What a request stands for, as the audit names it: a method of the API, "/sign-in", or "HTTP" for what is none.
std::string MethodOf(const Request& request) {
  if (const google::protobuf::MethodDescriptor* const method = FindMethod(request.path))
    return method->service()->name() + "." + method->name();
  if (request.path == kSignIn || request.path == kSignOut) return request.path;
  const bool is_post = request.method == "POST";
  switch (PlainOf(PlaceOf(request.path))) {
    case Plain::kNone:
      return "HTTP";
    case Plain::kMetrics:
      return "Admin.GetMetrics";
    case Plain::kSheet:
      return "Calibrations.GetCalibration";
    case Plain::kLogs:
      return "Ingest.PutLog";
    case Plain::kSessions:
      return "Ingest.CreateSession";
    case Plain::kSession:
      return "Ingest.DownloadSession";
    case Plain::kPrograms:
      return "Programs.PutProgram";
    case Plain::kRewrite:
      return "Programs.RewriteProgram";
    case Plain::kProgram:
      return is_post ? "Programs.PutProgram" : "Programs.GetProgram";
  }
  return "HTTP";
}

}  // namespace

Answer Gateway::Refusal(const Request& request, const absl::Status& status) const {
  handlers::Call call;
  call.peer = access::PeerHost(request.peer.address);
  const std::string method = MethodOf(request);
  core_.denied(call, method, status);
  core_.metrics->CallStarted(method);
  core_.metrics->CallEnded(method, status.code(), std::chrono::seconds(0));
  return ErrorAnswer(status);
}

std::optional<Answer> Gateway::Count(const Request& request) const {
  const absl::Status taken = core_.rates.Take(access::PeerHost(request.peer.address));
  if (taken.ok()) return std::nullopt;
  return ErrorAnswer(taken);
}

bool Gateway::TellsOfTooOften() const { return core_.told_refusals.Take("log").ok(); }

absl::StatusOr<access::Credentials> Gateway::CredentialsOf(const Request& request) const {
  access::Credentials credentials;
  credentials.login = request.peer.login;
  credentials.certificate_name = request.peer.certificate_name;
  credentials.certificate_ends = request.peer.certificate_ends;
  if (request.fields.count("authorization") > 0) {
    credentials.authorization = request.Field("authorization");
    return credentials;
  }
  const std::optional<std::string> cookie = CookieOf(request);
  if (!cookie || !core_.gate.asks()) return credentials;
  // A browser sends the cookie along whoever wrote the page: what changes something must come from ours.
  if (request.method != "GET" && !SaysOwnOrigin(request)) {
    return base::Error(absl::StatusCode::kPermissionDenied,
                       "a call by cookie needs the Origin of this service, which browsers send",
                       {"ORIGIN_REFUSED", {}});
  }
  credentials.authorization = sign_ins_.Find(*cookie);
  return credentials;
}

absl::StatusOr<access::Identity> Gateway::CallerOf(const Request& request) const {
  ASSIGN_OR_RETURN(const access::Credentials credentials, CredentialsOf(request));
  return core_.gate.Identify(credentials);
}

BodyRule Gateway::RuleFor(const Request& head) const {
  const absl::StatusOr<access::Identity> caller = CallerOf(head);
  BodyRule rule = RuleFor(head, caller);
  rule.is_known = caller.ok();
  rule.counted_as = caller.ok() ? caller->name : access::PeerHost(head.peer.address);
  return rule;
}

BodyRule Gateway::RuleFor(const Request& head, const absl::StatusOr<access::Identity>& caller) const {
  // Pages hold no data: a link of another page may lead to them.
  if (pages_.Has(head.path)) return {};
  const absl::Status origin = CheckOrigin(head, core_.gate.asks(), own_host_);
  if (!origin.ok()) return {0, Refusal(head, origin)};
  // Of who is nobody no more than a small message: nothing of his is read, but he is told so as the method's protocol
  // has it.
  if (FindMethod(head.path) != nullptr) return {caller.ok() ? MostBodyBytes(head) : kMostOtherBytes};
  const Plain plain = PlainOf(PlaceOf(head.path));
  if (head.method != "POST" || plain == Plain::kNone) return {kMostOtherBytes};
  if (!head.content_length) return {0, Answer{411, {}, ""}};
  // Nobody's file is taken in for nothing. What its role may do is asked with the call.
  if (!caller.ok()) return {0, Refusal(head, caller.status())};
  return {kMostFileBytes};
}

void Gateway::Serve(const Request& request, Exchange& exchange) {
  if (pages_.Has(request.path)) {
    exchange.Send(pages_.Get(request));
    return;
  }
  if (const google::protobuf::MethodDescriptor* const method = FindMethod(request.path)) {
    absl::StatusOr<access::Credentials> credentials = CredentialsOf(request);
    if (credentials.ok() && request.is_too_large) {
      const absl::Status identified = CallerOf(request).status();
      if (!identified.ok()) credentials = identified;
    }
    if (!credentials.ok()) Refusal(request, credentials.status());  // the answer is the method's to write
    ServeConnect(core_, channel_, *method, request, credentials, budget_, exchange);
    return;
  }
  if (request.path == kSignIn || request.path == kSignOut) {
    if (request.method != "POST") {
      exchange.Send(NotAllowed("POST"));
    } else if (!IsJson(request)) {
      exchange.Send({415, {{"Accept-Post", "application/json"}}, ""});
    } else if (request.path == kSignOut) {
      exchange.Send(SignOut(request, sign_ins_));
    } else if (absl::StatusOr<Answer> answer = SignIn(request, core_.gate, sign_ins_); answer.ok()) {
      exchange.Send(*std::move(answer));
    } else {
      const Answer refusal = Refusal(request, answer.status());
      exchange.Send(Count(request).value_or(refusal));
    }
    return;
  }
  ServePlain(request, PlaceOf(request.path), exchange);
}

void Gateway::ServePlain(const Request& request, const std::vector<std::string>& place, Exchange& exchange) {
  const Plain plain = PlainOf(place);
  if (plain == Plain::kNone) {
    exchange.Send(NotFound(request));
    return;
  }
  // A program may have a number for a name: by POST it is one.
  const bool only_up =
      plain == Plain::kLogs || plain == Plain::kSessions || plain == Plain::kPrograms || plain == Plain::kRewrite;
  const bool goes_up = only_up || (plain == Plain::kProgram && request.method == "POST");
  if (request.method != (goes_up ? "POST" : "GET")) {
    exchange.Send(NotAllowed(only_up ? "POST" : plain == Plain::kProgram ? "GET, POST" : "GET"));
    return;
  }
  if (request.is_too_large) {
    exchange.Send(ErrorAnswer(base::Error(absl::StatusCode::kResourceExhausted,
                                          absl::StrCat("a file of more than ", kMostFileBytes, " bytes"),
                                          {"MESSAGE_TOO_LARGE", {}})));
    return;
  }
  const absl::StatusOr<access::Credentials> credentials = CredentialsOf(request);
  if (!credentials.ok()) {
    exchange.Send(Refusal(request, credentials.status()));
    return;
  }
  const PlainCall call{core_, channel_, request, *credentials, exchange, budget_};
  if (plain == Plain::kMetrics) {
    GetMetrics(call);
  } else if (plain == Plain::kLogs) {
    PutLog(call, place[1]);
  } else if (plain == Plain::kSessions) {
    PutSession(call, place[1]);
  } else if (plain == Plain::kRewrite) {
    RewriteProgram(call, place[1]);
  } else if (goes_up) {
    PutProgram(call, place[1]);
  } else if (plain == Plain::kSession) {
    GetSession(call, std::stoll(place[1]));
  } else if (plain == Plain::kSheet) {
    GetSheet(call, std::stoll(place[1]));
  } else {
    GetProgram(call, std::stoll(place[1]));
  }
}

}  // namespace axiscal::http
