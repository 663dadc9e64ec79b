#include "proto/convert/volumetric.h"

#include "proto/convert/calibration.h"

namespace axiscal::convert {
namespace {

std::vector<records::AxisSpan> SpansOf(const google::protobuf::RepeatedPtrField<v1::AxisSpan>& messages) {
  std::vector<records::AxisSpan> spans;
  for (const v1::AxisSpan& one : messages) spans.push_back({one.axis(), one.from_mm_or_deg(), one.to_mm_or_deg()});
  return spans;
}

records::VolumetricFigure FigureOf(const v1::VolumetricFigure& message) {
  return {message.expected_um(), message.low_um(), message.high_um()};
}

records::VolumetricFigures FiguresOf(const v1::VolumetricFigures& message) {
  return {FigureOf(message.rms()),
          FigureOf(message.median()),
          FigureOf(message.p95()),
          FigureOf(message.max()),
          {message.largest_at_mm_or_deg().begin(), message.largest_at_mm_or_deg().end()}};
}

}  // namespace

v1::AxisSpan ToProto(const records::AxisSpan& span) {
  v1::AxisSpan message;
  message.set_axis(span.axis);
  message.set_from_mm_or_deg(span.from);
  message.set_to_mm_or_deg(span.to);
  return message;
}

absl::StatusOr<records::VolumetricError> FromProto(const v1::VolumetricError& message) {
  records::VolumetricError error;
  error.calibration = CalibrationId(message.calibration_id());
  error.measured_at = base::FromUtcUs(message.measured_utc_us());
  ASSIGN_OR_RETURN(error.state, FromProto(message.state()));
  if (message.has_before_calibration_id()) error.before_calibration = CalibrationId(message.before_calibration_id());
  error.box = SpansOf(message.box());
  error.measured = SpansOf(message.measured());
  error.poses = message.poses();
  error.known_share = message.known_share();
  error.uncorrected = FiguresOf(message.uncorrected());
  error.after = FiguresOf(message.after());
  if (message.has_before()) error.before = FiguresOf(message.before());
  if (message.has_after_where_known()) error.after_where_known = FiguresOf(message.after_where_known());
  error.weakest.assign(message.weakest().begin(), message.weakest().end());
  error.unknown.assign(message.unknown().begin(), message.unknown().end());
  error.problem = message.problem();
  return error;
}

}  // namespace axiscal::convert
