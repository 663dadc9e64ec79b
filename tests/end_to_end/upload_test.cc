// Sessions through the client library: stored whole, once, resumed, readable bit for bit.
#include "client/upload.h"

#include "core/base/error_detail.h"
#include "core/records/chunked_session.h"
#include "proto/convert/session.h"
#include "server/local_login.h"
#include "tests/end_to_end/testing/fixture.h"
#include "tests/end_to_end/testing/raw_upload.h"

namespace axiscal {
namespace {

using testing::BallbarSession;
using testing::MachineJson;

class Upload : public testing::EndToEnd {
 protected:
  void SetUp() override {
    EndToEnd::SetUp();
    ASSERT_OK(client().CreateMachine(MachineJson("mt")));
  }
  // Opens the session as the client library would; the messages of its stream.
  std::vector<v1::UploadRequest> Open(const session::Session& session) {
    stub_ = v1::Ingest::NewStub(channel());
    grpc::ClientContext context;
    context.AddMetadata("axiscal-user", "test");
    v1::CreateSessionResponse created;
    const std::string id = records::ContentId(MachineId("mt"), session, client::Options().chunk_readings);
    EXPECT_TRUE(stub_->CreateSession(&context, testing::CreateRequest("mt", id, session), &created).ok());
    id_ = created.session().session_id();
    return testing::UploadMessages(id_, session, kChunkReadings);
  }
  // Uploads the opened session to a new server on the same file: it is completed, whole and once. From which reading
  // on.
  int64_t ResumeAfterRestart(const session::Session& session) {
    stub_.reset();
    Restart();
    int64_t first_done = -1;
    const auto resumed = client().Upload(MachineId("mt"), session, [&](const client::TransferProgress& progress) {
      if (first_done < 0) first_done = progress.done;
    });
    EXPECT_TRUE(resumed.ok()) << resumed.status();
    if (!resumed.ok()) return -1;
    EXPECT_EQ(resumed->session.id.number(), id_);
    EXPECT_EQ(resumed->duplicate_chunks, 0);
    const auto back = client().DownloadSession(resumed->session.id);
    EXPECT_TRUE(back.ok() && *back == session) << back.status();
    return first_done;
  }

  static constexpr int kChunkReadings = 1000;
  std::unique_ptr<v1::Ingest::Stub> stub_;
  int64_t id_ = 0;
};

TEST_F(Upload, ComesBackBitForBitAndReportsItsProgress) {
  const session::Session session = BallbarSession("mt", "BX", 10'500);
  std::vector<int64_t> done;
  const auto upload = client().Upload(MachineId("mt"), session, [&](const client::TransferProgress& progress) {
    EXPECT_EQ(progress.total, 10'500);
    done.push_back(progress.done);
  });
  ASSERT_OK(upload);
  EXPECT_EQ(upload->session.state, records::SessionState::kComplete);
  EXPECT_EQ(upload->session.reading_count, 10'500);
  EXPECT_EQ(upload->session.name, "BX");
  EXPECT_EQ(upload->session.instrument, "ballbar");
  EXPECT_EQ(upload->session.created_by, "local:" + server::LoginOfProcess());  // not the name that the client states
  EXPECT_FALSE(upload->was_there);
  ASSERT_FALSE(done.empty());
  EXPECT_TRUE(std::is_sorted(done.begin(), done.end()));
  EXPECT_EQ(done.back(), 10'500);

  const auto back = client().DownloadSession(upload->session.id);
  ASSERT_OK(back);
  EXPECT_TRUE(*back == session);
}

TEST_F(Upload, TheSameSessionAgainIsStoredOnce) {
  const session::Session session = BallbarSession("mt", "BX", 2'000);
  const auto first = client().Upload(MachineId("mt"), session);
  ASSERT_OK(first);
  Restart();
  const auto second = client().Upload(MachineId("mt"), session);
  ASSERT_OK(second);
  EXPECT_TRUE(second->was_there);
  EXPECT_EQ(second->session.id, first->session.id);
  const auto all = client().ListSessions();
  ASSERT_OK(all);
  EXPECT_EQ(all->rows.size(), 1u);
}

TEST_F(Upload, TheSameFileOfAnotherUserIsTheSameSession) {
  const session::Session session = BallbarSession("mt", "BX", 2'000);
  const auto first = client().Upload(MachineId("mt"), session);
  ASSERT_OK(first);
  auto other = client::Client::InProcess(channel(), {.user = "another"});
  ASSERT_OK(other);
  const auto second = other->Upload(MachineId("mt"), session);
  ASSERT_OK(second);
  EXPECT_TRUE(second->was_there);
  EXPECT_EQ(second->session.id, first->session.id);
  EXPECT_EQ(client().ListSessions()->rows.size(), 1u);
}

TEST_F(Upload, AnAbortedOneCanBeSentAgain) {
  const session::Session session = BallbarSession("mt", "BX", 2'000);
  Open(session);
  ASSERT_OK(client().AbortSession(SessionId(id_)));
  const auto again = client().Upload(MachineId("mt"), session);
  ASSERT_OK(again);
  EXPECT_FALSE(again->was_there);
  EXPECT_NE(again->session.id.number(), id_);
  EXPECT_EQ(again->session.state, records::SessionState::kComplete);
  const auto back = client().DownloadSession(again->session.id);
  ASSERT_OK(back);
  EXPECT_TRUE(*back == session);
}

TEST_F(Upload, ResumesWhereABrokenStreamLeftIt) {
  const session::Session session = BallbarSession("mt", "BX", 10'000);
  std::vector<v1::UploadRequest> messages = Open(session);
  messages.resize(1 + 4);  // the cell stops after four chunks
  const testing::RawResult broken = testing::SendAll(*stub_, messages);
  // An orderly end: everything that was sent is on disk, and acknowledged.
  EXPECT_TRUE(broken.status.ok());
  EXPECT_EQ(broken.next_seq(), 4);
  EXPECT_FALSE(broken.completed());
  EXPECT_EQ(ResumeAfterRestart(session), 4'000);
}

TEST_F(Upload, WhatWasAcknowledgedBeforeACutIsThere) {
  const session::Session session = BallbarSession("mt", "BX", 10'000);
  const std::vector<v1::UploadRequest> messages = Open(session);
  grpc::ClientContext context;
  const auto stream = stub_->Upload(&context);
  for (int i = 0; i < 1 + 6; ++i) ASSERT_TRUE(stream->Write(messages[i]));
  v1::UploadResponse response;
  while (response.next_seq() < 2) ASSERT_TRUE(stream->Read(&response));
  context.TryCancel();  // the cable: what is not yet acknowledged may be there or not
  EXPECT_EQ(stream->Finish().error_code(), grpc::StatusCode::CANCELLED);
  const int64_t resumed_at = ResumeAfterRestart(session);
  EXPECT_GE(resumed_at, response.next_seq() * kChunkReadings);
  EXPECT_LE(resumed_at, 6 * kChunkReadings);
}

TEST_F(Upload, ASessionOfAnotherMachineIsRefusedAndNothingIsStored) {
  ASSERT_OK(client().CreateMachine(MachineJson("other")));
  const auto upload = client().Upload(MachineId("other"), BallbarSession("mt", "BX", 100));
  EXPECT_EQ(upload.status().code(), absl::StatusCode::kInvalidArgument);
  EXPECT_EQ(base::ErrorReason(upload.status()), "SESSION_INVALID");
  EXPECT_NE(upload.status().message().find("'mt', expected 'other'"), std::string::npos) << upload.status();
  EXPECT_NE(upload.status().message().find("[SESSION_INVALID]"), std::string::npos);
  const auto all = client().ListSessions();
  ASSERT_OK(all);
  EXPECT_TRUE(all->rows.empty());
}

TEST_F(Upload, AnUnknownMachineIsNotFound) {
  const auto upload = client().Upload(MachineId("nobody"), BallbarSession("nobody", "BX", 100));
  EXPECT_EQ(upload.status().code(), absl::StatusCode::kNotFound);
  EXPECT_EQ(base::ErrorReason(upload.status()), "MACHINE_NOT_FOUND");
}

TEST_F(Upload, ABadReadingRefusesTheSessionWithItsLineAndColumn) {
  session::Session session = BallbarSession("mt", "BX", 3'000);
  session.columns[1].values[2'345] = std::nan("");
  const auto upload = client().Upload(MachineId("mt"), session);
  EXPECT_EQ(base::ErrorReason(upload.status()), "SESSION_INVALID");
  // 7 header lines, the column names, then readings from line 9 on.
  EXPECT_NE(upload.status().message().find("line 2354, column 2 (X_mm)"), std::string::npos) << upload.status();
  const auto complete = client().ListSessions({.machine = {}, .state = records::SessionState::kComplete});
  ASSERT_OK(complete);
  EXPECT_TRUE(complete->rows.empty());
}

// Headers that speak of all readings are judged when those are there.
TEST_F(Upload, WhatATrackersHeaderSaysOfItsReadingsIsRefusedBeforeItIsStored) {
  std::vector<std::string> targets = {"R", "tool", "tool", "R"};
  const auto refusal = [&](const std::vector<session::HeaderEntry>& keys) {
    session::Session session;
    session.header = {{"machine", "mt"},           {"session", "T"},
                      {"instrument", "tracker"},   {"sigma_um", "5"},
                      {"tool_tip_mm", "0 0 -150"}, {"reference R", "900 -500 100"}};
    session.header.insert(session.header.end(), keys.begin(), keys.end());
    const std::vector<double> x_mm = {0, 0, 100, 0}, zero(4, 0.0);
    session.columns = {{"t_s", {0, 10, 20, 30}, {}}};
    for (const char* const name : {"X_mm", "Y_mm", "Z_mm", "B_deg", "C_deg"})
      session.columns.push_back({name, name == std::string("X_mm") ? x_mm : zero, {}});
    session.columns.push_back({"target", {}, targets});
    session.columns.push_back({"px_mm", {900, 0, 100, 900}, {}});
    session.columns.push_back({"py_mm", {-500, 0, 0, -500}, {}});
    session.columns.push_back({"pz_mm", {100, -150, -150, 100}, {}});
    return std::string(client().Upload(MachineId("mt"), session).status().message());
  };
  EXPECT_NE(refusal({{"knocked_s", "300"}})
                .find("session 'T': header 'knocked_s: 300', expected times between the first and the last reading, "
                      "t_s 0 to 30"),
            std::string::npos)
      << refusal({{"knocked_s", "300"}});
  EXPECT_NE(refusal({{"reference S", "0 0 1"}}).find("'reference S' is of a target that no reading is of"),
            std::string::npos);
  targets = {"R", "tool", "other", "R"};
  EXPECT_NE(refusal({}).find("target tool, other: expected"), std::string::npos) << refusal({});
  targets = {"R", "tool", "tool", "R"};
  const auto complete = client().ListSessions({.machine = {}, .state = records::SessionState::kComplete});
  ASSERT_OK(complete);
  EXPECT_TRUE(complete->rows.empty());
  EXPECT_EQ(refusal({{"knocked_s", "15"}}), "");
}

TEST_F(Upload, ReadingsThatTheMachineCannotGiveAreRefusedFromAnyClient) {
  session::Session metres = BallbarSession("mt", "metres", 3'000);
  for (const int column : {1, 2, 3}) {
    for (double& value : metres.columns[column].values) value /= 1000;
  }
  const auto first = client().Upload(MachineId("mt"), metres);
  EXPECT_EQ(first.status().code(), absl::StatusCode::kInvalidArgument);
  EXPECT_EQ(base::ErrorReason(first.status()), "SESSION_INVALID");
  EXPECT_NE(first.status().message().find("line 9: reading 1 of session 'metres': dL_mm = "), std::string::npos)
      << first.status();
  EXPECT_NE(first.status().message().find("expected within 50 mm: are the units (mm, deg)"), std::string::npos);

  session::Session sign = BallbarSession("mt", "sign", 10'000);
  for (size_t i = 9'500; i < 10'000; ++i) sign.columns[3].values[i] *= -1;
  const auto late = client().Upload(MachineId("mt"), sign);
  EXPECT_EQ(base::ErrorReason(late.status()), "SESSION_INVALID");
  EXPECT_NE(late.status().message().find("line 9509: reading 9501 of session 'sign': dL_mm = "), std::string::npos)
      << late.status();

  // Both stay open and empty of what was refused: no way around makes them complete.
  const auto open = client().ListSessions({.machine = {}, .state = records::SessionState::kOpen});
  ASSERT_OK(open);
  ASSERT_EQ(open->rows.size(), 2u);
  stub_ = v1::Ingest::NewStub(channel());
  for (const auto& row : open->rows) {
    const bool is_sign = row.name == "sign";
    EXPECT_LT(row.reading_count, is_sign ? 9'501 : 1);
    records::ChunkedSession chunks(is_sign ? sign : metres, client::Options().chunk_readings);
    grpc::ClientContext context;
    v1::FinishSessionRequest request;
    request.set_session_id(row.id.number());
    *request.mutable_totals() = convert::ToProto(chunks.Totals());
    v1::FinishSessionResponse response;
    EXPECT_EQ(testing::ReasonOf(stub_->FinishSession(&context, request, &response)), "TOTALS_MISMATCH");
  }
}

TEST_F(Upload, PagesStayStableWhileSessionsAreAdded) {
  for (const char* name : {"a", "b", "c", "d", "e"}) {
    ASSERT_OK(client().Upload(MachineId("mt"), BallbarSession("mt", name, 10)));
  }
  std::vector<std::string> names;
  records::PageRequest page{2, ""};
  do {
    const auto rows = client().ListSessions({.machine = MachineId("mt"), .state = {}}, page);
    ASSERT_OK(rows);
    for (const auto& row : rows->rows) names.push_back(row.name);
    page.token = rows->next_token;
    if (names.size() == 2) {
      ASSERT_OK(client().Upload(MachineId("mt"), BallbarSession("mt", "later", 10)));
    }
  } while (!page.token.empty());
  EXPECT_EQ(names, (std::vector<std::string>{"e", "d", "c", "b", "a"}));
}

}  // namespace
}  // namespace axiscal
