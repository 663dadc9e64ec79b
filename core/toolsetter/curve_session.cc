#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>
#include <numbers>

#include "core/base/units.h"
#include "core/toolsetter/header_numbers.h"
#include "core/toolsetter/wear.h"

namespace axiscal::toolsetter {
namespace {

using base::kDegPerRad;
using base::kRadPerDeg;
using base::kUmPerMm;
using Json = nlohmann::ordered_json;

absl::StatusOr<CurveSession> Read(const session::Session& session) {
  CurveSession out;
  out.session = session::FindHeader(session, "session").value_or("");
  const std::string instrument = session::FindHeader(session, "instrument").value_or("");
  if (instrument != "tool-curve") {
    return absl::InvalidArgumentError("instrument: '" + instrument + "', expected 'tool-curve'");
  }
  ASSIGN_OR_RETURN(const std::vector<double> sigma_um, HeaderNumbers(session, "sigma_um", 1, "one number in um"));
  if (sigma_um.empty() || !(sigma_um[0] > 0.0))
    return absl::InvalidArgumentError("sigma_um: expected a number above 0");
  out.sigma_mm = sigma_um[0] * base::kMmPerUm;
  ASSIGN_OR_RETURN(const std::vector<double> start_sigma_deg,
                   HeaderNumbers(session, "start_sigma_deg", 1, "one standard deviation in deg"));
  const double sigma_deg = start_sigma_deg.empty() ? kUsualStartSigmaDeg : start_sigma_deg[0];
  if (!(sigma_deg >= 0.0 && sigma_deg <= 30.0))
    return absl::InvalidArgumentError(absl::StrFormat("start_sigma_deg: %g, expected 0 to 30 deg", sigma_deg));
  out.start_sigma_rad = sigma_deg * kRadPerDeg;
  ASSIGN_OR_RETURN(const CutterDescription description, ReadCutterKeys(session));
  out.cutter = description.cutter;
  out.run = description.run;
  const session::Column* const starts = session::FindColumn(session, "start_deg");
  const session::Column* const lengths = session::FindColumn(session, "length_mm");
  if (starts == nullptr || lengths == nullptr)
    return absl::InvalidArgumentError("column start_deg or length_mm is missing");
  for (const double start_deg : starts->values) out.starts_rad.push_back(start_deg * kRadPerDeg);
  out.lengths_mm = lengths->values;
  std::vector<double> angles;
  for (const double start_rad : out.starts_rad)
    angles.push_back(start_rad - 2.0 * std::numbers::pi * std::floor(start_rad / (2.0 * std::numbers::pi)));
  std::sort(angles.begin(), angles.end());
  constexpr double kApartRad = 0.5 * kRadPerDeg;
  int different = angles.empty() ? 0 : 1;
  for (size_t i = 1; i < angles.size(); ++i) different += angles[i] - angles[i - 1] > kApartRad;
  const int least = out.cutter.inserts + 2;
  if (different < least) {
    return absl::InvalidArgumentError(
        absl::StrFormat("readings at %d start angles, expected at least %d: one length per insert (%d), the phase, and "
                        "one to judge them by",
                        different, least, out.cutter.inserts));
  }
  return out;
}

Json Optional(bool is_there, double number) { return is_there ? Json(number) : Json(); }

}  // namespace

absl::StatusOr<CurveSession> ReadCurveSession(const session::Session& session) {
  auto out = Read(session);
  if (!out.ok()) return base::Within("session " + session::FindHeader(session, "session").value_or("?"), out.status());
  return out;
}

std::string ToJson(const CurveSession& session, const WearReport& report) {
  Json json;
  json["session"] = session.session;
  json["length_mm"] = report.length_mm;
  json["length_sigma_um"] = report.length_sigma_mm * kUmPerMm;
  json["phase_deg"] = report.phase_rad * kDegPerRad;
  json["phase_sigma_deg"] = report.phase_sigma_rad * kDegPerRad;
  json["inserts"] = Json::array();
  for (size_t k = 0; k < report.inserts.size(); ++k) {
    const InsertWear& insert = report.inserts[k];
    Json row = {{"insert", k + 1},
                {"identifiable", insert.is_identifiable},
                {"wear_um", Optional(insert.is_identifiable, insert.wear_mm * kUmPerMm)},
                {"sigma_um", Optional(insert.is_identifiable, insert.sigma_mm * kUmPerMm)}};
    if (!insert.is_identifiable) row["at_least_um"] = insert.at_least_mm * kUmPerMm;
    row["readings"] = insert.readings;
    row["fires_first_deg"] = insert.share_rad * kDegPerRad;
    row["unseen_from_um"] = insert.unseen_from_mm * kUmPerMm;
    json["inserts"].push_back(std::move(row));
  }
  json["fit"] = {
      {"rms_um", report.rms_mm * kUmPerMm}, {"chi2", report.chi2}, {"degrees_of_freedom", report.degrees_of_freedom}};
  json["warnings"] = Json::array();
  constexpr double kPoorFit = 4.0;  // twice the stated sigma
  if (report.degrees_of_freedom > 0 && report.chi2 > kPoorFit * report.degrees_of_freedom) {
    json["warnings"].push_back(
        {{"kind", "scatter"},
         {"text",
          absl::StrFormat("the readings scatter by %.1f times their stated sigma about the curves of this cutter: "
                          "a number of it is another, or readings are bad",
                          std::sqrt(report.chi2 / report.degrees_of_freedom))}});
  }
  json["longest_reading_mm"] = report.longest_reading_mm;
  json["readings"] = Json::array();
  for (size_t i = 0; i < report.residual_mm.size(); ++i) {
    json["readings"].push_back({{"start_deg", session.starts_rad[i] * kDegPerRad},
                                {"length_mm", session.lengths_mm[i]},
                                {"residual_um", report.residual_mm[i] * kUmPerMm}});
  }
  if (report.propose_feed_mm_min)
    json["next_measurement"] = {{"feed_mm_min", *report.propose_feed_mm_min}, {"spindle_rpm", session.run.spindle_rpm}};
  return json.dump(1) + "\n";
}

}  // namespace axiscal::toolsetter
