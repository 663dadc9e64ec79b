// NC programs on the wire: what is known about them; their bytes travel beside.
#ifndef AXISCAL_PROTO_CONVERT_PROGRAM_H_
#define AXISCAL_PROTO_CONVERT_PROGRAM_H_

#include "axiscal/v1/program.pb.h"
#include "core/base/status.h"
#include "core/records/program.h"

namespace axiscal::convert {

inline constexpr int kMaxProgramPartBytes = 256 << 10;

v1::Program ToProto(const records::ProgramRecord& record);
// A complete program. FIELD_INVALID: no id, a negative size, a checksum that is none.
absl::StatusOr<records::ProgramRecord> FromProto(const v1::Program& message);

}  // namespace axiscal::convert

#endif  // AXISCAL_PROTO_CONVERT_PROGRAM_H_
