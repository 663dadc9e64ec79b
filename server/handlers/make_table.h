// Tables.MakeTable: a compensation table of a machine's calibration.
#ifndef AXISCAL_SERVER_HANDLERS_MAKE_TABLE_H_
#define AXISCAL_SERVER_HANDLERS_MAKE_TABLE_H_

#include "axiscal/v1/tables_service.pb.h"
#include "server/handlers/core.h"

namespace axiscal::handlers {

absl::StatusOr<v1::MakeTableResponse> MakeTable(Core& core, const Call& call, const v1::MakeTableRequest& request);

}  // namespace axiscal::handlers

#endif  // AXISCAL_SERVER_HANDLERS_MAKE_TABLE_H_
