#include "server/storage/sqlite_error.h"

#include <gtest/gtest.h>

#include "core/base/error_detail.h"

namespace axiscal::storage {
namespace {

// A busy store may be tried again; a read-only one is a refusal, so that nobody waits for it.
TEST(SqliteErrors, AReadOnlyDatabaseIsRefused) {
  sqlite3* db = nullptr;
  ASSERT_EQ(sqlite3_open(":memory:", &db), SQLITE_OK);
  ASSERT_EQ(sqlite3_exec(db, "PRAGMA query_only = ON", nullptr, nullptr, nullptr), SQLITE_OK);
  ASSERT_EQ(sqlite3_exec(db, "CREATE TABLE t (x)", nullptr, nullptr, nullptr), SQLITE_READONLY);
  const absl::Status status = SqliteError(db, "db");
  EXPECT_EQ(status.code(), absl::StatusCode::kFailedPrecondition) << status;
  EXPECT_EQ(base::ErrorReason(status), "STORE_READ_ONLY");
  sqlite3_close(db);
}

}  // namespace
}  // namespace axiscal::storage
