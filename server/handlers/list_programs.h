// Programs.ListPrograms: a page, newest first.
#ifndef AXISCAL_SERVER_HANDLERS_LIST_PROGRAMS_H_
#define AXISCAL_SERVER_HANDLERS_LIST_PROGRAMS_H_

#include "axiscal/v1/programs_service.pb.h"
#include "server/handlers/core.h"

namespace axiscal::handlers {

absl::StatusOr<v1::ListProgramsResponse> ListPrograms(Core& core, const Call& call,
                                                      const v1::ListProgramsRequest& request);

}  // namespace axiscal::handlers

#endif  // AXISCAL_SERVER_HANDLERS_LIST_PROGRAMS_H_
