#include "proto/convert/history.h"

#include <set>
#include <tuple>

#include "proto/convert/calibration.h"
#include "proto/convert/field.h"
#include "proto/convert/time.h"

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

// As many errors as drift follows (core/drift/calibration.h), and what a person writes in one go.
constexpr int kMaxMarkSymbols = 64;
constexpr size_t kMaxNoteBytes = 1000;

absl::StatusOr<records::DriftKind> KindFromProto(v1::DriftFindingKind kind) {
  if (kind < v1::DRIFT_FINDING_KIND_STEP || kind > v1::DRIFT_FINDING_KIND_UNSTABLE)
    return FieldError("findings.kind", absl::StrCat(static_cast<int>(kind), ", must be a known kind"));
  return static_cast<records::DriftKind>(kind);
}

absl::StatusOr<records::MarkKind> KindFromProto(v1::MarkKind kind) {
  if (kind < v1::MARK_KIND_COLLISION || kind > v1::MARK_KIND_REFIXTURING)
    return FieldError("kind", absl::StrCat(static_cast<int>(kind), ", must be a known kind"));
  return static_cast<records::MarkKind>(kind);
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

v1::Mark ToProto(const records::Mark& mark) {
  v1::Mark message;
  message.set_mark_id(mark.id.number());
  message.set_machine_id(mark.content.machine.text());
  message.set_at_utc_us(base::ToUtcUs(mark.content.at));
  message.set_kind(static_cast<v1::MarkKind>(mark.content.kind));
  for (const std::string& symbol : mark.content.symbols) message.add_symbols(symbol);
  message.set_note(mark.content.note);
  message.set_created_by(mark.created_by);
  message.set_created_utc_us(base::ToUtcUs(mark.created_at));
  message.set_withdrawn_by(mark.withdrawn_by);
  SET_OPTIONAL_UTC(message, withdrawn_utc_us, mark.withdrawn_at);
  return message;
}

absl::StatusOr<records::Mark> FromProto(const v1::Mark& message) {
  records::Mark mark;
  mark.id = MarkId(message.mark_id());
  ASSIGN_OR_RETURN(const records::MarkKind kind, KindFromProto(message.kind()));
  mark.content = {MachineId(message.machine_id()),
                  base::FromUtcUs(message.at_utc_us()),
                  kind,
                  {message.symbols().begin(), message.symbols().end()},
                  message.note()};
  mark.created_by = message.created_by();
  mark.created_at = base::FromUtcUs(message.created_utc_us());
  mark.withdrawn_by = message.withdrawn_by();
  mark.withdrawn_at = OPTIONAL_UTC(message, withdrawn_utc_us);
  return mark;
}

v1::PutMarkRequest ToProto(const records::NewMark& mark, const std::string& request_id) {
  v1::PutMarkRequest message;
  message.set_request_id(request_id);
  message.set_machine_id(mark.machine.text());
  message.set_at_utc_us(base::ToUtcUs(mark.at));
  message.set_kind(static_cast<v1::MarkKind>(mark.kind));
  for (const std::string& symbol : mark.symbols) message.add_symbols(symbol);
  message.set_note(mark.note);
  return message;
}

absl::StatusOr<records::NewMark> FromProto(const v1::PutMarkRequest& message) {
  RETURN_IF_ERROR(RequireText("machine_id", message.machine_id(), 1, 255));
  ASSIGN_OR_RETURN(const records::MarkKind kind, KindFromProto(message.kind()));
  RETURN_IF_ERROR(RequireAtMost("symbols", message.symbols_size(), kMaxMarkSymbols));
  std::set<std::string> seen;
  for (int i = 0; i < message.symbols_size(); ++i) {
    const std::string field = absl::StrCat("symbols[", i, "]");
    RETURN_IF_ERROR(RequireText(field, message.symbols(i), 1, 200));
    if (!seen.insert(message.symbols(i)).second) return FieldError(field, message.symbols(i) + " stands twice");
  }
  RETURN_IF_ERROR(RequireText("note", message.note(), 0, kMaxNoteBytes));
  return records::NewMark{MachineId(message.machine_id()),
                          base::FromUtcUs(message.at_utc_us()),
                          kind,
                          {message.symbols().begin(), message.symbols().end()},
                          message.note()};
}

v1::FindDriftRequest ToProto(const records::DriftSearch& search) {
  v1::FindDriftRequest message;
  message.set_machine_id(search.machine.text());
  message.set_counts_candidates(search.counts_candidates);
  for (const records::DriftLimit& limit : search.limits) {
    v1::DriftLimit& added = *message.add_limits();
    added.set_symbol(limit.symbol);
    added.set_low(limit.low);
    added.set_high(limit.high);
  }
  return message;
}

absl::StatusOr<records::DriftReport> FromProto(const v1::FindDriftResponse& message) {
  records::DriftReport report;
  const auto time_of = [](bool is_there, int64_t utc_us) {
    return is_there ? std::optional(base::FromUtcUs(utc_us)) : std::nullopt;
  };
  for (const v1::DriftFinding& finding : message.findings()) {
    ASSIGN_OR_RETURN(const records::DriftKind kind, KindFromProto(finding.kind()));
    records::DriftFinding& added = report.findings.emplace_back();
    added.kind = kind;
    added.text = finding.text();
    added.at = base::FromUtcUs(finding.at_utc_us());
    added.after = time_of(finding.has_after_utc_us(), finding.after_utc_us());
    added.by = time_of(finding.has_by_utc_us(), finding.by_utc_us());
    if (finding.has_certainty()) added.certainty = finding.certainty();
    added.is_revision = finding.is_revision();
    added.is_over = finding.is_over();
    for (const v1::DriftAmount& amount : finding.amounts()) {
      RETURN_IF_ERROR(RequireFinite("findings.amounts.size", amount.size()));
      ASSIGN_OR_RETURN(const records::EstimateUnit unit, FromProto(amount.unit()));
      added.amounts.push_back({amount.symbol(), unit, amount.size(), amount.sigma()});
    }
  }
  for (const v1::LimitForecast& forecast : message.limits()) {
    records::LimitForecast& added = report.limits.emplace_back();
    added.limit = {forecast.limit().symbol(), forecast.limit().low(), forecast.limit().high()};
    added.text = forecast.text();
    if (forecast.has_probability_now()) added.probability_now = forecast.probability_now();
    if (forecast.has_probability_within_year()) added.probability_within_year = forecast.probability_within_year();
    added.earliest = time_of(forecast.has_earliest_utc_us(), forecast.earliest_utc_us());
    added.median = time_of(forecast.has_median_utc_us(), forecast.median_utc_us());
    added.latest = time_of(forecast.has_latest_utc_us(), forecast.latest_utc_us());
  }
  for (const int64_t id : message.calibration_ids()) report.counted.push_back(CalibrationId(id));
  report.calibrations = message.calibrations();
  for (const v1::NotCounted& left_out : message.not_counted()) report.left_out.push_back(left_out.text());
  for (const v1::Mark& mark : message.marks()) {
    ASSIGN_OR_RETURN(records::Mark read, FromProto(mark));
    report.marks.push_back(std::move(read));
  }
  return report;
}

v1::MachineCare ToProto(const records::MachineCare& care) {
  v1::MachineCare message;
  message.set_machine_id(care.machine.text());
  message.set_care(static_cast<v1::Care>(care.care));
  for (const records::StandingFinding& finding : care.findings) {
    v1::StandingFinding& added = *message.add_findings();
    added.set_kind(static_cast<v1::DriftFindingKind>(finding.kind));
    added.set_text(finding.text);
    added.set_at_utc_us(base::ToUtcUs(finding.at));
  }
  message.set_new_events(care.new_events);
  message.set_newest_event(care.newest_event);
  message.set_waiting(care.waiting);
  message.set_is_followed(care.is_followed);
  message.mutable_groups()->Add(care.groups.begin(), care.groups.end());
  if (!care.in_use) return message;
  v1::CalibrationInUse& in_use = *message.mutable_in_use();
  in_use.set_calibration_id(care.in_use->calibration.number());
  in_use.set_version(care.in_use->version);
  in_use.set_measured_utc_us(base::ToUtcUs(care.in_use->measured_at));
  if (care.in_use->rms_before_um) in_use.set_rms_before_um(*care.in_use->rms_before_um);
  if (care.in_use->rms_after_um) in_use.set_rms_after_um(*care.in_use->rms_after_um);
  return message;
}

absl::StatusOr<records::MachineCare> FromProto(const v1::MachineCare& message) {
  RETURN_IF_ERROR(RequireText("machine_id", message.machine_id(), 1, 255));
  if (message.care() < v1::CARE_NOW || message.care() > v1::CARE_GOOD)
    return FieldError("care", absl::StrCat(static_cast<int>(message.care()), ", must be a known care"));
  records::MachineCare care;
  care.machine = MachineId(message.machine_id());
  care.care = static_cast<records::Care>(message.care());
  for (const v1::StandingFinding& finding : message.findings()) {
    ASSIGN_OR_RETURN(const records::DriftKind kind, KindFromProto(finding.kind()));
    care.findings.push_back({kind, base::FromUtcUs(finding.at_utc_us()), finding.text()});
  }
  care.new_events = message.new_events();
  care.newest_event = message.newest_event();
  care.waiting = message.waiting();
  care.is_followed = message.is_followed();
  care.groups.assign(message.groups().begin(), message.groups().end());
  if (!message.has_in_use()) return care;
  const v1::CalibrationInUse& in_use = message.in_use();
  records::MachineCare::InUse& used = care.in_use.emplace();
  used.calibration = CalibrationId(in_use.calibration_id());
  used.version = in_use.version();
  used.measured_at = base::FromUtcUs(in_use.measured_utc_us());
  for (const auto& [field, is_there, value, to] :
       {std::tuple("in_use.rms_before_um", in_use.has_rms_before_um(), in_use.rms_before_um(), &used.rms_before_um),
        std::tuple("in_use.rms_after_um", in_use.has_rms_after_um(), in_use.rms_after_um(), &used.rms_after_um)}) {
    if (!is_there) continue;
    RETURN_IF_ERROR(RequireFinite(field, value));
    *to = value;
  }
  return care;
}

}  // namespace axiscal::convert
