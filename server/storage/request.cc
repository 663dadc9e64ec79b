#include "server/storage/request.h"

#include <bit>

#include "core/base/error_detail.h"

namespace axiscal::storage {

BodyHash& BodyHash::Add(const std::string& field) {
  const uint64_t size = field.size();
  sha_.Add(&size, sizeof(size));
  sha_.Add(field);
  return *this;
}

BodyHash& BodyHash::AddReal(const std::optional<double>& number) {
  return number.has_value() ? Add(absl::StrFormat("%016x", std::bit_cast<uint64_t>(*number))) : Add("absent");
}

absl::Status RequestIdReused(const Caller& caller, const std::string& what) {
  return base::Error(absl::StatusCode::kInvalidArgument,
                     absl::StrCat("request_id ", caller.request_id, " was used before for another ", what),
                     {"REQUEST_ID_REUSED", {{"request_id", caller.request_id}}});
}

absl::StatusOr<std::optional<int64_t>> FindRequest(Connection& connection, const std::string& table,
                                                   const Caller& caller, const std::string& body_sha256) {
  if (caller.request_id.empty()) return std::nullopt;
  ASSIGN_OR_RETURN(Statement row,
                   connection.Ask("SELECT id, body_sha256 FROM " + table +
                                      " WHERE created_by = ?1 AND request_id = ?2 ORDER BY id DESC LIMIT 1",
                                  caller.principal, caller.request_id));
  ASSIGN_OR_RETURN(const bool found, row.Step());
  if (!found) return std::nullopt;
  if (row.Text(1) != body_sha256) return RequestIdReused(caller, table);
  return row.Int(0);
}

std::optional<std::string> RequestId(const Caller& caller) {
  return caller.request_id.empty() ? std::nullopt : std::optional<std::string>(caller.request_id);
}

}  // namespace axiscal::storage
