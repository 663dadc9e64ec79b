#include "server/storage/file_mode.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <sys/stat.h>

#include "server/storage/testing/temp_database.h"

namespace axiscal::storage {
namespace {

using ::testing::ElementsAre;
using ::testing::IsEmpty;

int ModeOf(const std::string& path) {
  struct stat info;
  return stat(path.c_str(), &info) == 0 ? static_cast<int>(info.st_mode & 07777u) : -1;
}

TEST(FileMode, ADatabaseIsItsOwnersAlone) {
  const mode_t before = umask(0);
  TempDatabase database;
  ASSERT_TRUE(database->CreateMachine(MachineId("mt"), "{}", Cell("")).ok());
  umask(before);
  for (const char* suffix : {"", "-wal", "-shm", ".lock"}) EXPECT_EQ(ModeOf(database.path() + suffix), 0600) << suffix;
  EXPECT_THAT(OpenToOthers(database.path()), IsEmpty());
}

TEST(FileMode, OneThatIsOpenToOthersStaysSoAndIsNamed) {
  TempDatabase database;
  database.Close();
  ASSERT_EQ(chmod(database.path().c_str(), 0644), 0);
  database.Open();
  ASSERT_TRUE(database->CreateMachine(MachineId("mt"), "{}", Cell("")).ok());
  const std::string path = database.path();
  EXPECT_THAT(OpenToOthers(path), ElementsAre(path + " (0644)", path + "-wal (0644)", path + "-shm (0644)"));
  EXPECT_EQ(ModeOf(path), 0644) << "who set it may have a reason";
}

}  // namespace
}  // namespace axiscal::storage
