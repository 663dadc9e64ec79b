// Tables.ListTableFormats.
#ifndef AXISCAL_SERVER_HANDLERS_LIST_TABLE_FORMATS_H_
#define AXISCAL_SERVER_HANDLERS_LIST_TABLE_FORMATS_H_

#include "axiscal/v1/tables_service.pb.h"
#include "server/handlers/core.h"

namespace axiscal::handlers {

absl::StatusOr<v1::ListTableFormatsResponse> ListTableFormats(Core& core, const Call& call,
                                                              const v1::ListTableFormatsRequest& request);

}  // namespace axiscal::handlers

#endif  // AXISCAL_SERVER_HANDLERS_LIST_TABLE_FORMATS_H_
