// Streams as they must not be: every one is refused with its reason, and the session stays open, never half complete.
#include "core/base/error_detail.h"
#include "tests/end_to_end/testing/fixture.h"
#include "tests/end_to_end/testing/raw_upload.h"

namespace axiscal {
namespace {

using testing::BallbarSession;
using testing::FieldOf;
using testing::MachineJson;
using testing::RawResult;
using testing::ReasonOf;
using testing::SendAll;

constexpr int kChunkReadings = 100;

class UploadFaults : public testing::EndToEnd {
 protected:
  void SetUp() override {
    EndToEnd::SetUp();
    ASSERT_OK(client().CreateMachine(MachineJson("mt")));
    stub_ = v1::Ingest::NewStub(channel());
    grpc::ClientContext context;
    v1::CreateSessionResponse created;
    ASSERT_TRUE(stub_->CreateSession(&context, testing::CreateRequest("mt", "id-1", session_), &created).ok());
    id_ = created.session().session_id();
    messages_ = testing::UploadMessages(id_, session_, kChunkReadings);
  }

  v1::Session Stored() {
    grpc::ClientContext context;
    v1::GetSessionRequest request;
    request.set_session_id(id_);
    v1::GetSessionResponse response;
    EXPECT_TRUE(stub_->GetSession(&context, request, &response).ok());
    return response.session();
  }

  const session::Session session_ = BallbarSession("mt", "BX", 10 * kChunkReadings);
  std::unique_ptr<v1::Ingest::Stub> stub_;
  int64_t id_ = 0;
  std::vector<v1::UploadRequest> messages_;  // header, chunks 0 to 9, finish
};

TEST_F(UploadFaults, WellFormedMessagesComplete) {
  const RawResult result = SendAll(*stub_, messages_);
  EXPECT_TRUE(result.status.ok()) << result.status.error_message();
  EXPECT_TRUE(result.completed());
  EXPECT_EQ(Stored().state(), v1::SESSION_STATE_COMPLETE);
}

TEST_F(UploadFaults, AMalformedMessageDoesNotComplete) {
  std::vector<std::string> bytes;
  for (const v1::UploadRequest& message : messages_) bytes.push_back(message.SerializeAsString());
  bytes[4] = "\x0a\xff\xff\xff\xff";  // chunk 3: a length that runs past the end
  const grpc::Status once = testing::SendBytes(channel(), "/axiscal.v1.Ingest/UploadOnce", bytes);
  EXPECT_EQ(once.error_code(), grpc::StatusCode::ABORTED);
  EXPECT_EQ(ReasonOf(once), "STREAM_INCOMPLETE");
  EXPECT_EQ(Stored().state(), v1::SESSION_STATE_OPEN);
  EXPECT_EQ(Stored().next_seq(), 3);
  EXPECT_FALSE(client().DownloadSession(SessionId(id_)).ok());
}

TEST_F(UploadFaults, AWrongChecksumIsRefused) {
  messages_[5].mutable_chunk()->set_crc32c(messages_[5].chunk().crc32c() ^ 1);
  const RawResult result = SendAll(*stub_, messages_);
  EXPECT_EQ(result.status.error_code(), grpc::StatusCode::INVALID_ARGUMENT);
  EXPECT_EQ(ReasonOf(result.status), "CHUNK_CORRUPT");
  EXPECT_EQ(Stored().state(), v1::SESSION_STATE_OPEN);
  EXPECT_EQ(Stored().next_seq(), 4);
}

TEST_F(UploadFaults, AGapIsRefusedAndSaysWhereToGoOn) {
  messages_.erase(messages_.begin() + 3);
  const RawResult result = SendAll(*stub_, messages_);
  EXPECT_EQ(result.status.error_code(), grpc::StatusCode::OUT_OF_RANGE);
  EXPECT_EQ(ReasonOf(result.status), "SEQ_GAP");
  EXPECT_EQ(Stored().next_seq(), 2);
}

TEST_F(UploadFaults, AChunkTwiceIsAcceptedWhenItIsTheSame) {
  messages_.insert(messages_.begin() + 3, messages_[2]);
  const RawResult result = SendAll(*stub_, messages_);
  EXPECT_TRUE(result.status.ok()) << result.status.error_message();
  ASSERT_TRUE(result.completed());
  EXPECT_EQ(result.responses.back().duplicate_chunks(), 1);
  const auto back = client().DownloadSession(SessionId(id_));
  ASSERT_OK(back);
  EXPECT_TRUE(*back == session_);
}

TEST_F(UploadFaults, AChunkTwiceWithOtherContentIsAConflict) {
  v1::UploadRequest other = messages_[3];
  other.mutable_chunk()->set_seq(1);
  messages_.insert(messages_.begin() + 3, other);
  const RawResult result = SendAll(*stub_, messages_);
  EXPECT_EQ(result.status.error_code(), grpc::StatusCode::ALREADY_EXISTS);
  EXPECT_EQ(ReasonOf(result.status), "CHUNK_CONFLICT");
  EXPECT_EQ(Stored().state(), v1::SESSION_STATE_OPEN);
}

TEST_F(UploadFaults, TotalsThatDoNotFitAreRefused) {
  messages_.back().mutable_finish()->mutable_totals()->set_readings(999);
  const RawResult result = SendAll(*stub_, messages_);
  EXPECT_EQ(result.status.error_code(), grpc::StatusCode::FAILED_PRECONDITION);
  EXPECT_EQ(ReasonOf(result.status), "TOTALS_MISMATCH");
  EXPECT_EQ(Stored().state(), v1::SESSION_STATE_OPEN);
}

TEST_F(UploadFaults, MessagesInAnotherOrderAreRefused) {
  const RawResult headless = SendAll(*stub_, {messages_[1]});
  EXPECT_EQ(ReasonOf(headless.status), "STREAM_INVALID");
  const RawResult two_headers = SendAll(*stub_, {messages_[0], messages_[0]});
  EXPECT_EQ(ReasonOf(two_headers.status), "STREAM_INVALID");
  const RawResult empty = SendAll(*stub_, {messages_[0], v1::UploadRequest()});
  EXPECT_EQ(ReasonOf(empty.status), "STREAM_INVALID");
}

TEST_F(UploadFaults, ColumnsOfAnotherLengthAreRefused) {
  messages_[1].mutable_chunk()->mutable_columns(2)->mutable_values()->RemoveLast();
  const RawResult result = SendAll(*stub_, messages_);
  EXPECT_EQ(ReasonOf(result.status), "CHUNK_INVALID");
  EXPECT_EQ(FieldOf(result.status), "chunk");
  EXPECT_EQ(Stored().next_seq(), 0);
}

TEST_F(UploadFaults, TimeThatRunsBackAfterAResumeIsRefused) {
  ASSERT_TRUE(SendAll(*stub_, {messages_.begin(), messages_.begin() + 4}).status.ok());
  // The session goes on with what was measured before: chunk 0's rows as chunk 3.
  std::vector<v1::UploadRequest> resumed = {messages_[0], messages_[1]};
  resumed[0].mutable_header()->set_resume_from_seq(3);
  resumed[1].mutable_chunk()->set_seq(3);
  const RawResult result = SendAll(*stub_, resumed);
  EXPECT_EQ(ReasonOf(result.status), "SESSION_INVALID");
  // 8 lines of head and 300 readings before it.
  EXPECT_NE(result.status.error_message().find("line 309, column 1 (t_s)"), std::string::npos)
      << result.status.error_message();
}

TEST_F(UploadFaults, ACompleteSessionTakesNothingMore) {
  ASSERT_TRUE(SendAll(*stub_, messages_).completed());
  const auto aborted = client().AbortSession(SessionId(id_));
  EXPECT_EQ(base::ErrorReason(aborted.status()), "SESSION_CLOSED");
  // The same again is harmless.
  EXPECT_TRUE(SendAll(*stub_, messages_).completed());
}

TEST_F(UploadFaults, ARequestIdIsNotForTwoSessions) {
  const session::Session other = BallbarSession("mt", "CR", 100);
  grpc::ClientContext context;
  v1::CreateSessionResponse created;
  const grpc::Status status = stub_->CreateSession(&context, testing::CreateRequest("mt", "id-1", other), &created);
  EXPECT_EQ(status.error_code(), grpc::StatusCode::INVALID_ARGUMENT);
  EXPECT_EQ(ReasonOf(status), "REQUEST_ID_REUSED");
}

TEST_F(UploadFaults, ErrorsNameTheField) {
  v1::CreateSessionRequest request = testing::CreateRequest("mt", "id-2", session_);
  request.mutable_schema()->mutable_columns(1)->set_kind(v1::COLUMN_KIND_UNSPECIFIED);
  grpc::ClientContext context;
  v1::CreateSessionResponse created;
  const grpc::Status status = stub_->CreateSession(&context, request, &created);
  EXPECT_EQ(status.error_code(), grpc::StatusCode::INVALID_ARGUMENT);
  EXPECT_EQ(ReasonOf(status), "FIELD_INVALID");
  EXPECT_EQ(FieldOf(status), "schema.columns[1].kind");
}

}  // namespace
}  // namespace axiscal
