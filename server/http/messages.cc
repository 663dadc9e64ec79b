#include "server/http/messages.h"

#include <google/protobuf/message.h>
#include <google/protobuf/util/json_util.h>

#include <memory>

#include "absl/strings/ascii.h"
#include "core/base/error_detail.h"
#include "core/base/utf8.h"
#include "server/http/exchange.h"

namespace axiscal::http {
namespace {

constexpr size_t kEnvelopeHead = 5;  // bytes
// Of the parser's complaint, which shows its input.
constexpr size_t kMaxComplaint = 300;

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

absl::StatusOr<std::string> ToBinary(const google::protobuf::Descriptor& type, Codec codec, const std::string& bytes,
                                     int most_bytes) {
  const std::unique_ptr<google::protobuf::Message> message = NewMessage(type);
  if (codec == Codec::kJson) {
    // Strictly: what lets unknown fields pass also reads an unknown name of an enum value as 0.
    const auto parsed = google::protobuf::util::JsonStringToMessage(bytes, message.get(), {});
    if (!parsed.ok()) return Invalid("the JSON is no " + type.name() + ": " + OneLine(std::string(parsed.message())));
  } else if (!message->ParseFromString(bytes)) {
    return Invalid("the bytes are no " + type.name());
  }
  std::string binary = codec == Codec::kJson ? message->SerializeAsString() : bytes;
  if (binary.size() > static_cast<size_t>(most_bytes)) {
    return base::Error(absl::StatusCode::kResourceExhausted,
                       absl::StrCat("a message of ", binary.size(), " bytes, must be at most ", most_bytes),
                       {"MESSAGE_TOO_LARGE", {}});
  }
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
