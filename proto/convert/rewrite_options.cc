// nc::RewriteOptions on the wire.
#include "proto/convert/field.h"
#include "proto/convert/job_params.h"

namespace axiscal::convert {
namespace {

v1::OnUnsupported ToProto(nc::OnUnsupported value) {
  if (value == nc::OnUnsupported::kStop) return v1::ON_UNSUPPORTED_STOP;
  return value == nc::OnUnsupported::kRefuse ? v1::ON_UNSUPPORTED_REFUSE : v1::ON_UNSUPPORTED_PASS;
}

v1::BlockDelete ToProto(nc::BlockDelete value) {
  if (value == nc::BlockDelete::kExecuted) return v1::BLOCK_DELETE_EXECUTED;
  return value == nc::BlockDelete::kSkipped ? v1::BLOCK_DELETE_SKIPPED : v1::BLOCK_DELETE_EITHER;
}

v1::IntegerWords ToProto(nc::IntegerWords value) {
  return value == nc::IntegerWords::kWholeUnits ? v1::INTEGER_WORDS_WHOLE_UNITS : v1::INTEGER_WORDS_LEAST_INCREMENT;
}

v1::ProgramUnit ToProto(nc::ProgramUnit value) {
  if (value == nc::ProgramUnit::kUnstated) return v1::PROGRAM_UNIT_UNSPECIFIED;
  return value == nc::ProgramUnit::kMillimetre ? v1::PROGRAM_UNIT_MILLIMETRE : v1::PROGRAM_UNIT_INCH;
}

absl::Status ReadChoices(const v1::RewriteOptions& message, nc::RewriteOptions* options) {
  if (message.on_unsupported() == v1::ON_UNSUPPORTED_PASS) {
    options->on_unsupported = nc::OnUnsupported::kPass;
  } else if (message.on_unsupported() == v1::ON_UNSUPPORTED_STOP) {
    options->on_unsupported = nc::OnUnsupported::kStop;
  } else if (message.on_unsupported() > v1::ON_UNSUPPORTED_STOP) {
    return FieldError("on_unsupported", "must be REFUSE, PASS or STOP");
  }
  if (message.block_delete() == v1::BLOCK_DELETE_EXECUTED) {
    options->block_delete = nc::BlockDelete::kExecuted;
  } else if (message.block_delete() == v1::BLOCK_DELETE_SKIPPED) {
    options->block_delete = nc::BlockDelete::kSkipped;
  } else if (message.block_delete() > v1::BLOCK_DELETE_SKIPPED) {
    return FieldError("block_delete", "must be EITHER, EXECUTED or SKIPPED");
  }
  if (message.integer_words() == v1::INTEGER_WORDS_LEAST_INCREMENT) {
    options->integer_words = nc::IntegerWords::kLeastIncrement;
  } else if (message.integer_words() > v1::INTEGER_WORDS_LEAST_INCREMENT) {
    return FieldError("integer_words", "must be WHOLE_UNITS or LEAST_INCREMENT");
  }
  if (message.unit() == v1::PROGRAM_UNIT_MILLIMETRE) {
    options->unit = nc::ProgramUnit::kMillimetre;
  } else if (message.unit() == v1::PROGRAM_UNIT_INCH) {
    options->unit = nc::ProgramUnit::kInch;
  } else if (message.unit() != v1::PROGRAM_UNIT_UNSPECIFIED) {
    return FieldError("unit", "must be MILLIMETRE or INCH");
  }
  return absl::OkStatus();
}

absl::StatusOr<std::vector<nc::AxisValue>> ReadAxisValues(
    const std::string& field, const google::protobuf::RepeatedPtrField<v1::AxisValue>& message) {
  std::vector<nc::AxisValue> values;
  for (int i = 0; i < message.size(); ++i) {
    const std::string at = absl::StrCat(field, "[", i, "]");
    RETURN_IF_ERROR(RequireText(at + ".axis", message[i].axis(), 1, 20));
    RETURN_IF_ERROR(RequireFinite(at + ".value_mm_or_rad", message[i].value_mm_or_rad()));
    values.push_back({message[i].axis(), message[i].value_mm_or_rad()});
  }
  return values;
}

void WriteAxisValues(const std::vector<nc::AxisValue>& values,
                     google::protobuf::RepeatedPtrField<v1::AxisValue>* message) {
  for (const nc::AxisValue& value : values) {
    v1::AxisValue* const out = message->Add();
    out->set_axis(value.axis);
    out->set_value_mm_or_rad(value.value);
  }
}

}  // namespace

v1::RewriteOptions ToProto(const nc::RewriteOptions& options) {
  v1::RewriteOptions message;
  message.set_dialect(options.dialect);
  message.set_on_unsupported(ToProto(options.on_unsupported));
  message.set_block_delete(ToProto(options.block_delete));
  message.set_integer_words(ToProto(options.integer_words));
  message.set_unit(ToProto(options.unit));
  for (const int number : options.harmless_m) message.add_harmless_m(number);
  message.set_decimals_mm(options.decimals_mm);
  message.set_decimals_inch(options.decimals_inch);
  message.set_max_correction_mm(options.max_correction_mm);
  message.set_tolerance_mm(options.tolerance_mm);
  message.set_cycle_tolerance_mm(options.cycle_tolerance_mm);
  message.set_cutter_tolerance_mm(options.cutter_tolerance_mm);
  message.set_orientation(options.orientation);
  message.set_max_rotary_correction_rad(options.max_rotary_correction_rad);
  message.set_tolerance_rad(options.tolerance_rad);
  WriteAxisValues(options.initial_position, message.mutable_initial_position());
  for (const std::string& axis : options.tool_change_keeps) message.add_tool_change_keeps(axis);
  for (const nc::WorkOffset& offset : options.work_offsets) {
    v1::WorkOffset* const out = message.add_work_offsets();
    out->set_code(offset.code);
    WriteAxisValues(offset.offsets, out->mutable_offsets());
  }
  for (const nc::ToolLength& length : options.tool_lengths) {
    v1::ToolLength* const out = message.add_tool_lengths();
    out->set_number(length.number);
    out->set_length_mm(length.length_mm);
  }
  for (const nc::ToolRadius& radius : options.tool_radii) {
    v1::ToolRadius* const out = message.add_tool_radii();
    out->set_number(radius.number);
    out->set_radius_mm(radius.radius_mm);
  }
  return message;
}

absl::StatusOr<nc::RewriteOptions> FromProto(const v1::RewriteOptions& message) {
  nc::RewriteOptions options;
  RETURN_IF_ERROR(ReadChoices(message, &options));
  if (message.has_dialect()) options.dialect = message.dialect();
  if (message.has_decimals_mm()) options.decimals_mm = message.decimals_mm();
  if (message.has_decimals_inch()) options.decimals_inch = message.decimals_inch();
  if (options.integer_words == nc::IntegerWords::kLeastIncrement && !message.has_decimals_mm())
    return FieldError("decimals_mm", "must be stated with LEAST_INCREMENT: it says how large an increment is");
  if (message.has_max_correction_mm()) options.max_correction_mm = message.max_correction_mm();
  if (message.has_tolerance_mm()) options.tolerance_mm = message.tolerance_mm();
  if (!(options.max_correction_mm > 0)) return FieldError("max_correction_mm", "must be > 0");
  if (!(options.tolerance_mm > 0)) return FieldError("tolerance_mm", "must be > 0");
  if (message.has_cycle_tolerance_mm()) options.cycle_tolerance_mm = message.cycle_tolerance_mm();
  if (!(options.cycle_tolerance_mm > 0)) return FieldError("cycle_tolerance_mm", "must be > 0");
  if (message.has_cutter_tolerance_mm()) options.cutter_tolerance_mm = message.cutter_tolerance_mm();
  if (!(options.cutter_tolerance_mm > 0)) return FieldError("cutter_tolerance_mm", "must be > 0");
  options.orientation = message.orientation();
  if (message.has_max_rotary_correction_rad()) options.max_rotary_correction_rad = message.max_rotary_correction_rad();
  if (message.has_tolerance_rad()) options.tolerance_rad = message.tolerance_rad();
  if (!(options.max_rotary_correction_rad > 0 && options.max_rotary_correction_rad <= nc::kMaxRotaryCorrectionRad))
    return FieldError("max_rotary_correction_rad", "must be > 0 and at most 0.1");
  if (!(options.tolerance_rad > 0)) return FieldError("tolerance_rad", "must be > 0");
  for (int i = 0; i < message.harmless_m_size(); ++i) {
    if (message.harmless_m(i) < 0 || message.harmless_m(i) > nc::kMaxHarmlessM)
      return FieldError(absl::StrCat("harmless_m[", i, "]"), absl::StrCat("must be 0 to ", nc::kMaxHarmlessM));
    options.harmless_m.push_back(message.harmless_m(i));
  }
  ASSIGN_OR_RETURN(options.initial_position, ReadAxisValues("initial_position", message.initial_position()));
  for (int i = 0; i < message.tool_change_keeps_size(); ++i) {
    RETURN_IF_ERROR(RequireText(absl::StrCat("tool_change_keeps[", i, "]"), message.tool_change_keeps(i), 1, 20));
    options.tool_change_keeps.push_back(message.tool_change_keeps(i));
  }
  for (int i = 0; i < message.work_offsets_size(); ++i) {
    const v1::WorkOffset& offset = message.work_offsets(i);
    const std::string field = absl::StrCat("work_offsets[", i, "]");
    RETURN_IF_ERROR(RequireText(field + ".code", offset.code(), 1, 20));
    ASSIGN_OR_RETURN(std::vector<nc::AxisValue> values, ReadAxisValues(field + ".offsets", offset.offsets()));
    options.work_offsets.push_back({offset.code(), std::move(values)});
  }
  for (int i = 0; i < message.tool_lengths_size(); ++i) {
    const v1::ToolLength& length = message.tool_lengths(i);
    RETURN_IF_ERROR(RequireFinite(absl::StrCat("tool_lengths[", i, "].length_mm"), length.length_mm()));
    options.tool_lengths.push_back({length.number(), length.length_mm()});
  }
  for (int i = 0; i < message.tool_radii_size(); ++i) {
    const v1::ToolRadius& radius = message.tool_radii(i);
    const std::string field = absl::StrCat("tool_radii[", i, "].radius_mm");
    RETURN_IF_ERROR(RequireFinite(field, radius.radius_mm()));
    if (radius.radius_mm() < 0) return FieldError(field, "must be >= 0");
    options.tool_radii.push_back({radius.number(), radius.radius_mm()});
  }
  return options;
}

}  // namespace axiscal::convert
