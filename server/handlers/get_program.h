// Programs.GetProgram: what is known about a program, then its bytes from an offset on.
#ifndef AXISCAL_SERVER_HANDLERS_GET_PROGRAM_H_
#define AXISCAL_SERVER_HANDLERS_GET_PROGRAM_H_

#include "axiscal/v1/programs_service.pb.h"
#include "server/handlers/core.h"

namespace axiscal::handlers {

// `send` returns false when the caller has left.
absl::Status GetProgram(Core& core, const Call& call, const v1::GetProgramRequest& request,
                        const std::function<bool(const v1::GetProgramResponse&)>& send);

}  // namespace axiscal::handlers

#endif  // AXISCAL_SERVER_HANDLERS_GET_PROGRAM_H_
