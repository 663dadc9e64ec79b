#include "server/access/named.h"

#include <google/protobuf/descriptor.h>

#include <algorithm>
#include <map>

#include "core/machine/machine_json.h"

namespace axiscal::access {
namespace {

using google::protobuf::FieldDescriptor;
using google::protobuf::Message;
using google::protobuf::Reflection;
using storage::Resource;
using storage::ResourceKind;

constexpr char kDescription[] = "description_json";

const std::map<std::string, ResourceKind>& Kinds() {
  static const auto* const kinds = new std::map<std::string, ResourceKind>{
      {"approved_of_machine_id", ResourceKind::kMachine},
      {"calibration_id", ResourceKind::kCalibration},
      {"check_session_ids", ResourceKind::kSession},
      {"event_id", ResourceKind::kEvent},
      {"fit_session_ids", ResourceKind::kSession},
      {"held_calibration_id", ResourceKind::kCalibration},
      {"job_id", ResourceKind::kJob},
      {"machine_id", ResourceKind::kMachine},
      {"mark_id", ResourceKind::kMark},
      {"program_id", ResourceKind::kProgram},
      {"session_id", ResourceKind::kSession},
      {"session_ids", ResourceKind::kSession},
      {"with_calibration_id", ResourceKind::kCalibration},
  };
  return *kinds;
}

void AddText(ResourceKind kind, const std::string& text, std::vector<Resource>& named) {
  if (!text.empty()) named.push_back({kind, text, 0});
}

void AddNumber(ResourceKind kind, int64_t number, std::vector<Resource>& named) {
  if (number != 0) named.push_back({kind, "", number});
}

void Walk(const Message& message, std::vector<Resource>& named);

void AddField(const Message& message, const FieldDescriptor& field, std::vector<Resource>& named) {
  const Reflection& reflection = *message.GetReflection();
  const int count = field.is_repeated() ? reflection.FieldSize(message, &field) : 0;
  if (field.cpp_type() == FieldDescriptor::CPPTYPE_MESSAGE) {
    for (int i = 0; i < count; ++i) Walk(reflection.GetRepeatedMessage(message, &field, i), named);
    if (!field.is_repeated()) Walk(reflection.GetMessage(message, &field), named);
    return;
  }
  if (field.name() == kDescription) {
    const absl::StatusOr<machine::Machine> machine = machine::MachineFromJson(reflection.GetString(message, &field));
    if (machine.ok()) AddText(ResourceKind::kMachine, machine->id, named);
    return;
  }
  const std::optional<ResourceKind> kind = KindOf(field.name());
  if (!kind) return;
  if (field.cpp_type() == FieldDescriptor::CPPTYPE_STRING) {
    for (int i = 0; i < count; ++i) AddText(*kind, reflection.GetRepeatedString(message, &field, i), named);
    if (!field.is_repeated()) AddText(*kind, reflection.GetString(message, &field), named);
  } else if (field.cpp_type() == FieldDescriptor::CPPTYPE_INT64) {
    for (int i = 0; i < count; ++i) AddNumber(*kind, reflection.GetRepeatedInt64(message, &field, i), named);
    if (!field.is_repeated()) AddNumber(*kind, reflection.GetInt64(message, &field), named);
  }
}

void Walk(const Message& message, std::vector<Resource>& named) {
  std::vector<const FieldDescriptor*> fields;
  message.GetReflection()->ListFields(message, &fields);
  for (const FieldDescriptor* const field : fields) AddField(message, *field, named);
}

}  // namespace

std::optional<ResourceKind> KindOf(const std::string& field_name) {
  const auto found = Kinds().find(field_name);
  return found == Kinds().end() ? std::nullopt : std::optional(found->second);
}

bool IsKnownId(const std::string& field_name) {
  return KindOf(field_name).has_value() || field_name == "request_id" || field_name == "token_id" ||
         field_name == "after_change_id" || field_name == "change_id" || field_name == "up_to_change_id";
}

std::vector<Resource> NamedIn(const Message& request) {
  std::vector<Resource> named;
  Walk(request, named);
  // A job may name a session twice, and ten thousand of them.
  std::vector<Resource> once;
  std::sort(named.begin(), named.end());
  std::unique_copy(named.begin(), named.end(), std::back_inserter(once));
  return once;
}

}  // namespace axiscal::access
