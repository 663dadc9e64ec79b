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
  const session::Session head{schema->header, {}};
  storage::NewSession session;
  session.machine = machine_id;
  session.name = session::FindHeader(head, "session").value_or("");
  session.instrument = session::FindHeader(head, "instrument").value_or("");
  session.header = schema->header;
  session.measured_at = StartedAt(head);
  session.columns = schema->columns;
  session.caller = call.By(request.request_id());
  ASSIGN_OR_RETURN(const records::SessionRecord record, core.database.CreateSession(session));
  v1::CreateSessionResponse response;
  *response.mutable_session() = convert::ToProto(record);
  response.set_max_chunk_readings(records::kMaxChunkReadings);
  response.set_max_chunk_bytes(convert::kMaxChunkBytes);
  response.set_window_chunks(core.limits.window_chunks);
  return response;
}

}  // namespace axiscal::handlers
