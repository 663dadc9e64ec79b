// How the server is.
#include "client/client_impl.h"

namespace axiscal::client {

absl::StatusOr<Diagnosis> Client::Diagnose() {
  ASSIGN_OR_RETURN(const auto response,
                   impl_->Call<v1::DiagnoseResponse>(*impl_->admin, &v1::Admin::Stub::Diagnose, v1::DiagnoseRequest()));
  Diagnosis diagnosis;
  for (const v1::Finding& message : response.findings()) {
    const bool is_known = message.state() >= v1::FINDING_STATE_OK && message.state() <= v1::FINDING_STATE_UNKNOWN;
    diagnosis.findings.push_back(
        {message.what(),
         is_known ? static_cast<records::FindingState>(message.state()) : records::FindingState::kUnknown,
         message.text(), message.advice()});
  }
  diagnosis.now = base::FromUtcUs(response.now_utc_us());
  return diagnosis;
}

absl::StatusOr<std::pair<records::LogLevel, records::LogLevel>> Client::SetLogLevel(
    std::optional<records::LogLevel> level) {
  v1::SetLogLevelRequest request;
  if (level) request.set_level(static_cast<v1::LogLevel>(*level));
  ASSIGN_OR_RETURN(const auto response,
                   impl_->Call<v1::SetLogLevelResponse>(*impl_->admin, &v1::Admin::Stub::SetLogLevel, request));
  for (const v1::LogLevel one : {response.former_level(), response.level()}) {
    if (one < v1::LOG_LEVEL_DEBUG || one > v1::LOG_LEVEL_ERROR)
      return absl::InternalError("the server names a log level that is not known here");
  }
  return std::pair(static_cast<records::LogLevel>(response.former_level()),
                   static_cast<records::LogLevel>(response.level()));
}

}  // namespace axiscal::client
