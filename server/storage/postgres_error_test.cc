#include "server/storage/postgres_error.h"

#include <gtest/gtest.h>

#include "core/base/error_detail.h"

namespace axiscal::storage {
namespace {

TEST(PostgresErrors, EachStateIsTheStatusThatSqliteGivesForTheSame) {
  const struct {
    const char* sqlstate;
    absl::StatusCode code;
    const char* reason;
  } kCases[] = {
      {"53100", absl::StatusCode::kResourceExhausted, "DISK_FULL"},         // disk_full
      {"25006", absl::StatusCode::kFailedPrecondition, "STORE_READ_ONLY"},  // read_only_sql_transaction
      {"42501", absl::StatusCode::kFailedPrecondition, "STORE_READ_ONLY"},  // insufficient_privilege
      {"40001", absl::StatusCode::kUnavailable, "STORE_BUSY"},              // serialization_failure
      {"40P01", absl::StatusCode::kUnavailable, "STORE_BUSY"},              // deadlock_detected
      {"55P03", absl::StatusCode::kUnavailable, "STORE_BUSY"},              // lock_not_available
      {"57P01", absl::StatusCode::kUnavailable, "STORE_DOWN"},              // admin_shutdown
      {"57P03", absl::StatusCode::kUnavailable, "STORE_DOWN"},              // cannot_connect_now
      {"53300", absl::StatusCode::kUnavailable, "STORE_DOWN"},              // too_many_connections
      {"", absl::StatusCode::kUnavailable, "STORE_DOWN"},                   // the connection is lost
      {"XX001", absl::StatusCode::kDataLoss, "STORE_DAMAGED"},              // data_corrupted
      {"22021", absl::StatusCode::kInvalidArgument, "TEXT_INVALID"},        // character_not_in_repertoire
      {"23505", absl::StatusCode::kInternal, "STORE_BUG"},                  // unique_violation
      {"42601", absl::StatusCode::kInternal, "STORE_BUG"},                  // syntax_error
  };
  for (const auto& one : kCases) {
    const absl::Status status = PostgresError(one.sqlstate, "text", "SELECT 1");
    EXPECT_EQ(status.code(), one.code) << one.sqlstate;
    EXPECT_EQ(base::ErrorReason(status), one.reason) << one.sqlstate;
    EXPECT_NE(status.message().find("SELECT 1: text"), std::string::npos) << status;
  }
}

}  // namespace
}  // namespace axiscal::storage
