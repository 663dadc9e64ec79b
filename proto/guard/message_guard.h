// How much a message may be beside its bytes. In Protobuf's binary form a part that holds nothing has 2 bytes, in
// memory 100 and more: 4 MB of them, which the limit on messages lets pass, would be hundreds of megabytes for whoever
// reaches the port. So requests are looked through before they are read, and those of too many parts are refused.
//
// Every header of services that protoc's gRPC plugin makes begins with this one (cmake/AxiscalProto.cmake): gRPC reads
// messages by SerializationTraits, of which the ones below take the place.
#ifndef AXISCAL_PROTO_GUARD_MESSAGE_GUARD_H_
#define AXISCAL_PROTO_GUARD_MESSAGE_GUARD_H_

#include <google/protobuf/descriptor.h>
#include <google/protobuf/io/zero_copy_stream.h>
#include <google/protobuf/message.h>
#include <grpcpp/impl/codegen/proto_utils.h>

#include <cstdint>

namespace axiscal::guard {

// Ten times what the API has a use for: a full chunk of readings has a part for each text.
inline constexpr int64_t kMostParts = 200'000;

// Messages, texts, bytes, and all that the type does not know, at any depth; lists of numbers count nothing, as they
// take at most 16 times their bytes. Counts until there are more than `most`, or until what is no message of the type,
// which its reader refuses. Linear, without memory.
int64_t CountParts(const google::protobuf::Descriptor& type, google::protobuf::io::ZeroCopyInputStream& bytes,
                   int64_t most);

// As gRPC's own; a request of more than kMostParts is RESOURCE_EXHAUSTED.
struct GuardedMessage {
  static grpc::Status Serialize(const google::protobuf::MessageLite& message, grpc::ByteBuffer* buffer,
                                bool* own_buffer);
  static grpc::Status Deserialize(grpc::ByteBuffer* buffer, google::protobuf::MessageLite* message);
};

}  // namespace axiscal::guard

// Requests of streams are read by their own types (message_guard_test.cc holds that none is missing), all others as
// MessageLite.
#define AXISCAL_STREAMED_REQUESTS(OF) \
  OF(BackupRequest)                   \
  OF(DownloadSessionRequest)          \
  OF(GetProgramRequest)               \
  OF(PutLogRequest)                   \
  OF(PutProgramRequest)               \
  OF(RewriteProgramRequest)           \
  OF(UploadRequest)                   \
  OF(WatchEventsRequest)              \
  OF(WatchJobRequest)

namespace axiscal::v1 {
#define AXISCAL_DECLARE(TYPE) class TYPE;
AXISCAL_STREAMED_REQUESTS(AXISCAL_DECLARE)
#undef AXISCAL_DECLARE
}  // namespace axiscal::v1

namespace grpc {
template <>
class SerializationTraits<google::protobuf::MessageLite, void> : public axiscal::guard::GuardedMessage {};
#define AXISCAL_GUARD(TYPE) \
  template <>               \
  class SerializationTraits<axiscal::v1::TYPE, void> : public axiscal::guard::GuardedMessage {};
AXISCAL_STREAMED_REQUESTS(AXISCAL_GUARD)
#undef AXISCAL_GUARD
}  // namespace grpc

#endif  // AXISCAL_PROTO_GUARD_MESSAGE_GUARD_H_
