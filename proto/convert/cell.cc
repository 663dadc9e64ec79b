#include "proto/convert/cell.h"

#include "proto/convert/field.h"

namespace axiscal::convert {

v1::CellReport ToProto(const records::CellReport& report) {
  v1::CellReport message;
  message.set_machine_id(report.machine.text());
  message.set_name(report.name);
  message.set_version(report.version);
  message.set_silent_after_s(static_cast<int32_t>(report.silent_after.count()));
  message.set_problem(report.problem);
  message.set_waiting_files(report.waiting_files);
  message.set_waiting_bytes(report.waiting_bytes);
  message.set_quarantined_files(report.quarantined_files);
  message.set_quarantined_bytes(report.quarantined_bytes);
  message.set_max_bytes(report.max_bytes);
  return message;
}

absl::StatusOr<records::CellReport> FromProto(const v1::CellReport& message) {
  constexpr int kLeastSilence = 60, kMostSilence = 30 * 86'400;
  RETURN_IF_ERROR(RequireText("machine_id", message.machine_id(), 1, 255));
  RETURN_IF_ERROR(RequireText("name", message.name(), 1, 64));
  RETURN_IF_ERROR(RequireText("version", message.version(), 0, 64));
  RETURN_IF_ERROR(RequireText("problem", message.problem(), 0, kMaxCellProblemBytes));
  if (message.silent_after_s() < kLeastSilence || message.silent_after_s() > kMostSilence) {
    return FieldError("silent_after_s",
                      absl::StrCat(message.silent_after_s(), ", must be ", kLeastSilence, " to ", kMostSilence));
  }
  RETURN_IF_ERROR(RequireNotNegative("waiting_files", message.waiting_files()));
  RETURN_IF_ERROR(RequireNotNegative("waiting_bytes", message.waiting_bytes()));
  RETURN_IF_ERROR(RequireNotNegative("quarantined_files", message.quarantined_files()));
  RETURN_IF_ERROR(RequireNotNegative("quarantined_bytes", message.quarantined_bytes()));
  RETURN_IF_ERROR(RequireNotNegative("max_bytes", message.max_bytes()));
  records::CellReport report;
  report.machine = MachineId(message.machine_id());
  report.name = message.name();
  report.version = message.version();
  report.silent_after = std::chrono::seconds(message.silent_after_s());
  report.problem = message.problem();
  report.waiting_files = message.waiting_files();
  report.waiting_bytes = message.waiting_bytes();
  report.quarantined_files = message.quarantined_files();
  report.quarantined_bytes = message.quarantined_bytes();
  report.max_bytes = message.max_bytes();
  return report;
}

v1::Cell ToProto(const records::CellRecord& cell) {
  v1::Cell message;
  *message.mutable_report() = ToProto(cell.report);
  message.set_reported_by(cell.reported_by);
  message.set_reported_utc_us(base::ToUtcUs(cell.reported_at));
  message.set_silence_us(cell.silence.count());
  message.set_is_silent(cell.is_silent());
  return message;
}

absl::StatusOr<records::CellRecord> FromProto(const v1::Cell& message) {
  RETURN_IF_ERROR(RequireMessage("report", message.has_report()));
  ASSIGN_OR_RETURN(records::CellReport report, FromProto(message.report()));
  return records::CellRecord{0, std::move(report), message.reported_by(), base::FromUtcUs(message.reported_utc_us()),
                             std::chrono::microseconds(message.silence_us())};
}

}  // namespace axiscal::convert
