#include "proto/convert/report.h"

#include <google/protobuf/util/json_util.h>

#include "core/base/error_detail.h"
#include "core/records/job_params.h"

namespace axiscal::convert {
namespace {

absl::Status Read(const std::string& json, google::protobuf::Message* report) {
  google::protobuf::util::JsonParseOptions options;
  options.ignore_unknown_fields = true;
  const auto status = google::protobuf::util::JsonStringToMessage(json, report, options);
  if (status.ok()) return absl::OkStatus();
  return base::Error(absl::StatusCode::kDataLoss, "the stored report is none: " + std::string(status.message()),
                     {"REPORT_DAMAGED", {}});
}

}  // namespace

absl::StatusOr<v1::Report> ReportFromJson(const std::string& kind, const std::string& report_json) {
  v1::Report report;
  if (kind == records::kIdentify) {
    RETURN_IF_ERROR(Read(report_json, report.mutable_identification()));
  } else if (kind == records::kCloseLoop) {
    RETURN_IF_ERROR(Read(report_json, report.mutable_loop()));
  } else if (kind == records::kCompensate) {
    RETURN_IF_ERROR(Read(report_json, report.mutable_rewrite()));
  } else if (kind == records::kToolSetter) {
    // Of the two kinds of sessions, that of a mill has inserts.
    v1::WearReport wear;
    RETURN_IF_ERROR(Read(report_json, &wear));
    if (wear.inserts_size() > 0) {
      *report.mutable_wear() = std::move(wear);
    } else {
      RETURN_IF_ERROR(Read(report_json, report.mutable_beam()));
    }
  } else {
    return base::Error(absl::StatusCode::kUnimplemented, "jobs of kind " + kind + " have no report",
                       {"JOB_KIND_UNKNOWN", {{"kind", kind}}});
  }
  return report;
}

}  // namespace axiscal::convert
