#include "server/handlers/list_table_formats.h"

#include "core/compensate/tables/format.h"

namespace axiscal::handlers {

absl::StatusOr<v1::ListTableFormatsResponse> ListTableFormats(Core& core, const Call& call,
                                                              const v1::ListTableFormatsRequest& request) {
  v1::ListTableFormatsResponse response;
  for (const tables::Format& format : tables::Formats()) {
    v1::TableFormat* const out = response.add_formats();
    out->set_name(format.name);
    out->set_title(format.title);
    out->set_values(format.values);
    out->set_limits(tables::LimitsText(format) + (format.assumed.empty() ? "" : "; assumed: " + format.assumed));
    if (format.limits.max_points > 0) out->set_max_points(format.limits.max_points);
    for (const std::string& what : format.cannot_carry) out->add_cannot_carry(what);
  }
  return response;
}

}  // namespace axiscal::handlers
