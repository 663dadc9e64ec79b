// What callers send by HTTP, and messages of any bytes: targets, content types, forms, envelopes; requests as JSON and
// in Protobuf's binary form, which must mean the same; what of the API names something is found in them.
#include <google/protobuf/message.h>
#include <google/protobuf/stubs/logging.h>

#include <algorithm>
#include <memory>

#include "axiscal/v1/ingest_service.pb.h"
#include "axiscal/v1/jobs_service.pb.h"
#include "core/base/crc32c.h"
#include "proto/convert/job_params.h"
#include "proto/convert/session.h"
#include "server/access/methods.h"
#include "server/access/named.h"
#include "server/http/exchange.h"
#include "server/http/messages.h"
#include "server/http/multipart.h"
#include "tests/fuzz/driver.h"

namespace axiscal::fuzz {
namespace {

using google::protobuf::Descriptor;
using google::protobuf::MethodDescriptor;

// Requests of all methods.
const std::vector<const Descriptor*>& Requests() {
  static const auto* const types = [] {
    auto* found = new std::vector<const Descriptor*>;
    const auto* const one = v1::Job::descriptor();  // links the generated descriptors
    MUST(one != nullptr);
    for (const access::MethodRule& rule : access::Methods()) {
      std::string path = "/axiscal.v1." + rule.method;
      path[path.rfind('.')] = '/';
      if (const MethodDescriptor* const method = http::FindMethod(path)) found->push_back(method->input_type());
    }
    MUST(found->size() > 30);
    return found;
  }();
  return *types;
}

void LookAtMessage(const Descriptor& type, http::Codec codec, const std::string& bytes) {
  constexpr int kMostBytes = 1 << 20;
  const auto binary = http::ToBinary(type, codec, bytes, kMostBytes);
  if (!binary.ok()) return;
  const std::unique_ptr<google::protobuf::Message> message(
      google::protobuf::MessageFactory::generated_factory()->GetPrototype(&type)->New());
  MUST(message->ParseFromString(*binary));
  // What is taken of the budget for it is no less than what it takes.
  constexpr int64_t kEmptyBytes = 4096;  // of the message itself
  MUST(static_cast<int64_t>(message->SpaceUsedLong()) <= http::BytesToRead(type, codec, bytes) + kEmptyBytes);
  for (const storage::Resource& named : access::NamedIn(*message)) MUST(!named.name.empty() || named.number != 0);
  if (const auto* const job = dynamic_cast<const v1::CreateJobRequest*>(message.get())) {
    if (const auto params = convert::FromProto(job->params()); params.ok())
      MUST(convert::ParseJobParams(convert::Serialize(*params)).ok());
  }
  if (const auto* const upload = dynamic_cast<const v1::UploadRequest*>(message.get())) {
    const std::vector<records::ColumnSpec> columns = {{"t_s", false}, {"X_mm", false}, {"feature", true}};
    const auto chunk = convert::FromProto(upload->chunk(), columns);
    MUST(chunk.ok() || !chunk.status().message().empty());
  }
  if (codec == http::Codec::kProto) return;
  // What was taken as JSON is JSON again, of the same message.
  const auto json = http::FromBinary(type, http::Codec::kJson, *binary);
  MUST(json.ok());
  const auto again = http::ToBinary(type, http::Codec::kJson, *json, kMostBytes);
  MUST(again.ok() && *again == *binary);
}

}  // namespace

void Look(const std::string& bytes) {
  static const google::protobuf::LogSilencer* const silence = new google::protobuf::LogSilencer();
  MUST(silence != nullptr);
  std::string path;
  std::map<std::string, std::string> query;
  if (http::SplitTarget(bytes, &path, &query)) MUST(!path.empty() && path[0] == '/');
  static_cast<void>(http::PercentDecoded(bytes));
  MUST(!http::Words(bytes, ';').empty());
  if (const auto type = http::ContentTypeOf(bytes)) MUST(http::ContentTypeOf(http::NameOf(*type)).has_value());
  static_cast<void>(http::FindMethod(bytes));
  static_cast<void>(http::ReadMultipart(bytes, "--b\r\n"));
  if (const auto form = http::ReadMultipart("multipart/form-data; boundary=b", bytes); form.ok()) {
    size_t held = 0;
    for (const auto& [name, part] : *form) {
      MUST(!name.empty() && part.file.find('/') == std::string::npos);
      held += name.size() + part.text.size();
    }
    MUST(held <= bytes.size());
  }
  const auto only = http::OnlyMessage(bytes);
  MUST(!only.ok() || http::Envelope(0, *only) == bytes);
  // One request type per input; mutations meet all of them. JSON says by itself which fields it has: try them all.
  const std::vector<const Descriptor*>& types = Requests();
  LookAtMessage(*types[base::Crc32c(0, bytes.data(), bytes.size()) % types.size()], http::Codec::kProto, bytes);
  for (const Descriptor* const type : types) LookAtMessage(*type, http::Codec::kJson, bytes);
}

}  // namespace axiscal::fuzz
