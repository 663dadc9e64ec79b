#include <google/protobuf/util/json_util.h>

#include <nlohmann/json.hpp>

#include "absl/strings/escaping.h"
#include "absl/strings/strip.h"
#include "core/base/utf8.h"
#include "google/rpc/error_details.pb.h"
#include "proto/convert/status.h"
#include "server/http/errors.h"

namespace axiscal::http {
namespace {

struct CodeRow {
  const char* name;
  int http_status;
};

// By the number of the code. Source: the table of the Connect protocol.
constexpr CodeRow kCodes[] = {
    {"ok", 200},
    {"canceled", 499},
    {"unknown", 500},
    {"invalid_argument", 400},
    {"deadline_exceeded", 504},
    {"not_found", 404},
    {"already_exists", 409},
    {"permission_denied", 403},
    {"resource_exhausted", 429},
    {"failed_precondition", 400},
    {"aborted", 409},
    {"out_of_range", 400},
    {"unimplemented", 501},
    {"internal", 500},
    {"unavailable", 503},
    {"data_loss", 500},
    {"unauthenticated", 401},
};
constexpr int kUnknown = 2;

const CodeRow& RowOf(int code) {
  constexpr int kCount = sizeof(kCodes) / sizeof(kCodes[0]);
  return kCodes[code > 0 && code < kCount ? code : kUnknown];
}

// The types of details that we send; of others `debug` is left out.
template <typename Message>
bool AddDebug(const google::protobuf::Any& any, nlohmann::json& detail) {
  Message message;
  std::string text;
  if (!any.Is<Message>() || !any.UnpackTo(&message)) return false;
  if (!google::protobuf::util::MessageToJsonString(message, &text).ok()) return false;
  nlohmann::json debug = nlohmann::json::parse(text, nullptr, false);
  if (!debug.is_discarded()) detail["debug"] = std::move(debug);
  return true;
}

nlohmann::json JsonOf(const google::rpc::Status& error) {
  nlohmann::json json = {{"code", CodeName(error.code())}, {"message", base::ToUtf8(error.message())}};
  for (const google::protobuf::Any& any : error.details()) {
    const std::string value = absl::Base64Escape(any.value());
    nlohmann::json detail = {{"type", any.type_url().substr(any.type_url().rfind('/') + 1)},
                             {"value", value.substr(0, value.find('='))}};
    static_cast<void>(AddDebug<google::rpc::ErrorInfo>(any, detail) || AddDebug<google::rpc::BadRequest>(any, detail) ||
                      AddDebug<google::rpc::RetryInfo>(any, detail));
    json["details"].push_back(std::move(detail));
  }
  return json;
}

}  // namespace

std::string CodeName(int code) { return RowOf(code).name; }
int HttpStatusOf(int code) { return RowOf(code).http_status; }

google::rpc::Status ErrorOf(const grpc::Status& status) {
  google::rpc::Status error;
  if (!status.error_details().empty() && error.ParseFromString(status.error_details()) && error.code() != 0)
    return error;
  error.Clear();
  error.set_code(status.error_code());
  error.set_message(status.error_message());
  return error;
}

google::rpc::Status ErrorOf(const absl::Status& status) { return convert::ToProto(status); }

std::string ErrorJson(const google::rpc::Status& error) { return JsonOf(error).dump(); }

Answer ErrorAnswer(const google::rpc::Status& error) {
  return {HttpStatusOf(error.code()), {{"Content-Type", "application/json"}}, ErrorJson(error)};
}

Answer ErrorAnswer(const absl::Status& status) { return ErrorAnswer(ErrorOf(status)); }

std::string EndOfStreamJson(const google::rpc::Status* error) {
  return error == nullptr ? "{}" : nlohmann::json{{"error", JsonOf(*error)}}.dump();
}

}  // namespace axiscal::http
