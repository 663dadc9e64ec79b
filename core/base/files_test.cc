#include "core/base/files.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <sys/stat.h>

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
    EXPECT_EQ(FileCount(), 2u);
  }
  EXPECT_EQ(FileCount(), 1u);
  EXPECT_EQ(*ReadFile(Path("a"), 100), "old");
}

TEST_F(Files, WhatCannotBeReadIsNamed) {
  EXPECT_EQ(ReadFile(Path("none"), 10).status().code(), absl::StatusCode::kNotFound);
  EXPECT_THAT(std::string(ReadFile(folder_.string(), 10).status().message()), HasSubstr("is not a file"));
  ASSERT_TRUE(WriteFileAtomically(Path("big"), std::string(11, 'x')).ok());
  EXPECT_THAT(std::string(ReadFile(Path("big"), 10).status().message()), HasSubstr("11 bytes, at most 10 are read"));
}

}  // namespace
}  // namespace axiscal::base
