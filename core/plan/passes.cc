#include "core/plan/passes.h"

#include "core/base/demand.h"
#include "core/plan/session_builder.h"

namespace axiscal::plan {

PlannedSession InPasses(const PlannedSession& planned, int passes) {
  DEMAND(passes >= 2);
  PlannedSession out = planned;
  for (session::HeaderEntry& entry : out.session.header) {
    if (entry.key == "session") absl::StrAppend(&entry.value, "-x", passes);
  }
  absl::StrAppend(&out.text, ", ", passes, " passes there and back in one go");
  const int count = static_cast<int>(planned.session.reading_count());
  for (session::Column& column : out.session.columns) {
    const std::vector<double> once = column.values;
    const std::vector<std::string> texts = column.texts;
    const bool is_time = column.name == "t_s";
    const double step_s = is_time && count > 1 ? (once.back() - once.front()) / (count - 1) : 0.0;
    for (int pass = 1; pass < passes; ++pass) {
      // The end of one pass is the beginning of the next.
      for (int k = 1; k < count; ++k) {
        const int at = pass % 2 == 0 ? k : count - 1 - k;
        if (!once.empty()) column.values.push_back(is_time ? Rounded(column.values.back() + step_s) : once[at]);
        if (!texts.empty()) column.texts.push_back(texts[at]);
      }
    }
  }
  return out;
}

}  // namespace axiscal::plan
