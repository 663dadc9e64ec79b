// From file to file: what stands at the output's place when the work ends, however it ends.
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <signal.h>
#include <sys/resource.h>
#include <sys/wait.h>
#include <unistd.h>

#include <filesystem>

#include "core/base/files.h"
#include "core/nc/testing/rewritten.h"

namespace axiscal::nc {
namespace {

using ::testing::HasSubstr;
using testing::kAtZero;
using testing::LeaningHead;

constexpr size_t kMaxBytes = 64u << 20;

class RewriteFileTest : public ::testing::Test {
 protected:
  RewriteFileTest() {
    std::string name = (std::filesystem::temp_directory_path() / "axiscal-rewrite-XXXXXX").string();
    EXPECT_NE(mkdtemp(name.data()), nullptr);
    folder_ = name;
    for (int i = 0; i < 30000; ++i) absl::StrAppendFormat(&program_, "G01 X%d.5 Y0.0000 B%d. F2000\n", i % 100, i % 90);
    EXPECT_TRUE(base::WriteFileAtomically(Path("in.nc"), program_).ok());
    EXPECT_TRUE(base::WriteFileAtomically(Path("out.nc"), "old").ok());
  }
  ~RewriteFileTest() override { std::filesystem::remove_all(folder_); }

  std::string Path(const std::string& name) const { return (folder_ / name).string(); }
  std::string Bytes(const std::string& name) const { return base::ReadFile(Path(name), kMaxBytes).value_or("none"); }
  absl::Status Rewrite(const std::string& output, RewriteReport* report) const {
    return RewriteFile(Path("in.nc"), Path(output), LeaningHead(), kAtZero, report);
  }
  void ExpectTheOldFileAlone() const {
    EXPECT_EQ(Bytes("out.nc"), "old");
    EXPECT_EQ(std::distance(std::filesystem::directory_iterator(folder_), std::filesystem::directory_iterator()), 2);
  }

  std::filesystem::path folder_;
  std::string program_;
};

TEST_F(RewriteFileTest, GivesTheBytesOfTheTextForm) {
  RewriteReport report, of_text;
  const auto expected = RewriteText(program_, LeaningHead(), kAtZero, &of_text);
  ASSERT_TRUE(expected.ok());
  ASSERT_TRUE(Rewrite("out.nc", &report).ok());
  EXPECT_TRUE(Bytes("out.nc") == *expected);
  EXPECT_EQ(reports::ToJson(ReportOf(report)), reports::ToJson(ReportOf(of_text)));
  EXPECT_TRUE(Bytes("in.nc") == program_);
  // In its own place too: the source is read to its end before it is replaced.
  ASSERT_TRUE(Rewrite("in.nc", &report).ok());
  EXPECT_TRUE(Bytes("in.nc") == *expected);
}

TEST_F(RewriteFileTest, ARefusedProgramLeavesTheOldFile) {
  // At its very end: most of the output is written by then.
  ASSERT_TRUE(base::WriteFileAtomically(Path("in.nc"), program_ + "G31 X1.\n").ok());
  RewriteReport report;
  EXPECT_EQ(Rewrite("out.nc", &report).code(), absl::StatusCode::kFailedPrecondition);
  EXPECT_EQ(report.blocks_refused, 1);
  ExpectTheOldFileAlone();
}

TEST_F(RewriteFileTest, AFullDiskLeavesTheOldFile) {
  // The limit of a file's size fails the write in the middle, as a full disk does.
  const auto old_handler = signal(SIGXFSZ, SIG_IGN);
  rlimit limit{};
  ASSERT_EQ(getrlimit(RLIMIT_FSIZE, &limit), 0);
  const rlimit small{program_.size() / 2, limit.rlim_max};
  ASSERT_EQ(setrlimit(RLIMIT_FSIZE, &small), 0);
  RewriteReport report;
  const absl::Status status = Rewrite("out.nc", &report);
  setrlimit(RLIMIT_FSIZE, &limit);
  signal(SIGXFSZ, old_handler);
  EXPECT_EQ(status.code(), absl::StatusCode::kResourceExhausted);
  EXPECT_THAT(std::string(status.message()), HasSubstr("out.nc: File too large"));
  ExpectTheOldFileAlone();
}

TEST_F(RewriteFileTest, AProcessKilledMidwayLeavesTheOldFile) {
  const pid_t process = fork();
  if (process == 0) {
    // The signal of the limit ends the process in the middle of its output.
    rlimit limit{};
    getrlimit(RLIMIT_FSIZE, &limit);
    const rlimit small{program_.size() / 2, limit.rlim_max};
    const rlimit no_core{0, 0};
    setrlimit(RLIMIT_CORE, &no_core);
    setrlimit(RLIMIT_FSIZE, &small);
    signal(SIGXFSZ, SIG_DFL);
    RewriteReport report;
    _exit(Rewrite("out.nc", &report).ok() ? 0 : 1);
  }
  int status = 0;
  ASSERT_EQ(waitpid(process, &status, 0), process);
  ASSERT_TRUE(WIFSIGNALED(status));
  EXPECT_EQ(Bytes("out.nc"), "old");
}

TEST_F(RewriteFileTest, DevicesAreNoOutput) {
  RewriteReport report;
  const absl::Status status = RewriteFile(Path("in.nc"), "/dev/full", LeaningHead(), kAtZero, &report);
  EXPECT_EQ(status.code(), absl::StatusCode::kInvalidArgument);
  EXPECT_THAT(std::string(status.message()), HasSubstr("/dev/full: is not a file"));
}

}  // namespace
}  // namespace axiscal::nc
