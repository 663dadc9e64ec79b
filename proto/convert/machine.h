// Machines on the wire. The description travels as its JSON text; machine::MachineFromJson reads it.
#ifndef AXISCAL_PROTO_CONVERT_MACHINE_H_
#define AXISCAL_PROTO_CONVERT_MACHINE_H_

#include "axiscal/v1/machine.pb.h"
#include "core/base/status.h"
#include "core/records/machine.h"

namespace axiscal::convert {

v1::Machine ToProto(const records::MachineRecord& record);
// INVALID_ARGUMENT FIELD_INVALID: no id, no description, an etag that is none.
absl::StatusOr<records::MachineRecord> FromProto(const v1::Machine& message);

}  // namespace axiscal::convert

#endif  // AXISCAL_PROTO_CONVERT_MACHINE_H_
