#include "core/base/files.h"

#include <fcntl.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <signal.h>
#include <sys/resource.h>
#include <sys/stat.h>
#include <sys/wait.h>
#include <unistd.h>

#include <filesystem>

namespace axiscal::base {
namespace {

using ::testing::HasSubstr;

class Files : public ::testing::Test {
 protected:
  Files() {
    std::string name = (std::filesystem::temp_directory_path() / "axiscal-files-XXXXXX").string();
    EXPECT_NE(mkdtemp(name.data()), nullptr);
    folder_ = name;
  }
  ~Files() override { std::filesystem::remove_all(folder_); }

  std::string Path(const std::string& name) const { return (folder_ / name).string(); }
  size_t FileCount() const {
    return std::distance(std::filesystem::directory_iterator(folder_), std::filesystem::directory_iterator());
  }

  bool CanHoldNamelessFiles() const {
    const int file = open(folder_.c_str(), O_TMPFILE | O_RDWR, 0600);
    if (file >= 0) close(file);
    return file >= 0;
  }

  std::filesystem::path folder_;
};

TEST_F(Files, WhatIsWrittenIsReadAndReplacesWhatWasThere) {
  ASSERT_TRUE(WriteFileAtomically(Path("a"), "old").ok());
  const std::string bytes("new\0\r\n", 6);
  ASSERT_TRUE(WriteFileAtomically(Path("a"), bytes).ok());
  EXPECT_EQ(*ReadFile(Path("a"), 100), bytes);
  EXPECT_EQ(FileCount(), 1u);
}

TEST_F(Files, AFailedWriteLeavesNothingBehind) {
  EXPECT_EQ(WriteFileAtomically(Path("no/such/folder"), "x").code(), absl::StatusCode::kNotFound);
  ASSERT_TRUE(std::filesystem::create_directory(folder_ / "d"));
  EXPECT_EQ(WriteFileAtomically(Path("d"), "x").code(), absl::StatusCode::kInvalidArgument);
  EXPECT_EQ(FileCount(), 1u);
}

TEST_F(Files, APipeIsNotReplaced) {
  ASSERT_EQ(mkfifo(Path("pipe").c_str(), 0600), 0);
  const absl::Status status = WriteFileAtomically(Path("pipe"), "x");
  EXPECT_EQ(status.code(), absl::StatusCode::kInvalidArgument);
  EXPECT_THAT(std::string(status.message()), HasSubstr("is not a file"));
  EXPECT_TRUE(std::filesystem::is_fifo(Path("pipe")));
  EXPECT_EQ(FileCount(), 1u);
}

TEST_F(Files, ALinkStaysAndItsTargetIsReplaced) {
  ASSERT_TRUE(WriteFileAtomically(Path("target"), "old").ok());
  std::filesystem::create_symlink("target", Path("link"));
  ASSERT_TRUE(WriteFileAtomically(Path("link"), "new").ok());
  EXPECT_TRUE(std::filesystem::is_symlink(Path("link")));
  EXPECT_EQ(*ReadFile(Path("target"), 100), "new");
  EXPECT_EQ(FileCount(), 2u);
}

TEST_F(Files, WithoutCommitTheOldFileStays) {
  ASSERT_TRUE(WriteFileAtomically(Path("a"), "old").ok());
  {
    AtomicFile file;
    ASSERT_TRUE(file.Open(Path("a")).ok());
    ASSERT_TRUE(file.Write("half").ok());
  }
  EXPECT_EQ(FileCount(), 1u);
  EXPECT_EQ(*ReadFile(Path("a"), 100), "old");
}

TEST_F(Files, AKilledWriterLeavesNothingBehind) {
  ASSERT_TRUE(WriteFileAtomically(Path("a"), "old").ok());
  const pid_t writer = fork();
  if (writer == 0) {
    AtomicFile file;
    if (file.Open(Path("a")).ok() && file.Write("half").ok()) kill(getpid(), SIGKILL);
    _exit(1);
  }
  int status = 0;
  ASSERT_EQ(waitpid(writer, &status, 0), writer);
  ASSERT_TRUE(WIFSIGNALED(status));
  EXPECT_EQ(*ReadFile(Path("a"), 100), "old");
  if (CanHoldNamelessFiles()) {
    EXPECT_EQ(FileCount(), 1u);
  }
}

TEST_F(Files, WhatTheDiskDoesNotTakeLeavesTheOldFile) {
  ASSERT_TRUE(WriteFileAtomically(Path("a"), "old").ok());
  const auto old_handler = signal(SIGXFSZ, SIG_IGN);
  rlimit limit{};
  ASSERT_EQ(getrlimit(RLIMIT_FSIZE, &limit), 0);
  const rlimit small{1000, limit.rlim_max};
  ASSERT_EQ(setrlimit(RLIMIT_FSIZE, &small), 0);
  const absl::Status status = WriteFileAtomically(Path("a"), std::string(1001, 'x'));
  setrlimit(RLIMIT_FSIZE, &limit);
  signal(SIGXFSZ, old_handler);
  EXPECT_EQ(status.code(), absl::StatusCode::kResourceExhausted);
  EXPECT_THAT(std::string(status.message()), HasSubstr(Path("a") + ": File too large"));
  EXPECT_EQ(*ReadFile(Path("a"), 100), "old");
  EXPECT_EQ(FileCount(), 1u);
}

TEST_F(Files, ALargeFileIsWholeInAnyPieces) {
  // Beyond the size at which the disk is started before the end.
  std::string expected;
  AtomicFile file;
  ASSERT_TRUE(file.Open(Path("a")).ok());
  for (size_t i = 0; expected.size() < (20u << 20); ++i) {
    const std::string bytes(i * 7919 % 700000, static_cast<char>('a' + i % 26));
    ASSERT_TRUE(file.Write(bytes).ok());
    expected += bytes;
  }
  ASSERT_TRUE(file.Commit().ok());
  EXPECT_TRUE(*ReadFile(Path("a"), 30u << 20) == expected);
}

TEST_F(Files, ANewFileHasTheRightsOfTheUsersFiles) {
  const mode_t mask = umask(0027);
  ASSERT_TRUE(WriteFileAtomically(Path("a"), "x").ok());
  umask(mask);
  struct stat info;
  ASSERT_EQ(stat(Path("a").c_str(), &info), 0);
  EXPECT_EQ(info.st_mode & 0777, 0640u);
}

TEST_F(Files, WhatCannotBeReadIsNamed) {
  EXPECT_EQ(ReadFile(Path("none"), 10).status().code(), absl::StatusCode::kNotFound);
  EXPECT_THAT(std::string(ReadFile(folder_.string(), 10).status().message()), HasSubstr("is not a file"));
  ASSERT_TRUE(WriteFileAtomically(Path("big"), std::string(11, 'x')).ok());
  EXPECT_THAT(std::string(ReadFile(Path("big"), 10).status().message()), HasSubstr("11 bytes, at most 10 are read"));
}

}  // namespace
}  // namespace axiscal::base
