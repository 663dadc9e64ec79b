// Reports as messages. Their fields have the names and units of the JSON (core/reports), so that one text says both.
#ifndef AXISCAL_PROTO_CONVERT_REPORT_H_
#define AXISCAL_PROTO_CONVERT_REPORT_H_

#include <string>

#include "axiscal/v1/report.pb.h"
#include "core/base/status.h"

namespace axiscal::convert {

// `kind`: of the job (records::kIdentify ...). What a later version writes and the messages do not have is passed over.
// DATA_LOSS REPORT_DAMAGED where the text is no such report; UNIMPLEMENTED JOB_KIND_UNKNOWN.
absl::StatusOr<v1::Report> ReportFromJson(const std::string& kind, const std::string& report_json);

}  // namespace axiscal::convert

#endif  // AXISCAL_PROTO_CONVERT_REPORT_H_
