#include "core/compensate/tables/format.h"

namespace axiscal::tables {
namespace {

std::string StepText(const Format& format) {
  const Limits& limits = format.limits;
  const std::string free = limits.is_resolution_free ? " unless stated" : "";
  if (format.layout == Layout::kComponents)
    return absl::StrFormat("values to %g mm and %g rad", limits.value_step_mm, limits.value_step_deg);
  if (!limits.holds_rotary || format.layout == Layout::kPoints)
    return absl::StrFormat("values to %g mm", limits.value_step_mm) + free;
  return absl::StrFormat("values to %g mm or %g deg", limits.value_step_mm, limits.value_step_deg) + free;
}

}  // namespace

const std::vector<Format>& Formats() {
  static const std::vector<Format>* const kFormats = new std::vector<Format>{
      GeneralFormat(),       LinuxcncCompFormat(),         LinuxcncXyzacFormat(), LinuxcncXyzbcFormat(),
      SiemensEecFormat(),    SiemensCecFormat(),           FanucPitchFormat(),    FanucGridFormat(),
      HeidenhainComFormat(), HeidenhainKinematicsFormat(), IsgVolumetricFormat()};
  return *kFormats;
}

absl::StatusOr<const Format*> FindFormat(const std::string& name) {
  std::string names;
  for (const Format& format : Formats()) {
    if (format.name == name) return &format;
    absl::StrAppend(&names, names.empty() ? "" : ", ", format.name);
  }
  return absl::InvalidArgumentError(absl::StrCat("format '", name, "', expected one of ", names));
}

std::string LimitsText(const Format& format) {
  const Limits& limits = format.limits;
  std::string text;
  if (limits.max_points > 0) {
    absl::StrAppend(&text, limits.max_points, format.layout == Layout::kGrid ? " points per axis" : " points",
                    limits.equal_steps ? " at equal steps" : " anywhere",
                    limits.by_sense ? ", by sense of motion" : ", no sense of motion", "; ");
  }
  absl::StrAppend(&text, StepText(format));
  if (limits.largest_mm > 0) absl::StrAppend(&text, "; at most ", limits.largest_mm, " mm");
  if (limits.one_axis) absl::StrAppend(&text, "; one axis per file");
  return text;
}

}  // namespace axiscal::tables
