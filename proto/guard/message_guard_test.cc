#include "proto/guard/message_guard.h"

#include <google/protobuf/io/zero_copy_stream_impl_lite.h>
#include <gtest/gtest.h>

#include <set>
#include <string>

#include "axiscal/v1/admin_service.grpc.pb.h"
#include "axiscal/v1/events_service.grpc.pb.h"
#include "axiscal/v1/ingest_service.grpc.pb.h"
#include "axiscal/v1/jobs_service.grpc.pb.h"
#include "axiscal/v1/programs_service.grpc.pb.h"

namespace axiscal::guard {
namespace {

using google::protobuf::io::ArrayInputStream;

int64_t PartsOf(const google::protobuf::Message& message, int64_t most = 1000) {
  const std::string bytes = message.SerializeAsString();
  ArrayInputStream in(bytes.data(), static_cast<int>(bytes.size()), 7);  // in pieces, as they come
  return CountParts(*message.GetDescriptor(), in, most);
}

int64_t PartsOf(const google::protobuf::Descriptor& type, const std::string& bytes, int64_t most = 1000) {
  ArrayInputStream in(bytes.data(), static_cast<int>(bytes.size()));
  return CountParts(type, in, most);
}

std::string Times(int count, const std::string& bytes) {
  std::string all;
  for (int i = 0; i < count; ++i) all += bytes;
  return all;
}

v1::UploadRequest Chunk(int columns, int readings, int texts) {
  v1::UploadRequest request;
  for (int i = 0; i < columns; ++i) {
    v1::ColumnCells& cells = *request.mutable_chunk()->add_columns();
    for (int k = 0; k < readings; ++k) cells.add_values(k);
    for (int k = 0; k < texts; ++k) cells.add_texts("");
  }
  return request;
}

TEST(CountParts, CountsMessagesAndTextsAndNoNumbers) {
  EXPECT_EQ(PartsOf(v1::UploadRequest()), 0);
  EXPECT_EQ(PartsOf(Chunk(0, 0, 0)), 0);
  EXPECT_EQ(PartsOf(Chunk(3, 100, 0)), 4);   // the chunk and its columns
  EXPECT_EQ(PartsOf(Chunk(2, 0, 50)), 103);  // and each text
  EXPECT_GT(PartsOf(Chunk(2, 0, 50), 10), 10);
  v1::WatchJobRequest number;
  number.set_job_id(7);
  EXPECT_EQ(PartsOf(number), 0);
}

TEST(CountParts, CountsWhatTheTypeDoesNotKnow) {
  const auto& type = *v1::WatchJobRequest::descriptor();
  EXPECT_EQ(PartsOf(type, Times(20, std::string("\x7a\x00", 2))), 20);          // texts of field 15
  EXPECT_EQ(PartsOf(type, Times(20, std::string("\x78\x01", 2))), 20);          // numbers of it
  EXPECT_EQ(PartsOf(type, Times(20, std::string("\x7b\x78\x01\x7c", 4))), 40);  // groups with a number each
  EXPECT_EQ(PartsOf(type, Times(20, std::string("\x0a\x00", 2))), 20);          // job_id, a number, as a list
  EXPECT_LE(PartsOf(type, Times(500, std::string("\x7b", 1)), 1000), 1000);     // deeper than any reader goes
  EXPECT_EQ(PartsOf(type, std::string("\x7a\x05", 2) + "ab"), 1);               // cut short
}

TEST(GuardedMessage, RefusesRequestsOfTooManyPartsAndReadsTheLargestChunk) {
  const auto read = [](const google::protobuf::MessageLite& message, google::protobuf::MessageLite* into) {
    grpc::ByteBuffer buffer;
    bool own_buffer = false;
    EXPECT_TRUE(GuardedMessage::Serialize(message, &buffer, &own_buffer).ok());
    return GuardedMessage::Deserialize(&buffer, into);
  };
  v1::UploadRequest upload;
  const grpc::Status refused = read(Chunk(1, 0, kMostParts), &upload);
  EXPECT_EQ(refused.error_code(), grpc::StatusCode::RESOURCE_EXHAUSTED) << refused.error_message();
  EXPECT_EQ(upload.ByteSizeLong(), 0u);
  constexpr int kReadings = 4096, kTextColumns = 40;  // as many as the protocol lets a chunk have
  EXPECT_TRUE(read(Chunk(kTextColumns, 0, kReadings), &upload).ok());
  EXPECT_EQ(upload.chunk().columns_size(), kTextColumns);
  // An answer is not held to it.
  v1::ListJobsResponse jobs, read_jobs;
  for (int64_t i = 0; i <= kMostParts; ++i) jobs.add_jobs();
  EXPECT_TRUE(read(jobs, &read_jobs).ok());
}

// Of each method that streams, the request is in the list of message_guard.h.
TEST(GuardedMessage, GuardsEveryRequestThatIsStreamed) {
  std::set<std::string> guarded, streamed;
#define AXISCAL_NAME(TYPE) guarded.insert(#TYPE);
  AXISCAL_STREAMED_REQUESTS(AXISCAL_NAME)
#undef AXISCAL_NAME
  for (const google::protobuf::FileDescriptor* const file :
       {v1::BackupRequest::descriptor()->file(), v1::WatchEventsRequest::descriptor()->file(),
        v1::UploadRequest::descriptor()->file(), v1::WatchJobRequest::descriptor()->file(),
        v1::PutProgramRequest::descriptor()->file()}) {
    for (int i = 0; i < file->service_count(); ++i) {
      for (int k = 0; k < file->service(i)->method_count(); ++k) {
        const auto& method = *file->service(i)->method(k);
        if (method.client_streaming() || method.server_streaming()) streamed.insert(method.input_type()->name());
      }
    }
  }
  EXPECT_EQ(guarded, streamed);
}

}  // namespace
}  // namespace axiscal::guard
