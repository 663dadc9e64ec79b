// Methods of the API by the path of a request, and their messages as they travel by HTTP: Protobuf's own binary form or
// its own JSON, one by one or, in streams, in envelopes.
#ifndef AXISCAL_SERVER_HTTP_MESSAGES_H_
#define AXISCAL_SERVER_HTTP_MESSAGES_H_

#include <google/protobuf/descriptor.h>

#include <cstdint>
#include <optional>
#include <string>

#include "core/base/status.h"

namespace axiscal::http {

enum class Codec { kJson, kProto };

// Of "/axiscal.v1.Jobs/GetJob"; null where there is none.
const google::protobuf::MethodDescriptor* FindMethod(const std::string& path);

// What a Content-Type says.
struct ContentType {
  Codec codec = Codec::kJson;
  bool is_stream = false;
};
// "application/json", "application/proto", "application/connect+json", "application/connect+proto", in letters of any
// size, behind JSON also with "; charset=utf-8". Nothing of others.
std::optional<ContentType> ContentTypeOf(const std::string& field);
std::string NameOf(const ContentType& type);

// Parts of a message as proto/guard counts them; of JSON at least as many as it has values (of fields, in lists),
// counted without reading them.
int64_t PartsOf(const google::protobuf::Descriptor& type, Codec codec, const std::string& bytes);
// Memory that ToBinary() and FromBinary() need for that text or message, with what comes of it.
int64_t BytesToRead(const google::protobuf::Descriptor& type, Codec codec, const std::string& text);
int64_t BytesToWrite(Codec codec, const std::string& binary);

// A message as gRPC carries it, from how it came. INVALID_ARGUMENT MESSAGE_INVALID for what is none, unknown fields and
// names of enum values included; RESOURCE_EXHAUSTED MESSAGE_TOO_LARGE beyond `most_bytes`, and for more parts than
// proto/guard lets pass, of JSON values.
absl::StatusOr<std::string> ToBinary(const google::protobuf::Descriptor& type, Codec codec, const std::string& bytes,
                                     int most_bytes);
// The other way round. INTERNAL for what is no such message.
absl::StatusOr<std::string> FromBinary(const google::protobuf::Descriptor& type, Codec codec, std::string binary);

// Bits of an envelope's first byte.
inline constexpr unsigned kCompressed = 1, kEndOfStream = 2;
// One byte of flags, four of length (the first the largest), the message.
std::string Envelope(unsigned flags, const std::string& message);
// The one message of a stream's request. UNIMPLEMENTED MESSAGE_COUNT for none or several; INTERNAL CODING_UNKNOWN for a
// compressed one; INVALID_ARGUMENT MESSAGE_INVALID where lengths and bytes do not agree.
absl::StatusOr<std::string> OnlyMessage(const std::string& body);

}  // namespace axiscal::http

#endif  // AXISCAL_SERVER_HTTP_MESSAGES_H_
