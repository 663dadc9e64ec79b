#include "server/handlers/session_remarks.h"

#include <algorithm>

#include "proto/convert/field.h"
#include "proto/convert/session.h"

namespace axiscal::handlers {
namespace {

constexpr int kMostLabels = 16;
constexpr size_t kMostNoteBytes = 4000, kMostReasonBytes = 1000;

absl::StatusOr<std::vector<std::string>> LabelsOf(const v1::AnnotateSessionRequest& request) {
  if (request.labels_size() > kMostLabels)
    return convert::FieldError("labels", absl::StrCat(request.labels_size(), " labels, at most ", kMostLabels));
  std::vector<std::string> labels(request.labels().begin(), request.labels().end());
  for (size_t i = 0; i < labels.size(); ++i) {
    const std::string field = absl::StrCat("labels[", i, "]");
    RETURN_IF_ERROR(convert::RequireAccessName(field, labels[i]));
    if (std::count(labels.begin(), labels.end(), labels[i]) > 1)
      return convert::FieldError(field, "'" + labels[i] + "' stands twice");
  }
  return labels;
}

}  // namespace

absl::StatusOr<v1::AnnotateSessionResponse> AnnotateSession(Core& core, const Call& call,
                                                            const v1::AnnotateSessionRequest& request) {
  RETURN_IF_ERROR(convert::RequireText("note", request.note(), 0, kMostNoteBytes));
  RETURN_IF_ERROR(convert::RequireNotNegative("etag", request.etag()));
  ASSIGN_OR_RETURN(const std::vector<std::string> labels, LabelsOf(request));
  ASSIGN_OR_RETURN(const records::SessionRecord session,
                   core.database.AnnotateSession(SessionId(request.session_id()), request.note(), labels,
                                                 request.etag(), call.By()));
  v1::AnnotateSessionResponse response;
  *response.mutable_session() = convert::ToProto(session);
  return response;
}

absl::StatusOr<v1::RejectSessionResponse> RejectSession(Core& core, const Call& call,
                                                        const v1::RejectSessionRequest& request) {
  RETURN_IF_ERROR(convert::RequireText("reason", request.reason(), 1, kMostReasonBytes));
  ASSIGN_OR_RETURN(
      const storage::RejectedSession rejected,
      core.database.RejectSession(SessionId(request.session_id()), request.is_rejected(), request.reason(), call.By()));
  core.look_soon(rejected.session.machine);
  core.run_soon(rejected.session.machine);
  v1::RejectSessionResponse response;
  *response.mutable_session() = convert::ToProto(rejected.session);
  for (const CalibrationId& id : rejected.calibrations) response.add_calibration_ids(id.number());
  return response;
}

}  // namespace axiscal::handlers
