// The store's tests, on SQLite or, with --store=postgresql, on a PostgreSQL server that is started for them: the same
// cases but those of what SQLite alone has.
#include <gtest/gtest.h>

#include <cstdio>
#include <cstring>
#include <memory>
#include <string>

#include "server/storage/testing/postgres_server.h"
#include "server/storage/testing/temp_database.h"

namespace axiscal::storage {
namespace {

// Of the file, its disk, its log, its locks, copies and migrations, and of what needs no store. docs/scale.md says what
// PostgreSQL has in their place.
constexpr char kOfSqliteAlone[] =
    "-WriterTest.*:SqliteErrors.*:Statements.*:Migrations.*:SqliteDatabase.*:FileMode.*:CheckTest.*:ChunkCodec.*:"
    "Backup.*:PostgresErrors.*:PostgresSqlTexts.*:PostgresUrl.*:Sessions.LowDiskRefusesGrowthButLetsThingsEnd";

int RunOnPostgres() {
  absl::StatusOr<std::unique_ptr<PostgresServer>> server = PostgresServer::Start();
  if (absl::IsNotFound(server.status())) {
    std::printf("SKIPPED: %s\n", std::string(server.status().message()).c_str());
    return 77;
  }
  if (!server.ok()) {
    std::printf("%s\n", server.status().ToString().c_str());
    return 1;
  }
  TestServer::present = server->get();
  if (testing::GTEST_FLAG(filter) == "*") testing::GTEST_FLAG(filter) = kOfSqliteAlone;
  return RUN_ALL_TESTS();
}

}  // namespace
}  // namespace axiscal::storage

int main(int argc, char** argv) {
  testing::InitGoogleTest(&argc, argv);
  if (argc == 1 || std::strcmp(argv[1], "--store=sqlite") == 0) return RUN_ALL_TESTS();
  if (std::strcmp(argv[1], "--store=postgresql") == 0) return axiscal::storage::RunOnPostgres();
  std::printf("storage_test: %s: must be --store=sqlite or --store=postgresql\n", argv[1]);
  return 2;
}
