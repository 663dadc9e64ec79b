#include "core/session/case.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>

#include "core/base/testing/source_path.h"
#include "core/session/read_session.h"
#include "core/session/testing/example.h"
#include "core/session/write_session.h"

namespace axiscal::session {
namespace {

using ::testing::AllOf;
using ::testing::HasSubstr;
namespace fs = std::filesystem;

const fs::path kSource(base::SourcePath(""));

std::vector<fs::path> Folders(const fs::path& parent) {
  std::vector<fs::path> folders;
  for (const auto& entry : fs::directory_iterator(parent)) {
    if (entry.is_directory()) folders.push_back(entry.path());
  }
  return folders;
}

TEST(ReadCase, EveryLoopCaseLoadsInNameOrder) {
  const auto folders = Folders(kSource / "tests/data/loop");
  EXPECT_EQ(folders.size(), 15u);
  for (const fs::path& folder : folders) {
    const auto read = ReadCase(folder.string());
    ASSERT_TRUE(read.ok()) << read.status();
    EXPECT_GE(read->fit.size(), 5u);
    EXPECT_GE(read->check.size(), 4u);
    EXPECT_EQ(fs::path(read->fit_files[0]).filename().string().substr(0, 3), "00-");
    EXPECT_EQ(fs::path(read->fit_files[1]).filename().string().substr(0, 3), "01-");
  }
}

TEST(ReadCase, WrittenSessionsReadBackEqual) {
  const auto read = ReadCase((kSource / "tests/data/loop/case-002").string());
  ASSERT_TRUE(read.ok()) << read.status();
  for (const Session& session : read->fit) {
    EXPECT_EQ(*ReadSessionText(*WriteSession(session), "again"), session);
  }
}

TEST(ReadCase, MeasuredArmsLoad) {
  const fs::path robots = kSource / "../shared/data/robots";
  if (!fs::exists(robots)) GTEST_SKIP() << "../shared is absent";
  EXPECT_EQ(ReadCase((robots / "ur5").string())->fit[0].reading_count(), 1000u);
  EXPECT_EQ(ReadCase((robots / "wam").string())->fit[0].reading_count(), 216u);
}

class CaseFolder : public ::testing::Test {
 protected:
  CaseFolder() {
    std::string name = (fs::temp_directory_path() / "axiscal-case-XXXXXX").string();
    EXPECT_NE(mkdtemp(name.data()), nullptr);
    folder_ = name;
    fs::create_directory(folder_ / "fit");
  }
  ~CaseFolder() override { fs::remove_all(folder_); }

  void Write(const std::string& name, const std::string& text) { std::ofstream(folder_ / name) << text; }
  void CopyMachine() { fs::copy(kSource / "tests/data/loop/case-000/machine.json", folder_); }

  fs::path folder_;
};

TEST_F(CaseFolder, TheTruthIsNeverReadAndOtherFilesAreLeftAlone) {
  CopyMachine();
  Write("truth.json", "{ broken");
  Write("fit/a.csv", testing::kBallbar);
  Write("fit/notes.txt", "not a session");
  const auto read = ReadCase(folder_.string());
  ASSERT_TRUE(read.ok()) << read.status();
  EXPECT_EQ(read->fit.size(), 1u);
  EXPECT_TRUE(read->check.empty());
}

TEST_F(CaseFolder, ErrorsNameTheFile) {
  EXPECT_EQ(ReadCase(folder_.string()).status().code(), absl::StatusCode::kNotFound);
  Write("machine.json", R"({"id": 3})");
  EXPECT_THAT(std::string(ReadCase(folder_.string()).status().message()),
              AllOf(HasSubstr("machine.json: 5 fields are missing or wrong:"), HasSubstr("\n  id: 3, expected a text"),
                    HasSubstr("\n  axes: is missing")));
  fs::remove(folder_ / "machine.json");
  CopyMachine();
  EXPECT_THAT(std::string(ReadCase(folder_.string()).status().message()), HasSubstr("fit: no session files"));
  Write("fit/a.csv", testing::Replaced(testing::kBallbar, "machine: mt", "machine: mx"));
  EXPECT_THAT(std::string(ReadCase(folder_.string()).status().message()),
              HasSubstr("fit/a.csv: line 1: machine: 'mx', expected 'mt'"));
}

}  // namespace
}  // namespace axiscal::session
