#include "core/records/table.h"

#include "absl/strings/str_cat.h"
#include "core/compensate/tables/format.h"

namespace axiscal::records {

TableFormat Summary(const tables::Format& format) {
  TableFormat summary{format.name, format.title, format.values, tables::LimitsText(format), {}, format.cannot_carry};
  if (!format.assumed.empty()) absl::StrAppend(&summary.limits, "; assumed: ", format.assumed);
  if (format.limits.max_points > 0) summary.max_points = format.limits.max_points;
  return summary;
}

}  // namespace axiscal::records
