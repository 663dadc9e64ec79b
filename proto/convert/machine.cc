#include "proto/convert/machine.h"

#include "proto/convert/field.h"
#include "proto/convert/time.h"

namespace axiscal::convert {

v1::Machine ToProto(const records::MachineRecord& record) {
  v1::Machine message;
  message.set_machine_id(record.id.text());
  message.set_description_json(record.description_json);
  message.set_etag(record.revision);
  message.set_created_utc_us(base::ToUtcUs(record.created_at));
  message.set_updated_utc_us(base::ToUtcUs(record.updated_at));
  SET_OPTIONAL_UTC(message, deleted_utc_us, record.deleted_at);
  return message;
}

absl::StatusOr<records::MachineRecord> FromProto(const v1::Machine& message) {
  RETURN_IF_ERROR(RequireText("machine_id", message.machine_id(), 1, 255));
  RETURN_IF_ERROR(RequireMessage("description_json", !message.description_json().empty()));
  RETURN_IF_ERROR(RequirePositive("etag", message.etag()));
  records::MachineRecord record;
  record.id = MachineId(message.machine_id());
  record.revision = message.etag();
  record.description_json = message.description_json();
  record.created_at = base::FromUtcUs(message.created_utc_us());
  record.updated_at = base::FromUtcUs(message.updated_utc_us());
  record.deleted_at = OPTIONAL_UTC(message, deleted_utc_us);
  return record;
}

}  // namespace axiscal::convert
