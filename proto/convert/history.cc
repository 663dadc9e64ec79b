#include "proto/convert/history.h"

#include "proto/convert/calibration.h"
#include "proto/convert/field.h"

namespace axiscal::convert {
namespace {

absl::StatusOr<records::DriftPoint> PointFromProto(const v1::DriftPoint& message) {
  RETURN_IF_ERROR(RequirePositive("count", message.count()));
  RETURN_IF_ERROR(RequireFinite("min_value", message.min_value()));
  RETURN_IF_ERROR(RequireFinite("max_value", message.max_value()));
  RETURN_IF_ERROR(RequireFinite("mean_value", message.mean_value()));
  records::DriftPoint point;
  point.first_at = base::FromUtcUs(message.first_utc_us());
  point.last_at = base::FromUtcUs(message.last_utc_us());
  point.count = message.count();
  point.min = message.min_value();
  point.max = message.max_value();
  point.mean = message.mean_value();
  if (message.has_sigma()) {
    RETURN_IF_ERROR(RequireFinite("sigma", message.sigma()));
    point.sigma = message.sigma();
  }
  point.last_calibration = CalibrationId(message.last_calibration_id());
  return point;
}

v1::DriftPoint PointToProto(const records::DriftPoint& point) {
  v1::DriftPoint message;
  message.set_first_utc_us(base::ToUtcUs(point.first_at));
  message.set_last_utc_us(base::ToUtcUs(point.last_at));
  message.set_count(point.count);
  message.set_min_value(point.min);
  message.set_max_value(point.max);
  message.set_mean_value(point.mean);
  if (point.sigma) message.set_sigma(*point.sigma);
  message.set_last_calibration_id(point.last_calibration.number());
  return message;
}

}  // namespace

v1::QueryDriftRequest ToProto(const records::DriftQuery& query) {
  v1::QueryDriftRequest message;
  message.set_machine_id(query.machine.text());
  for (const std::string& symbol : query.symbols) message.add_symbols(symbol);
  message.set_from_utc_us(base::ToUtcUs(query.from));
  message.set_to_utc_us(base::ToUtcUs(query.to));
  message.set_max_points(query.max_points);
  return message;
}

absl::StatusOr<records::DriftQuery> FromProto(const v1::QueryDriftRequest& message) {
  RETURN_IF_ERROR(RequireText("machine_id", message.machine_id(), 1, 255));
  records::DriftQuery query;
  query.machine = MachineId(message.machine_id());
  RETURN_IF_ERROR(RequireAtMost("symbols", message.symbols_size(), kMaxSymbols));
  query.symbols.assign(message.symbols().begin(), message.symbols().end());
  query.from = message.has_from_utc_us() ? base::FromUtcUs(message.from_utc_us()) : base::UtcTime::min();
  query.to = message.has_to_utc_us() ? base::FromUtcUs(message.to_utc_us()) : base::UtcTime::max();
  if (query.from > query.to) return FieldError("from_utc_us", "must not be after to_utc_us");
  if (message.max_points() < 0 || message.max_points() > kMaxDriftPoints) {
    return FieldError("max_points", absl::StrCat(message.max_points(), ", must be 0 to ", kMaxDriftPoints));
  }
  query.max_points = message.max_points() == 0 ? kDefaultDriftPoints : message.max_points();
  return query;
}

v1::DriftSeries ToProto(const records::DriftSeries& series) {
  v1::DriftSeries message;
  message.set_symbol(series.symbol);
  message.set_unit(ToProto(series.unit));
  for (const records::DriftPoint& point : series.points) *message.add_points() = PointToProto(point);
  message.set_not_identifiable_count(series.not_identifiable_count);
  return message;
}

absl::StatusOr<records::DriftSeries> FromProto(const v1::DriftSeries& message) {
  RETURN_IF_ERROR(RequireText("symbol", message.symbol(), 1, 100));
  records::DriftSeries series;
  series.symbol = message.symbol();
  ASSIGN_OR_RETURN(series.unit, FromProto(message.unit()));
  for (int i = 0; i < message.points_size(); ++i) {
    absl::StatusOr<records::DriftPoint> point = PointFromProto(message.points(i));
    if (!point.ok()) return InField(absl::StrCat("points[", i, "]"), point.status());
    series.points.push_back(*point);
  }
  series.not_identifiable_count = message.not_identifiable_count();
  return series;
}

v1::MachineLatest ToProto(const records::FleetRow& row) {
  v1::MachineLatest message;
  message.set_machine_id(row.machine.text());
  for (const records::LatestEstimate& latest : row.latest) {
    v1::LatestEstimate* const out = message.add_estimates();
    *out->mutable_estimate() = ToProto(latest.estimate);
    out->set_measured_utc_us(base::ToUtcUs(latest.measured_at));
    out->set_calibration_id(latest.calibration.number());
    out->set_state(ToProto(latest.state));
  }
  return message;
}

absl::StatusOr<records::FleetRow> FromProto(const v1::MachineLatest& message) {
  RETURN_IF_ERROR(RequireText("machine_id", message.machine_id(), 1, 255));
  records::FleetRow row;
  row.machine = MachineId(message.machine_id());
  for (const v1::LatestEstimate& latest : message.estimates()) {
    ASSIGN_OR_RETURN(records::Estimate estimate, FromProto(latest.estimate()));
    records::LatestEstimate& one = row.latest.emplace_back();
    one.estimate = std::move(estimate);
    one.measured_at = base::FromUtcUs(latest.measured_utc_us());
    one.calibration = CalibrationId(latest.calibration_id());
    // Servers before this field say nothing of it.
    if (latest.state() == v1::CALIBRATION_STATE_UNSPECIFIED) continue;
    ASSIGN_OR_RETURN(one.state, FromProto(latest.state()));
  }
  return row;
}

}  // namespace axiscal::convert
