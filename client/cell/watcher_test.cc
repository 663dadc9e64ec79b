#include "client/cell/watcher.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cstdlib>
#include <filesystem>
#include <fstream>

namespace axiscal::cell {
namespace {

namespace fs = std::filesystem;
using ::testing::ElementsAre;
using ::testing::IsEmpty;

class FolderWatcherTest : public ::testing::Test {
 protected:
  FolderWatcherTest() {
    std::string name = (fs::temp_directory_path() / "axiscal-watch-XXXXXX").string();
    EXPECT_NE(mkdtemp(name.data()), nullptr);
    watch_.folder = name;
    watch_.files = "*.log";
  }
  ~FolderWatcherTest() override { fs::remove_all(watch_.folder); }
  std::string Path(const std::string& name) const { return watch_.folder + "/" + name; }
  void Append(const std::string& name, const std::string& text) const {
    std::ofstream(Path(name), std::ios::binary | std::ios::app) << text;
  }
  // After so many seconds.
  Found Look(FolderWatcher& watcher, int seconds) {
    return watcher.LookThrough(base::SteadyTime() + std::chrono::seconds(seconds), known_);
  }

  Watch watch_;
  KnownFiles known_;
};

TEST_F(FolderWatcherTest, AFileIsWholeWhenItStaysAsItIs) {
  FolderWatcher watcher(watch_, std::chrono::seconds(10));
  Append("a.log", "X1\n");
  EXPECT_THAT(Look(watcher, 0).whole, IsEmpty());
  EXPECT_EQ(Look(watcher, 9).growing, 1);
  Append("a.log", "X2\n");
  EXPECT_THAT(Look(watcher, 10).whole, IsEmpty()) << "it has grown";
  EXPECT_THAT(Look(watcher, 19).whole, IsEmpty());
  EXPECT_THAT(Look(watcher, 20).whole, ElementsAre(Path("a.log")));
  EXPECT_THAT(Look(watcher, 21).whole, ElementsAre(Path("a.log"))) << "until somebody knows it";
  known_[Path("a.log")] = FolderWatcher::LookAt(Path("a.log"));
  EXPECT_THAT(Look(watcher, 22).whole, IsEmpty());
  // Another content under the name is another file.
  Append("a.log", "X3\n");
  EXPECT_THAT(Look(watcher, 30).whole, IsEmpty());
  EXPECT_THAT(Look(watcher, 40).whole, ElementsAre(Path("a.log")));
  fs::remove(Path("a.log"));
  EXPECT_THAT(Look(watcher, 41).whole, IsEmpty());
  EXPECT_THAT(known_, IsEmpty());
}

TEST_F(FolderWatcherTest, WhatIsWrittenUnderAnotherNameIsNotMeant) {
  FolderWatcher watcher(watch_, std::chrono::seconds(0));
  for (const char* const name : {".a.log", "b.log.tmp", "c.log.part", "d.log~", "e.txt", "f.log"}) Append(name, "x");
  fs::create_directory(Path("folder.log"));
  const Found found = Look(watcher, 0);
  EXPECT_THAT(found.whole, ElementsAre(Path("f.log")));
  EXPECT_EQ(found.growing, 0);
}

TEST_F(FolderWatcherTest, AnEmptyFileIsWaitedForNoLongerThanOthers) {
  FolderWatcher watcher(watch_, std::chrono::seconds(10));
  Append("empty.log", "");
  EXPECT_EQ(Look(watcher, 0).growing, 1);
  EXPECT_EQ(Look(watcher, 10).growing, 0) << "a look that waits for what grows ends";
  EXPECT_THAT(Look(watcher, 11).whole, IsEmpty()) << "there is nothing to send";
  Append("empty.log", "X1\n");
  EXPECT_EQ(Look(watcher, 20).growing, 1);
  EXPECT_THAT(Look(watcher, 30).whole, ElementsAre(Path("empty.log")));
}

TEST_F(FolderWatcherTest, TheOldestComesFirst) {
  FolderWatcher watcher(watch_, std::chrono::seconds(0));
  for (const char* const name : {"a.log", "b.log", "c.log"}) Append(name, "x");
  const auto now = fs::last_write_time(Path("a.log"));
  fs::last_write_time(Path("a.log"), now - std::chrono::seconds(1));
  fs::last_write_time(Path("c.log"), now - std::chrono::seconds(3));
  EXPECT_THAT(Look(watcher, 0).whole, ElementsAre(Path("c.log"), Path("a.log"), Path("b.log")));
}

TEST_F(FolderWatcherTest, ALastLineSaysThatAFileIsWhole) {
  watch_.end_line = "%";
  FolderWatcher watcher(watch_, std::chrono::seconds(10));
  Append("a.log", "%\nX1\n");
  Append("b.log", "%\nX1 50%\n");
  Look(watcher, 0);
  const Found found = Look(watcher, 10);
  EXPECT_THAT(found.whole, IsEmpty());
  EXPECT_EQ(found.without_end, 2);
  Append("a.log", "%\r\n\n");
  Look(watcher, 20);
  EXPECT_THAT(Look(watcher, 30).whole, ElementsAre(Path("a.log")));
}

TEST_F(FolderWatcherTest, AFolderThatIsAwayForgetsNothing) {
  FolderWatcher watcher(watch_, std::chrono::seconds(0));
  Append("a.log", "x");
  known_[Path("a.log")] = FolderWatcher::LookAt(Path("a.log"));
  const KnownFiles before = known_;
  const std::string away = watch_.folder + "-away";
  fs::rename(watch_.folder, away);
  const Found found = Look(watcher, 0);
  EXPECT_FALSE(found.status.ok());
  EXPECT_EQ(known_, before);
  fs::rename(away, watch_.folder);
  EXPECT_THAT(Look(watcher, 1).whole, IsEmpty());
}

TEST_F(FolderWatcherTest, WhatIsWrittenAgainAfterItWasFoundIsNotTaken) {
  FolderWatcher watcher(watch_, std::chrono::seconds(0));
  Append("a.log", "X1\n");
  const Found found = Look(watcher, 0);
  ASSERT_THAT(found.whole, ElementsAre(Path("a.log")));
  EXPECT_EQ(*ReadAsFound(found.whole[0], found.looks[0]), "X1\n");
  Append("a.log", "X2");
  EXPECT_TRUE(absl::IsUnavailable(ReadAsFound(found.whole[0], found.looks[0]).status())) << "half of a file";
  fs::remove(Path("a.log"));
  EXPECT_TRUE(absl::IsUnavailable(ReadAsFound(found.whole[0], found.looks[0]).status()));
}

TEST_F(FolderWatcherTest, LinksAreNotFollowed) {
  FolderWatcher watcher(watch_, std::chrono::seconds(0));
  Append("secret.txt", "X1\n");
  fs::create_symlink(Path("secret.txt"), Path("a.log"));
  const Found found = Look(watcher, 0);
  EXPECT_THAT(found.whole, IsEmpty());
  EXPECT_EQ(found.links, 1);
  // Nor where the file became one after it was found.
  const axiscal::cell::Look look = FolderWatcher::LookAt(Path("secret.txt"));
  EXPECT_TRUE(absl::IsUnavailable(ReadAsFound(Path("a.log"), look).status()));
}

TEST(KnownFiles, AreKeptAsText) {
  const KnownFiles known = {{"/a b/c 1.log", {3, -5}}, {"/x", {0, 1'700'000'000'000'000'001}}};
  EXPECT_EQ(ReadKnown(WriteKnown(known)), known);
  EXPECT_THAT(ReadKnown("3 4\n"), IsEmpty());
  EXPECT_THAT(ReadKnown("x y z\n"), IsEmpty());
  EXPECT_THAT(ReadKnown("3 4 /a"), IsEmpty()) << "cut";
  EXPECT_THAT(ReadKnown(""), IsEmpty());
}

}  // namespace
}  // namespace axiscal::cell
