#include "server/handlers/upload.h"

#include <gtest/gtest.h>

#include <future>

#include "core/session/checksum.h"
#include "server/handlers/create_machine.h"
#include "server/handlers/create_session.h"
#include "server/handlers/testing/test_core.h"

namespace axiscal::handlers {
namespace {

constexpr int kReadings = 5;

class UploadTest : public ::testing::Test, protected TestCore {
 protected:
  void SetUp() override {
    v1::CreateMachineRequest machine;
    machine.set_description_json(kMachineJson);
    ASSERT_TRUE(CreateMachine(core, call, machine).ok());
    id_ = CreateSession(core, call, Parse<v1::CreateSessionRequest>(kTrackerSession))->session().session_id();
  }
  v1::UploadRequest Header(int64_t resume_from_seq = 0) const {
    v1::UploadRequest request;
    request.mutable_header()->set_session_id(id_);
    request.mutable_header()->set_resume_from_seq(resume_from_seq);
    return request;
  }
  static std::vector<session::Column> ColumnsOf(int64_t seq, double x_mm = 1) {
    std::vector<session::Column> columns;
    for (const char* name : {"t_s", "X_mm", "Y_mm", "Z_mm", "C_deg", "px_mm", "py_mm", "pz_mm"}) {
      columns.push_back({name, std::vector<double>(kReadings, x_mm), {}});
    }
    for (int i = 0; i < kReadings; ++i) columns[0].values[i] = static_cast<double>(seq * kReadings + i);
    return columns;
  }
  static records::Chunk MakeChunk(int64_t seq, double x_mm = 1) {
    return records::Chunk::Seal(seq, ColumnsOf(seq, x_mm));
  }
  static v1::UploadRequest ChunkMessage(const records::Chunk& chunk) {
    v1::UploadRequest request;
    *request.mutable_chunk() = convert::ToProto(chunk);
    return request;
  }
  static v1::UploadRequest FinishMessage(int chunks) {
    std::vector<uint32_t> crcs;
    for (int seq = 0; seq < chunks; ++seq) crcs.push_back(MakeChunk(seq).crc32c());
    v1::UploadRequest request;
    *request.mutable_finish()->mutable_totals() =
        convert::ToProto(records::SessionTotals{chunks, chunks * kReadings, session::SessionHash(crcs)});
    return request;
  }
  int64_t id_ = 0;
};

TEST_F(UploadTest, AcknowledgesWhatIsDurableAndCompletes) {
  std::vector<v1::UploadResponse> sent;
  {
    const auto send = [&](const v1::UploadResponse& response) {
      sent.push_back(response);
      return true;
    };
    UploadStream upload(core, call, {.send = send});
    ASSERT_TRUE(upload.Receive(Header()).ok());
    for (int seq = 0; seq < 20; ++seq) ASSERT_TRUE(upload.Receive(ChunkMessage(MakeChunk(seq))).ok());
    ASSERT_TRUE(upload.Receive(FinishMessage(20)).ok());
    EXPECT_TRUE(upload.End().ok());
    EXPECT_TRUE(upload.completed().has_value());
  }
  ASSERT_FALSE(sent.empty());
  EXPECT_TRUE(sent.back().has_completed_session());
  for (size_t i = 1; i < sent.size(); ++i) EXPECT_GE(sent[i].next_seq(), sent[i - 1].next_seq());
  EXPECT_EQ(database->GetSession(SessionId(id_))->state, records::SessionState::kComplete);
}

TEST_F(UploadTest, EndingAcknowledgesEveryChunkThatIsDurable) {
  std::promise<void> end_is_near;
  std::vector<int64_t> acknowledged;
  const auto send = [&](const v1::UploadResponse& response) {
    // Falls behind, so that the end comes before the last acknowledgement.
    if (acknowledged.empty()) end_is_near.get_future().wait();
    acknowledged.push_back(response.next_seq());
    return true;
  };
  UploadStream upload(core, call, {.send = send});
  ASSERT_TRUE(upload.Receive(Header()).ok());
  for (int seq = 0; seq < 4; ++seq) ASSERT_TRUE(upload.Receive(ChunkMessage(MakeChunk(seq))).ok());
  end_is_near.set_value();
  ASSERT_TRUE(upload.End().ok());
  EXPECT_EQ(acknowledged.back(), 4);
  EXPECT_EQ(database->GetSession(SessionId(id_))->next_seq, 4);
}

TEST_F(UploadTest, AnErrorOfTheStoreAsksTheCallerToEndAndIsTheStatus) {
  std::vector<v1::UploadResponse> sent;
  const auto send = [&](const v1::UploadResponse& response) {
    sent.push_back(response);
    return true;
  };
  UploadStream upload(core, call, {.send = send});
  ASSERT_TRUE(upload.Receive(Header()).ok());
  ASSERT_TRUE(upload.Receive(ChunkMessage(MakeChunk(0))).ok());
  static_cast<void>(upload.Receive(ChunkMessage(MakeChunk(0, 2))));  // the same place, another content
  const absl::Status status = upload.End();
  EXPECT_EQ(base::ErrorReason(status), "CHUNK_CONFLICT");
  EXPECT_FALSE(upload.completed().has_value());
}

TEST_F(UploadTest, EndingWithoutFinishIsIncomplete) {
  UploadStream upload(core, call, {});
  ASSERT_TRUE(upload.Receive(Header()).ok());
  ASSERT_TRUE(upload.Receive(ChunkMessage(MakeChunk(0))).ok());
  ASSERT_TRUE(upload.End().ok());
  v1::UploadOnceResponse response;
  EXPECT_EQ(base::ErrorReason(Summarise(upload, &response)), "STREAM_INCOMPLETE");
  EXPECT_EQ(database->GetSession(SessionId(id_))->next_seq, 1);
}

TEST_F(UploadTest, ResumesOnlyWhereItStands) {
  {
    UploadStream upload(core, call, {});
    ASSERT_TRUE(upload.Receive(Header()).ok());
    ASSERT_TRUE(upload.Receive(ChunkMessage(MakeChunk(0))).ok());
    ASSERT_TRUE(upload.End().ok());
  }
  const auto gap = UploadStream(core, call, {}).Receive(Header(2));
  EXPECT_EQ(base::ErrorReason(gap), "SEQ_GAP");
  EXPECT_EQ(base::GetErrorDetail(gap)->facts.at("next_seq"), "1");
  UploadStream upload(core, call, {});
  ASSERT_TRUE(upload.Receive(Header(1)).ok());
  ASSERT_TRUE(upload.Receive(ChunkMessage(MakeChunk(1))).ok());
  ASSERT_TRUE(upload.Receive(FinishMessage(2)).ok());
}

TEST_F(UploadTest, ReadingsAreHeldToTheFilesRules) {
  UploadStream upload(core, call, {});
  ASSERT_TRUE(upload.Receive(Header()).ok());
  ASSERT_TRUE(upload.Receive(ChunkMessage(MakeChunk(0))).ok());
  std::vector<session::Column> late = ColumnsOf(1);
  late[0].values[0] = 0;
  const absl::Status back_in_time = upload.Receive(ChunkMessage(records::Chunk::Seal(1, late)));
  EXPECT_EQ(base::ErrorReason(back_in_time), "SESSION_INVALID");
  // 6 header lines, the names, 5 readings before it.
  EXPECT_NE(back_in_time.message().find("line 13, column 1 (t_s)"), std::string::npos) << back_in_time;
  EXPECT_TRUE(upload.End().ok());  // chunk 0 stands

  UploadStream beyond(core, call, {});
  ASSERT_TRUE(beyond.Receive(Header(1)).ok());
  std::vector<session::Column> far = ColumnsOf(1);
  far[3].values[2] = 401;
  const absl::Status travel = beyond.Receive(ChunkMessage(records::Chunk::Seal(1, far)));
  EXPECT_EQ(base::ErrorReason(travel), "SESSION_INVALID");
  EXPECT_NE(travel.message().find("beyond the travel of Z"), std::string::npos) << travel;
}

TEST_F(UploadTest, AnEmptySessionDoesNotComplete) {
  UploadStream upload(core, call, {});
  ASSERT_TRUE(upload.Receive(Header()).ok());
  EXPECT_EQ(base::ErrorReason(upload.Receive(FinishMessage(0))), "SESSION_INVALID");
}

TEST_F(UploadTest, DrainingSendsTheCallerAwayBetweenTwoChunks) {
  UploadStream upload(core, call, {});
  ASSERT_TRUE(upload.Receive(Header()).ok());
  core.draining = true;
  EXPECT_EQ(base::ErrorReason(upload.Receive(ChunkMessage(MakeChunk(0)))), "DRAINING");
}

}  // namespace
}  // namespace axiscal::handlers
