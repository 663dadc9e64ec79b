// The API by HTTP: the cases of the Connect conformance suite for calls that are no streams and those that stream their
// answer, plain files, browsers, and who may do what.
#include <gmock/gmock.h>
#include <google/protobuf/util/json_util.h>

#include <algorithm>
#include <cstdlib>
#include <regex>

#include "absl/strings/str_replace.h"
#include "axiscal/v1/admin_service.pb.h"
#include "axiscal/v1/ingest_service.pb.h"
#include "axiscal/v1/jobs_service.pb.h"
#include "axiscal/v1/programs_service.pb.h"
#include "core/base/files.h"
#include "core/base/sha256.h"
#include "core/base/testing/source_path.h"
#include "core/session/write_session.h"
#include "server/access/gate.h"
#include "server/http/messages.h"
#include "server/log.h"
#include "server/server.h"
#include "server/storage/sqlite_database.h"
#include "tests/end_to_end/testing/fixture.h"
#include "tests/end_to_end/testing/http_client.h"

namespace axiscal {
namespace {

using http::Envelope;
using records::Role;
using ::testing::AllOf;
using testing::CallJson;
using testing::Fetch;
using ::testing::HasSubstr;
using testing::HttpAnswer;
using testing::HttpConnection;
using testing::HttpFields;
using testing::MachineJson;
using ::testing::Not;
using ::testing::Pair;
using ::testing::UnorderedElementsAre;

const HttpFields kJson = {{"Content-Type", "application/json"}};
const HttpFields kProto = {{"Content-Type", "application/proto"}};
const HttpFields kJsonStream = {{"Content-Type", "application/connect+json"}};
const HttpFields kProtoStream = {{"Content-Type", "application/connect+proto"}};
constexpr char kGetServerInfo[] = "/axiscal.v1.Admin/GetServerInfo";
constexpr char kWatchJob[] = "/axiscal.v1.Jobs/WatchJob";

template <typename Message>
Message FromJson(const std::string& json) {
  Message message;
  EXPECT_TRUE(google::protobuf::util::JsonStringToMessage(json, &message).ok()) << json;
  return message;
}

HttpFields With(HttpFields fields, const std::string& name, const std::string& value) {
  fields[name] = value;
  return fields;
}

// The envelopes of a stream's body: flags and message.
std::vector<std::pair<int, std::string>> EnvelopesOf(const std::string& body) {
  std::vector<std::pair<int, std::string>> envelopes;
  for (size_t at = 0; at + 5 <= body.size();) {
    size_t size = 0;
    for (size_t i = 1; i < 5; ++i) size = size << 8 | static_cast<unsigned char>(body[at + i]);
    envelopes.emplace_back(body[at], body.substr(at + 5, size));
    at += 5 + size;
  }
  return envelopes;
}

// The JSON behind the last message of a stream, which ends as HTTP wants it.
std::string EndOf(const HttpAnswer& answer) {
  EXPECT_EQ(answer.status, 200);
  EXPECT_TRUE(answer.is_whole);
  const auto envelopes = EnvelopesOf(answer.body);
  if (envelopes.empty() || envelopes.back().first != 2) return "no end in " + answer.body;
  return envelopes.back().second;
}

class Http : public ::testing::Test {
 protected:
  void SetUp() override { Start({}); }

  void Start(server::ServerOptions options, std::chrono::milliseconds drain = std::chrono::milliseconds(200)) {
    server_.reset();
    options.database_path = dir_.File("axiscal.db");
    options.http_address = "127.0.0.1:0";
    options.drain = drain;
    auto started = server::Server::Start(options);
    ASSERT_OK(started);
    server_ = *std::move(started);
  }
  int port() const { return server_->http_port(); }

  void CreateMachine() {
    const std::string description = absl::StrReplaceAll(MachineJson("mt"), {{"\"", "\\\""}, {"\n", "\\n"}});
    const HttpAnswer answer =
        CallJson(port(), "Machines/CreateMachine", "{\"descriptionJson\": \"" + description + "\"}");
    ASSERT_EQ(answer.status, 200) << answer.body;
  }
  static std::string SessionText(const std::string& name, int readings = 720) {
    return *session::WriteSession(testing::BallbarSession("mt", name, readings));
  }
  int64_t StoreSession(const std::string& name, int readings = 720) {
    const HttpAnswer answer = Fetch(port(), "POST", "/v1/machines/mt/sessions", {}, SessionText(name, readings));
    EXPECT_EQ(answer.status, 201) << answer.body;
    return FromJson<v1::Session>(answer.body).session_id();
  }
  // The simulation would take hours: the job lasts until it is cancelled.
  int64_t StartEndlessJob() {
    const HttpAnswer answer =
        CallJson(port(), "Jobs/CreateJob",
                 absl::StrCat(R"({"requestId": "endless", "params": {"identify": {"machineId": "mt", "sessionIds": [)",
                              StoreSession("long", 10'000), R"(], "monteCarloRuns": 100000}}})"));
    EXPECT_EQ(answer.status, 200) << answer.body;
    return FromJson<v1::CreateJobResponse>(answer.body).job().job_id();
  }
  std::string JobRequest(int64_t id) const { return absl::StrCat(R"({"jobId": ")", id, R"("})"); }

  testing::TempDir dir_;
  std::unique_ptr<server::Server> server_;
};

// ---- calls that are no streams

TEST_F(Http, ACallAnswersInJsonAndInTheBinaryForm) {
  const HttpAnswer json = Fetch(port(), "POST", kGetServerInfo, With(kJson, "Connect-Protocol-Version", "1"), "{}");
  ASSERT_EQ(json.status, 200) << json.body;
  EXPECT_EQ(json.Field("content-type"), "application/json");
  EXPECT_EQ(json.Field("x-content-type-options"), "nosniff");
  EXPECT_EQ(FromJson<v1::GetServerInfoResponse>(json.body).max_message_bytes(), 4 << 20);
  EXPECT_TRUE(json.is_whole);
  // Bytes of none are an empty message; the charset behind JSON and letters of any size are taken.
  const HttpAnswer proto = Fetch(port(), "POST", kGetServerInfo, kProto, "");
  ASSERT_EQ(proto.status, 200);
  EXPECT_EQ(proto.Field("content-type"), "application/proto");
  v1::GetServerInfoResponse info;
  ASSERT_TRUE(info.ParseFromString(proto.body));
  EXPECT_EQ(info.max_message_bytes(), 4 << 20);
  EXPECT_EQ(Fetch(port(), "POST", kGetServerInfo, {{"content-type", "Application/Json; charset=UTF-8"}}, "{}").status,
            200);
}

// A report of thousands of outliers.
TEST_F(Http, AnAnswerMayBeLongerThanWhatIsSent) {
  ASSERT_NO_FATAL_FAILURE(CreateMachine());
  server_.reset();
  storage::SqliteOptions sqlite;
  sqlite.path = dir_.File("axiscal.db");
  auto database = storage::OpenSqlite(sqlite);
  ASSERT_OK(database);
  storage::NewCalibration calibration;
  calibration.machine = MachineId("mt");
  calibration.machine_revision = 1;
  calibration.options_json = calibration.model_json = "{}";
  calibration.report_json = "[" + std::string(5 << 20, '7') + "]";
  const auto stored = (*database)->CreateCalibration(calibration);
  ASSERT_OK(stored);
  database->reset();
  ASSERT_NO_FATAL_FAILURE(Start({}));
  const HttpAnswer answer =
      CallJson(port(), "Calibrations/GetCalibration", absl::StrCat(R"({"calibrationId": )", stored->id.number(), "}"));
  EXPECT_EQ(answer.status, 200);
  EXPECT_NE(answer.body.find(calibration.report_json), std::string::npos);
}

TEST_F(Http, WebhooksAreMadeAndListedWithoutTheirSecret) {
  const HttpAnswer made = CallJson(port(), "Webhooks/PutWebhook",
                                   R"({"webhook": {"name": "mes", "url": "http://mes/hook", "scope": {"all": true}}})");
  ASSERT_EQ(made.status, 200) << made.body;
  EXPECT_THAT(made.body, HasSubstr(R"("secret":"whsec_)"));
  const HttpAnswer listed = CallJson(port(), "Webhooks/ListWebhooks", "{}");
  EXPECT_THAT(listed.body, AllOf(HasSubstr(R"("url":"http://mes/hook")"), Not(HasSubstr("whsec"))));
  const HttpAnswer wrong = CallJson(port(), "Webhooks/PutWebhook",
                                    R"({"webhook": {"name": "mes", "url": "file:///etc", "scope": {"all": true}}})");
  EXPECT_EQ(wrong.status, 400);
  EXPECT_THAT(wrong.body, HasSubstr("webhook.url"));
  // This server was not told to send any.
  EXPECT_THAT(CallJson(port(), "Webhooks/TestWebhook", R"({"name": "mes"})").body, HasSubstr("WEBHOOKS_NOT_SENT"));
}

TEST_F(Http, AnErrorHasTheCodeTheTextAndTheDetails) {
  const HttpAnswer answer = CallJson(port(), "Jobs/GetJob", R"({"jobId": "77"})");
  EXPECT_EQ(answer.status, 404);
  EXPECT_EQ(answer.Field("content-type"), "application/json");
  EXPECT_THAT(answer.body, AllOf(HasSubstr(R"("code":"not_found")"), HasSubstr(R"("type":"google.rpc.ErrorInfo")"),
                                 HasSubstr(R"("reason":"JOB_NOT_FOUND")")));
  // The same in the binary form.
  v1::GetJobRequest request;
  request.set_job_id(77);
  const HttpAnswer proto = Fetch(port(), "POST", "/axiscal.v1.Jobs/GetJob", kProto, request.SerializeAsString());
  EXPECT_EQ(proto.body, answer.body);
}

TEST_F(Http, WhatIsNoCallIsRefusedAsTheProtocolSays) {
  struct Case {
    std::string method, path;
    HttpFields fields;
    std::string body;
    int status;
    std::string text;
  };
  const std::vector<Case> cases = {
      {"DELETE", kGetServerInfo, kJson, "", 405, ""},
      {"GET", kGetServerInfo, kJson, "", 405, ""},
      {"OPTIONS", kGetServerInfo, {}, "", 405, ""},
      {"POST", "/axiscal.v1.Admin/None", kJson, "{}", 404, "unimplemented"},
      {"POST", "/axiscal.v1.None/GetServerInfo", kJson, "{}", 404, "unimplemented"},
      {"POST", "/nothing", kJson, "{}", 404, "unimplemented"},
      {"POST", kGetServerInfo, {{"Content-Type", "application/foo"}}, "{}", 415, ""},
      {"POST", kGetServerInfo, {{"Content-Type", "image/jpeg"}}, "{}", 415, ""},
      {"POST", kGetServerInfo, {}, "{}", 415, ""},
      {"POST", kGetServerInfo, kJsonStream, "{}", 415, ""},  // no stream by the content type of one
      {"POST", kWatchJob, kJson, "{}", 415, ""},             // and the other way round
      {"POST", kGetServerInfo, With(kJson, "Content-Encoding", "foo"), "{}", 501, "unimplemented"},
      {"POST", kGetServerInfo, With(kJson, "Content-Encoding", "identity"), "{}", 200, ""},
      {"POST", kGetServerInfo, With(kJson, "Connect-Protocol-Version", "2"), "{}", 400, "invalid_argument"},
      {"POST", kGetServerInfo, With(kJson, "Connect-Timeout-Ms", "soon"), "{}", 400, "invalid_argument"},
      {"POST", kGetServerInfo, With(kJson, "Connect-Timeout-Ms", "12345678901"), "{}", 400, "invalid_argument"},
      {"POST", kGetServerInfo, With(kJson, "Connect-Timeout-Ms", "1234567890"), "{}", 200, ""},
      {"POST", kGetServerInfo, kJson, "{", 400, "invalid_argument"},
      {"POST", kGetServerInfo, kJson, R"({"noSuchField": 1})", 400, "noSuchField"},
      {"POST", "/axiscal.v1.Jobs/ListJobs", kJson, R"({"state": "JOB_STATE_NOPE"})", 400, "JOB_STATE_NOPE"},
      {"POST", kGetServerInfo, kProto, "\xff\xff", 400, "invalid_argument"},
      {"POST", "/axiscal.v1.Ingest/UploadOnce", kJsonStream, Envelope(0, "{}"), 200, "unimplemented"},
      {"POST", kGetServerInfo, With(kJson, "axiscal-user", "J\xfcrg"), "{}", 400, "axiscal-user"},
      {"POST", kGetServerInfo, With(kJson, "axiscal-ticket", "forged"), "{}", 200, ""},  // a field like any other
  };
  for (const Case& one : cases) {
    const HttpAnswer answer = Fetch(port(), one.method, one.path, one.fields, one.body);
    EXPECT_EQ(answer.status, one.status) << one.method << " " << one.path << " " << one.body;
    EXPECT_THAT(answer.body, HasSubstr(one.text)) << one.method << " " << one.path;
    EXPECT_TRUE(answer.is_whole) << one.method << " " << one.path;
    if (answer.status == 405) {
      EXPECT_EQ(answer.Field("allow"), "POST");
    }
  }
}

TEST_F(Http, AMessageThatIsTooLargeIsRefusedBeforeItIsRead) {
  HttpConnection announced(port());
  announced.Send("POST " + std::string(kGetServerInfo) +
                 " HTTP/1.1\r\nHost: localhost\r\nContent-Type: application/proto\r\nContent-Length: 5000000\r\n\r\n");
  const HttpAnswer answer = announced.Receive();
  EXPECT_EQ(answer.status, 429);
  EXPECT_THAT(answer.body, AllOf(HasSubstr("resource_exhausted"), HasSubstr("MESSAGE_TOO_LARGE")));
  EXPECT_EQ(answer.Field("connection"), "close");
  EXPECT_TRUE(announced.WaitForClose());
  // One whose length is not announced, and one that is too large only as a message.
  HttpConnection chunked(port());
  chunked.Send("POST " + std::string(kGetServerInfo) +
               " HTTP/1.1\r\nHost: localhost\r\nContent-Type: application/proto\r\nTransfer-Encoding: chunked\r\n\r\n");
  for (int i = 0; i < 80; ++i) chunked.Send("10000\r\n" + std::string(0x10000, 'x') + "\r\n");
  EXPECT_EQ(chunked.Receive().status, 429);
  const HttpAnswer json =
      CallJson(port(), "Machines/GetMachine", R"({"machineId": ")" + std::string(5'000'000, 'm') + R"("})");
  EXPECT_EQ(json.status, 429) << json.body.substr(0, 300);
}

// In JSON an empty part has 3 bytes, in memory 100.
TEST_F(Http, AMessageOfTooManyPartsIsRefusedBeforeItIsRead) {
  std::string json = R"({"params": {"compensate": {"options": {"toolLengths": [{})";
  for (int i = 0; i < 300'000; ++i) json += ",{}";
  const HttpAnswer answer = CallJson(port(), "Jobs/CreateJob", json + "]}}}}");
  EXPECT_EQ(answer.status, 429) << answer.body.substr(0, 300);
  EXPECT_THAT(answer.body, AllOf(HasSubstr("MESSAGE_TOO_LARGE"), HasSubstr("200000 parts")));
  v1::CreateJobRequest request;
  for (int i = 0; i < 300'000; ++i)
    request.mutable_params()->mutable_compensate()->mutable_options()->add_tool_lengths();
  EXPECT_EQ(Fetch(port(), "POST", "/axiscal.v1.Jobs/CreateJob", kProto, request.SerializeAsString()).status, 429);
}

TEST_F(Http, ABodyMayComeInChunksAndAConnectionIsKept) {
  HttpConnection connection(port());
  connection.Send("POST " + std::string(kGetServerInfo) +
                  " HTTP/1.1\r\nHost: localhost\r\nContent-Type: application/json\r\nTransfer-Encoding: chunked\r\n"
                  "\r\n1\r\n{\r\n1\r\n}\r\n0\r\n\r\n");
  EXPECT_EQ(connection.Receive().status, 200);
  // Two requests at once are answered one after the other.
  connection.Send("POST " + std::string(kGetServerInfo) +
                  " HTTP/1.1\r\nHost: localhost\r\nContent-Type: application/json\r\nContent-Length: 2\r\n\r\n{}"
                  "DELETE /x HTTP/1.1\r\nHost: localhost\r\n\r\n");
  EXPECT_EQ(connection.Receive().status, 200);
  EXPECT_EQ(connection.Receive().status, 404);
  // A caller that waits for it is told to go on.
  connection.Send("POST " + std::string(kGetServerInfo) +
                  " HTTP/1.1\r\nHost: localhost\r\nContent-Type: application/json\r\nContent-Length: 2\r\n"
                  "Expect: 100-continue\r\nConnection: close\r\n\r\n");
  EXPECT_EQ(connection.Receive().status, 100);
  connection.Send("{}");
  EXPECT_EQ(connection.Receive().status, 200);
  EXPECT_TRUE(connection.WaitForClose());
}

TEST_F(Http, WhatIsNoHttpIsRefused) {
  for (const std::string& bytes :
       {std::string("\x16\x03\x01\x02\x00\x01"), std::string("GET / HTTP/9\r\n\r\n"),
        std::string("GET http://a/ HTTP/1.1\r\nHost: a\r\n\r\n"), std::string("GET / HTTP/1.1\r\n\r\n"),
        std::string("POST / HTTP/1.1\r\nHost: localhost\r\nContent-Length: 1\r\nContent-Length: 2\r\n\r\n")}) {
    HttpConnection connection(port());
    connection.Send(bytes + "\r\n\r\n");
    EXPECT_EQ(connection.Receive().status, 400) << bytes;
  }
  HttpConnection connection(port());
  connection.Send("GET / HTTP/1.1\r\nHost: localhost\r\nX: " + std::string(20'000, 'x') + "\r\n\r\n");
  EXPECT_EQ(connection.Receive().status, 431);
}

// What follows such a head is a body by another reading, so no request that hides in it may be heard.
TEST_F(Http, AnUnknownTransferCodingIsRefusedAndEndsTheConnection) {
  const std::string hidden = absl::StrCat("POST ", kGetServerInfo,
                                          " HTTP/1.1\r\nHost: localhost\r\nContent-Type: application/json\r\n"
                                          "Content-Length: 2\r\n\r\n{}");
  for (const std::string coding : {"xchunked", "gzip", "gzip, chunked", "chunked, identity", ""}) {
    HttpConnection connection(port());
    connection.Send("GET /metrics HTTP/1.1\r\nHost: localhost\r\nTransfer-Encoding: " + coding + "\r\n\r\n" + hidden);
    EXPECT_EQ(connection.Receive().status, 501) << coding;
    EXPECT_EQ(connection.Receive().status, 0) << coding;
  }
  HttpConnection connection(port());
  connection.Send("POST " + std::string(kGetServerInfo) +
                  " HTTP/1.1\r\nHost: localhost\r\nContent-Type: application/json\r\nTransfer-Encoding: "
                  "Chunked\r\n\r\n2\r\n{}\r\n0\r\n\r\n");
  EXPECT_EQ(connection.Receive().status, 200);
}

TEST_F(Http, ADeadlineEndsACall) {
  CreateMachine();
  const int64_t job = StartEndlessJob();
  const HttpAnswer waited =
      CallJson(port(), "Jobs/WaitJob", absl::StrCat(R"({"jobId": ")", job, R"(", "timeoutMs": "60000"})"),
               {{"Connect-Timeout-Ms", "200"}});
  EXPECT_EQ(waited.status, 504) << waited.body;
  EXPECT_THAT(waited.body, HasSubstr("deadline_exceeded"));
  const HttpAnswer watched =
      Fetch(port(), "POST", kWatchJob, With(kJsonStream, "Connect-Timeout-Ms", "200"), Envelope(0, JobRequest(job)));
  EXPECT_THAT(EndOf(watched), HasSubstr(R"("code":"deadline_exceeded")"));
  EXPECT_GE(EnvelopesOf(watched.body).size(), 2u);
}

// ---- streams

TEST_F(Http, AStreamSendsEachMessageAndThenItsEnd) {
  CreateMachine();
  const int64_t session = StoreSession("BX");
  const HttpAnswer created =
      CallJson(port(), "Jobs/CreateJob",
               absl::StrCat(R"({"requestId": "a", "params": {"identify": {"machineId": "mt", "sessionIds": [)", session,
                            "]}}}"));
  ASSERT_EQ(created.status, 200) << created.body;
  const int64_t job = FromJson<v1::CreateJobResponse>(created.body).job().job_id();
  const HttpAnswer json = Fetch(port(), "POST", kWatchJob, kJsonStream, Envelope(0, JobRequest(job)));
  EXPECT_EQ(json.Field("content-type"), "application/connect+json");
  EXPECT_EQ(EndOf(json), "{}");
  const auto envelopes = EnvelopesOf(json.body);
  ASSERT_GE(envelopes.size(), 2u);
  EXPECT_EQ(envelopes[0].first, 0);
  EXPECT_EQ(FromJson<v1::WatchJobResponse>(envelopes[envelopes.size() - 2].second).job().state(),
            v1::JOB_STATE_SUCCEEDED);
  v1::WatchJobRequest request;
  request.set_job_id(job);
  const HttpAnswer proto = Fetch(port(), "POST", kWatchJob, kProtoStream, Envelope(0, request.SerializeAsString()));
  EXPECT_EQ(proto.Field("content-type"), "application/connect+proto");
  EXPECT_EQ(EndOf(proto), "{}");
  v1::WatchJobResponse watched;
  ASSERT_TRUE(watched.ParseFromString(EnvelopesOf(proto.body)[0].second));
  EXPECT_EQ(watched.job().job_id(), job);
}

TEST_F(Http, AStreamsErrorStandsAtItsEnd) {
  const std::string one = Envelope(0, R"({"jobId": "77"})");
  const std::vector<std::tuple<HttpFields, std::string, std::string>> cases = {
      {kJsonStream, one, "not_found"},
      {kJsonStream, "", "unimplemented"},         // no message
      {kJsonStream, one + one, "unimplemented"},  // two
      {kJsonStream, Envelope(1, "x"), "internal"},
      {With(kJsonStream, "Connect-Content-Encoding", "gzip"), one, "unimplemented"},
      {kJsonStream, Envelope(0, "{"), "invalid_argument"},
      {kJsonStream, one.substr(0, 8), "invalid_argument"},
      {With(kJsonStream, "Connect-Timeout-Ms", "x"), one, "invalid_argument"},
      {kProtoStream, Envelope(0, "\xff"), "invalid_argument"},
      {kProtoStream, Envelope(0, std::string(4'300'000, 'x')), "resource_exhausted"}};
  for (const auto& [fields, body, code] : cases) {
    const HttpAnswer answer = Fetch(port(), "POST", kWatchJob, fields, body);
    EXPECT_THAT(EndOf(answer), HasSubstr("{\"error\":{\"code\":\"" + code + "\"")) << body.substr(0, 40);
    EXPECT_EQ(EnvelopesOf(answer.body).size(), 1u);
  }
}

TEST_F(Http, AHundredStreamsAndASlowReaderHoldUpNobody) {
  CreateMachine();
  const int64_t job = StartEndlessJob();
  std::vector<HttpConnection> streams;
  for (int i = 0; i < 100; ++i) {
    streams.emplace_back(port());
    streams.back().SendRequest("POST", kWatchJob, kJsonStream, Envelope(0, JobRequest(job)));
    ASSERT_EQ(streams.back().ReceiveSome(1).status, 200) << i;
  }
  // More than the system's buffers take.
  std::string program;
  while (program.size() < 24u << 20) absl::StrAppend(&program, "N", program.size(), " G01 X1.0 Y2.0 F1000\n");
  const HttpAnswer put = Fetch(port(), "POST", "/v1/programs/big.nc", {}, program);
  ASSERT_EQ(put.status, 201) << put.body;
  HttpConnection slow(port());
  slow.SendRequest("GET", put.Field("location"));
  EXPECT_FALSE(slow.ReceiveSome(1).is_whole);
  for (int i = 0; i < 20; ++i) EXPECT_EQ(CallJson(port(), "Admin/GetServerInfo", "{}").status, 200);
  // It gets all of it in the end, and the streams theirs.
  const HttpAnswer whole = slow.Receive();
  EXPECT_TRUE(whole.is_whole);
  EXPECT_TRUE(whole.body == program);
  EXPECT_EQ(CallJson(port(), "Jobs/CancelJob", JobRequest(job)).status, 200);
  for (HttpConnection& stream : streams) EXPECT_EQ(EndOf(stream.Receive()), "{}");
}

TEST_F(Http, WhoTakesNothingIsCutOff) {
  server::ServerOptions options;
  options.silence = std::chrono::milliseconds(200);
  options.connection_idle = std::chrono::milliseconds(200);
  Start(options);
  const std::string program(24 << 20, 'x');
  const HttpAnswer put = Fetch(port(), "POST", "/v1/programs/big.nc", {}, program);
  ASSERT_EQ(put.status, 201);
  HttpConnection slow(port());
  slow.SendRequest("GET", put.Field("location"));
  EXPECT_EQ(slow.ReceiveSome(1).status, 200);
  EXPECT_TRUE(HttpConnection(port()).WaitForClose());  // idle
  HttpConnection half(port());
  half.Send("POST " + std::string(kGetServerInfo) +
            " HTTP/1.1\r\nHost: localhost\r\nContent-Type: application/json\r\nContent-Length: 2\r\n\r\n{");
  EXPECT_TRUE(half.WaitForClose());
  EXPECT_FALSE(slow.Receive().is_whole);
}

// A call whose caller is gone holds up the end of the server no longer.
TEST_F(Http, ACallerThatLeavesEndsItsCall) {
  server::ServerOptions options;
  options.silence = std::chrono::hours(1);
  Start(options, std::chrono::hours(1));
  const HttpAnswer put = Fetch(port(), "POST", "/v1/programs/big.nc", {}, std::string(24 << 20, 'x'));
  ASSERT_EQ(put.status, 201);
  {
    HttpConnection leaving(port());
    leaving.SendRequest("GET", put.Field("location"));
    EXPECT_EQ(leaving.ReceiveSome(1).status, 200);
  }
  server_.reset();
}

// ---- plain files

TEST_F(Http, ASessionFileGoesUpAndComesBackAsItWas) {
  CreateMachine();
  const std::string text = SessionText("BX");
  const HttpAnswer first = Fetch(port(), "POST", "/v1/machines/mt/sessions", {}, text);
  ASSERT_EQ(first.status, 201) << first.body;
  const v1::Session session = FromJson<v1::Session>(first.body);
  EXPECT_EQ(session.state(), v1::SESSION_STATE_COMPLETE);
  EXPECT_EQ(session.readings(), 720);
  EXPECT_EQ(first.Field("location"), absl::StrCat("/v1/sessions/", session.session_id()));
  // Sent again it is the one that is there.
  const HttpAnswer again = Fetch(port(), "POST", "/v1/machines/mt/sessions", {}, text);
  EXPECT_EQ(again.status, 200) << again.body;
  EXPECT_EQ(again.body, first.body);
  const HttpAnswer down = Fetch(port(), "GET", first.Field("location"));
  EXPECT_EQ(down.status, 200);
  EXPECT_EQ(down.body, text);
  EXPECT_EQ(down.Field("etag"), "\"" + session.sha256() + "\"");
  const HttpAnswer unchanged = Fetch(port(), "GET", first.Field("location"), {{"If-None-Match", down.Field("etag")}});
  EXPECT_EQ(unchanged.status, 304);
  EXPECT_EQ(unchanged.body, "");
}

TEST_F(Http, MetricsCountWhatHappened) {
  CreateMachine();
  StoreSession("BX", 720);
  CallJson(port(), "Machines/GetMachine", R"({"machineId": "none"})");
  const HttpAnswer answer = Fetch(port(), "GET", "/metrics");
  ASSERT_EQ(answer.status, 200) << answer.body;
  EXPECT_EQ(answer.Field("content-type"), "text/plain; version=0.0.4; charset=utf-8");
  EXPECT_THAT(answer.body, AllOf(HasSubstr("axiscal_readings_stored_total 720\n"),
                                 HasSubstr(R"(grpc_server_handled_total{grpc_code="NotFound",grpc_method="GetMachine",)"
                                           R"(grpc_service="axiscal.v1.Machines",grpc_type="unary"} 1)"),
                                 HasSubstr("axiscal_store_up 1\n"), HasSubstr(R"(axiscal_jobs{state="queued"} 0)"),
                                 HasSubstr("axiscal_database_bytes "), HasSubstr("axiscal_disk_free_bytes "),
                                 HasSubstr("process_resident_memory_bytes ")));
  EXPECT_EQ(Fetch(port(), "POST", "/metrics").status, 405);
}

TEST_F(Http, ASessionFileThatIsWrongIsRefusedWithItsPlace) {
  CreateMachine();
  std::string text = SessionText("BX");
  text.replace(text.rfind("\n", text.size() - 2) + 1, 1, "x");
  const HttpAnswer wrong = Fetch(port(), "POST", "/v1/machines/mt/sessions", {}, text);
  EXPECT_EQ(wrong.status, 400);
  EXPECT_THAT(wrong.body, AllOf(HasSubstr("SESSION_INVALID"), HasSubstr("session file: line "), HasSubstr("column 1")));
  EXPECT_EQ(Fetch(port(), "POST", "/v1/machines/none/sessions", {}, SessionText("BX")).status, 404);
  const HttpAnswer other =
      Fetch(port(), "POST", "/v1/machines/mt/sessions", {{"Idempotency-Key", "k"}}, SessionText("A"));
  EXPECT_EQ(other.status, 201);
  const HttpAnswer reused =
      Fetch(port(), "POST", "/v1/machines/mt/sessions", {{"Idempotency-Key", "\"k\""}}, SessionText("B"));
  EXPECT_EQ(reused.status, 400);
  EXPECT_THAT(reused.body, HasSubstr("REQUEST_ID_REUSED"));
  EXPECT_EQ(Fetch(port(), "GET", "/v1/sessions/99").status, 404);
  EXPECT_EQ(Fetch(port(), "PUT", "/v1/machines/mt/sessions").status, 405);
  // Nothing of it was stored.
  EXPECT_EQ(FromJson<v1::ListSessionsResponse>(CallJson(port(), "Ingest/ListSessions", "{}").body).sessions_size(), 1);
  HttpConnection chunked(port());
  chunked.Send(
      "POST /v1/machines/mt/sessions HTTP/1.1\r\nHost: localhost\r\nTransfer-Encoding: chunked\r\n\r\n0\r\n\r\n");
  EXPECT_EQ(chunked.Receive().status, 411);
}

// A form as curl sends it.
HttpAnswer PutForm(int port, const std::string& path, const HttpFields& fields,
                   const std::vector<std::pair<std::string, std::string>>& parts) {
  std::string body;
  for (const auto& [disposition, text] : parts)
    body += "--b\r\nContent-Disposition: form-data; " + disposition + "\r\n\r\n" + text + "\r\n";
  return Fetch(port, "POST", path, With(fields, "Content-Type", "multipart/form-data; boundary=b"), body + "--b--\r\n");
}

std::vector<std::pair<std::string, std::string>> BallbarLog(const std::string& log, const std::string& machine = "mt") {
  return {{"name=\"log\"; filename=\"bar.log\"", log},
          {"name=\"template\"", "line: {t_s} {dL_mm}\n"},
          {"name=\"plan\"; filename=\"BX.csv\"", *session::WriteSession(testing::BallbarSession(machine, "BX", 3))}};
}

TEST_F(Http, ALogGoesUpAsAFormAndIsReducedByTheServer) {
  ASSERT_NO_FATAL_FAILURE(CreateMachine());
  const std::string log = "0.0 0.001\n0.1 0.002\n0.2 0.003\n", path = "/v1/machines/mt/logs";
  const HttpAnswer first = PutForm(port(), path, {}, BallbarLog(log));
  ASSERT_EQ(first.status, 201) << first.body;
  const auto stored = FromJson<v1::PutLogResponse>(first.body);
  EXPECT_EQ(first.Field("location"), absl::StrCat("/v1/sessions/", stored.session().session_id()));
  EXPECT_EQ(stored.session().readings(), 3);
  EXPECT_EQ(Fetch(port(), "GET", absl::StrCat("/v1/programs/", stored.log().program_id())).body, log);
  EXPECT_THAT(Fetch(port(), "GET", first.Field("location")).body, HasSubstr("# log: bar.log\n"));
  EXPECT_EQ(PutForm(port(), path, {}, BallbarLog(log)).status, 200) << "it was there";
  const HttpAnswer wrong = PutForm(port(), path, {}, BallbarLog("0.0 0.001\n0.1 high\n0.2 0.003\n"));
  EXPECT_EQ(wrong.status, 400);
  EXPECT_THAT(wrong.body, AllOf(HasSubstr("LOG_INVALID"), HasSubstr(R"("line":"2")"), HasSubstr(R"("column":"5")")));
  EXPECT_EQ(PutForm(port(), path, {}, {{"name=log", log}}).status, 400) << "no template";
  EXPECT_EQ(PutForm(port(), path, {}, {{"name=log", log}, {"name=template", "dprnt"}, {"name=x", ""}}).status, 400);
  EXPECT_EQ(Fetch(port(), "POST", path, {{"Content-Type", "text/plain"}}, log).status, 400);
  EXPECT_EQ(Fetch(port(), "GET", path).status, 405);
  EXPECT_EQ(PutForm(port(), "/v1/machines/none/logs", {}, BallbarLog(log)).status, 404);
}

TEST_F(Http, AProgramGoesUpAndComesDownFromAnyByteOn) {
  const std::string bytes = "N10 G01 X1.0 (\xfc)\r\n" + std::string(600'000, 'x') + "\n";
  const HttpAnswer put = Fetch(port(), "POST", "/v1/programs/part%201.nc", {}, bytes);
  ASSERT_EQ(put.status, 201) << put.body;
  const v1::Program program = FromJson<v1::Program>(put.body);
  EXPECT_EQ(program.name(), "part 1.nc");
  EXPECT_EQ(program.sha256(), base::Sha256Hex(bytes));
  const std::string place = put.Field("location");
  const HttpAnswer whole = Fetch(port(), "GET", place);
  EXPECT_EQ(whole.status, 200);
  EXPECT_EQ(whole.Field("content-length"), absl::StrCat(bytes.size()));
  EXPECT_EQ(whole.Field("content-disposition"), "attachment; filename*=UTF-8''part%201.nc");
  EXPECT_TRUE(whole.body == bytes);
  const std::string etag = whole.Field("etag");
  EXPECT_EQ(Fetch(port(), "GET", place, {{"If-None-Match", "\"x\", " + etag}}).status, 304);
  const HttpAnswer part = Fetch(port(), "GET", place, {{"Range", "bytes=100000-"}, {"If-Range", etag}});
  EXPECT_EQ(part.status, 206);
  EXPECT_EQ(part.Field("content-range"), absl::StrCat("bytes 100000-", bytes.size() - 1, "/", bytes.size()));
  EXPECT_TRUE(part.body == bytes.substr(100'000));
  // Of another program than the caller has begun to take, it is sent whole.
  EXPECT_EQ(Fetch(port(), "GET", place, {{"Range", "bytes=100000-"}, {"If-Range", "\"x\""}}).body.size(), bytes.size());
  EXPECT_EQ(Fetch(port(), "GET", place, {{"Range", absl::StrCat("bytes=", bytes.size(), "-")}}).status, 416);
  EXPECT_EQ(Fetch(port(), "GET", place, {{"Range", "bytes=1-2"}}).status, 200);
  EXPECT_EQ(Fetch(port(), "POST", "/v1/programs/a%2Fb.nc", {}, "x").status, 400);
  EXPECT_EQ(Fetch(port(), "GET", "/v1/programs/99").status, 404);
}

// ---- who calls

TEST_F(Http, APageOfAnotherOriginIsRefusedWhereNobodyIsAsked) {
  for (const HttpFields& fields :
       {HttpFields{{"Origin", "https://evil.example"}}, HttpFields{{"Origin", "null"}},
        HttpFields{{"Sec-Fetch-Site", "cross-site"}}, HttpFields{{"Host", "evil.example"}}}) {
    const HttpAnswer answer = CallJson(port(), "Admin/GetServerInfo", "{}", fields);
    EXPECT_EQ(answer.status, 403) << answer.body;
    EXPECT_THAT(answer.body, HasSubstr("ORIGIN_REFUSED"));
    EXPECT_EQ(answer.Field("access-control-allow-origin"), "");
    EXPECT_EQ(Fetch(port(), "POST", "/v1/programs/a.nc", fields, "x").status, 403);
  }
  const HttpFields own = {{"Host", absl::StrCat("127.0.0.1:", port())},
                          {"Origin", absl::StrCat("http://127.0.0.1:", port())}};
  EXPECT_EQ(CallJson(port(), "Admin/GetServerInfo", "{}", own).status, 200);
}

class HttpAccess : public Http {
 protected:
  void SetUp() override {
    storage::SqliteOptions sqlite;
    sqlite.path = dir_.File("axiscal.db");
    auto opened = storage::OpenSqlite(sqlite);
    ASSERT_OK(opened);
    storage::Database& database = **opened;
    ASSERT_OK(database.CreateMachine(MachineId("mt"), MachineJson("mt"), kAdmin));
    ASSERT_OK(database.CreateMachine(MachineId("other"), MachineJson("other"), kAdmin));
    Add(database, "root", {Role::kAdmin, {}});
    Add(database, "ann", {Role::kApprover, {}});
    Add(database, "bob", {Role::kTechnician, {}});
    Add(database, "cell", {Role::kCell, {records::Scope::Kind::kMachine, "mt"}});
    Add(database, "other-cell", {Role::kCell, {records::Scope::Kind::kMachine, "other"}});
    Add(database, "viewer", {Role::kViewer, {records::Scope::Kind::kMachine, "mt"}});
    opened->reset();
    StartAsking({});
  }
  void StartAsking(server::ServerOptions options) {
    options.asks_identity = true;
    options.ask_again = std::chrono::milliseconds(20);
    Start(options);
  }
  void Add(storage::Database& database, const std::string& name, const records::Grant& grant) {
    ASSERT_OK(database.CreatePrincipal(name, "", kAdmin));
    ASSERT_OK(database.ChangeRole(name, grant, true, kAdmin));
    tokens_[name] = access::NewToken();
    ASSERT_OK(database.CreateToken({name, access::HashOfToken(tokens_[name]), "", {}}, kAdmin));
  }
  HttpFields As(const std::string& name, HttpFields fields = {}) const {
    return With(std::move(fields), "Authorization", "Bearer " + tokens_.at(name));
  }

  static inline const storage::Caller kAdmin = {"setup", ""};
  std::map<std::string, std::string> tokens_;
};

TEST_F(HttpAccess, TheSameGateDecides) {
  const auto status = [&](const std::string& name, const std::string& method, const std::string& json) {
    return CallJson(port(), method, json, name.empty() ? HttpFields() : As(name)).status;
  };
  EXPECT_EQ(status("", "Machines/GetMachine", R"({"machineId": "mt"})"), 401);
  EXPECT_EQ(status("viewer", "Machines/GetMachine", R"({"machineId": "mt"})"), 200);
  EXPECT_EQ(status("viewer", "Machines/GetMachine", R"({"machineId": "other"})"), 404);
  EXPECT_EQ(status("viewer", "Machines/DeleteMachine", R"({"machineId": "mt", "etag": "1"})"), 403);
  // As over gRPC, what is outside the scope is answered as what does not exist.
  for (const std::string name : {"other", "none"}) {
    EXPECT_THAT(CallJson(port(), "Machines/GetMachine", R"({"machineId": ")" + name + R"("})", As("viewer")).body,
                HasSubstr("\"message\":\"machine " + name + " does not exist\""));
  }
  const HttpAnswer forged = CallJson(port(), "Machines/GetMachine", R"({"machineId": "mt"})",
                                     {{"Authorization", "Bearer axt_forged"}, {"axiscal-user", "ann"}});
  EXPECT_EQ(forged.status, 401);
  EXPECT_THAT(forged.body, HasSubstr("TOKEN_INVALID"));
  // Two of them are none.
  HttpConnection twice(port());
  twice.Send("POST " + std::string(kGetServerInfo) +
             " HTTP/1.1\r\nHost: localhost\r\nContent-Type: application/json\r\nContent-Length: 2\r\nAuthorization: "
             "Bearer " +
             tokens_["root"] + "\r\nAuthorization: Bearer " + tokens_["cell"] + "\r\n\r\n{}");
  EXPECT_EQ(twice.Receive().status, 401);
  // A stream's says so at its end.
  EXPECT_THAT(EndOf(Fetch(port(), "POST", kWatchJob, kJsonStream, Envelope(0, R"({"jobId": "1"})"))),
              HasSubstr("unauthenticated"));
}

TEST_F(HttpAccess, FilesNeedTheRolesOfTheirCalls) {
  const std::string text = SessionText("BX");
  const HttpAnswer put = Fetch(port(), "POST", "/v1/machines/mt/sessions", As("cell"), text);
  ASSERT_EQ(put.status, 201) << put.body;
  EXPECT_EQ(FromJson<v1::Session>(put.body).created_by(), "cell");
  EXPECT_EQ(Fetch(port(), "POST", "/v1/machines/mt/sessions", As("viewer"), text).status, 403);
  EXPECT_EQ(Fetch(port(), "POST", "/v1/machines/other/sessions", As("cell"), text).status, 404);
  // A log: by the cell alone; whoever sees the machine sees what was kept.
  const auto log = BallbarLog("0.0 0.001\n0.1 0.002\n0.2 0.003\n");
  const HttpAnswer reduced = PutForm(port(), "/v1/machines/mt/logs", As("cell"), log);
  ASSERT_EQ(reduced.status, 201) << reduced.body;
  EXPECT_EQ(PutForm(port(), "/v1/machines/mt/logs", As("viewer"), log).status, 403);
  EXPECT_EQ(PutForm(port(), "/v1/machines/other/logs", As("cell"), log).status, 404);
  const std::string raw = absl::StrCat("/v1/programs/", FromJson<v1::PutLogResponse>(reduced.body).log().program_id());
  EXPECT_EQ(Fetch(port(), "GET", raw, As("viewer")).status, 200);
  EXPECT_EQ(Fetch(port(), "GET", raw, As("cell")).status, 403);
  EXPECT_EQ(Fetch(port(), "GET", put.Field("location"), As("cell")).status, 403);
  EXPECT_EQ(Fetch(port(), "GET", put.Field("location"), As("viewer")).body, text);
  EXPECT_EQ(Fetch(port(), "GET", "/v1/calibrations/1/report", As("viewer")).status, 404);
  EXPECT_EQ(Fetch(port(), "GET", "/v1/calibrations/1/report").status, 401);
  EXPECT_EQ(Fetch(port(), "POST", "/v1/calibrations/1/report", As("viewer"), "").status, 405);
  EXPECT_EQ(Fetch(port(), "POST", "/v1/programs/a.nc", As("viewer"), "x").status, 403);
  EXPECT_EQ(Fetch(port(), "POST", "/v1/programs/a.nc", As("root"), "x").status, 201);
  // Nobody's file is not even taken in.
  HttpConnection nobody(port());
  nobody.Send("POST /v1/machines/mt/sessions HTTP/1.1\r\nHost: localhost\r\nContent-Length: 100000000\r\n\r\n");
  EXPECT_EQ(nobody.Receive().status, 401);
}

// Neither status, fields nor words of an answer tell what is hidden from what is not there.
TEST_F(HttpAccess, AFileOutsideTheScopeIsAnsweredAsOneThatIsNowhere) {
  const std::string text = absl::StrReplaceAll(SessionText("BX"), {{"# machine: mt\n", "# machine: other\n"}});
  const HttpAnswer session = Fetch(port(), "POST", "/v1/machines/other/sessions", As("other-cell"), text);
  ASSERT_EQ(session.status, 201) << session.body;
  const HttpAnswer log = PutForm(port(), "/v1/machines/other/logs", As("other-cell"),
                                 BallbarLog("0.0 0.001\n0.1 0.002\n0.2 0.003\n", "other"));
  ASSERT_EQ(log.status, 201) << log.body;
  const int64_t kept = FromJson<v1::PutLogResponse>(log.body).log().program_id();
  const auto told = [](HttpAnswer answer, const std::string& name) {
    answer.fields.erase("date");
    std::string all = absl::StrCat(answer.status, "\n");
    for (const auto& [field, value] : answer.fields)
      if (field != "content-length") absl::StrAppend(&all, field, ": ", value, "\n");
    // What was asked for stands in the words, and in the facts, whose bytes stand beside them as text.
    absl::StrAppend(&all, std::regex_replace(answer.body, std::regex("\"value\":\"[^\"]*\""), ""));
    return absl::StrReplaceAll(all, {{name, "#"}});
  };
  const auto compare = [&](const std::string& method, const std::string& before, const std::string& hidden,
                           const std::string& missing, const std::string& after, const std::string& who) {
    const auto ask = [&](const std::string& name) {
      return told(Fetch(port(), method, before + name + after, As(who), method == "POST" ? text : ""), name);
    };
    EXPECT_EQ(ask(hidden), ask(missing)) << before << after;
    EXPECT_EQ(ask(hidden).substr(0, 4), "404\n") << before << after;
  };
  const std::string session_id = absl::StrCat(FromJson<v1::Session>(session.body).session_id());
  compare("GET", "/v1/sessions/", session_id, "777001", "", "viewer");
  compare("GET", "/v1/programs/", absl::StrCat(kept), "777002", "", "viewer");
  compare("POST", "/v1/machines/", "other", "nowhere", "/sessions", "cell");
  compare("POST", "/v1/machines/", "other", "nowhere", "/rewrite?calibration=1", "viewer");
  for (const std::string name : {"other", "nowhere"}) {
    const HttpAnswer answer = PutForm(port(), "/v1/machines/" + name + "/logs", As("cell"),
                                      BallbarLog("0.0 0.001\n0.1 0.002\n0.2 0.003\n", "other"));
    EXPECT_EQ(answer.status, 404);
    EXPECT_THAT(answer.body, HasSubstr("machine " + name + " does not exist"));
  }
}

TEST_F(HttpAccess, NothingLargeIsReadOfNobody) {
  const std::string head =
      "POST " + std::string(kGetServerInfo) + " HTTP/1.1\r\nHost: localhost\r\nContent-Type: application/json\r\n";
  for (const std::string shown : {"", "Authorization: Bearer axt_forged\r\n"}) {
    HttpConnection announced(port());
    announced.Send(head + shown + "Content-Length: 10000000\r\n\r\n");
    const HttpAnswer answer = announced.Receive();
    EXPECT_EQ(answer.status, 401);
    EXPECT_THAT(answer.body, HasSubstr(shown.empty() ? "IDENTITY_MISSING" : "TOKEN_INVALID"));
    HttpConnection chunked(port());
    chunked.Send(head + shown + "Transfer-Encoding: chunked\r\n\r\n10000\r\n" + std::string(0x10000, ' ') + "\r\n");
    EXPECT_EQ(chunked.Receive().status, 401);
  }
  HttpConnection stream(port());
  stream.Send("POST " + std::string(kWatchJob) +
              " HTTP/1.1\r\nHost: localhost\r\nContent-Type: application/connect+json\r\nContent-Length: 10000000"
              "\r\n\r\n");
  EXPECT_THAT(EndOf(stream.Receive()), HasSubstr("IDENTITY_MISSING"));
  // Of somebody it is.
  EXPECT_EQ(
      CallJson(port(), "Machines/GetMachine", R"({"machineId": "mt")" + std::string(100'000, ' ') + "}", As("viewer"))
          .status,
      200);
  EXPECT_THAT(CallJson(port(), "Machines/GetMachine", R"({"machineId": "mt")" + std::string(20'000'000, ' ') + "}",
                       As("viewer"))
                  .body,
              HasSubstr("MESSAGE_TOO_LARGE"));
}

// Bodies that are half sent and go no further: bob's fill the room that he may have, and others still have theirs.
TEST_F(HttpAccess, OneCallerCannotHoldTheMemoryOfAll) {
  server::ServerOptions options;
  options.http_bytes = 1 << 20;
  StartAsking(options);
  const std::string head = absl::StrCat("POST /axiscal.v1.Machines/GetMachine HTTP/1.1\r\nHost: localhost\r\n",
                                        "Content-Type: application/json\r\nContent-Length: 4000000\r\n");
  std::vector<HttpConnection> half_sent;
  for (int i = 0; i < 40; ++i) {
    HttpConnection& connection = half_sent.emplace_back(port());
    connection.Send(head + "Authorization: Bearer " + tokens_["bob"] + "\r\n\r\n" + std::string(50'000, ' '));
  }
  HttpConnection one_more(port());
  one_more.Send(head + "Authorization: Bearer " + tokens_["bob"] + "\r\n\r\n" + std::string(1'500'000, ' '));
  const HttpAnswer refused = one_more.Receive();
  EXPECT_EQ(refused.status, 429) << refused.body;
  EXPECT_THAT(refused.body, HasSubstr("QUEUE_FULL"));
  for (int i = 0; i < 5; ++i) {
    const HttpAnswer answer =
        CallJson(port(), "Machines/GetMachine", R"({"machineId": "mt")" + std::string(5'000, ' ') + "}", As("viewer"));
    EXPECT_EQ(answer.status, 200) << answer.body;
  }
}

// Requests that last: those that bob may have are under way, and others are served.
TEST_F(HttpAccess, OneCallerCannotHoldTheRequestsOfAll) {
  server::ServerOptions options;
  options.http_requests = 16;
  StartAsking(options);
  std::vector<HttpConnection> streams;
  int under_way = 0;
  for (int status = 200; status == 200 && under_way < 40;) {
    HttpConnection& stream = streams.emplace_back(port());
    stream.SendRequest("POST", "/axiscal.v1.Events/WatchEvents", As("bob", kJsonStream), Envelope(0, "{}"));
    status = stream.ReceiveSome(0).status;
    under_way += status == 200 ? 1 : 0;
    EXPECT_THAT(status, ::testing::AnyOf(200, 503));
  }
  EXPECT_EQ(under_way, 14);
  EXPECT_EQ(CallJson(port(), "Machines/GetMachine", R"({"machineId": "mt"})", As("viewer")).status, 200);
}

// Connections that have shown nobody: beyond what they may have the first gives way, and nobody's who is known.
TEST_F(HttpAccess, StrangersCannotHoldAllConnections) {
  server::ServerOptions options;
  options.strangers = 4;
  StartAsking(options);
  HttpConnection known(port());
  const auto call = [&] {
    known.SendRequest("POST", "/axiscal.v1.Machines/GetMachine", As("viewer", kJson), R"({"machineId": "mt"})");
    return known.Receive().status;
  };
  EXPECT_EQ(call(), 200);
  std::vector<HttpConnection> strangers;
  for (int i = 0; i < 10; ++i) strangers.emplace_back(port());
  for (size_t i = 0; i < 6; ++i) EXPECT_TRUE(strangers[i].WaitForClose()) << i;
  EXPECT_EQ(call(), 200);
  strangers.back().SendRequest("POST", "/axiscal.v1.Machines/GetMachine", As("viewer", kJson),
                               R"({"machineId": "mt"})");
  EXPECT_EQ(strangers.back().Receive().status, 200);
}

TEST_F(HttpAccess, MetricsAreForViewersOfAllMachines) {
  EXPECT_EQ(Fetch(port(), "GET", "/metrics").status, 401);
  EXPECT_EQ(Fetch(port(), "GET", "/metrics", As("viewer")).status, 403);  // of one machine
  EXPECT_EQ(Fetch(port(), "GET", "/metrics", As("bob")).status, 200);     // a technician of all is their viewer, too
}

TEST_F(HttpAccess, ABrowserSignsInByACookie) {
  const std::string origin = "http://localhost";
  const HttpFields page = {{"Content-Type", "application/json"}, {"Origin", origin}};
  const HttpAnswer in = Fetch(port(), "POST", "/sign-in", page, R"({"token": ")" + tokens_["viewer"] + R"("})");
  ASSERT_EQ(in.status, 200) << in.body;
  EXPECT_EQ(in.body, R"({"name":"viewer"})");
  const std::string set = in.Field("set-cookie");
  EXPECT_THAT(set, AllOf(HasSubstr("HttpOnly"), HasSubstr("SameSite=Strict"), Not(HasSubstr(tokens_["viewer"]))));
  const std::string cookie = set.substr(0, set.find(';'));
  const auto call = [&](HttpFields fields) {
    fields["Cookie"] = "a=b; " + cookie;
    return CallJson(port(), "Machines/GetMachine", R"({"machineId": "mt"})", fields).status;
  };
  EXPECT_EQ(call({{"Origin", origin}}), 200);
  EXPECT_EQ(call({{"Sec-Fetch-Site", "same-origin"}}), 200);
  EXPECT_EQ(call({}), 403);
  EXPECT_EQ(call({{"Origin", "http://evil.example"}}), 403);
  EXPECT_EQ(call({{"Origin", "http://evil.example"}, {"Sec-Fetch-Site", "cross-site"}}), 403);
  // What only reads needs none: no other page gets to see it.
  EXPECT_EQ(Fetch(port(), "GET", "/v1/sessions/99", {{"Cookie", cookie}}).status, 404);
  EXPECT_EQ(Fetch(port(), "GET", "/v1/sessions/99").status, 401);
  EXPECT_EQ(Fetch(port(), "POST", "/sign-in", page, R"({"token": "axt_wrong"})").status, 401);
  EXPECT_EQ(Fetch(port(), "POST", "/sign-in", page, "{}").status, 400);
  EXPECT_EQ(Fetch(port(), "POST", "/sign-in", {{"Origin", origin}}, "{}").status, 415);
  EXPECT_EQ(Fetch(port(), "GET", "/sign-in?token=" + tokens_["viewer"]).status, 405);
  EXPECT_EQ(Fetch(port(), "POST", "/sign-out", With(page, "Cookie", cookie), "{}").status, 204);
  EXPECT_EQ(call({{"Origin", origin}}), 401);
}

// What is refused before it is a call of the API is denied all the same.
TEST_F(HttpAccess, WhatIsDeniedAtTheDoorIsInTheAudit) {
  const HttpFields page = {{"Content-Type", "application/json"}, {"Origin", "http://localhost"}};
  for (int tries = 0; tries < 3; ++tries)
    EXPECT_EQ(Fetch(port(), "POST", "/sign-in", page, R"({"token": "axt_wrong"})").status, 401);
  EXPECT_EQ(Fetch(port(), "POST", "/sign-in", page, "{}").status, 400);  // a slip, no attempt
  EXPECT_EQ(Fetch(port(), "POST", "/sign-in", With(page, "Origin", "http://evil.example"), "{}").status, 403);
  EXPECT_EQ(Fetch(port(), "POST", "/v1/machines/mt/sessions", {}, "x").status, 401);
  server_.reset();  // writes what was gathered and is not written yet
  storage::SqliteOptions sqlite;
  sqlite.path = dir_.File("axiscal.db");
  const auto opened = storage::OpenSqlite(sqlite);
  ASSERT_OK(opened);
  const auto audit = (*opened)->ListAudit({}, {});
  ASSERT_OK(audit);
  std::map<std::string, int> calls;
  for (const storage::AuditEntry& entry : audit->rows) {
    if (entry.action.rfind("denied ", 0) != 0) continue;
    EXPECT_EQ(entry.principal, "");
    EXPECT_EQ(entry.peer, "ipv4:127.0.0.1");
    EXPECT_EQ(entry.resource, "");
    const size_t comma = entry.detail.find(", ");
    calls[absl::StrCat(entry.action, " ", entry.outcome, " ", entry.detail.substr(0, comma))] +=
        std::atoi(entry.detail.substr(comma + 2).c_str());
  }
  EXPECT_THAT(calls, UnorderedElementsAre(Pair("denied /sign-in UNAUTHENTICATED TOKEN_INVALID", 3),
                                          Pair("denied /sign-in PERMISSION_DENIED ORIGIN_REFUSED", 1),
                                          Pair("denied Ingest.CreateSession UNAUTHENTICATED IDENTITY_MISSING", 1)));
}

// Files of nobody, tokens that are tried, pages of others and what is no HTTP are calls of whoever is at that address.
TEST_F(HttpAccess, WhatIsRefusedAtTheDoorIsCountedAndFillsNoLog) {
  server::ServerOptions options;
  options.calls_per_second = 5;
  StartAsking(options);
  server::StartLog(server::LogFormat::kKeyValue);
  ::testing::internal::CaptureStderr();
  const HttpFields page = {{"Content-Type", "application/json"}, {"Origin", "http://localhost"}};
  const auto file = [&] { return Fetch(port(), "POST", "/v1/programs/x.nc"); };
  const auto sign_in = [&] { return Fetch(port(), "POST", "/sign-in", page, R"({"token": "axt_wrong"})"); };
  const auto foreign = [&] { return Fetch(port(), "GET", "/metrics", {{"Origin", "http://evil.example"}}); };
  constexpr int kTries = 300;
  int first_refused = kTries, let_in = 0;
  for (int i = 0; i < kTries; ++i) {
    const HttpAnswer answer = i % 3 == 0 ? file() : i % 3 == 1 ? sign_in() : foreign();
    if (answer.status == 429) {
      EXPECT_THAT(answer.body, HasSubstr("RATE_EXCEEDED"));
      first_refused = std::min(first_refused, i);
    } else {
      EXPECT_TRUE(answer.status == 401 || answer.status == 403) << answer.status << " " << answer.body;
      ++let_in;
    }
    HttpConnection no_http(port());
    no_http.Send("?\r\n\r\n");
    EXPECT_THAT(no_http.Receive().status, ::testing::AnyOf(400, 429));
  }
  server::StartLog(server::LogFormat::kNone);
  const std::string log = ::testing::internal::GetCapturedStderr();
  EXPECT_LT(first_refused, kTries);
  const auto lines = std::count(log.begin(), log.end(), '\n');
  EXPECT_LT(lines, kTries) << let_in << " were let in";
  EXPECT_THAT(log, HasSubstr("event=http_refused"));
}

// docs/http.md shows what a cell, a technician and an approver do by curl alone: it is done.
TEST_F(HttpAccess, ThePagesExampleWorks) {
  const absl::StatusOr<std::string> page = base::ReadFile(base::SourcePath("/docs/http.md"), 1 << 20);
  ASSERT_OK(page);
  const std::string fence = "```sh\n";
  const size_t begin = page->find(fence) + fence.size();
  const std::string script = page->substr(begin, page->find("```", begin) - begin);
  const auto write = [&](const std::string& name, const std::string& text) {
    ASSERT_OK(base::WriteFileAtomically(dir_.File(name), text));
  };
  for (const char* name : {"cell", "bob", "ann"}) write(std::string(name) + ".token", tokens_.at(name) + "\n");
  write("tuesday.csv", SessionText("BX"));
  const auto log = BallbarLog("0.0 0.001\n0.1 0.002\n0.2 0.003\n");
  write("bar.log", log[0].second);
  write("bar.txt", log[1].second);
  write("bar.csv", log[2].second);
  write("part.nc", "%\nG90 G21\nN10 G01 X100.0000 Y0.0000 Z421.9000 B0.0000 C0.0000 F1000\n%\n");
  write("run.sh", absl::StrCat("set -e -o pipefail\nAXISCAL=http://localhost:", port(), "\n", script));
  const std::string command = "cd '" + dir_.File("") + "' && bash run.sh > seen.txt 2>&1";
  const int status = std::system(command.c_str());
  const std::string seen = *base::ReadFile(dir_.File("seen.txt"), 1 << 20);
  ASSERT_EQ(status, 0) << seen;
  EXPECT_THAT(seen, HasSubstr("JOB_STATE_SUCCEEDED"));
  EXPECT_THAT(seen, HasSubstr(R"("kind":"log")"));
  EXPECT_EQ(*base::ReadFile(dir_.File("copy.csv"), 1 << 20), SessionText("BX"));
  EXPECT_THAT(*base::ReadFile(dir_.File("corrected.nc"), 1 << 20), HasSubstr("X100.0120 Y-0.0050 Z421.9000"));
  EXPECT_EQ(*base::ReadFile(dir_.File("at-once.nc"), 1 << 20), *base::ReadFile(dir_.File("corrected.nc"), 1 << 20));
  EXPECT_THAT(*base::ReadFile(dir_.File("report.json"), 1 << 20), HasSubstr("\"tool_point_error\""));
  EXPECT_THAT(seen, HasSubstr("\"rmsAfterUm\""));
}

TEST_F(HttpAccess, AProgramThatCannotBeCorrectedComesBackAsAnError) {
  const auto rewrite = [&](const std::string& who, const std::string& params, const std::string& bytes,
                           const std::string& machine = "mt") {
    return Fetch(port(), "POST", "/v1/machines/" + machine + "/rewrite", With(As(who), "Axiscal-Params", params),
                 bytes);
  };
  const std::string program = "%\nG90 G21\nN10 G01 X100.0000 Y0.0000 Z421.9000 B0.0000 C0.0000 F1000\n%\n";
  const std::string tip = R"({"toolTipMm": [0, 0, -356.4]})";
  EXPECT_THAT(rewrite("bob", tip, program).body, HasSubstr("CALIBRATION_NOT_APPROVED"));
  EXPECT_EQ(rewrite("viewer", tip, program).status, 403);
  EXPECT_EQ(rewrite("bob", tip, program, "none").status, 404);
  EXPECT_THAT(rewrite("bob", "{", program).body, HasSubstr("Axiscal-Params"));
  EXPECT_THAT(rewrite("bob", R"({"toolTip": 1})", program).body, HasSubstr("MESSAGE_INVALID"));
  EXPECT_THAT(rewrite("bob", R"({"machineId": "other"})", program).body, HasSubstr("the path says 'mt'"));
  EXPECT_THAT(rewrite("bob", R"({"programId": 1})", program).body, HasSubstr("the program is the body"));
  EXPECT_THAT(rewrite("bob", "", program).body, HasSubstr("tool_tip_mm"));
  EXPECT_EQ(Fetch(port(), "GET", "/v1/machines/mt/rewrite", As("bob")).status, 405);
}

// By TLS the certificate says who calls; one of another authority is none.
TEST_F(HttpAccess, ByTlsACertificateSaysWhoCalls) {
  const std::string make = base::SourcePath("/deploy/make-certs");
  // Whether it ended well, and what it printed.
  const auto run = [&](const std::string& script) {
    const std::string command = "cd '" + dir_.File("") + "' && (" + script + ") > seen.txt 2>&1";
    const int status = std::system(command.c_str());
    return std::pair(status == 0, *base::ReadFile(dir_.File("seen.txt"), 1 << 20));
  };
  const auto [is_made, text] = run("set -e; for pki in pki other; do " + make + " $pki ca; " + make +
                                   " $pki client cell; done; " + make + " pki server localhost");
  ASSERT_TRUE(is_made) << text;
  server::ServerOptions options;
  options.tls = {dir_.File("pki/server/localhost.crt"), dir_.File("pki/server/localhost.key"), dir_.File("pki/ca.crt")};
  Start(options);
  const std::string url = absl::StrCat("https://localhost:", port());
  const std::string curl = "curl -sS -i --cacert pki/ca.crt -H 'Content-Type: application/json' ";
  const std::string who = curl + "-d '{}' " + url + "/axiscal.v1.Access/GetIdentity ";
  EXPECT_THAT(run(who + "--cert pki/client/cell.crt --key pki/client/cell.key").second,
              AllOf(HasSubstr("HTTP/1.1 200"), HasSubstr(R"("name":"cell")")));
  EXPECT_THAT(run(who).second, AllOf(HasSubstr("HTTP/1.1 401"), HasSubstr("IDENTITY_MISSING")));
  EXPECT_THAT(run(who + "-H 'Authorization: Bearer " + tokens_["ann"] + "'").second, HasSubstr(R"("name":"ann")"));
  const auto [is_let_in, as_other] = run(who + "--cert other/client/cell.crt --key other/client/cell.key");
  EXPECT_FALSE(is_let_in) << as_other;
  EXPECT_THAT(as_other, Not(HasSubstr("HTTP/1.1")));
  // The cookie goes by TLS only, and to this host.
  const std::string token = "-d '{\"token\": \"" + tokens_["ann"] + "\"}' ";
  EXPECT_THAT(run(curl + token + url + "/sign-in").second,
              AllOf(HasSubstr("Set-Cookie: __Host-axiscal="), HasSubstr("; Secure")));
}

TEST_F(HttpAccess, WhoIsRevokedIsCutOffInTheMidstOfAStream) {
  const HttpAnswer put = Fetch(port(), "POST", "/v1/machines/mt/sessions", As("cell"), SessionText("long", 10'000));
  ASSERT_EQ(put.status, 201) << put.body;
  const HttpAnswer created =
      CallJson(port(), "Jobs/CreateJob",
               absl::StrCat(R"({"requestId": "endless", "params": {"identify": {"machineId": "mt", "sessionIds": [)",
                            FromJson<v1::Session>(put.body).session_id(), R"(], "monteCarloRuns": 100000}}})"),
               As("root"));
  ASSERT_EQ(created.status, 200) << created.body;
  const int64_t job = FromJson<v1::CreateJobResponse>(created.body).job().job_id();
  HttpConnection watching(port());
  watching.SendRequest("POST", kWatchJob, As("viewer", kJsonStream), Envelope(0, JobRequest(job)));
  EXPECT_EQ(watching.ReceiveSome(1).status, 200);
  EXPECT_EQ(CallJson(port(), "Access/RevokePrincipal", R"({"name": "viewer"})", As("root")).status, 200);
  EXPECT_THAT(EndOf(watching.Receive()), HasSubstr("canceled"));
}

}  // namespace
}  // namespace axiscal
