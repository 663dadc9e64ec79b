#include "server/handlers/abort_session.h"

#include "proto/convert/session.h"

namespace axiscal::handlers {

absl::StatusOr<v1::AbortSessionResponse> AbortSession(Core& core, const Call& call,
                                                      const v1::AbortSessionRequest& request) {
  ASSIGN_OR_RETURN(const records::SessionRecord record, core.database.AbortSession(SessionId(request.session_id())));
  v1::AbortSessionResponse response;
  *response.mutable_session() = convert::ToProto(record);
  return response;
}

}  // namespace axiscal::handlers
