#include "server/handlers/list_table_formats.h"

#include "core/compensate/tables/format.h"
#include "proto/convert/table.h"

namespace axiscal::handlers {

absl::StatusOr<v1::ListTableFormatsResponse> ListTableFormats(Core& core, const Call& call,
                                                              const v1::ListTableFormatsRequest& request) {
  v1::ListTableFormatsResponse response;
  for (const tables::Format& format : tables::Formats())
    *response.add_formats() = convert::ToProto(records::Summary(format));
  return response;
}

}  // namespace axiscal::handlers
