// A written table, read as its controller would read it, must be the table that was written.
#ifndef AXISCAL_CORE_COMPENSATE_TABLES_READ_BACK_H_
#define AXISCAL_CORE_COMPENSATE_TABLES_READ_BACK_H_

#include <string>

#include "core/compensate/tables/plan.h"

namespace axiscal::tables {

// The table that the format's reader makes of `text`. INTERNAL when it differs from `written` by more than rounding.
absl::StatusOr<compensate::Table> ReadBack(const Plan& plan, const compensate::Table& written, const std::string& text);

}  // namespace axiscal::tables

#endif  // AXISCAL_CORE_COMPENSATE_TABLES_READ_BACK_H_
