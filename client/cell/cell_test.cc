#include "client/cell/cell.h"

#include <gtest/gtest.h>

#include <cstdlib>
#include <filesystem>
#include <fstream>

namespace axiscal::cell {
namespace {

namespace fs = std::filesystem;

TEST(Cell, ALargeFolderIsTakenInOverSeveralRoundsAndKnownAfterEach) {
  std::string name = (fs::temp_directory_path() / "axiscal-cell-XXXXXX").string();
  ASSERT_NE(mkdtemp(name.data()), nullptr);
  const fs::path folder = name;
  Config config;
  config.server = "unix:" + name + "/nobody";
  config.name = "cell-7";
  config.spool.folder = name + "/spool";
  config.status_file = name + "/status.json";
  config.client.connect_deadline = std::chrono::milliseconds(0);
  config.client.give_up_after = std::chrono::milliseconds(1);
  config.settle = config.look_every = std::chrono::milliseconds(0);
  for (const char* const watched : {"a", "b"}) {
    fs::create_directory(folder / watched);
    Watch watch;
    watch.folder = (folder / watched).string();
    watch.files = "*.csv";
    config.watches.push_back(watch);
  }
  for (const char* const file : {"a/1.csv", "a/2.csv", "a/3.csv", "b/1.csv"}) std::ofstream(folder / file) << file;
  {
    const absl::StatusOr<std::unique_ptr<Cell>> cell = Cell::Create(config);
    ASSERT_TRUE(cell.ok()) << cell.status();
    const auto stops = [] { return true; };  // nothing is sent
    (*cell)->Step(stops);
    EXPECT_EQ((*cell)->status().spool.waiting, 2) << "one of each folder";
    EXPECT_TRUE((*cell)->status().looks_on);
    EXPECT_EQ((*cell)->Pause(), std::chrono::milliseconds(1));
    std::ifstream known(config.spool.folder + "/known");
    const std::string text((std::istreambuf_iterator<char>(known)), std::istreambuf_iterator<char>());
    EXPECT_EQ(ReadKnown(text).size(), 2u) << "who is killed now does not begin anew";
    (*cell)->Step(stops);
    EXPECT_EQ((*cell)->status().spool.waiting, 3);
    (*cell)->Step(stops);
    EXPECT_EQ((*cell)->status().spool.waiting, 4);
    EXPECT_FALSE((*cell)->status().looks_on);
  }
  fs::remove_all(folder);
}

}  // namespace
}  // namespace axiscal::cell
