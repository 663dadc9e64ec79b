// Routines and their runs on the wire.
#ifndef AXISCAL_PROTO_CONVERT_ROUTINE_H_
#define AXISCAL_PROTO_CONVERT_ROUTINE_H_

#include "axiscal/v1/routines_service.pb.h"
#include "core/base/status.h"
#include "core/records/routine.h"

namespace axiscal::convert {

v1::Routine ToProto(const records::Routine& routine);
v1::Routine ToProto(const records::RoutineRecord& record);
// What a person says of it. FIELD_INVALID with the field's path: a name that is none, a scope of all machines, a
// session without a name or there twice, options of another work, a number out of range.
absl::StatusOr<records::Routine> FromProto(const v1::Routine& message);
// As a server sends it.
absl::StatusOr<records::RoutineRecord> RecordFromProto(const v1::Routine& message);

v1::RoutineRun ToProto(const records::RoutineRun& run);
// States of newer servers are read as their number.
absl::StatusOr<records::RoutineRun> FromProto(const v1::RoutineRun& message);

}  // namespace axiscal::convert

#endif  // AXISCAL_PROTO_CONVERT_ROUTINE_H_
