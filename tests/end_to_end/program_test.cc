// NC programs up and down, byte for byte.
#include <gmock/gmock.h>

#include <thread>

#include "axiscal/v1/programs_service.grpc.pb.h"
#include "core/base/demand.h"
#include "core/base/error_detail.h"
#include "core/base/sha256.h"
#include "core/base/testing/fake_clock.h"
#include "server/storage/sqlite_connection.h"
#include "server/storage/sqlite_database.h"
#include "tests/end_to_end/testing/fixture.h"
#include "tests/end_to_end/testing/raw_upload.h"

namespace axiscal {
namespace {

// Lines that differ, with every byte value among them.
std::string BigProgram(size_t bytes) {
  std::string program;
  program.reserve(bytes + 100);
  for (int n = 1; program.size() < bytes; ++n) {
    program += absl::StrCat("N", n, " G01 X", n % 977, ".5 (", std::string(1, static_cast<char>(n % 256)), ")\r\n");
  }
  program.resize(bytes);
  return program;
}

using Program = testing::EndToEnd;

TEST_F(Program, TwentyMegabytesComeBackByteForByte) {
  const std::string program = BigProgram(20 << 20);
  int64_t up = 0, down = 0;
  const auto put =
      client().PutProgram("part.nc", program, [&](const client::TransferProgress& progress) { up = progress.done; });
  ASSERT_OK(put);
  EXPECT_EQ(put->byte_count, 20 << 20);
  EXPECT_EQ(put->sha256, base::Sha256Hex(program));
  const auto back =
      client().GetProgram(put->id, [&](const client::TransferProgress& progress) { down = progress.done; });
  ASSERT_OK(back);
  EXPECT_TRUE(*back == program);
  EXPECT_EQ(up, 20 << 20);
  EXPECT_EQ(down, 20 << 20);
}

// A picture, a spreadsheet, a text of two bytes per character, by the first bytes of each.
TEST_F(Program, WhatIsNoTextIsRefused) {
  using namespace std::string_literals;
  for (const std::string& bytes : {"\x89PNG\r\n\x1a\n\0\0\0\rIHDR"s, "PK\3\4\x14\0\6\0"s, "\xFF\xFEG\0001\0"s}) {
    const absl::Status status = client().PutProgram("part.nc", bytes).status();
    EXPECT_EQ(status.code(), absl::StatusCode::kInvalidArgument) << status;
    EXPECT_EQ(base::ErrorReason(status), "PROGRAM_NOT_TEXT") << status;
  }
  EXPECT_THAT(std::string(client().PutProgram("part.nc", "G1\0X5"s).status().message()),
              ::testing::HasSubstr("byte 3"));
  // Leader and trailer of a tape.
  ASSERT_OK(client().PutProgram("tape.nc", "\0\0%\nG1 X5.\n%\0\0"s));
}

TEST_F(Program, AHalfSentOneIsDroppedByTheServer) {
  embedded_.reset();
  ProgramId half;
  {
    base::FakeClock clock;
    storage::SqliteOptions options;
    options.path = dir_.File("axiscal.db");
    options.clock = &clock;
    const auto database = storage::OpenSqlite(options);
    ASSERT_OK(database);
    half = (*database)->BeginProgram({"nc", "O1.nc", {"test", "half"}})->id;
    ASSERT_OK((*database)->AppendProgram(half, 0, "G01 X1\n"));
    clock.Advance(std::chrono::hours(24 * 8));  // the server is up
  }
  Restart();
  const auto connection = storage::SqliteConnection::Open(dir_.File("axiscal.db"), storage::Access::kReadOnly);
  ASSERT_OK(connection);
  const auto is_dropped = [&] {
    auto row = (*connection)->Ask("SELECT count(*) FROM program_part WHERE program_id = ?1", half);
    DEMAND(row.ok() && row->Step().ok());
    return row->Int(0) == 0;
  };
  // The server looks when it starts, on a thread of its own; half a minute means that it does not.
  for (int i = 0; i < 3000 && !is_dropped(); ++i) std::this_thread::sleep_for(std::chrono::milliseconds(10));
  EXPECT_TRUE(is_dropped());
}

TEST_F(Program, AnEmptyProgramIsAProgram) {
  const auto put = client().PutProgram("empty.nc", "");
  ASSERT_OK(put);
  const auto back = client().GetProgram(put->id);
  ASSERT_OK(back);
  EXPECT_EQ(*back, "");
}

TEST_F(Program, TheSameBytesAreStoredOnce) {
  const auto first = client().PutProgram("a.nc", "G0 X1\n");
  const auto second = client().PutProgram("b.nc", "G0 X1\n");
  ASSERT_OK(first);
  ASSERT_OK(second);
  EXPECT_EQ(first->id, second->id);
}

TEST_F(Program, ADownloadGoesOnFromAnOffset) {
  const auto put = client().PutProgram("a.nc", "0123456789");
  ASSERT_OK(put);
  const auto stub = v1::Programs::NewStub(channel());
  grpc::ClientContext context;
  v1::GetProgramRequest request;
  request.set_program_id(put->id.number());
  request.set_offset_bytes(7);
  const auto reader = stub->GetProgram(&context, request);
  v1::GetProgramResponse response;
  ASSERT_TRUE(reader->Read(&response));
  EXPECT_EQ(response.program().size_bytes(), 10);
  ASSERT_TRUE(reader->Read(&response));
  EXPECT_EQ(response.data(), "789");
  EXPECT_FALSE(reader->Read(&response));
  EXPECT_TRUE(reader->Finish().ok());
}

TEST_F(Program, WhatDoesNotFitItsHeaderIsNotStored) {
  v1::PutProgramRequest header, data;
  header.mutable_header()->set_name("a.nc");
  header.mutable_header()->set_size_bytes(4);
  header.mutable_header()->set_sha256(base::Sha256Hex("G0X1"));
  header.mutable_header()->set_request_id("r-1");
  data.set_data("G0X2");
  const std::string method = "/axiscal.v1.Programs/PutProgram";
  const auto send = [&](std::vector<std::string> messages) { return testing::SendBytes(channel(), method, messages); };

  EXPECT_EQ(testing::ReasonOf(send({header.SerializeAsString(), data.SerializeAsString()})), "TOTALS_MISMATCH");
  header.mutable_header()->set_request_id("r-2");
  EXPECT_EQ(testing::ReasonOf(send({header.SerializeAsString(), "\x0a\xff\xff\xff"})), "STREAM_INCOMPLETE");
  data.set_data("G0X12");
  EXPECT_EQ(testing::ReasonOf(send({header.SerializeAsString(), data.SerializeAsString()})), "SIZE_EXCEEDED");
  EXPECT_EQ(testing::ReasonOf(send({data.SerializeAsString()})), "STREAM_INVALID");
  const auto stored = client().ListPrograms();
  ASSERT_OK(stored);
  EXPECT_TRUE(stored->rows.empty());
}

// The first attempt breaks off behind parts that are stored already; the second one cuts its messages elsewhere.
TEST_F(Program, SentAgainInOtherMessagesItIsStoredOnce) {
  const std::string program = BigProgram(3'500'000);
  v1::PutProgramRequest header;
  header.mutable_header()->set_name("a.nc");
  header.mutable_header()->set_size_bytes(static_cast<int64_t>(program.size()));
  header.mutable_header()->set_sha256(base::Sha256Hex(program));
  header.mutable_header()->set_request_id("r-1");
  const auto stub = v1::Programs::NewStub(channel());
  const auto send = [&](size_t message_bytes, size_t total_bytes) {
    grpc::ClientContext context;
    v1::PutProgramResponse response;
    const auto writer = stub->PutProgram(&context, &response);
    v1::PutProgramRequest data;
    bool is_open = writer->Write(header);
    for (size_t at = 0; is_open && at < total_bytes; at += message_bytes) {
      data.set_data(program.substr(at, std::min(message_bytes, total_bytes - at)));
      is_open = writer->Write(data);
    }
    writer->WritesDone();
    return writer->Finish();
  };
  EXPECT_EQ(testing::ReasonOf(send(200'000, 2'900'000)), "STREAM_INCOMPLETE");
  EXPECT_TRUE(send(77'777, program.size()).ok());
  EXPECT_TRUE(send(250'000, program.size()).ok());  // it is there already
  const auto stored = client().ListPrograms();
  ASSERT_OK(stored);
  ASSERT_EQ(stored->rows.size(), 1u);
  const auto back = client().GetProgram(stored->rows[0].id);
  ASSERT_OK(back);
  EXPECT_TRUE(*back == program);
}

TEST_F(Program, AnUnknownProgramIsNotFound) {
  const auto back = client().GetProgram(ProgramId(77));
  EXPECT_EQ(back.status().code(), absl::StatusCode::kNotFound);
  EXPECT_EQ(base::ErrorReason(back.status()), "PROGRAM_NOT_FOUND");
}

}  // namespace
}  // namespace axiscal
