#include "server/storage/calibration_checksum.h"

#include "server/storage/request.h"

namespace axiscal::storage {
namespace {

int64_t OrAbsent(const std::optional<UtcTime>& time) { return time.has_value() ? base::ToUtcUs(*time) : -1; }

}  // namespace

std::string CalibrationChecksum(const CalibrationRecord& record, const std::string& description_json) {
  const NewCalibration& content = record.content;
  BodyHash hash;
  // The first field names this order of fields: another order would get another name.
  hash.Add("calibration 1").Add(record.id.number()).Add(record.version).Add(static_cast<int64_t>(record.state));
  hash.Add(record.etag).Add(record.job.has_value() ? record.job->number() : -1).Add(base::ToUtcUs(record.created_at));
  hash.Add(record.approved_by).Add(OrAbsent(record.approved_at)).Add(OrAbsent(record.retired_at));
  hash.Add(content.machine.text()).Add(content.machine_revision).Add(description_json);
  hash.Add(base::ToUtcUs(content.measured_at)).Add(content.model_json).Add(content.options_json);
  hash.Add(content.report_json).Add(content.engine_version).Add(content.rank).AddReal(content.condition);
  hash.AddReal(content.chi2_per_dof).AddReal(content.rms_before_um).AddReal(content.rms_after_um);
  hash.Add(content.created_by).Add(content.sessions.size());
  for (const SessionId session : content.sessions) hash.Add(session.number());
  hash.Add(content.estimates.size());
  for (const Estimate& estimate : content.estimates) {
    hash.Add(estimate.symbol).Add(static_cast<int64_t>(estimate.unit)).Add(estimate.identifiable ? 1 : 0);
    hash.AddReal(estimate.value).AddReal(estimate.sigma);
  }
  return hash.Hex();
}

}  // namespace axiscal::storage
