#include "server/http/messages.h"

#include <google/protobuf/io/zero_copy_stream_impl_lite.h>
#include <google/protobuf/message.h>
#include <google/protobuf/util/json_util.h>

#include <algorithm>
#include <memory>

#include "absl/strings/ascii.h"
#include "core/base/error_detail.h"
#include "core/base/utf8.h"
#include "proto/guard/message_guard.h"
#include "server/http/exchange.h"

namespace axiscal::http {
namespace {

constexpr size_t kEnvelopeHead = 5;  // bytes
// Of the parser's complaint, which shows its input.
constexpr size_t kMaxComplaint = 300;
// Of one part of a message: the largest of a request that a list holds, its place in the list, what the allocator adds.
constexpr int64_t kPartBytes = 256;
// Of a request's message, parts aside, against its text: a number of 1 byte is 8 in a list, which has room for twice as
// many. Texts are there once more in the binary form, and JSON's twice.
constexpr int64_t kRequestFactor = 16;
// Of an answer's message in memory and of its JSON, against its binary form: about 3 and 4 for histories.
constexpr int64_t kAnswerFactor = 8;

absl::Status Invalid(const std::string& text) {
  return base::Error(absl::StatusCode::kInvalidArgument, text, {"MESSAGE_INVALID", {}});
}

std::unique_ptr<google::protobuf::Message> NewMessage(const google::protobuf::Descriptor& type) {
  const google::protobuf::Message* const prototype =
      google::protobuf::MessageFactory::generated_factory()->GetPrototype(&type);
  return std::unique_ptr<google::protobuf::Message>(prototype->New());
}

// The complaint on one line.
std::string OneLine(std::string text) {
  for (char& c : text) {
    if (absl::ascii_iscntrl(static_cast<unsigned char>(c))) c = ' ';
  }
  if (text.size() > kMaxComplaint) text = text.substr(0, kMaxComplaint) + " ...";
  return base::ToUtf8(text);
}

// Commas and brackets outside of texts.
int64_t CountValues(const std::string& json) {
  int64_t count = 1;
  char quote = 0;  // the parser takes both kinds
  for (size_t i = 0; i < json.size(); ++i) {
    const char c = json[i];
    if (quote != 0) {
      if (c == '\\') ++i;
      if (c == quote) quote = 0;
    } else if (c == '"' || c == '\'') {
      quote = c;
    } else if (c == ',' || c == '{' || c == '[') {
      ++count;
    }
  }
  return count;
}

}  // namespace

const google::protobuf::MethodDescriptor* FindMethod(const std::string& path) {
  constexpr char kPackage[] = "/axiscal.v1.";
  const size_t slash = path.rfind('/');
  if (path.rfind(kPackage, 0) != 0 || slash == 0) return nullptr;
  const google::protobuf::ServiceDescriptor* const service =
      google::protobuf::DescriptorPool::generated_pool()->FindServiceByName(path.substr(1, slash - 1));
  return service == nullptr ? nullptr : service->FindMethodByName(path.substr(slash + 1));
}

std::optional<ContentType> ContentTypeOf(const std::string& field) {
  const std::vector<std::string> words = Words(absl::AsciiStrToLower(field), ';');
  const bool is_json = words[0] == "application/json" || words[0] == "application/connect+json";
  const bool is_proto = words[0] == "application/proto" || words[0] == "application/connect+proto";
  const bool has_charset = words.size() == 2 && (words[1] == "charset=utf-8" || words[1] == "charset=\"utf-8\"");
  if ((!is_json && !is_proto) || (words.size() > 1 && !(is_json && has_charset))) return std::nullopt;
  return ContentType{is_json ? Codec::kJson : Codec::kProto, words[0].rfind("application/connect+", 0) == 0};
}

std::string NameOf(const ContentType& type) {
  return absl::StrCat("application/", type.is_stream ? "connect+" : "", type.codec == Codec::kJson ? "json" : "proto");
}

int64_t PartsOf(const google::protobuf::Descriptor& type, Codec codec, const std::string& bytes) {
  if (codec == Codec::kJson) return CountValues(bytes);
  google::protobuf::io::ArrayInputStream in(bytes.data(), static_cast<int>(bytes.size()));
  return guard::CountParts(type, in, guard::kMostParts);
}

int64_t BytesToRead(const google::protobuf::Descriptor& type, Codec codec, const std::string& text) {
  return kRequestFactor * static_cast<int64_t>(text.size()) +
         kPartBytes * std::min(PartsOf(type, codec, text), guard::kMostParts);
}

int64_t BytesToWrite(Codec codec, const std::string& binary) {
  return (codec == Codec::kProto ? 2 : kAnswerFactor) * static_cast<int64_t>(binary.size());
}

absl::StatusOr<std::string> ToBinary(const google::protobuf::Descriptor& type, Codec codec, const std::string& bytes,
                                     int most_bytes) {
  const auto too_large = [](const std::string& what) {
    return base::Error(absl::StatusCode::kResourceExhausted, what, {"MESSAGE_TOO_LARGE", {}});
  };
  if (PartsOf(type, codec, bytes) > guard::kMostParts)
    return too_large(absl::StrCat("a message of more than ", guard::kMostParts, " parts"));
  const std::unique_ptr<google::protobuf::Message> message = NewMessage(type);
  if (codec == Codec::kJson) {
    // Strictly: what lets unknown fields pass also reads an unknown name of an enum value as 0.
    const auto parsed = google::protobuf::util::JsonStringToMessage(bytes, message.get(), {});
    if (!parsed.ok()) return Invalid("the JSON is no " + type.name() + ": " + OneLine(std::string(parsed.message())));
  } else if (!message->ParseFromString(bytes)) {
    return Invalid("the bytes are no " + type.name());
  }
  std::string binary = codec == Codec::kJson ? message->SerializeAsString() : bytes;
  if (binary.size() > static_cast<size_t>(most_bytes))
    return too_large(absl::StrCat("a message of ", binary.size(), " bytes, must be at most ", most_bytes));
  return binary;
}

absl::StatusOr<std::string> FromBinary(const google::protobuf::Descriptor& type, Codec codec, std::string binary) {
  if (codec == Codec::kProto) return binary;
  const std::unique_ptr<google::protobuf::Message> message = NewMessage(type);
  std::string json;
  if (!message->ParseFromString(binary) || !google::protobuf::util::MessageToJsonString(*message, &json).ok())
    return absl::InternalError("a reply that is no " + type.name());
  return json;
}

std::string Envelope(unsigned flags, const std::string& message) {
  std::string envelope(1, static_cast<char>(flags));
  for (int shift = 24; shift >= 0; shift -= 8) envelope += static_cast<char>((message.size() >> shift) & 0xff);
  return envelope + message;
}

absl::StatusOr<std::string> OnlyMessage(const std::string& body) {
  const auto count = [](const std::string& what) {
    return base::Error(absl::StatusCode::kUnimplemented, what + " in the request, must be one", {"MESSAGE_COUNT", {}});
  };
  if (body.empty()) return count("no message");
  if (body.size() < kEnvelopeHead)
    return Invalid(absl::StrCat("an envelope of ", body.size(), " bytes, must be 5 and its message"));
  const auto byte = [&](size_t i) { return static_cast<unsigned char>(body[i]); };
  if ((byte(0) & kCompressed) != 0) {
    return base::Error(absl::StatusCode::kInternal, "a compressed message without a Connect-Content-Encoding",
                       {"CODING_UNKNOWN", {}});
  }
  if (byte(0) != 0) return Invalid(absl::StrCat("an envelope with the flags ", byte(0), ", must be 0"));
  size_t size = 0;
  for (size_t i = 1; i < kEnvelopeHead; ++i) size = size << 8 | byte(i);
  const size_t have = body.size() - kEnvelopeHead;
  if (have < size) return Invalid(absl::StrCat("an envelope of ", size, " bytes that has ", have));
  if (have > size) return count("several messages");
  return body.substr(kEnvelopeHead);
}

}  // namespace axiscal::http
