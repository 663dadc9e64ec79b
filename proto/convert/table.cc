#include "proto/convert/table.h"

#include "proto/convert/field.h"

namespace axiscal::convert {
namespace {

constexpr int kMaxNames = 200;  // axes by axes of the largest machine

absl::Status ReadNumbers(const v1::MakeTableRequest& message, tables::TableRequest* request) {
  if (message.tool_tip_mm_size() != 3)
    return FieldError("tool_tip_mm", absl::StrCat(message.tool_tip_mm_size(), " numbers, must be 3"));
  for (int i = 0; i < 3; ++i) {
    RETURN_IF_ERROR(RequireFinite(absl::StrCat("tool_tip_mm[", i, "]"), message.tool_tip_mm(i)));
    request->state.tool_tip_mm[i] = message.tool_tip_mm(i);
  }
  if (message.has_tolerance_mm()) {
    RETURN_IF_ERROR(RequireFinite("tolerance_mm", message.tolerance_mm()));
    request->tolerance_mm = message.tolerance_mm();
  }
  if (message.has_max_points()) request->max_points = message.max_points();
  if (message.has_resolution_mm_or_deg()) {
    RETURN_IF_ERROR(RequireFinite("resolution_mm_or_deg", message.resolution_mm_or_deg()));
    request->resolution = message.resolution_mm_or_deg();
  }
  if (message.has_time_s()) {
    RETURN_IF_ERROR(RequireFinite("time_s", message.time_s()));
    request->state.time_s = message.time_s();
  }
  if (message.has_temperature_celsius()) {
    RETURN_IF_ERROR(RequireFinite("temperature_celsius", message.temperature_celsius()));
    request->state.temperature_celsius = message.temperature_celsius();
  }
  return absl::OkStatus();
}

}  // namespace

v1::MakeTableRequest ToProto(const records::TableParams& params) {
  const tables::TableRequest& request = params.request;
  v1::MakeTableRequest message;
  message.set_machine_id(params.machine.text());
  if (params.calibration) message.set_calibration_id(params.calibration->number());
  message.set_format(request.format);
  for (const double value_mm : request.state.tool_tip_mm) message.add_tool_tip_mm(value_mm);
  for (const std::string& axis : request.axes) message.add_axes(axis);
  for (const tables::AxisRange& range : request.ranges) {
    v1::TableRange* const out = message.add_ranges();
    out->set_axis(range.axis);
    out->set_min_mm_or_rad(range.min);
    out->set_max_mm_or_rad(range.max);
  }
  for (const tables::AxisPosition& position : request.reference) {
    v1::AxisValue* const out = message.add_reference();
    out->set_axis(position.axis);
    out->set_value_mm_or_rad(position.position);
  }
  message.set_tolerance_mm(request.tolerance_mm);
  if (request.max_points) message.set_max_points(*request.max_points);
  if (request.resolution) message.set_resolution_mm_or_deg(*request.resolution);
  if (request.state.time_s) message.set_time_s(*request.state.time_s);
  if (request.state.temperature_celsius) message.set_temperature_celsius(*request.state.temperature_celsius);
  return message;
}

absl::StatusOr<records::TableParams> FromProto(const v1::MakeTableRequest& message) {
  RETURN_IF_ERROR(RequireText("machine_id", message.machine_id(), 1, 255));
  RETURN_IF_ERROR(RequireText("format", message.format(), 1, 64));
  records::TableParams params;
  params.machine = MachineId(message.machine_id());
  if (message.has_calibration_id()) {
    RETURN_IF_ERROR(RequirePositive("calibration_id", message.calibration_id()));
    params.calibration = CalibrationId(message.calibration_id());
  }
  tables::TableRequest& request = params.request;
  request.format = message.format();
  RETURN_IF_ERROR(ReadNumbers(message, &request));
  if (message.axes_size() > kMaxNames || message.ranges_size() > kMaxNames || message.reference_size() > kMaxNames)
    return FieldError("axes", absl::StrCat("more than ", kMaxNames, " axes, ranges or reference positions"));
  for (int i = 0; i < message.axes_size(); ++i) {
    RETURN_IF_ERROR(RequireText(absl::StrCat("axes[", i, "]"), message.axes(i), 1, 64));
    request.axes.push_back(message.axes(i));
  }
  for (int i = 0; i < message.ranges_size(); ++i) {
    const v1::TableRange& range = message.ranges(i);
    const std::string field = absl::StrCat("ranges[", i, "]");
    RETURN_IF_ERROR(RequireText(field + ".axis", range.axis(), 1, 64));
    RETURN_IF_ERROR(RequireFinite(field + ".min_mm_or_rad", range.min_mm_or_rad()));
    RETURN_IF_ERROR(RequireFinite(field + ".max_mm_or_rad", range.max_mm_or_rad()));
    request.ranges.push_back({range.axis(), range.min_mm_or_rad(), range.max_mm_or_rad()});
  }
  for (int i = 0; i < message.reference_size(); ++i) {
    const v1::AxisValue& position = message.reference(i);
    const std::string field = absl::StrCat("reference[", i, "]");
    RETURN_IF_ERROR(RequireText(field + ".axis", position.axis(), 1, 64));
    RETURN_IF_ERROR(RequireFinite(field + ".value_mm_or_rad", position.value_mm_or_rad()));
    request.reference.push_back({position.axis(), position.value_mm_or_rad()});
  }
  return params;
}

v1::TableFormat ToProto(const records::TableFormat& format) {
  v1::TableFormat message;
  message.set_name(format.name);
  message.set_title(format.title);
  message.set_values(format.values);
  message.set_limits(format.limits);
  if (format.max_points) message.set_max_points(*format.max_points);
  for (const std::string& what : format.cannot_carry) message.add_cannot_carry(what);
  return message;
}

absl::StatusOr<records::TableFormat> FromProto(const v1::TableFormat& message) {
  RETURN_IF_ERROR(RequireText("name", message.name(), 1, 64));
  records::TableFormat format{message.name(), message.title(), message.values(), message.limits(), {}, {}};
  if (message.has_max_points()) {
    RETURN_IF_ERROR(RequirePositive("max_points", message.max_points()));
    format.max_points = message.max_points();
  }
  format.cannot_carry.assign(message.cannot_carry().begin(), message.cannot_carry().end());
  return format;
}

v1::MakeTableResponse ToProto(const records::MadeTable& made) {
  v1::MakeTableResponse message;
  message.set_content(made.table.text);
  message.set_report_json(made.table.report_json);
  message.set_calibration_id(made.calibration.number());
  return message;
}

absl::StatusOr<records::MadeTable> FromProto(const v1::MakeTableResponse& message) {
  RETURN_IF_ERROR(RequirePositive("calibration_id", message.calibration_id()));
  return records::MadeTable{{message.content(), message.report_json()}, CalibrationId(message.calibration_id())};
}

}  // namespace axiscal::convert
