#include "core/toolsetter/rod_session.h"

#include <algorithm>

#include "core/base/units.h"
#include "core/toolsetter/header_numbers.h"

namespace axiscal::toolsetter {
namespace {

using base::kMmPerUm;
using base::kRadPerDeg;

absl::Status CheckSigmas(const std::string& key, const std::vector<double>& sigmas) {
  if (std::all_of(sigmas.begin(), sigmas.end(), [](double sigma) { return sigma >= 0.0; })) return absl::OkStatus();
  return absl::InvalidArgumentError(key + ": a number below 0, expected standard deviations");
}

absl::StatusOr<MeasuredRod> ReadRod(const session::Session& session, const std::string& name) {
  MeasuredRod rod;
  rod.name = name;
  ASSIGN_OR_RETURN(const std::vector<double> n,
                   HeaderNumbers(session, "rod " + name, 6, "6 numbers: R_r R_f phi tau L_r theta_th in mm and deg"));
  if (n.empty()) return absl::InvalidArgumentError("rod " + name + ": is missing");
  // 90 deg means a square face, whatever a product of decimals makes of it.
  const double face_rad = n[2] == 90.0 ? 0.5 * std::numbers::pi : n[2] * kRadPerDeg;
  rod.rod = {n[0], n[1], face_rad, n[3] * kRadPerDeg, n[4], n[5] * kRadPerDeg};
  const std::string key = "rod_sigma " + rod.body();
  ASSIGN_OR_RETURN(const std::vector<double> s,
                   HeaderNumbers(session, key, 5, "5 standard deviations: R_r R_f phi tau L_r in mm and deg"));
  if (!s.empty()) {
    RETURN_IF_ERROR(CheckSigmas(key, s));
    rod.sigma = {s[0], s[1], s[2] * kRadPerDeg, s[3] * kRadPerDeg, s[4]};
  }
  RETURN_IF_ERROR(base::Within(name, Validate(rod.rod)));
  return rod;
}

absl::StatusOr<RodSession> Read(const session::Session& session) {
  RodSession out;
  out.session = session::FindHeader(session, "session").value_or("");
  const std::string instrument = session::FindHeader(session, "instrument").value_or("");
  if (instrument != "tool-setter") {
    return absl::InvalidArgumentError("instrument: '" + instrument + "', expected 'tool-setter'");
  }
  ASSIGN_OR_RETURN(const std::vector<double> sigma_um, HeaderNumbers(session, "sigma_um", 1, "one number in um"));
  ASSIGN_OR_RETURN(const std::vector<double> tip_mm, HeaderNumbers(session, "tool_tip_mm", 3, "three numbers in mm"));
  ASSIGN_OR_RETURN(const std::vector<double> beam,
                   HeaderNumbers(session, "beam", 3, "R_l in mm, yaw and pitch in deg"));
  if (sigma_um.empty() || tip_mm.empty() || beam.empty())
    return absl::InvalidArgumentError("sigma_um, tool_tip_mm or beam is missing");
  out.sigma_mm = sigma_um[0] * kMmPerUm;
  out.spindle_at_home_mm = tip_mm[2];
  out.beam = {beam[0], beam[1] * kRadPerDeg, beam[2] * kRadPerDeg};
  RETURN_IF_ERROR(Validate(out.beam));
  ASSIGN_OR_RETURN(const std::vector<double> s,
                   HeaderNumbers(session, "beam_sigma", 3, "3 standard deviations: R_l in mm, yaw and pitch in deg"));
  if (!s.empty()) {
    RETURN_IF_ERROR(CheckSigmas("beam_sigma", s));
    out.beam_sigma = {s[0], s[1] * kRadPerDeg, s[2] * kRadPerDeg};
  }
  for (const session::HeaderEntry& entry : session.header) {
    if (entry.key.rfind("rod ", 0) != 0) continue;
    ASSIGN_OR_RETURN(out.rods.emplace_back(), ReadRod(session, entry.key.substr(4)));
  }
  const session::Column* const names = session::FindColumn(session, "rod");
  const session::Column* const heights = session::FindColumn(session, "Z_mm");
  if (names == nullptr || heights == nullptr) return absl::InvalidArgumentError("column rod or Z_mm is missing");
  for (size_t i = 0; i < names->texts.size(); ++i) {
    const auto rod =
        std::find_if(out.rods.begin(), out.rods.end(), [&](const MeasuredRod& r) { return r.name == names->texts[i]; });
    if (rod == out.rods.end()) {
      return absl::InvalidArgumentError(
          absl::StrCat("reading ", i + 1, ": rod '", names->texts[i], "', expected one of the rods of the header"));
    }
    rod->readouts_mm.push_back(heights->values[i]);
  }
  return out;
}

}  // namespace

absl::StatusOr<RodSession> ReadRodSession(const session::Session& session) {
  auto out = Read(session);
  if (!out.ok()) return base::Within("session " + session::FindHeader(session, "session").value_or("?"), out.status());
  return out;
}

}  // namespace axiscal::toolsetter
