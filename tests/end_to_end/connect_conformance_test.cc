// The cases of the Connect conformance suite (repository connectrpc/conformance, testsuites/data) for unary calls and
// server streams over HTTP/1.1, with identity compression, in JSON and the binary form, rebuilt on calls of this API.
// The test prints what was expected and what came, as the table of docs/http.md.
#include <gmock/gmock.h>

#include <cstdio>

#include "absl/strings/match.h"
#include "absl/strings/str_replace.h"
#include "axiscal/v1/jobs_service.pb.h"
#include "core/session/write_session.h"
#include "server/http/messages.h"
#include "server/server.h"
#include "tests/end_to_end/testing/fixture.h"
#include "tests/end_to_end/testing/http_client.h"

namespace axiscal {
namespace {

using http::Envelope;
using testing::CallJson;
using testing::Fetch;
using testing::HttpAnswer;
using testing::HttpConnection;
using testing::HttpFields;

constexpr char kInfo[] = "/axiscal.v1.Admin/GetServerInfo";
constexpr char kGetJob[] = "/axiscal.v1.Jobs/GetJob";
constexpr char kWaitJob[] = "/axiscal.v1.Jobs/WaitJob";
constexpr char kWatchJob[] = "/axiscal.v1.Jobs/WatchJob";

// What an answer comes to: the HTTP status of a call that is no stream and its code, or the code at the end of a
// stream.
std::string Seen(const HttpAnswer& answer) {
  const auto code_in = [](const std::string& json) -> std::string {
    const size_t at = json.find("\"code\":\"");
    return at == std::string::npos ? "ok" : json.substr(at + 8, json.find('"', at + 8) - at - 8);
  };
  if (!answer.is_whole) return "cut off";
  if (!absl::StartsWith(answer.Field("content-type"), "application/connect+")) {
    return absl::StrCat(answer.status, answer.status == 200 || answer.body.empty() ? "" : " " + code_in(answer.body));
  }
  std::string end = "no end";
  int messages = 0;
  for (size_t at = 0; at + 5 <= answer.body.size();) {
    size_t size = 0;
    for (size_t i = 1; i < 5; ++i) size = size << 8 | static_cast<unsigned char>(answer.body[at + i]);
    if (answer.body[at] == 2) {
      end = code_in(answer.body.substr(at + 5, size));
    } else {
      ++messages;
    }
    at += 5 + size;
  }
  return absl::StrCat(answer.status, " stream, end ", end, messages > 0 ? "" : ", no message");
}

class ConnectConformance : public ::testing::Test {
 protected:
  void SetUp() override {
    server::ServerOptions options;
    options.database_path = dir_.File("axiscal.db");
    options.http_address = "127.0.0.1:0";
    options.drain = std::chrono::milliseconds(200);
    auto started = server::Server::Start(options);
    ASSERT_OK(started);
    server_ = *std::move(started);
    const std::string description = absl::StrReplaceAll(testing::MachineJson("mt"), {{"\"", "\\\""}, {"\n", "\\n"}});
    ASSERT_EQ(CallJson(port(), "Machines/CreateMachine", "{\"descriptionJson\": \"" + description + "\"}").status, 200);
    const HttpAnswer stored = Fetch(port(), "POST", "/v1/machines/mt/sessions", {},
                                    *session::WriteSession(testing::BallbarSession("mt", "long", 10'000)));
    ASSERT_EQ(stored.status, 201) << stored.body;
    // It lasts until it is cancelled.
    const HttpAnswer created = CallJson(port(), "Jobs/CreateJob",
                                        R"({"requestId": "endless", "params": {"identify": {"machineId": "mt",
                                            "sessionIds": [1], "monteCarloRuns": 100000}}})");
    ASSERT_EQ(created.status, 200) << created.body;
  }
  int port() const { return server_->http_port(); }

  testing::TempDir dir_;
  std::unique_ptr<server::Server> server_;
};

struct Case {
  std::string name;  // as in the suite, or what it is
  std::string method, path;
  HttpFields fields;
  std::string body;
  std::string expected;
};

TEST_F(ConnectConformance, EveryCaseOfUnaryCallsAndServerStreams) {
  v1::GetJobRequest get_job;
  get_job.set_job_id(1);
  v1::WatchJobRequest watch_job;
  watch_job.set_job_id(77);
  v1::WaitJobRequest wait_job;
  wait_job.set_job_id(1);
  const std::string none_json = Envelope(0, R"({"jobId": "77"})"), one_json = Envelope(0, R"({"jobId": "1"})");
  const std::string none_proto = Envelope(0, watch_job.SerializeAsString());
  const auto with = [](const char* type, HttpFields fields = {}) {
    fields["Content-Type"] = type;
    return fields;
  };
  constexpr char kJson[] = "application/json", kProto[] = "application/proto",
                 kJsonStream[] = "application/connect+json", kProtoStream[] = "application/connect+proto";
  const std::vector<Case> cases = {
      {"unary/success, json", "POST", kGetJob, with(kJson), R"({"jobId": "1"})", "200"},
      {"unary/success, proto", "POST", kGetJob, with(kProto), get_job.SerializeAsString(), "200"},
      {"unary/zero-byte proto body", "POST", kInfo, with(kProto), "", "200"},
      {"unary/error, json", "POST", kGetJob, with(kJson), R"({"jobId": "77"})", "404 not_found"},
      {"unary/error, proto", "POST", kGetJob, with(kProto), std::string("\x08\x4d", 2), "404 not_found"},
      {"unary/charset behind json", "POST", kInfo, with("application/json; charset=utf-8"), "{}", "200"},
      {"unary/content type in capitals", "POST", kInfo, with("Application/JSON"), "{}", "200"},
      {"unary/deadline 200 ms, json", "POST", kWaitJob, with(kJson, {{"Connect-Timeout-Ms", "200"}}),
       R"({"jobId": "1", "timeoutMs": "60000"})", "504 deadline_exceeded"},
      {"unary/deadline 200 ms, proto", "POST", kWaitJob, with(kProto, {{"Connect-Timeout-Ms", "200"}}),
       wait_job.SerializeAsString(), "504 deadline_exceeded"},
      {"unary/deadline of 10 digits", "POST", kInfo, with(kJson, {{"Connect-Timeout-Ms", "1234567890"}}), "{}", "200"},
      {"unary/deadline of 11 digits", "POST", kInfo, with(kJson, {{"Connect-Timeout-Ms", "12345678901"}}), "{}",
       "400 invalid_argument"},
      {"unary/protocol version 1", "POST", kInfo, with(kJson, {{"Connect-Protocol-Version", "1"}}), "{}", "200"},
      {"unary/no protocol version", "POST", kInfo, with(kJson), "{}", "200"},
      {"unary/protocol version 2", "POST", kInfo, with(kJson, {{"Connect-Protocol-Version", "2"}}), "{}",
       "400 invalid_argument"},
      {"unary/identity coding", "POST", kInfo, with(kJson, {{"Content-Encoding", "identity"}}), "{}", "200"},
      {"unary/unexpected compression", "POST", kInfo, with(kJson, {{"Content-Encoding", "foo"}}), "{}",
       "501 unimplemented"},
      {"unary/message over the limit", "POST", kGetJob, with(kProto), std::string(4'300'000, 'x'),
       "429 resource_exhausted"},
      {"unary/malformed json", "POST", kInfo, with(kJson), "{", "400 invalid_argument"},
      {"unary/malformed proto", "POST", kInfo, with(kProto), "\xff\xff", "400 invalid_argument"},
      {"unary/unimplemented method", "POST", "/axiscal.v1.Admin/None", with(kJson), "{}", "404 unimplemented"},
      {"unary/unknown service", "POST", "/axiscal.v1.None/GetServerInfo", with(kJson), "{}", "404 unimplemented"},
      {"http/DELETE", "DELETE", kInfo, with(kJson), "", "405"},
      {"http/unknown path", "POST", "/nothing", with(kJson), "{}", "404 unimplemented"},
      {"http/application/foo", "POST", kInfo, with("application/foo"), "{}", "415"},
      {"http/image/jpeg", "POST", kInfo, with("image/jpeg"), "{}", "415"},
      {"http/stream type of a unary call", "POST", kInfo, with(kJsonStream), Envelope(0, "{}"), "415"},
      {"http/unary type of a stream", "POST", kWatchJob, with(kJson), "{}", "415"},
      {"server-stream/error before a message, json", "POST", kWatchJob, with(kJsonStream), none_json,
       "200 stream, end not_found, no message"},
      {"server-stream/error before a message, proto", "POST", kWatchJob, with(kProtoStream), none_proto,
       "200 stream, end not_found, no message"},
      {"server-stream/no request message", "POST", kWatchJob, with(kJsonStream), "",
       "200 stream, end unimplemented, no message"},
      {"server-stream/two request messages", "POST", kWatchJob, with(kJsonStream), none_json + none_json,
       "200 stream, end unimplemented, no message"},
      {"server-stream/flag of compression without a coding", "POST", kWatchJob, with(kJsonStream), Envelope(1, "x"),
       "200 stream, end internal, no message"},
      {"server-stream/unexpected compression", "POST", kWatchJob,
       with(kJsonStream, {{"Connect-Content-Encoding", "gzip"}}), none_json,
       "200 stream, end unimplemented, no message"},
      {"server-stream/malformed message", "POST", kWatchJob, with(kJsonStream), Envelope(0, "{"),
       "200 stream, end invalid_argument, no message"},
      {"server-stream/envelope cut off", "POST", kWatchJob, with(kJsonStream), none_json.substr(0, 8),
       "200 stream, end invalid_argument, no message"},
      {"server-stream/message over the limit", "POST", kWatchJob, with(kProtoStream),
       Envelope(0, std::string(4'300'000, 'x')), "200 stream, end resource_exhausted, no message"},
      {"server-stream/deadline 200 ms behind messages", "POST", kWatchJob,
       with(kJsonStream, {{"Connect-Timeout-Ms", "200"}}), one_json, "200 stream, end deadline_exceeded"},
  };
  std::string table = "| case | expected | seen |\n|---|---|---|\n";
  for (const Case& one : cases) {
    const std::string seen = Seen(Fetch(port(), one.method, one.path, one.fields, one.body));
    EXPECT_EQ(seen, one.expected) << one.name;
    absl::StrAppend(&table, "| ", one.name, " | ", one.expected, " | ", seen, " |\n");
  }
  std::fputs(table.c_str(), stdout);
}

// A field that stands twice is one list (RFC 9110, 5.3): of fields that are handed on both values arrive.
TEST_F(ConnectConformance, FieldsThatStandTwiceAreJoined) {
  HttpConnection connection(port());
  connection.Send("POST " + std::string(kInfo) +
                  " HTTP/1.1\r\nHost: localhost\r\nContent-Type: application/json\r\nContent-Length: 2\r\n"
                  "X-Custom: a\r\nX-Custom: b\r\n\r\n{}");
  EXPECT_EQ(connection.Receive().status, 200);
}

// The head of a stream goes out before its first message, or a caller would take a quiet stream for a dead server.
TEST_F(ConnectConformance, TheHeadOfAStreamComesBeforeItsFirstMessage) {
  // From now on nothing happens: the stream's first message is at once, changes never come.
  HttpConnection connection(port());
  connection.SendRequest("POST", "/axiscal.v1.Events/WatchEvents", {{"Content-Type", "application/connect+json"}},
                         Envelope(0, "{}"));
  const HttpAnswer head = connection.ReceiveSome(1);
  EXPECT_EQ(head.status, 200);
  EXPECT_EQ(head.Field("content-type"), "application/connect+json");
  EXPECT_FALSE(head.is_whole);
}

}  // namespace
}  // namespace axiscal
