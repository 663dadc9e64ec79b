// History.PutMark, ListMarks, WithdrawMark: what people say has happened to a machine (docs/drift.md, "Marks").
#ifndef AXISCAL_SERVER_HANDLERS_MARKS_H_
#define AXISCAL_SERVER_HANDLERS_MARKS_H_

#include "axiscal/v1/history_service.pb.h"
#include "server/handlers/core.h"

namespace axiscal::handlers {

// FIELD_INVALID as the message says; also for an error that no calibration of the machine has, where it has any: a
// mark for a misspelt error would end nothing.
absl::StatusOr<v1::PutMarkResponse> PutMark(Core& core, const Call& call, const v1::PutMarkRequest& request);
absl::StatusOr<v1::ListMarksResponse> ListMarks(Core& core, const Call& call, const v1::ListMarksRequest& request);
absl::StatusOr<v1::WithdrawMarkResponse> WithdrawMark(Core& core, const Call& call,
                                                      const v1::WithdrawMarkRequest& request);

}  // namespace axiscal::handlers

#endif  // AXISCAL_SERVER_HANDLERS_MARKS_H_
