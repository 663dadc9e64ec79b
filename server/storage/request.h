// Repeatable calls: a row remembers who asked for it with which request id and what the request said.
#ifndef AXISCAL_SERVER_STORAGE_REQUEST_H_
#define AXISCAL_SERVER_STORAGE_REQUEST_H_

#include <optional>
#include <string>

#include "core/base/sha256.h"
#include "server/storage/connection.h"
#include "server/storage/records.h"

namespace axiscal::storage {

// SHA-256 of fields, each with its length, so that moving text from one field to the next changes it.
class BodyHash {
 public:
  BodyHash& Add(const std::string& field);
  BodyHash& Add(int64_t number) { return Add(std::to_string(number)); }
  // Its 64 bits, or that it is absent.
  BodyHash& AddReal(const std::optional<double>& number);
  std::string Hex() { return sha_.HexDigest(); }

 private:
  base::Sha256 sha_;
};

// INVALID_ARGUMENT REQUEST_ID_REUSED; `what` is "session", "job" or "program".
absl::Status RequestIdReused(const Caller& caller, const std::string& what);

// The id of the newest row of `table` made by the same request, or nothing. INVALID_ARGUMENT REQUEST_ID_REUSED when its
// body was another.
absl::StatusOr<std::optional<int64_t>> FindRequest(Connection& connection, const std::string& table,
                                                   const Caller& caller, const std::string& body_sha256);

// What the column request_id holds: NULL for a call that need not be repeatable.
std::optional<std::string> RequestId(const Caller& caller);

}  // namespace axiscal::storage

#endif  // AXISCAL_SERVER_STORAGE_REQUEST_H_
