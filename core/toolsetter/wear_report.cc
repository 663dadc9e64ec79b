#include <cmath>

#include "core/base/units.h"
#include "core/toolsetter/wear.h"

namespace axiscal::toolsetter {

reports::Wear ReportOf(const CurveSession& session, const WearReport& found) {
  using base::kDegPerRad;
  using base::kUmPerMm;
  reports::Wear report;
  report.session = session.session;
  report.length_mm = found.length_mm;
  report.length_sigma_um = found.length_sigma_mm * kUmPerMm;
  report.phase_deg = found.phase_rad * kDegPerRad;
  report.phase_sigma_deg = found.phase_sigma_rad * kDegPerRad;
  for (size_t k = 0; k < found.inserts.size(); ++k) {
    const InsertWear& insert = found.inserts[k];
    reports::InsertWear& row = report.inserts.emplace_back();
    row.insert = static_cast<int>(k + 1);
    row.identifiable = insert.is_identifiable;
    if (insert.is_identifiable) {
      row.wear_um = insert.wear_mm * kUmPerMm;
      row.sigma_um = insert.sigma_mm * kUmPerMm;
    } else {
      row.at_least_um = insert.at_least_mm * kUmPerMm;
    }
    row.readings = insert.readings;
    row.fires_first_deg = insert.share_rad * kDegPerRad;
    row.unseen_from_um = insert.unseen_from_mm * kUmPerMm;
  }
  report.rms_um = found.rms_mm * kUmPerMm;
  report.chi2 = found.chi2;
  report.degrees_of_freedom = found.degrees_of_freedom;
  report.coverage_factor = found.coverage_factor;
  if (found.degrees_of_freedom > 0 && found.chi2 > reports::kPoorFitChi2PerDof * found.degrees_of_freedom) {
    report.warnings.push_back(reports::InWords(reports::Scatter{
        .times_sigma = std::sqrt(found.chi2 / found.degrees_of_freedom), .about = reports::Scatter::About::kCutter}));
  }
  report.longest_reading_mm = found.longest_reading_mm;
  for (size_t i = 0; i < found.residual_mm.size(); ++i) {
    report.readings.push_back(
        {session.starts_rad[i] * kDegPerRad, session.lengths_mm[i], found.residual_mm[i] * kUmPerMm});
  }
  if (found.propose) {
    report.next_measurement = {found.propose->feed_mm_min, session.run.spindle_rpm,
                               found.propose->sees_mm * kUmPerMm};
  }
  return report;
}

}  // namespace axiscal::toolsetter
