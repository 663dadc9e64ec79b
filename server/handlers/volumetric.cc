#include "server/handlers/volumetric.h"

#include <algorithm>

#include "core/base/error_detail.h"
#include "core/base/units.h"
#include "core/machine/error_json.h"
#include "core/machine/machine_json.h"
#include "core/predict/box_errors.h"
#include "core/records/job_params.h"
#include "core/reports/rewrite.h"
#include "proto/convert/calibration.h"
#include "proto/convert/field.h"
#include "server/handlers/axis_spans.h"
#include "server/jobs/job_sessions.h"
#include "server/storage/page_token.h"

namespace axiscal::handlers {
namespace {

using records::CalibrationRecord;
using records::CalibrationState;

constexpr int kDefaultErrors = 20, kMostErrors = 100;
constexpr size_t kMostKept = 2000;  // of 1 to 3 KB

absl::Status NoVolumetric(CalibrationId id, const std::string& why) {
  return base::Error(absl::StatusCode::kFailedPrecondition,
                     absl::StrCat("calibration ", id.number(), " has no volumetric error: ", why),
                     {"VOLUMETRIC_UNKNOWN", {{"calibration", std::to_string(id.number())}}});
}

void SetFigure(const predict::Figure& figure, v1::VolumetricFigure* message) {
  message->set_expected_um(figure.expected_mm * base::kUmPerMm);
  message->set_low_um(figure.low_mm * base::kUmPerMm);
  message->set_high_um(figure.high_mm * base::kUmPerMm);
}

v1::VolumetricFigures ToProto(const machine::Machine& machine, const predict::LengthFigures& figures) {
  v1::VolumetricFigures message;
  SetFigure(figures.rms, message.mutable_rms());
  SetFigure(figures.median, message.mutable_median());
  SetFigure(figures.p95, message.mutable_p95());
  SetFigure(figures.max, message.mutable_max());
  for (size_t i = 0; i < figures.largest_at.size(); ++i)
    message.add_largest_at_mm_or_deg(figures.largest_at[i] / UnitOf(machine.axes[i]));
  return message;
}

v1::VolumetricError ToProto(const machine::Machine& machine, const predict::BoxErrors& errors) {
  v1::VolumetricError message;
  SetSpans(machine, errors.box, message.mutable_box());
  SetSpans(machine, errors.measured, message.mutable_measured());
  message.set_poses(errors.poses);
  message.set_known_share(errors.known_share);
  *message.mutable_uncorrected() = ToProto(machine, errors.uncorrected);
  if (errors.before) *message.mutable_before() = ToProto(machine, *errors.before);
  *message.mutable_after() = ToProto(machine, errors.after);
  if (errors.after_where_known) *message.mutable_after_where_known() = ToProto(machine, *errors.after_where_known);
  for (const std::string& name : errors.weakest) message.add_weakest(name);
  for (const std::string& name : errors.unknown) message.add_unknown(name);
  return message;
}

absl::StatusOr<v1::VolumetricError> Compute(Core& core, const Call& call, CalibrationId id,
                                            const std::optional<CalibrationId>& before_id, const Spans& asked) {
  storage::Database& database = core.database;
  ASSIGN_OR_RETURN(const CalibrationRecord record, database.GetCalibration(id));
  ASSIGN_OR_RETURN(const records::MachineRecord described,
                   database.GetMachineRevision(record.content.machine, record.content.machine_revision));
  ASSIGN_OR_RETURN(const machine::Machine machine, machine::MachineFromJson(described.description_json));
  ASSIGN_OR_RETURN(const machine::KnownErrors found, machine::ReadKnownErrors(record.content.model_json, machine));
  if (found.covariance.is_empty()) return NoVolumetric(id, "nothing is known of how good its errors are");
  std::optional<machine::ErrorModel> before;
  if (before_id) {
    ASSIGN_OR_RETURN(const CalibrationRecord former, database.GetCalibration(*before_id));
    const absl::StatusOr<machine::ErrorModel> model = machine::ReadErrors(former.content.model_json, machine);
    if (model.ok()) before = *model;  // else of other axes
  }
  ASSIGN_OR_RETURN(const jobs::MeasuredSessions measured,
                   jobs::LoadSessions(database, record.content.sessions, machine, call.is_cancelled));
  ASSIGN_OR_RETURN(const predict::Box box, BoxOf(machine, predict::MeasuredBox(measured.runs), asked));
  std::vector<std::string> unknown;
  for (const records::Estimate& estimate : record.content.estimates)
    if (!estimate.identifiable) unknown.push_back(estimate.symbol);
  const std::optional<predict::BoxErrors> errors =
      predict::ErrorsOverBox(machine, measured.runs, before, found, unknown, box);
  if (!errors) return NoVolumetric(id, "no axis moves in its box");
  v1::VolumetricError message = ToProto(machine, *errors);
  message.set_calibration_id(id.number());
  message.set_measured_utc_us(base::ToUtcUs(record.content.measured_at));
  if (before_id) message.set_before_calibration_id(before_id->number());
  return message;
}

absl::StatusOr<v1::VolumetricError> ErrorOf(Core& core, const Call& call, const CalibrationRecord& record,
                                            const Spans& asked) {
  ASSIGN_OR_RETURN(const std::optional<CalibrationId> before, core.database.GetFormerOf(record.id));
  std::string key = absl::StrCat(record.id.number(), "|", before ? before->number() : 0);
  for (const v1::AxisSpan& span : asked) absl::StrAppend(&key, "|", span.SerializeAsString());
  std::optional<v1::VolumetricError> error = core.volumetric->Find(key);
  if (!error) {
    ASSIGN_OR_RETURN(error, Compute(core, call, record.id, before, asked));
    core.volumetric->Keep(key, *error);
  }
  error->set_state(convert::ToProto(record.state));
  return *std::move(error);
}

// Whether a calibration stands in the history of the machine's error.
bool IsListed(const CalibrationRecord& record) {
  const bool was_given_up = record.state == CalibrationState::kRetired && !record.approved_at;
  return !was_given_up && record.rejected_sessions.empty();
}

// Of one of which nothing can be said it says why: it hides none of the others.
absl::StatusOr<v1::VolumetricError> ErrorOrProblem(Core& core, const Call& call, const CalibrationRecord& record,
                                                   const Spans& asked) {
  absl::StatusOr<v1::VolumetricError> error = ErrorOf(core, call, record, asked);
  if (error.ok() || absl::IsCancelled(error.status()) || absl::IsUnavailable(error.status())) return error;
  v1::VolumetricError problem;
  problem.set_calibration_id(record.id.number());
  problem.set_measured_utc_us(base::ToUtcUs(record.content.measured_at));
  problem.set_state(convert::ToProto(record.state));
  problem.set_problem(std::string(error.status().message()));
  return problem;
}

// In which the corrected program of a job moves.
absl::StatusOr<Spans> SpansOfJob(Core& core, JobId id) {
  ASSIGN_OR_RETURN(const records::JobRecord job, core.jobs.Get(id));
  if (job.kind != records::kCompensate || job.state != records::JobState::kSucceeded)
    return convert::FieldError("job_id", "must be of a COMPENSATE job that has succeeded");
  ASSIGN_OR_RETURN(const reports::Rewrite report, reports::ReadRewrite(job.result));
  if (report.positions.empty())
    return convert::FieldError("job_id", "nothing of its program was corrected, or an earlier version made it");
  Spans spans;
  for (const reports::AxisRange& range : report.positions) {
    v1::AxisSpan& span = *spans.Add();
    span.set_axis(range.axis);
    span.set_from_mm_or_deg(range.from);
    span.set_to_mm_or_deg(range.to);
  }
  return spans;
}

}  // namespace

std::optional<v1::VolumetricError> VolumetricCache::Find(const std::string& key) {
  const base::MutexLock lock(mutex_);
  const auto found = kept_.find(key);
  return found == kept_.end() ? std::nullopt : std::optional(found->second);
}

void VolumetricCache::Keep(const std::string& key, const v1::VolumetricError& error) {
  const base::MutexLock lock(mutex_);
  if (!kept_.emplace(key, error).second) return;
  order_.push_back(key);
  if (order_.size() <= kMostKept) return;
  kept_.erase(order_.front());
  order_.pop_front();
}

absl::StatusOr<v1::GetVolumetricErrorResponse> GetVolumetricError(Core& core, const Call& call,
                                                                  const v1::GetVolumetricErrorRequest& request) {
  if (request.has_job_id() && request.box_size() > 0)
    return convert::FieldError("job_id", "at most one of box and job_id may be set");
  ASSIGN_OR_RETURN(const CalibrationRecord record,
                   core.database.GetCalibration(CalibrationId(request.calibration_id())));
  Spans asked = request.box();
  if (request.has_job_id()) {
    ASSIGN_OR_RETURN(asked, SpansOfJob(core, JobId(request.job_id())));
  }
  v1::GetVolumetricErrorResponse response;
  ASSIGN_OR_RETURN(*response.mutable_error(), ErrorOf(core, call, record, asked));
  return response;
}

absl::StatusOr<v1::ListVolumetricErrorsResponse> ListVolumetricErrors(Core& core, const Call& call,
                                                                      const v1::ListVolumetricErrorsRequest& request) {
  RETURN_IF_ERROR(convert::RequireText("machine_id", request.machine_id(), 1, 255));
  std::string list = "volumetric|" + request.machine_id();
  for (const v1::AxisSpan& span : request.box()) absl::StrAppend(&list, "|", span.SerializeAsString());
  ASSIGN_OR_RETURN(const storage::PageStart start,
                   storage::StartPage({request.page_size(), request.page_token()}, list));
  const int size = request.page_size() == 0 ? kDefaultErrors : std::min(request.page_size(), kMostErrors);
  records::CalibrationFilter filter;
  filter.machine = MachineId(request.machine_id());
  // A token holds the one of the list of calibrations: a page reads its own of them, and those between that are not
  // listed.
  std::string place = start.after.value_or("");
  v1::ListVolumetricErrorsResponse response;
  do {
    ASSIGN_OR_RETURN(const records::Page<CalibrationRecord> page,
                     core.database.ListCalibrations(filter, {size - response.errors_size(), place}));
    place = page.next_token;
    for (const CalibrationRecord& record : page.rows) {
      if (call.is_cancelled())
        return base::Error(absl::StatusCode::kCancelled, "the caller has left", {"CALLER_GONE", {}});
      if (!IsListed(record)) continue;
      ASSIGN_OR_RETURN(*response.add_errors(), ErrorOrProblem(core, call, record, request.box()));
    }
  } while (response.errors_size() < size && !place.empty());
  if (!place.empty()) response.set_next_page_token(storage::MakePageToken(start, place));
  return response;
}

}  // namespace axiscal::handlers
