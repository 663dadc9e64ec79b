#include "core/nc/report.h"

#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>

#include "absl/strings/str_format.h"
#include "core/base/units.h"

namespace axiscal::nc {
namespace {

using Json = nlohmann::ordered_json;

Json ToJsonValue(const Spread& spread) {
  return {{"max_um", spread.max_mm * base::kUmPerMm},
          {"rms_um", spread.rms_mm() * base::kUmPerMm},
          {"count", spread.count}};
}

Json ToJsonValue(const AngleSpread& spread) {
  return {{"max_urad", spread.max_rad * base::kUradPerRad},
          {"rms_urad", spread.rms_rad() * base::kUradPerRad},
          {"count", spread.count}};
}

Json ToJsonValue(const std::vector<Finding>& findings) {
  Json list = Json::array();
  for (const Finding& finding : findings) {
    list.push_back({{"line", finding.line}, {"block", finding.block}, {"reason", finding.reason}});
  }
  return list;
}

}  // namespace

double Spread::rms_mm() const { return count == 0 ? 0.0 : std::sqrt(sum_squares_mm2 / static_cast<double>(count)); }

double AngleSpread::rms_rad() const {
  return count == 0 ? 0.0 : std::sqrt(sum_squares_rad2 / static_cast<double>(count));
}

std::string ToJson(const RewriteReport& report) {
  Json json;
  json["calibration"] = report.calibration;
  json["null_correction"] = report.is_null_correction;
  json["blocks"] = {{"read", report.blocks_read},     {"corrected", report.blocks_corrected},
                    {"split", report.blocks_split},   {"inserted", report.blocks_inserted},
                    {"passed", report.blocks_passed}, {"refused", report.blocks_refused}};
  for (const AxisSpread& axis : report.axes) json["correction"][axis.axis] = ToJsonValue(axis.correction);
  json["tool_point_error"] = {{"before", ToJsonValue(report.error_before)}, {"after", ToJsonValue(report.error_after)}};
  json["tool_point_error_along_path"] = {{"before_at_most_um", report.path_before_max_mm * base::kUmPerMm},
                                         {"after_at_most_um", report.path_after_max_mm * base::kUmPerMm}};
  json["max_tilt_left_urad"] = report.max_tilt_left_rad * base::kUradPerRad;
  if (report.has_orientation) {
    Json& orientation = json["orientation"];
    orientation["max_rotary_correction_deg"] = report.max_rotary_correction_rad * base::kDegPerRad;
    for (const RotaryAxisSpread& axis : report.rotary_axes)
      orientation["correction"][axis.axis] = ToJsonValue(axis.correction);
    orientation["error"] = {{"before", ToJsonValue(report.tilt_before)}, {"after", ToJsonValue(report.tilt_after)}};
    orientation["blocks_not_reached"] = report.blocks_tilted;
    orientation["not_reached"] = ToJsonValue(report.tilted);
  }
  json["max_departure_um"] = report.max_departure_mm * base::kUmPerMm;
  json["passed"] = ToJsonValue(report.passed);
  json["refused"] = ToJsonValue(report.refused);
  json["notes"] = report.notes;
  if (report.has_source_crc32c) json["source_crc32c"] = absl::StrFormat("%08x", report.source_crc32c);
  // Programs hold bytes of any encoding: what is no UTF-8 is replaced, in the report only.
  return json.dump(1, ' ', false, Json::error_handler_t::replace) + "\n";
}

}  // namespace axiscal::nc
