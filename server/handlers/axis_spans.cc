#include "server/handlers/axis_spans.h"

#include <algorithm>
#include <cmath>

#include "core/base/units.h"
#include "proto/convert/field.h"

namespace axiscal::handlers {

double UnitOf(const machine::Axis& axis) { return axis.kind == machine::AxisKind::kRotary ? base::kRadPerDeg : 1.0; }

absl::StatusOr<predict::Box> BoxOf(const machine::Machine& machine, const predict::Box& measured, const Spans& asked) {
  predict::Box box = measured;
  for (int i = 0; i < asked.size(); ++i) {
    const std::string field = absl::StrCat("box[", i, "]");
    const auto axis = std::find_if(machine.axes.begin(), machine.axes.end(),
                                   [&](const machine::Axis& one) { return one.name == asked[i].axis(); });
    if (axis == machine.axes.end())
      return convert::FieldError(field + ".axis", "'" + asked[i].axis() + "', is no axis of machine " + machine.id);
    const double from = asked[i].from_mm_or_deg(), to = asked[i].to_mm_or_deg();
    if (!std::isfinite(from) || !std::isfinite(to) || from > to)
      return convert::FieldError(field, absl::StrCat(from, " to ", to, ", must be finite and not fall"));
    for (int k = 0; k < i; ++k)
      if (asked[k].axis() == asked[i].axis()) return convert::FieldError(field + ".axis", "stands twice");
    const auto at = static_cast<size_t>(axis - machine.axes.begin());
    box.low[at] = from * UnitOf(*axis);
    box.high[at] = to * UnitOf(*axis);
  }
  return box;
}

void SetSpans(const machine::Machine& machine, const predict::Box& box, Spans* spans) {
  for (size_t i = 0; i < box.low.size(); ++i) {
    v1::AxisSpan& span = *spans->Add();
    span.set_axis(machine.axes[i].name);
    span.set_from_mm_or_deg(box.low[i] / UnitOf(machine.axes[i]));
    span.set_to_mm_or_deg(box.high[i] / UnitOf(machine.axes[i]));
  }
}

}  // namespace axiscal::handlers
