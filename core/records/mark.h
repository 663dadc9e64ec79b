// What a person says has happened to a machine. It stands in the machine's history and ends what was known of where its
// errors stand (docs/drift.md, "Marks").
#ifndef AXISCAL_CORE_RECORDS_MARK_H_
#define AXISCAL_CORE_RECORDS_MARK_H_

#include <optional>
#include <string>
#include <vector>

#include "core/base/clock.h"
#include "core/base/ids.h"

namespace axiscal::records {

// Never renumber.
enum class MarkKind { kCollision = 1, kService = 2, kRefixturing = 3 };

struct NewMark {
  MachineId machine;
  base::UtcTime at;  // when it happened; calibrations measured until then stand before it
  MarkKind kind = MarkKind::kCollision;
  std::vector<std::string> symbols;  // the errors that it can have moved ("EX0C"); empty: all
  std::string note;                  // in the person's words
};

struct Mark {
  MarkId id;
  NewMark content;
  std::string created_by;
  base::UtcTime created_at;
  std::string withdrawn_by;  // it was put in by mistake and counts no more
  std::optional<base::UtcTime> withdrawn_at;
};

}  // namespace axiscal::records

#endif  // AXISCAL_CORE_RECORDS_MARK_H_
