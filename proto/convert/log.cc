#include "proto/convert/log.h"

#include "proto/convert/field.h"
#include "proto/convert/program.h"
#include "proto/convert/session.h"

namespace axiscal::convert {
namespace {

constexpr size_t kMaxNameBytes = 255;

absl::Status RequireBytes(const std::string& field, const std::string& text, size_t min, size_t max) {
  if (text.size() >= min && text.size() <= max) return absl::OkStatus();
  return FieldError(field, absl::StrCat(text.size(), " bytes, must be ", min, " to ", max));
}

}  // namespace

v1::LogForm ToProto(const records::LogForm& form) {
  v1::LogForm message;
  message.set_template_text(form.template_text);
  message.set_template_name(form.template_name);
  message.set_plan_text(form.plan_text);
  message.set_plan_name(form.plan_name);
  message.set_session_name(form.session);
  if (form.start_s) message.set_start_s(*form.start_s);
  return message;
}

absl::StatusOr<records::LogForm> FromProto(const v1::LogForm& message) {
  RETURN_IF_ERROR(RequireBytes("template_text", message.template_text(), 1, records::kMaxTemplateBytes));
  RETURN_IF_ERROR(RequireText("template_name", message.template_name(), 0, kMaxNameBytes));
  RETURN_IF_ERROR(RequireBytes("plan_text", message.plan_text(), 0, records::kMaxPlanBytes));
  RETURN_IF_ERROR(RequireText("plan_name", message.plan_name(), 0, kMaxNameBytes));
  RETURN_IF_ERROR(RequireText("session_name", message.session_name(), 0, kMaxNameBytes));
  if (message.has_start_s()) RETURN_IF_ERROR(RequireFinite("start_s", message.start_s()));
  records::LogForm form{message.template_text(), message.template_name(), message.plan_text(),
                        message.plan_name(),     message.session_name(),  std::nullopt};
  if (message.has_start_s()) form.start_s = message.start_s();
  return form;
}

v1::PutLogResponse ToProto(const records::StoredLog& stored) {
  v1::PutLogResponse message;
  *message.mutable_session() = ToProto(stored.session);
  message.set_was_there(stored.was_there);
  *message.mutable_log() = ToProto(stored.log);
  for (const std::string& note : stored.notes) message.add_notes(note);
  message.set_first_line(stored.first_line);
  message.set_last_line(stored.last_line);
  message.set_cut_line(stored.cut_line.value_or(0));
  return message;
}

absl::StatusOr<records::StoredLog> FromProto(const v1::PutLogResponse& message) {
  records::StoredLog stored;
  ASSIGN_OR_RETURN(stored.session, FromProto(message.session()));
  stored.was_there = message.was_there();
  ASSIGN_OR_RETURN(stored.log, FromProto(message.log()));
  stored.notes.assign(message.notes().begin(), message.notes().end());
  stored.first_line = message.first_line();
  stored.last_line = message.last_line();
  if (message.cut_line() > 0) stored.cut_line = message.cut_line();
  return stored;
}

}  // namespace axiscal::convert
