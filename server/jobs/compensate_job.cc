#include "server/jobs/compensate_job.h"

#include <algorithm>
#include <string>

#include "core/nc/rewrite.h"
#include "proto/convert/job_params.h"
#include "server/inputs/compensation.h"

namespace axiscal::jobs {
namespace {

constexpr size_t kPartBytes = 1 << 20;

// Takes bytes as they come and stores them in parts of equal size, so that a second attempt stores the same parts
// again.
class ProgramWriter {
 public:
  static absl::StatusOr<ProgramWriter> Create(storage::Database& database, const storage::NewProgram& program) {
    ASSIGN_OR_RETURN(const records::ProgramRecord record, database.BeginProgram(program));
    return ProgramWriter(database, record);
  }

  absl::Status Append(const char* bytes, size_t size) {
    buffer_.append(bytes, size);
    size_t taken = 0;
    for (; buffer_.size() - taken >= kPartBytes; taken += kPartBytes) {
      RETURN_IF_ERROR(Store(buffer_.substr(taken, kPartBytes)));
    }
    buffer_.erase(0, taken);
    return absl::OkStatus();
  }

  absl::StatusOr<records::ProgramRecord> Finish() {
    if (!buffer_.empty()) RETURN_IF_ERROR(Store(buffer_));
    return database_.FinishProgram(record_.id, offset_, "");
  }

 private:
  ProgramWriter(storage::Database& database, const records::ProgramRecord& record)
      : database_(database), record_(record) {}

  absl::Status Store(const std::string& part) {
    const int64_t offset = offset_;
    offset_ += static_cast<int64_t>(part.size());
    // An attempt before this one may have finished it and died afterwards.
    if (record_.state == records::ProgramState::kComplete) return absl::OkStatus();
    return database_.AppendProgram(record_.id, offset, part).status();
  }

  storage::Database& database_;
  const records::ProgramRecord record_;
  std::string buffer_;
  int64_t offset_ = 0;
};

// "part.nc" becomes "part-compensated.nc": where both lie in one folder nobody takes one for the other.
std::string CompensatedName(const std::string& name) {
  constexpr size_t kMostBytes = 255;  // of a file's name on Linux and Windows
  const std::string suffix = "-compensated";
  size_t dot = name.rfind('.');
  if (dot == std::string::npos || dot == 0 || name.size() - dot > kMostBytes / 2) dot = name.size();
  const std::string ending = suffix + name.substr(dot);
  size_t kept = std::min(dot, kMostBytes - ending.size());
  const auto is_within_character = [&name](size_t at) { return at < name.size() && (name[at] & 0xC0) == 0x80; };
  while (kept > 0 && is_within_character(kept)) --kept;  // UTF-8
  return name.substr(0, kept) + ending;
}

absl::StatusOr<storage::JobProduct> RunCompensate(storage::Database& database, const records::JobRecord& job,
                                                  JobContext& context) {
  ASSIGN_OR_RETURN(const records::JobParams any_params, convert::ParseJobParams(job.params));
  const auto& params = std::get<records::CompensateParams>(any_params);
  ASSIGN_OR_RETURN(const inputs::Compensation compensation,
                   inputs::CompensationFor(database, params, "params.compensate"));
  const records::CalibrationRecord& calibration = compensation.calibration;
  ASSIGN_OR_RETURN(const records::ProgramRecord source, database.GetProgram(params.program));

  // Attempts of one job that use the same calibration and profile write the same program.
  const std::string request_id = absl::StrCat("job-", job.id.number(), "-calibration-", calibration.id.number(),
                                              "-revision-", compensation.machine_revision, "-compensated");
  ASSIGN_OR_RETURN(ProgramWriter writer,
                   ProgramWriter::Create(
                       database, {kCompensatedProgram, CompensatedName(source.name), {job.created_by, request_id}}));

  // The engine reads the program twice: for its checksum, then to rewrite it.
  const double total_bytes = 2.0 * static_cast<double>(std::max<int64_t>(1, source.byte_count));
  int64_t read_bytes = 0;
  const nc::ByteSource read = [&](const nc::ByteSink& take) {
    return database.ReadProgram(source.id, 0, [&](const std::string& bytes) {
      if (context.cancelled()) return absl::CancelledError("stopped");
      read_bytes += static_cast<int64_t>(bytes.size());
      context.ReportProgress("rewrite", std::min(1.0, static_cast<double>(read_bytes) / total_bytes),
                             absl::StrCat(read_bytes / 2, " of ", source.byte_count, " bytes"));
      return take(bytes.data(), bytes.size());
    });
  };
  nc::RewriteReport report;
  RETURN_IF_ERROR(nc::RewriteProgram(
      read, [&](const char* bytes, size_t size) { return writer.Append(bytes, size); }, compensation.compensator,
      compensation.options, &report));
  compensation.AddTo(&report);
  ASSIGN_OR_RETURN(const records::ProgramRecord program, writer.Finish());
  storage::JobProduct product;
  product.result = reports::ToJson(nc::ReportOf(report));
  product.programs = {program.id};
  return product;
}

}  // namespace

JobFunction CompensateJob(storage::Database& database) {
  return
      [&database](const records::JobRecord& job, JobContext& context) { return RunCompensate(database, job, context); };
}

}  // namespace axiscal::jobs
