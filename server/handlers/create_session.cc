#include "server/handlers/create_session.h"

#include "proto/convert/field.h"
#include "proto/convert/session.h"
#include "server/handlers/session_check.h"

namespace axiscal::handlers {

absl::StatusOr<v1::CreateSessionResponse> CreateSession(Core& core, const Call& call,
                                                        const v1::CreateSessionRequest& request) {
  RETURN_IF_ERROR(RequireAccepting(core));
  RETURN_IF_ERROR(RequireRequestId(request.request_id()));
  absl::StatusOr<records::SessionSchema> schema = convert::FromProto(request.schema());
  if (!schema.ok()) return convert::InField("schema", schema.status());
  const MachineId machine_id(request.machine_id());
  RETURN_IF_ERROR(CheckSchema(core, machine_id, *schema));
  ASSIGN_OR_RETURN(const records::SessionRecord record,
                   core.database.CreateSession(NewSessionOf(machine_id, *schema, call.By(request.request_id()))));
  v1::CreateSessionResponse response;
  *response.mutable_session() = convert::ToProto(record);
  response.set_max_chunk_readings(records::kMaxChunkReadings);
  response.set_max_chunk_bytes(convert::kMaxChunkBytes);
  response.set_window_chunks(core.limits.window_chunks);
  return response;
}

}  // namespace axiscal::handlers
