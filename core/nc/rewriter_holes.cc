// Holes of drilling cycles: X and Y are right where the drill goes in, Z at the bottom. What the drill leans between
// them has no word in a cycle.
#include <algorithm>
#include <optional>

#include "core/base/units.h"
#include "core/nc/rewriter_impl.h"

namespace axiscal::nc {

double Rewriter::Impl::LeftAt(const Piece& wanted, const Commanded& at) const {
  Eigen::Vector3d left_mm = Eigen::Vector3d::Zero();
  const std::vector<int>& axes = compensator.linear_axes();
  for (size_t k = 0; k < axes.size(); ++k) {
    const double off_mm = static_cast<double>(at.ticks[axes[k]] - wanted.targets[axes[k]]) / kTicksPerUnit;
    left_mm += wanted.correction.tip_per_mm[k] * off_mm;
  }
  return left_mm.norm() + wanted.correction.after_mm;
}

double Rewriter::Impl::RoundingMm() const {
  double rounding_mm = 0.0;
  for (const int axis : compensator.linear_axes()) {
    const Ticks grain = GrainTicks(interpreter.ticks_per_unit(axis),
                                   interpreter.modal().is_inch ? options.decimals_inch : options.decimals_mm);
    rounding_mm += static_cast<double>(grain) / kTicksPerUnit;
  }
  return rounding_mm;
}

void Rewriter::Impl::Drill() {
  const int z = interpreter.AxisOf('Z');
  const Positions behind = step.end;
  const Ticks entry_height = step.hole.entry, bottom_height = step.hole.bottom;
  step.end.ticks[z] = entry_height;
  step.end.known |= static_cast<uint16_t>(1u << z);
  step.end.sense[z] = -1;
  bool is_consequence = false;
  const std::string unknown = UnknownPosition(&is_consequence);
  const std::string turns_back = step.is_tool_point ? WhyNoToolPoint() : "";
  if (!unknown.empty() || !turns_back.empty()) {
    AskStart();
    step.end = behind;
    NotCorrected(unknown.empty() ? turns_back : unknown, is_consequence);
    if (MustReturn()) Return();
    return Copy();
  }
  Piece entry, bottom;
  absl::Status corrected = corrector().CorrectEnd(step, WordGrain(), &entry);
  step.end.ticks[z] = bottom_height;
  if (corrected.ok()) corrected = corrector().CorrectEnd(step, WordGrain(), &bottom);
  step.end = behind;
  if (!corrected.ok()) {
    job.Refused(now, std::string(corrected.message()), false);
    return Copy();
  }
  job.SetPlace(interpreter.tool(), interpreter.coordinates());
  ++job.report().blocks_corrected;
  std::optional<Commanded> before;
  if (step.may_be_skipped) before = writer.commanded();
  const size_t begin = out.size();
  writer.WriteHole(now.text, now.size, block, step, entry, bottom, &out);
  CheckLength(begin);
  if (!is_mark_written && !IsWrittenAsItWas(begin)) WriteMark(begin);
  Commanded at = writer.commanded();
  at.ticks[z] = writer.hole_entry();
  job.BreakPath();
  job.Account(now, entry, at, 0.0);
  job.BreakPath();
  at.ticks[z] = writer.hole_bottom();
  job.Account(now, bottom, at, 0.0);
  job.BreakPath();
  const bool is_fixed = step.hole.is_fixed;
  double left_mm = LeftAt(bottom, at);
  if (is_fixed) {  // its heights have no words here, nor has a call where the tool stands
    at.ticks[z] = writer.hole_entry();
    left_mm = std::max(left_mm, LeftAt(entry, at));
  }
  job.Drilled(now, left_mm, RoundingMm(),
              is_fixed && !step.hole.shifted_to
                  ? "the heights of a called cycle hold for all its holes, and the drill leans"
                  : "the drill leans, and the cycle has no word for it");
  if (passes()) writer.Arrive(step);
  if (before) writer.ForgetChanges(*before);
}

}  // namespace axiscal::nc
