#include "server/handlers/list_residuals.h"

#include <algorithm>

#include "absl/strings/numbers.h"
#include "core/base/error_detail.h"
#include "core/base/units.h"
#include "server/handlers/calibration_fit.h"
#include "server/storage/page_token.h"

namespace axiscal::handlers {
namespace {

constexpr int kDefaultPage = 1000, kMostOnPage = 10'000;

void AddSession(const CalibrationFit& fit, size_t i, v1::ListResidualsResponse& response) {
  v1::ResidualSession& added = *response.add_sessions();
  added.set_session_id(fit.sessions[i].id.number());
  added.set_name(fit.sessions[i].name);
  added.set_instrument(fit.sessions[i].instrument);
  added.set_sigma_um(fit.runs[i].sigma_mm * base::kUmPerMm);
  added.set_readings(fit.after_mm[i].cols());
  added.set_rms_before_um(fit.rms_before_mm[i] * base::kUmPerMm);
  added.set_rms_after_um(fit.rms_after_mm[i] * base::kUmPerMm);
}

// measured - predicted.
v1::Residual ResidualOf(const CalibrationFit& fit, size_t i, int reading) {
  const instruments::MeasuringRun& run = fit.runs[i];
  v1::Residual sent;
  sent.set_session_id(fit.sessions[i].id.number());
  sent.set_reading(reading + 1);
  // Readings along a path are at no position.
  const bool is_at_position = run.path_readings == nullptr;
  for (int axis = 0; is_at_position && axis < run.axis_count; ++axis) {
    const bool is_rotary = fit.machine.axes[axis].kind == machine::AxisKind::kRotary;
    sent.add_positions_mm_or_deg(run.PositionsOf(reading)[axis] * (is_rotary ? base::kDegPerRad : 1.0));
  }
  if (is_at_position && run.has_time) sent.set_time_s(run.time_s[reading]);
  if (is_at_position && run.has_temperature) sent.set_temperature_celsius(run.temperature_celsius[reading]);
  for (Eigen::Index row = 0; row < fit.after_mm[i].rows(); ++row) {
    sent.add_before_um(-base::kUmPerMm * fit.before_mm[i](row, reading));
    sent.add_after_um(-base::kUmPerMm * fit.after_mm[i](row, reading));
    if (fit.is_set_aside[i][static_cast<size_t>(reading * fit.after_mm[i].rows() + row)]) sent.set_is_set_aside(true);
  }
  return sent;
}

// The place of the first reading of the page, counted over all that are listed.
absl::StatusOr<int64_t> FirstOf(const storage::PageStart& start) {
  int64_t last = -1;
  // A token's checksum has no secret: whoever makes one up may write any number.
  constexpr int64_t kMost = int64_t{1} << 48;
  if (start.after.has_value() && (!absl::SimpleAtoi(*start.after, &last) || last < 0 || last > kMost)) {
    return base::Error(absl::StatusCode::kInvalidArgument, "page_token: is not one that a list has given",
                       {"PAGE_INVALID", {{"field", "page_token"}}});
  }
  return last + 1;
}

}  // namespace

absl::StatusOr<v1::ListResidualsResponse> ListResiduals(Core& core, const Call& call,
                                                        const v1::ListResidualsRequest& request) {
  const CalibrationId id(request.calibration_id());
  // Of the page only: the store's own bounds are those of rows, which are larger.
  ASSIGN_OR_RETURN(const storage::PageStart start,
                   storage::StartPage({request.page_size(), request.page_token()},
                                      absl::StrCat("residuals|", id.number(), "|", request.session_id())));
  const int64_t size = request.page_size() == 0 ? kDefaultPage : std::min(request.page_size(), kMostOnPage);
  ASSIGN_OR_RETURN(int64_t first, FirstOf(start));
  ASSIGN_OR_RETURN(const std::shared_ptr<const CalibrationFit> fit,
                   core.fits->Of(core.database, id, call.is_cancelled));
  v1::ListResidualsResponse response;
  for (const machine::Axis& axis : fit->machine.axes)
    response.add_axes(axis.name + (axis.kind == machine::AxisKind::kRotary ? "_deg" : "_mm"));
  bool is_there = !request.has_session_id();
  int64_t before = 0;  // readings of the sessions passed
  const int64_t end = first + size;
  for (size_t i = 0; i < fit->runs.size(); ++i) {
    if (request.has_session_id() && fit->sessions[i].id.number() != request.session_id()) continue;
    is_there = true;
    AddSession(*fit, i, response);
    const int64_t count = fit->after_mm[i].cols();
    for (; first < std::min(end, before + count); ++first)
      *response.add_residuals() = ResidualOf(*fit, i, static_cast<int>(first - before));
    before += count;
  }
  if (!is_there) {
    const std::string session = std::to_string(request.session_id());
    return base::Error(absl::StatusCode::kNotFound,
                       absl::StrCat("calibration ", id.number(), " does not stand on session ", session),
                       {"SESSION_NOT_FOUND", {{"session", session}}});
  }
  if (first < before) response.set_next_page_token(storage::MakePageToken(start, std::to_string(first - 1)));
  return response;
}

}  // namespace axiscal::handlers
