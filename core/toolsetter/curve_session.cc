#include <algorithm>
#include <cmath>
#include <numbers>

#include "core/base/units.h"
#include "core/toolsetter/header_numbers.h"
#include "core/toolsetter/wear.h"

namespace axiscal::toolsetter {
namespace {

using base::kRadPerDeg;

absl::StatusOr<CurveSession> Read(const session::Session& session) {
  CurveSession out;
  out.session = session::FindHeader(session, "session").value_or("");
  const std::string instrument = session::FindHeader(session, "instrument").value_or("");
  if (instrument != "tool-curve") {
    return absl::InvalidArgumentError("instrument: '" + instrument + "', expected 'tool-curve'");
  }
  ASSIGN_OR_RETURN(out.sigma_mm, CurveSigmaMm(session));
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

}  // namespace

absl::StatusOr<double> CurveSigmaMm(const session::Session& session) {
  ASSIGN_OR_RETURN(const std::vector<double> sigma_um, HeaderNumbers(session, "sigma_um", 1, "one number in um"));
  if (sigma_um.empty() || !(sigma_um[0] > 0.0))
    return absl::InvalidArgumentError("sigma_um: expected a number above 0");
  return sigma_um[0] * base::kMmPerUm;
}

absl::StatusOr<CurveSession> ReadCurveSession(const session::Session& session) {
  auto out = Read(session);
  if (!out.ok()) return base::Within("session " + session::FindHeader(session, "session").value_or("?"), out.status());
  return out;
}

}  // namespace axiscal::toolsetter
