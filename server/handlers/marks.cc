#include "server/handlers/marks.h"

#include "proto/convert/field.h"
#include "proto/convert/history.h"
#include "server/handlers/known_errors.h"

namespace axiscal::handlers {
absl::StatusOr<v1::PutMarkResponse> PutMark(Core& core, const Call& call, const v1::PutMarkRequest& request) {
  RETURN_IF_ERROR(RequireRequestId(request.request_id()));
  ASSIGN_OR_RETURN(const records::NewMark mark, convert::FromProto(request));
  ASSIGN_OR_RETURN(const KnownErrors known, KnownErrors::Of(core.database, mark.machine));
  for (size_t i = 0; i < mark.symbols.size(); ++i)
    RETURN_IF_ERROR(known.Require(absl::StrCat("symbols[", i, "]"), mark.symbols[i]));
  ASSIGN_OR_RETURN(const records::Mark stored, core.database.PutMark(mark, call.By(request.request_id())));
  core.look_soon(stored.content.machine);
  v1::PutMarkResponse response;
  *response.mutable_mark() = convert::ToProto(stored);
  return response;
}

absl::StatusOr<v1::ListMarksResponse> ListMarks(Core& core, const Call&, const v1::ListMarksRequest& request) {
  RETURN_IF_ERROR(convert::RequireText("machine_id", request.machine_id(), 1, 255));
  ASSIGN_OR_RETURN(const records::PageRequest page, PageFrom(request.page_size(), request.page_token()));
  ASSIGN_OR_RETURN(const records::Page<records::Mark> marks,
                   core.database.ListMarks(MachineId(request.machine_id()), page));
  v1::ListMarksResponse response;
  for (const records::Mark& mark : marks.rows) *response.add_marks() = convert::ToProto(mark);
  response.set_next_page_token(marks.next_token);
  return response;
}

absl::StatusOr<v1::WithdrawMarkResponse> WithdrawMark(Core& core, const Call& call,
                                                      const v1::WithdrawMarkRequest& request) {
  ASSIGN_OR_RETURN(const records::Mark mark, core.database.WithdrawMark(MarkId(request.mark_id()), call.By()));
  core.look_soon(mark.content.machine);
  v1::WithdrawMarkResponse response;
  *response.mutable_mark() = convert::ToProto(mark);
  return response;
}

}  // namespace axiscal::handlers
