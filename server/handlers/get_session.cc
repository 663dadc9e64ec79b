#include "server/handlers/get_session.h"

#include "proto/convert/session.h"

namespace axiscal::handlers {

absl::StatusOr<v1::GetSessionResponse> GetSession(Core& core, const Call& call, const v1::GetSessionRequest& request) {
  ASSIGN_OR_RETURN(const records::SessionRecord record, core.database.GetSession(SessionId(request.session_id())));
  v1::GetSessionResponse response;
  *response.mutable_session() = convert::ToProto(record);
  *response.mutable_schema() = convert::ToProto(records::SessionSchema{record.header, record.columns});
  return response;
}

}  // namespace axiscal::handlers
