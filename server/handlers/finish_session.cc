#include "server/handlers/finish_session.h"

#include "proto/convert/field.h"
#include "proto/convert/session.h"
#include "server/handlers/session_check.h"

namespace axiscal::handlers {

absl::StatusOr<v1::FinishSessionResponse> FinishSession(Core& core, const Call& call,
                                                        const v1::FinishSessionRequest& request) {
  absl::StatusOr<records::SessionTotals> totals = convert::FromProto(request.totals());
  if (!totals.ok()) return convert::InField("totals", totals.status());
  ASSIGN_OR_RETURN(const records::SessionRecord record, FinishChecked(core, SessionId(request.session_id()), *totals));
  v1::FinishSessionResponse response;
  *response.mutable_session() = convert::ToProto(record);
  return response;
}

}  // namespace axiscal::handlers
