#include <nlohmann/json.hpp>

#include "core/base/units.h"
#include "core/nc/verify.h"

namespace axiscal::nc {
namespace {

using Json = nlohmann::ordered_json;

Json SpreadJson(const Spread& spread) {
  return {{"max_um", spread.max_mm * base::kUmPerMm},
          {"rms_um", spread.rms_mm() * base::kUmPerMm},
          {"count", spread.count}};
}

Json SpreadJson(const AngleSpread& spread) {
  return {{"max_urad", spread.max_rad * base::kUradPerRad},
          {"rms_urad", spread.rms_rad() * base::kUradPerRad},
          {"count", spread.count}};
}

}  // namespace

std::string ToJson(const VerifyReport& report) {
  const auto both = [](const auto& before, const auto& after) {
    return Json{{"before", SpreadJson(before)}, {"after", SpreadJson(after)}};
  };
  Json json;
  json["moves"] = report.moves;
  json["pieces"] = report.pieces;
  json["moves_unknown"] = report.moves_unknown;
  json["blocks_unsupported"] = report.blocks_unsupported;
  json["end"] = both(report.end_before, report.end_after);
  json["path"] = both(report.path_before, report.path_after);
  json["end_tilt"] = both(report.end_tilt_before, report.end_tilt_after);
  json["path_tilt"] = both(report.path_tilt_before, report.path_tilt_after);
  json["blocks_passed"] = report.blocks_passed;
  json["ranges_not_judged"] = report.not_judged.count;
  json["not_judged"] = Json::array();
  for (const reports::LineRange& range : report.not_judged.listed)
    json["not_judged"].push_back({{"first", range.first}, {"last", range.last}, {"reason", range.reason}});
  json["worst_line"] = report.worst_line;
  return json.dump(1) + "\n";
}

}  // namespace axiscal::nc
