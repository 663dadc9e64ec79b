#include "server/handlers/find_drift.h"

#include <algorithm>

#include "core/drift/forecast.h"
#include "proto/convert/field.h"
#include "proto/convert/history.h"
#include "server/inputs/machine_history.h"

namespace axiscal::handlers {
namespace {

using inputs::DayText;

// Most limits of one request: each takes some milliseconds.
constexpr int kMostLimits = 100;
constexpr int kMostForecastDays = 1826;  // five years: beyond, a forecast says nothing

v1::EstimateUnit UnitOf(drift::Unit unit) {
  return unit == drift::Unit::kUm ? v1::ESTIMATE_UNIT_UM : v1::ESTIMATE_UNIT_URAD;
}

void AddAmount(const drift::Amount& amount, v1::DriftFinding& message) {
  v1::DriftAmount& added = *message.add_amounts();
  added.set_symbol(amount.symbol);
  added.set_unit(UnitOf(amount.unit));
  added.set_size(amount.size);
  added.set_sigma(amount.sigma);
}

// The fields of each kind; the text is set for all.
struct FillFinding {
  v1::DriftFinding& to;

  void operator()(const drift::StepChange& step) const {
    to.set_kind(v1::DRIFT_FINDING_KIND_STEP);
    to.set_at_utc_us(base::ToUtcUs(step.found_at));
    to.set_after_utc_us(base::ToUtcUs(step.after));
    to.set_by_utc_us(base::ToUtcUs(step.by));
    to.set_certainty(step.certainty);
    to.set_is_revision(step.is_revision);
    for (const drift::Amount& amount : step.amounts) AddAmount(amount, to);
  }
  void operator()(const drift::Retraction& retraction) const {
    to.set_kind(v1::DRIFT_FINDING_KIND_RETRACTION);
    to.set_at_utc_us(base::ToUtcUs(retraction.at));
    to.set_after_utc_us(base::ToUtcUs(retraction.after));
    to.set_by_utc_us(base::ToUtcUs(retraction.by));
  }
  void operator()(const drift::Suspect& suspect) const {
    to.set_kind(v1::DRIFT_FINDING_KIND_SUSPECT);
    to.set_at_utc_us(base::ToUtcUs(suspect.at));
    to.set_certainty(suspect.certainty);
    for (const drift::Amount& amount : suspect.amounts) AddAmount(amount, to);
  }
  void operator()(const drift::Slope& slope) const {
    to.set_kind(v1::DRIFT_FINDING_KIND_SLOPE);
    to.set_at_utc_us(base::ToUtcUs(slope.at));
    to.set_is_over(slope.is_over);
    to.set_certainty(slope.certainty);
    AddAmount(slope.per_year, to);
  }
  void operator()(const drift::Season& season) const {
    to.set_kind(v1::DRIFT_FINDING_KIND_SEASON);
    to.set_at_utc_us(base::ToUtcUs(season.at));
    to.set_is_over(season.is_over);
    to.set_certainty(season.certainty);
    AddAmount(season.amplitude, to);
  }
  void operator()(const drift::Noise& noise) const {
    to.set_kind(v1::DRIFT_FINDING_KIND_NOISE);
    to.set_at_utc_us(base::ToUtcUs(noise.at));
    to.set_is_over(noise.is_over);
  }
  void operator()(const drift::Unstable& unstable) const {
    to.set_kind(v1::DRIFT_FINDING_KIND_UNSTABLE);
    to.set_at_utc_us(base::ToUtcUs(unstable.at));
    to.set_after_utc_us(base::ToUtcUs(unstable.since));
  }
};

absl::Status CheckLimits(const v1::FindDriftRequest& request) {
  RETURN_IF_ERROR(convert::RequireAtMost("limits", request.limits_size(), kMostLimits));
  for (int i = 0; i < request.limits_size(); ++i) {
    const std::string field = absl::StrCat("limits[", i, "]");
    RETURN_IF_ERROR(convert::RequireText(field + ".symbol", request.limits(i).symbol(), 1, 200));
    RETURN_IF_ERROR(convert::RequireFinite(field + ".low", request.limits(i).low()));
    RETURN_IF_ERROR(convert::RequireFinite(field + ".high", request.limits(i).high()));
    if (!(request.limits(i).low() < request.limits(i).high()))
      return convert::FieldError(field + ".low", "must be less than high");
  }
  return absl::OkStatus();
}

// "EX0C is outside -20 .. 20 um within a year with a probability of 31 %; by 2027-03-02 (2026-12-01 to 2027-08-14)".
std::string TextOf(const v1::DriftLimit& limit, drift::Unit unit, const drift::Crossing& crossing) {
  std::string text =
      absl::StrFormat("%s is outside %g .. %g %s now with a probability of %.0f %%, within a year with one of %.0f %%",
                      limit.symbol(), limit.low(), limit.high(), drift::Text(unit), 100 * crossing.probability_now,
                      100 * crossing.probability_within_year);
  if (!crossing.median) return text;
  absl::StrAppend(&text, "; most likely by ", DayText(*crossing.median));
  if (crossing.earliest) absl::StrAppend(&text, ", not before ", DayText(*crossing.earliest));
  if (crossing.latest) absl::StrAppend(&text, ", by ", DayText(*crossing.latest), " at the latest");
  return text + " (90 %)";
}

v1::LimitForecast ForecastOf(const drift::State& state, const v1::DriftLimit& limit) {
  v1::LimitForecast message;
  *message.mutable_limit() = limit;
  const auto error = std::find_if(state.errors.begin(), state.errors.end(),
                                  [&](const drift::Followed& followed) { return followed.symbol == limit.symbol(); });
  const absl::StatusOr<drift::Crossing> crossing =
      drift::CrossingOf(state, limit.symbol(), {limit.low(), limit.high()});
  if (!crossing.ok() || error == state.errors.end()) {
    message.set_text("no forecast: " + std::string(crossing.status().message()));
    return message;
  }
  message.set_unit(UnitOf(error->unit));
  message.set_probability_now(crossing->probability_now);
  message.set_probability_within_year(crossing->probability_within_year);
  if (crossing->earliest) message.set_earliest_utc_us(base::ToUtcUs(*crossing->earliest));
  if (crossing->median) message.set_median_utc_us(base::ToUtcUs(*crossing->median));
  if (crossing->latest) message.set_latest_utc_us(base::ToUtcUs(*crossing->latest));
  message.set_text(TextOf(limit, error->unit, *crossing));
  return message;
}

// The course that one error will take within so many days of the last calibration.
v1::ErrorForecast CourseOf(const drift::State& state, const drift::Followed& error, int days) {
  constexpr int kSteps = 12;  // of a band that bends little
  v1::ErrorForecast course;
  course.set_symbol(error.symbol);
  course.set_unit(UnitOf(error.unit));
  for (int i = 0; i <= kSteps; ++i) {
    const base::UtcTime at = state.last_at + std::chrono::hours(24) * days * i / kSteps;
    const absl::StatusOr<drift::Forecast> forecast = drift::ForecastOf(state, error.symbol, at);
    if (!forecast.ok()) {
      course.clear_points();
      course.set_text("no forecast: " + std::string(forecast.status().message()));
      break;
    }
    v1::ForecastPoint& point = *course.add_points();
    point.set_at_utc_us(base::ToUtcUs(at));
    point.set_value(forecast->value);
    point.set_low(forecast->low);
    point.set_high(forecast->high);
  }
  return course;
}

void AddForecasts(const drift::State& state, int days, v1::FindDriftResponse& response) {
  std::vector<const drift::Followed*> errors;
  for (const drift::Followed& error : state.errors) errors.push_back(&error);
  std::sort(errors.begin(), errors.end(), [](const auto* a, const auto* b) { return a->symbol < b->symbol; });
  for (const drift::Followed* const error : errors) *response.add_forecasts() = CourseOf(state, *error, days);
}

}  // namespace

absl::StatusOr<v1::FindDriftResponse> FindDrift(Core& core, const Call& call, const v1::FindDriftRequest& request) {
  RETURN_IF_ERROR(convert::RequireText("machine_id", request.machine_id(), 1, 255));
  RETURN_IF_ERROR(CheckLimits(request));
  if (request.forecast_days() < 0 || request.forecast_days() > kMostForecastDays) {
    return convert::FieldError("forecast_days",
                               absl::StrCat(request.forecast_days(), ", must be 0 to ", kMostForecastDays));
  }
  const MachineId machine(request.machine_id());
  RETURN_IF_ERROR(core.database.GetMachine(machine).status());
  ASSIGN_OR_RETURN(const inputs::MachineHistory history,
                   inputs::FollowHistory(core.database, machine, request.counts_candidates(), call.is_cancelled));
  v1::FindDriftResponse response;
  for (const inputs::MachineHistory::LeftOut& left_out : history.left_out) {
    v1::NotCounted& message = *response.add_not_counted();
    message.set_calibration_id(left_out.id.number());
    message.set_text(left_out.text);
  }
  for (const records::CalibrationRecord& record : history.counted) response.add_calibration_ids(record.id.number());
  for (const drift::Finding& finding : history.findings) {
    v1::DriftFinding& message = *response.add_findings();
    std::visit(FillFinding{message}, finding);
    message.set_text(drift::Text(finding));
  }
  for (const records::Mark& mark : history.marks) *response.add_marks() = convert::ToProto(mark);
  response.set_calibrations(static_cast<int32_t>(history.calibrations));
  for (const v1::DriftLimit& limit : request.limits()) *response.add_limits() = ForecastOf(history.state, limit);
  if (request.forecast_days() > 0) AddForecasts(history.state, request.forecast_days(), response);
  return response;
}

}  // namespace axiscal::handlers
