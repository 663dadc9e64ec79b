#include "server/http/messages.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "axiscal/v1/history_service.pb.h"
#include "axiscal/v1/jobs_service.pb.h"
#include "core/base/error_detail.h"
#include "server/http/errors.h"
#include "server/http/exchange.h"

namespace axiscal::http {
namespace {

using ::testing::HasSubstr;
using ::testing::Not;

constexpr int kMost = 1 << 20;

std::string ReasonOf(const absl::StatusOr<std::string>& result) { return base::ErrorReason(result.status()); }

TEST(FindMethod, KnowsTheApiAndNothingElse) {
  v1::GetJobRequest linked;  // so that the descriptors are
  ASSERT_NE(FindMethod("/axiscal.v1.Jobs/GetJob"), nullptr);
  EXPECT_EQ(FindMethod("/axiscal.v1.Jobs/GetJob")->full_name(), "axiscal.v1.Jobs.GetJob");
  for (const char* path :
       {"/axiscal.v1.Jobs/getjob", "/axiscal.v1.Jobs/", "/axiscal.v1.Jobs", "/", "", "axiscal.v1.Jobs/GetJob",
        "/axiscal.v1./GetJob", "/grpc.health.v1.Health/Check", "/axiscal.v1.Jobs/GetJob/"}) {
    EXPECT_EQ(FindMethod(path), nullptr) << path;
  }
}

TEST(ContentTypeOf, TakesTheFourAndACharsetBehindJson) {
  EXPECT_EQ(NameOf(*ContentTypeOf("application/json")), "application/json");
  EXPECT_EQ(NameOf(*ContentTypeOf("Application/JSON; Charset=UTF-8")), "application/json");
  EXPECT_EQ(NameOf(*ContentTypeOf("application/proto")), "application/proto");
  EXPECT_EQ(NameOf(*ContentTypeOf("application/connect+proto")), "application/connect+proto");
  for (const char* name : {"", "application/foo", "image/jpeg", "text/plain", "application/proto; charset=utf-8",
                           "application/json; charset=latin1", "application/connect+xml", "application/grpc"}) {
    EXPECT_FALSE(ContentTypeOf(name)) << name;
  }
}

TEST(PartsOf, CountsValuesOfJsonOutsideItsTexts) {
  const auto& type = *v1::QueryDriftRequest::descriptor();
  const auto count = [&](const std::string& json) { return PartsOf(type, Codec::kJson, json); };
  EXPECT_EQ(count(""), 1);
  EXPECT_EQ(count(R"({"a": 1})"), 2);
  EXPECT_EQ(count("[1,2,3,4]"), 5);
  EXPECT_EQ(count(R"(["a,b,[{", 'c,",', "\",,,\\"])"), 4);  // marks in texts do not count, in either kind of quotes
  EXPECT_EQ(count(R"(["cut short ,,,)"), 2);
  v1::QueryDriftRequest request;
  request.add_symbols("EX0C");
  request.add_symbols("EY0C");
  EXPECT_EQ(PartsOf(type, Codec::kProto, request.SerializeAsString()), 2);
}

TEST(Messages, OfMorePartsThanMayBeAreRefused) {
  const auto& type = *v1::QueryDriftRequest::descriptor();
  v1::QueryDriftRequest request;
  std::string json = R"({"symbols": ["")";
  for (int i = 0; i < 200'001; ++i) {
    request.add_symbols("");
    json += R"(,"")";
  }
  json += "]}";
  for (const auto& [codec, bytes] : {std::pair(Codec::kJson, json), {Codec::kProto, request.SerializeAsString()}}) {
    EXPECT_EQ(ReasonOf(ToBinary(type, codec, bytes, kMost)), "MESSAGE_TOO_LARGE");
    EXPECT_GT(BytesToRead(type, codec, bytes), 200'000 * 40);
    EXPECT_LT(BytesToRead(type, codec, bytes), 128 << 20);
  }
}

TEST(Messages, AreReadStrictlyFromJson) {
  const auto& type = *v1::QueryDriftRequest::descriptor();
  const absl::StatusOr<std::string> binary =
      ToBinary(type, Codec::kJson, R"({"machineId": "mt", "to_utc_us": "9007199254740993"})", kMost);
  ASSERT_TRUE(binary.ok()) << binary.status();
  v1::QueryDriftRequest message;
  ASSERT_TRUE(message.ParseFromString(*binary));
  EXPECT_EQ(message.machine_id(), "mt");
  EXPECT_EQ(message.to_utc_us(), 9007199254740993);  // exact beyond 2^53
  // Neither an unknown field nor an unknown name of an enum value is taken for nothing.
  const absl::StatusOr<std::string> field = ToBinary(type, Codec::kJson, R"({"machine": "mt"})", kMost);
  EXPECT_EQ(ReasonOf(field), "MESSAGE_INVALID");
  EXPECT_THAT(field.status().message(), HasSubstr("QueryDriftRequest"));
  EXPECT_EQ(
      ReasonOf(ToBinary(*v1::ListJobsRequest::descriptor(), Codec::kJson, R"({"state": "JOB_STATE_NOPE"})", kMost)),
      "MESSAGE_INVALID");
  for (const char* text : {"", "[]", "{", "{\n\n\"machineId\": 1.5.2}"}) {
    const absl::StatusOr<std::string> wrong = ToBinary(type, Codec::kJson, text, kMost);
    EXPECT_EQ(ReasonOf(wrong), "MESSAGE_INVALID") << text;
    EXPECT_THAT(wrong.status().message(), Not(HasSubstr("\n"))) << text;
  }
}

TEST(Messages, OfNoBytesAreEmptyOnesInTheBinaryForm) {
  const auto& type = *v1::QueryDriftRequest::descriptor();
  EXPECT_EQ(*ToBinary(type, Codec::kProto, "", kMost), "");
  EXPECT_EQ(ReasonOf(ToBinary(type, Codec::kProto, "\xff\xff\xff", kMost)), "MESSAGE_INVALID");
  // An empty reply is an object for clients that parse it.
  EXPECT_EQ(*FromBinary(type, Codec::kJson, ""), "{}");
}

TEST(Messages, HaveALimit) {
  const auto& type = *v1::QueryDriftRequest::descriptor();
  const std::string text = R"({"machineId": ")" + std::string(100, 'm') + R"("})";
  EXPECT_EQ(ReasonOf(ToBinary(type, Codec::kJson, text, 101)), "MESSAGE_TOO_LARGE");
  EXPECT_TRUE(ToBinary(type, Codec::kJson, text, 102).ok());
}

TEST(Envelopes, HoldOneMessageInARequest) {
  EXPECT_EQ(Envelope(0, "ab"), std::string("\0\0\0\0\2ab", 7));
  EXPECT_EQ(Envelope(2, std::string(0x010203, 'x')).substr(0, 5), std::string("\2\0\1\2\3", 5));
  EXPECT_EQ(*OnlyMessage(Envelope(0, "ab")), "ab");
  EXPECT_EQ(*OnlyMessage(Envelope(0, "")), "");
  EXPECT_EQ(ReasonOf(OnlyMessage("")), "MESSAGE_COUNT");
  EXPECT_EQ(ReasonOf(OnlyMessage(Envelope(0, "a") + Envelope(0, "b"))), "MESSAGE_COUNT");
  EXPECT_EQ(OnlyMessage("").status().code(), absl::StatusCode::kUnimplemented);
  EXPECT_EQ(OnlyMessage(Envelope(1, "ab")).status().code(), absl::StatusCode::kInternal);
  for (const std::string& wrong : {Envelope(2, "{}"), Envelope(0, "ab").substr(0, 6), std::string("\0\0", 2)})
    EXPECT_EQ(ReasonOf(OnlyMessage(wrong)), "MESSAGE_INVALID");
}

TEST(Errors, HaveTheNamesAndNumbersOfTheProtocol) {
  // Source: https://connectrpc.com/docs/protocol, "Error Codes".
  const std::vector<std::pair<std::string, int>> codes = {{"canceled", 499},
                                                          {"unknown", 500},
                                                          {"invalid_argument", 400},
                                                          {"deadline_exceeded", 504},
                                                          {"not_found", 404},
                                                          {"already_exists", 409},
                                                          {"permission_denied", 403},
                                                          {"resource_exhausted", 429},
                                                          {"failed_precondition", 400},
                                                          {"aborted", 409},
                                                          {"out_of_range", 400},
                                                          {"unimplemented", 501},
                                                          {"internal", 500},
                                                          {"unavailable", 503},
                                                          {"data_loss", 500},
                                                          {"unauthenticated", 401}};
  for (size_t i = 0; i < codes.size(); ++i) {
    EXPECT_EQ(CodeName(static_cast<int>(i) + 1), codes[i].first);
    EXPECT_EQ(HttpStatusOf(static_cast<int>(i) + 1), codes[i].second) << codes[i].first;
  }
  EXPECT_EQ(CodeName(77), "unknown");
}

TEST(Errors, CarryTheDetailsOfGrpc) {
  const absl::Status status =
      base::Error(absl::StatusCode::kNotFound, "no machine 'm\xff'", {"MACHINE_NOT_FOUND", {{"machine", "m"}}});
  const Answer answer = ErrorAnswer(status);
  EXPECT_EQ(answer.status, 404);
  EXPECT_THAT(answer.body, HasSubstr(R"("code":"not_found")"));
  EXPECT_THAT(answer.body, HasSubstr(R"("type":"google.rpc.ErrorInfo")"));
  EXPECT_THAT(answer.body, HasSubstr(R"("reason":"MACHINE_NOT_FOUND")"));
  EXPECT_THAT(answer.body, Not(HasSubstr("=\"")));  // base64 without its padding
  EXPECT_EQ(EndOfStreamJson(nullptr), "{}");
  const google::rpc::Status bare = ErrorOf(grpc::Status(grpc::StatusCode::INTERNAL, "x"));
  EXPECT_EQ(EndOfStreamJson(&bare), R"({"error":{"code":"internal","message":"x"}})");
}

TEST(Targets, AreTakenApart) {
  std::string path;
  std::map<std::string, std::string> query;
  ASSERT_TRUE(SplitTarget("/v1/x%20y?a=b%26c&d", &path, &query));
  EXPECT_EQ(path, "/v1/x%20y");
  EXPECT_EQ(query, (std::map<std::string, std::string>{{"a", "b&c"}, {"d", ""}}));
  EXPECT_FALSE(SplitTarget("http://host/x", &path, &query));
  EXPECT_FALSE(SplitTarget("/x?a=%4", &path, &query));
  EXPECT_EQ(*PercentDecoded("a%2fB%2F"), "a/B/");
  EXPECT_FALSE(PercentDecoded("%zz"));
}

}  // namespace
}  // namespace axiscal::http
