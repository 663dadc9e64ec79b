#include "proto/guard/message_guard.h"

#include <google/protobuf/io/coded_stream.h>
#include <google/protobuf/wire_format_lite.h>

#include <string>

namespace axiscal::guard {
namespace {

using google::protobuf::Descriptor;
using google::protobuf::FieldDescriptor;
using google::protobuf::internal::WireFormatLite;
using google::protobuf::io::CodedInputStream;

// Smaller messages are harmless, and most are.
constexpr size_t kHarmlessBytes = 64 << 10;

class Counter {
 public:
  Counter(CodedInputStream& in, int64_t most) : in_(in), most_(most) {}

  int64_t count() const { return count_; }
  // To the end of what is limited, or of a group. False where nothing more is to be counted.
  bool Message(const Descriptor* type) {
    while (count_ <= most_) {
      const uint32_t tag = in_.ReadTag();
      if (tag == 0 || WireFormatLite::GetTagWireType(tag) == WireFormatLite::WIRETYPE_END_GROUP) return true;
      if (!Field(tag, type == nullptr ? nullptr : type->FindFieldByNumber(WireFormatLite::GetTagFieldNumber(tag))))
        return false;
    }
    return false;
  }

 private:
  bool Field(uint32_t tag, const FieldDescriptor* field) {
    const auto wire_type = WireFormatLite::GetTagWireType(tag);
    const bool is_list = wire_type == WireFormatLite::WIRETYPE_LENGTH_DELIMITED;
    // What comes in another form than its field has is kept as what is not known.
    const bool is_number = field != nullptr && field->cpp_type() != FieldDescriptor::CPPTYPE_MESSAGE &&
                           field->cpp_type() != FieldDescriptor::CPPTYPE_STRING && (!is_list || field->is_packable());
    if (!is_number) ++count_;
    const bool is_message = field != nullptr && field->cpp_type() == FieldDescriptor::CPPTYPE_MESSAGE;
    if (wire_type == WireFormatLite::WIRETYPE_START_GROUP) {
      // The reader keeps what it does not know, with its depth.
      const bool is_whole = in_.IncrementRecursionDepth() && Message(nullptr);
      in_.DecrementRecursionDepth();
      return is_whole;
    }
    if (!is_message || !is_list) return WireFormatLite::SkipField(&in_, tag);
    int length = 0;
    if (!in_.ReadVarintSizeAsInt(&length)) return false;
    const auto [limit, depth_left] = in_.IncrementRecursionDepthAndPushLimit(length);
    return depth_left >= 0 && Message(field->message_type()) && in_.DecrementRecursionDepthAndPopLimit(limit);
  }

  CodedInputStream& in_;
  const int64_t most_;
  int64_t count_ = 0;
};

// Answers are the service's own.
const Descriptor* RequestType(const google::protobuf::MessageLite& message) {
  const std::string end = "Request", name = message.GetTypeName();
  const bool is_request = name.size() >= end.size() && name.compare(name.size() - end.size(), end.size(), end) == 0;
  const auto* const full = is_request ? dynamic_cast<const google::protobuf::Message*>(&message) : nullptr;
  return full == nullptr ? nullptr : full->GetDescriptor();
}

}  // namespace

int64_t CountParts(const Descriptor& type, google::protobuf::io::ZeroCopyInputStream& bytes, int64_t most) {
  CodedInputStream in(&bytes);
  Counter counter(in, most);
  counter.Message(&type);
  return counter.count();
}

grpc::Status GuardedMessage::Serialize(const google::protobuf::MessageLite& message, grpc::ByteBuffer* buffer,
                                       bool* own_buffer) {
  return grpc::GenericSerialize<grpc::ProtoBufferWriter, google::protobuf::MessageLite>(message, buffer, own_buffer);
}

grpc::Status GuardedMessage::Deserialize(grpc::ByteBuffer* buffer, google::protobuf::MessageLite* message) {
  const Descriptor* const type =
      buffer == nullptr || buffer->Length() < kHarmlessBytes ? nullptr : RequestType(*message);
  if (type != nullptr) {
    grpc::ProtoBufferReader reader(buffer);
    if (reader.status().ok() && CountParts(*type, reader, kMostParts) > kMostParts) {
      buffer->Clear();
      return {grpc::StatusCode::RESOURCE_EXHAUSTED,
              "a message of more than " + std::to_string(kMostParts) + " parts (messages, texts)"};
    }
  }
  return grpc::GenericDeserialize<grpc::ProtoBufferReader, google::protobuf::MessageLite>(buffer, message);
}

}  // namespace axiscal::guard
