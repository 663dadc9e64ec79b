#include "client/spool/spool.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <signal.h>
#include <sys/wait.h>
#include <unistd.h>

#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <memory>
#include <random>
#include <set>

#include "client/spool/sender.h"
#include "core/base/error_detail.h"

namespace axiscal::spool {
namespace {

namespace fs = std::filesystem;
using ::testing::ElementsAre;
using ::testing::IsEmpty;

class SpoolTest : public ::testing::Test {
 protected:
  SpoolTest() {
    std::string name = (fs::temp_directory_path() / "axiscal-spool-XXXXXX").string();
    EXPECT_NE(mkdtemp(name.data()), nullptr);
    folder_ = name;
    options_.folder = name + "/spool";
  }
  ~SpoolTest() override { fs::remove_all(folder_); }
  Spool Open() {
    absl::StatusOr<Spool> spool = Spool::Open(options_);
    EXPECT_TRUE(spool.ok()) << spool.status();
    return *std::move(spool);
  }
  static Item Log(const std::string& name) {
    Item item;
    item.is_log = true;
    item.machine = "mt";
    item.name = name;
    item.form.template_text = "line: X{X_mm}\n";
    item.form.template_name = "t.txt";
    item.form.plan_text = "# plan\n";
    item.form.start_s = 0.1;
    return item;
  }
  void Write(const std::string& name, const std::string& text) const {
    std::ofstream(folder_ / name, std::ios::binary) << text;
  }

  fs::path folder_;
  SpoolOptions options_;
};

TEST_F(SpoolTest, WhatIsAddedWaitsInOrderOverRestarts) {
  const std::string bytes("\0\r\n\xff", 4);
  {
    Spool spool = Open();
    EXPECT_EQ(spool.Add(Log("b.log"), bytes)->number, 1);
    EXPECT_EQ(spool.Add(Log("a.log"), bytes)->number, 2) << "another name is another entry";
    const auto again = spool.Add(Log("b.log"), bytes);
    EXPECT_EQ(again->number, 1);
    EXPECT_TRUE(again->was_there);
  }
  Spool spool = Open();
  EXPECT_THAT(*spool.Numbers(Place::kWaiting), ElementsAre(1, 2));
  const auto entry = spool.Get(Place::kWaiting, 1);
  ASSERT_TRUE(entry.ok()) << entry.status();
  EXPECT_EQ(entry->item, Log("b.log"));
  EXPECT_EQ(*spool.Content(Place::kWaiting, 1), bytes);
  // The order is kept where the first ones have gone.
  ASSERT_TRUE(spool.MarkSent(1, {{"session_id", "7"}}).ok());
  ASSERT_TRUE(spool.Refuse(2, {{"text", "wrong"}, {"line", "3"}}).ok());
  EXPECT_EQ(spool.Add(Log("c.log"), bytes)->number, 3);
  EXPECT_EQ(spool.NoteOf(Place::kSent, 1).at("session_id"), "7");
  EXPECT_EQ(spool.NoteOf(Place::kRefused, 2).at("line"), "3");
  EXPECT_EQ(spool.Add(Log("a.log"), bytes)->place, Place::kRefused) << "what was refused is not sent again by itself";
  EXPECT_EQ(spool.Add(Log("b.log"), bytes)->place, Place::kSent);
  ASSERT_TRUE(spool.Retry(2).ok());
  EXPECT_THAT(*spool.Numbers(Place::kWaiting), ElementsAre(2, 3));
  ASSERT_TRUE(spool.Refuse(2, {}).ok());
  ASSERT_TRUE(spool.Drop(2).ok());
  EXPECT_THAT(*spool.Numbers(Place::kRefused), IsEmpty());
  EXPECT_EQ(base::ErrorReason(spool.Drop(3)), "SPOOL_ENTRY_NOT_FOUND") << "what waits is never dropped";
}

TEST_F(SpoolTest, TheQuotaTakesCopiesOfWhatWasSentAndNothingElse) {
  options_.max_bytes = 4000;
  Spool spool = Open();
  const std::string kilobyte(1000, 'x');
  ASSERT_TRUE(spool.Add(Log("1"), kilobyte).ok());
  ASSERT_TRUE(spool.Add(Log("2"), kilobyte).ok());
  EXPECT_EQ(base::ErrorReason(spool.Add(Log("3"), std::string(2000, 'y')).status()), "SPOOL_FULL");
  EXPECT_THAT(*spool.Numbers(Place::kWaiting), ElementsAre(1, 2));
  ASSERT_TRUE(spool.MarkSent(1, {}).ok());
  const auto third = spool.Add(Log("3"), kilobyte);
  ASSERT_TRUE(third.ok()) << third.status();
  EXPECT_EQ(third->number, 3);
  EXPECT_THAT(*spool.Numbers(Place::kSent), IsEmpty());
  EXPECT_THAT(*spool.Numbers(Place::kWaiting), ElementsAre(2, 3));
  ASSERT_TRUE(spool.Refuse(2, {}).ok());
  EXPECT_EQ(base::ErrorReason(spool.Add(Log("4"), std::string(2000, 'z')).status()), "SPOOL_FULL") << "refused stays";
  EXPECT_THAT(*spool.Numbers(Place::kRefused), ElementsAre(2));
}

TEST_F(SpoolTest, CopiesOfWhatWasSentAreCounted) {
  options_.max_sent = 2;
  Spool spool = Open();
  for (int i = 1; i <= 4; ++i) {
    ASSERT_TRUE(spool.Add(Log(std::to_string(i)), "x").ok());
    ASSERT_TRUE(spool.MarkSent(i, {}).ok());
  }
  EXPECT_THAT(*spool.Numbers(Place::kSent), ElementsAre(3, 4));
}

// Two who share a spool remember sizes of entries, and what they remember is what is there.
TEST_F(SpoolTest, WhatIsRememberedOfSizesIsWhatIsThere) {
  Spool one = Open(), other = Open();
  const auto agree = [&] {
    const Usage fresh = *Open().Measure();
    for (const Spool& spool : {one, other}) {
      const Usage usage = *spool.Measure();
      EXPECT_EQ(usage.waiting_bytes, fresh.waiting_bytes);
      EXPECT_EQ(usage.refused_bytes, fresh.refused_bytes);
      EXPECT_EQ(usage.sent_bytes, fresh.sent_bytes);
    }
    return fresh.bytes();
  };
  for (const char* name : {"a.log", "b.log", "c.log"}) EXPECT_TRUE(one.Add(Log(name), std::string(1000, 'x')).ok());
  const int64_t added = agree();
  EXPECT_GT(added, 3000);
  EXPECT_TRUE(one.MarkSent(1, {}).ok());
  EXPECT_TRUE(other.Refuse(2, {}).ok());
  EXPECT_GT(agree(), added) << "what was answered is kept with it";
  EXPECT_TRUE(one.Retry(2).ok());
  agree();
  EXPECT_TRUE(other.Refuse(2, {}).ok());
  EXPECT_TRUE(other.Drop(2).ok());
  EXPECT_LT(agree(), added);
}

TEST_F(SpoolTest, ASourceGoesOnceItWasSentUnlessItHasChanged) {
  Spool spool = Open();
  for (const char* const name : {"kept.log", "gone.log", "changed.log"}) {
    Write(name, "bytes");
    Item item = Log(name);
    item.source = (folder_ / name).string();
    item.removes_source = std::string(name) != "kept.log";
    ASSERT_TRUE(spool.Add(item, "bytes").ok());
  }
  Write("changed.log", "other");
  EXPECT_TRUE(fs::exists(folder_ / "gone.log")) << "not before the server has it";
  for (int number = 1; number <= 3; ++number) ASSERT_TRUE(spool.MarkSent(number, {}).ok());
  EXPECT_TRUE(fs::exists(folder_ / "kept.log"));
  EXPECT_FALSE(fs::exists(folder_ / "gone.log"));
  EXPECT_TRUE(fs::exists(folder_ / "changed.log"));
  // Killed between the two: found again, it goes.
  Write("gone.log", "bytes");
  Item item = Log("gone.log");
  item.source = (folder_ / "gone.log").string();
  item.removes_source = true;
  EXPECT_EQ(spool.Add(item, "bytes")->place, Place::kSent);
  EXPECT_FALSE(fs::exists(folder_ / "gone.log"));
}

TEST_F(SpoolTest, CopiesOfWhatWasSentWaitAgainBeforeWhatCameLater) {
  Spool spool = Open();
  for (const char* const name : {"a.log", "b.log", "c.log"}) ASSERT_TRUE(spool.Add(Log(name), name).ok());
  ASSERT_TRUE(spool.MarkSent(1, {}).ok());
  ASSERT_TRUE(spool.Refuse(2, {}).ok());
  ASSERT_TRUE(spool.MarkSent(3, {}).ok());
  ASSERT_TRUE(spool.Add(Log("d.log"), "d.log").ok());
  EXPECT_EQ(*spool.SendAgain(), 2);
  EXPECT_THAT(*spool.Numbers(Place::kWaiting), ElementsAre(1, 3, 4)) << "what was refused stays where it is";
  EXPECT_EQ(*spool.Content(Place::kWaiting, 1), "a.log");
  ASSERT_TRUE(spool.MarkSent(1, {}).ok());
  EXPECT_THAT(*spool.Numbers(Place::kSent), ElementsAre(1));
}

TEST_F(SpoolTest, WhatTheDiskHasChangedIsSeen) {
  Spool spool = Open();
  for (const char* const file : {"content", "template", "plan", "entry.json"}) {
    const auto added = spool.Add(Log(file), "bytes of a log");
    ASSERT_TRUE(added.ok());
    for (const fs::directory_entry& entry : fs::directory_iterator(options_.folder + "/waiting")) {
      const std::string number = entry.path().filename().string().substr(0, 12);
      if (std::stoll(number) != added->number) continue;
      std::fstream out(entry.path() / file, std::ios::in | std::ios::out | std::ios::binary);
      out.seekp(4);
      out.put('#');
    }
    EXPECT_EQ(base::ErrorReason(spool.Content(Place::kWaiting, added->number).status()), "SPOOL_DAMAGED") << file;
  }
}

TEST_F(SpoolTest, WhatIsNoFileToSendIsRefused) {
  options_.max_file_bytes = 10;
  Spool spool = Open();
  EXPECT_EQ(base::ErrorReason(spool.Add(Log("a"), "").status()), "SPOOL_FILE_INVALID");
  EXPECT_EQ(base::ErrorReason(spool.Add(Log("a"), std::string(11, 'x')).status()), "SPOOL_FILE_INVALID");
  EXPECT_EQ(base::ErrorReason(spool.Add(Log("a/b"), "x").status()), "SPOOL_FILE_INVALID");
  Item item = Log("a");
  item.form.template_text.clear();
  EXPECT_EQ(base::ErrorReason(spool.Add(item, "x").status()), "SPOOL_FILE_INVALID");
  EXPECT_THAT(*spool.Numbers(Place::kWaiting), IsEmpty());
}

TEST_F(SpoolTest, OneSenderAtATime) {
  Open();
  auto first = std::make_unique<absl::StatusOr<SenderLock>>(SenderLock::Take(options_.folder));
  ASSERT_TRUE(first->ok());
  EXPECT_EQ(base::ErrorReason(SenderLock::Take(options_.folder).status()), "SPOOL_BUSY");
  first.reset();
  EXPECT_TRUE(SenderLock::Take(options_.folder).ok());
}

// Two processes that add, one that sends, each killed at moments by chance: what was added is there once and whole.
TEST_F(SpoolTest, KilledAtAnyMomentItHoldsEveryFileOnceAndWhole) {
  constexpr int kRounds = 20, kFiles = 8;
  std::mt19937 random(25);
  const auto name = [](int round, int i) { return absl::StrCat("r", round, "-", i, ".log"); };
  const auto text = [](const std::string& of) { return absl::StrCat(std::string(20'000, '.'), of); };
  for (int round = 0; round < kRounds; ++round) {
    // A byte for each file that was added: moments are told by the work done, as a busy machine does none for a while.
    int done[2];
    ASSERT_EQ(pipe(done), 0);
    std::vector<pid_t> children;
    for (int who = 0; who < 3; ++who) {
      const pid_t child = fork();
      ASSERT_GE(child, 0);
      if (child > 0) {
        children.push_back(child);
        continue;
      }
      auto spool = Spool::Open(options_);
      if (!spool.ok()) _exit(1);
      for (int i = 0; i < kFiles; ++i) {
        if (who < 2) {
          static_cast<void>(spool->Add(Log(name(round, i)), text(name(round, i))));
          if (write(done[1], "+", 1) != 1) _exit(1);
          continue;
        }
        const auto waiting = spool->Numbers(Place::kWaiting);
        if (waiting.ok() && !waiting->empty()) static_cast<void>(spool->MarkSent(waiting->front(), {{"n", "1"}}));
      }
      _exit(0);
    }
    close(done[1]);
    char byte = 0;
    for (int left = static_cast<int>(random() % (2 * kFiles)); left > 0 && read(done[0], &byte, 1) == 1; --left) {
    }
    usleep(static_cast<useconds_t>(random() % 1'000));  // some way into the next file
    close(done[0]);
    for (const pid_t child : children) kill(child, SIGKILL);
    for (const pid_t child : children) waitpid(child, nullptr, 0);
  }
  // Whoever was killed adds again what it did not know to be there.
  Spool spool = Open();
  int known = 0;
  for (int round = 0; round < kRounds; ++round) {
    for (int i = 0; i < kFiles; ++i) {
      const auto added = spool.Add(Log(name(round, i)), text(name(round, i)));
      ASSERT_TRUE(added.ok()) << added.status();
      known += added->was_there ? 1 : 0;
    }
  }
  EXPECT_GT(known, 0);
  EXPECT_LT(known, kRounds * kFiles) << "none was killed before its end";
  std::set<std::string> names;
  for (const Place place : {Place::kWaiting, Place::kSent}) {
    const auto numbers = spool.Numbers(place);
    ASSERT_TRUE(numbers.ok()) << numbers.status();
    for (const int64_t number : *numbers) {
      const auto entry = spool.Get(place, number);
      ASSERT_TRUE(entry.ok()) << entry.status();
      EXPECT_EQ(*spool.Content(place, number), text(entry->item.name));
      EXPECT_TRUE(names.insert(entry->item.name).second) << entry->item.name << " twice";
    }
  }
  EXPECT_EQ(names.size(), static_cast<size_t>(kRounds * kFiles));
  EXPECT_TRUE(fs::is_empty(options_.folder + "/tmp"));
}

// What a kill between the two steps of MarkSent() leaves: sent, and its source still there.
TEST_F(SpoolTest, SourcesOfWhatWasSentGoEvenAfterAKill) {
  Spool spool = Open();
  const auto item = [&](const std::string& name, bool removes) {
    Item one = Log(name);
    one.source = (folder_ / name).string();
    one.removes_source = removes;
    return one;
  };
  const std::string latin1 = "caf\xe9.log";
  for (const std::string& name : {std::string("a.log"), latin1, std::string("kept.log"), std::string("changed.log")}) {
    Item one = item(name, name != "kept.log");
    one.name = name == latin1 ? "caf%E9.log" : name;
    ASSERT_TRUE(spool.Add(one, "x" + name).ok());
  }
  for (const int64_t number : {1, 2, 3, 4}) ASSERT_TRUE(spool.MarkSent(number, {}).ok());
  Write("a.log", "xa.log");
  Write(latin1, "x" + latin1);
  Write("kept.log", "xkept.log");
  Write("changed.log", "another");
  EXPECT_EQ(*spool.RemoveSentSources(), 2);
  EXPECT_FALSE(fs::exists(folder_ / "a.log"));
  EXPECT_FALSE(fs::exists(folder_ / latin1));
  EXPECT_TRUE(fs::exists(folder_ / "kept.log"));
  EXPECT_TRUE(fs::exists(folder_ / "changed.log")) << "another file by now";
}

TEST(FateOf, TellsTheFileFromTheServerAndTheCaller) {
  const auto fate = [](absl::StatusCode code, const std::string& reason) {
    return FateOf(base::Error(code, "", {reason, {}}));
  };
  EXPECT_EQ(FateOf(absl::OkStatus()), Fate::kSent);
  EXPECT_EQ(fate(absl::StatusCode::kInvalidArgument, "LOG_INVALID"), Fate::kRefused);
  EXPECT_EQ(fate(absl::StatusCode::kNotFound, "MACHINE_NOT_FOUND"), Fate::kRefused);
  EXPECT_EQ(fate(absl::StatusCode::kResourceExhausted, "LOG_TOO_LARGE"), Fate::kRefused);
  EXPECT_EQ(fate(absl::StatusCode::kResourceExhausted, "DISK_LOW"), Fate::kLater);
  EXPECT_EQ(fate(absl::StatusCode::kUnavailable, "DRAINING"), Fate::kLater);
  EXPECT_EQ(fate(absl::StatusCode::kUnauthenticated, "TOKEN_INVALID"), Fate::kNotAllowed);
  EXPECT_EQ(fate(absl::StatusCode::kPermissionDenied, "ROLE_MISSING"), Fate::kNotHere);
  EXPECT_EQ(fate(absl::StatusCode::kInternal, "INTERNAL"), Fate::kOurBug);
}

}  // namespace
}  // namespace axiscal::spool
