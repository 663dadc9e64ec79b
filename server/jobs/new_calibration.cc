#include "server/jobs/new_calibration.h"

#include <cmath>
#include <map>

#include "core/base/units.h"
#include "core/machine/error_json.h"

namespace axiscal::jobs {
namespace {

// The store knows um and urad; what is per a reference says so in its name: "EXX:linear/m".
std::optional<records::Estimate> ToRecord(const identify::Estimate& estimate) {
  records::Estimate record;
  const bool is_angle = estimate.unit.rfind("urad", 0) == 0;
  if (!is_angle && estimate.unit.rfind("um", 0) != 0) return std::nullopt;  // a decay length, a time constant
  record.symbol = estimate.name + estimate.unit.substr(is_angle ? 4 : 2);
  record.unit = is_angle ? records::EstimateUnit::kUrad : records::EstimateUnit::kUm;
  record.identifiable = estimate.identifiable && std::isfinite(estimate.value);
  if (!record.identifiable) return record;
  record.value = estimate.value / estimate.factor;
  if (std::isfinite(estimate.sigma)) record.sigma = estimate.sigma / estimate.factor;
  return record;
}

std::optional<double> IfFinite(double value) { return std::isfinite(value) ? std::optional(value) : std::nullopt; }

}  // namespace

records::NewCalibration MakeCalibration(const MachineInput& input, const MeasuredSessions& fit,
                                        const identify::FitStatistics& before, const identify::Result& result,
                                        const records::JobRecord& job) {
  records::NewCalibration calibration;
  calibration.machine = input.record.id;
  calibration.machine_revision = input.record.revision;
  for (const records::SessionRecord& record : fit.records) calibration.sessions.push_back(record.id);
  calibration.measured_at = fit.measured_at;
  calibration.model_json = machine::WriteErrors(result.model, input.machine);
  calibration.engine_version = AXISCAL_VERSION;
  calibration.rank = result.rank;
  calibration.condition = IfFinite(result.condition);
  calibration.chi2_per_dof = IfFinite(result.fit.chi2_per_dof);
  calibration.rms_before_um = IfFinite(before.rms_mm * base::kUmPerMm);
  calibration.rms_after_um = IfFinite(result.fit.rms_mm * base::kUmPerMm);
  std::map<std::string, int> uses;
  for (const identify::Estimate& estimate : result.estimates) {
    std::optional<records::Estimate> record = ToRecord(estimate);
    if (!record) continue;
    // Two decays of one component differ in their length only, which the name does not hold.
    if (const int use = ++uses[record->symbol]; use > 1) absl::StrAppend(&record->symbol, "#", use);
    calibration.estimates.push_back(*std::move(record));
  }
  calibration.created_by = job.created_by;
  return calibration;
}

}  // namespace axiscal::jobs
