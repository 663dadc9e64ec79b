#include "core/session/read_session.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <filesystem>
#include <fstream>

#include "core/session/line_reader.h"
#include "core/session/testing/example.h"

namespace axiscal::session {
namespace {

using ::testing::HasSubstr;
using testing::kBallbar;
using testing::kEccentricity;
using testing::kTouch;
using testing::Replaced;

TEST(ReadSession, HeaderAndColumnsStandAsInTheFile) {
  const auto session = ReadSessionText(kBallbar, "a");
  ASSERT_TRUE(session.ok()) << session.status();
  EXPECT_EQ(session->header.size(), 8u);
  EXPECT_EQ(FindHeader(*session, "operator"), "night shift");
  EXPECT_EQ(session->columns.size(), 8u);
  EXPECT_EQ(session->reading_count(), 3u);
  EXPECT_EQ(FindColumn(*session, "X_mm")->values, (std::vector<double>{100, 103.1101, 106.22}));
  EXPECT_EQ(FindColumn(*session, "dL_mm")->values[2], -0.0181);
}

TEST(ReadSession, CrlfMarkAndPlusSignAreTheSameFile) {
  std::string text = kBallbar;
  for (size_t at = 0; (at = text.find('\n', at)) != std::string::npos; at += 2) text.replace(at, 1, "\r\n");
  text = "\xEF\xBB\xBF" + Replaced(text, "103.1101", "+103.1101");
  const auto session = ReadSessionText(text, "a");
  ASSERT_TRUE(session.ok()) << session.status();
  EXPECT_EQ(*session, *ReadSessionText(kBallbar, "a"));
}

TEST(ReadSession, NamesAndEmptyCellsWhereTheInstrumentHasThem) {
  const auto touch = ReadSessionText(kTouch, "a");
  ASSERT_TRUE(touch.ok()) << touch.status();
  EXPECT_EQ(FindColumn(*touch, "feature")->texts, (std::vector<std::string>{"top", "ball"}));
  const auto runs = ReadSessionText(kEccentricity, "a");
  ASSERT_TRUE(runs.ok()) << runs.status();
  EXPECT_TRUE(std::isnan(FindColumn(*runs, "ey_um")->values[0]));
  EXPECT_EQ(FindColumn(*runs, "ez_um")->values[1], -42);
}

TEST(ReadSession, LinesAcrossBlocksOfTheReaderAreWhole) {
  std::string text = kBallbar;
  const size_t rows = 60000;  // 3.5 MB: several blocks
  for (size_t i = 0; i < rows; ++i) text += absl::StrFormat("%d.5,1,2,3,4,5,20,0.%05d\n", i + 1, i);
  const auto session = ReadSessionText(text, "a");
  ASSERT_TRUE(session.ok()) << session.status();
  ASSERT_EQ(session->reading_count(), rows + 3);
  for (size_t i = 0; i < rows; ++i) {
    ASSERT_EQ(FindColumn(*session, "dL_mm")->values[i + 3], static_cast<double>(i) / 1e5);
  }
}

class ReadSessionFiles : public ::testing::Test {
 protected:
  ReadSessionFiles() {
    std::string name = (std::filesystem::temp_directory_path() / "axiscal-session-XXXXXX").string();
    EXPECT_NE(mkdtemp(name.data()), nullptr);
    folder_ = name;
  }
  ~ReadSessionFiles() override { std::filesystem::remove_all(folder_); }
  std::filesystem::path folder_;
};

TEST_F(ReadSessionFiles, TheFileIsNamedInFrontOfEveryMessage) {
  const std::string path = (folder_ / "a.csv").string();
  EXPECT_EQ(ReadSessionFile(path).status().code(), absl::StatusCode::kNotFound);
  std::ofstream(path) << kBallbar;
  EXPECT_TRUE(ReadSessionFile(path).ok());
  std::ofstream(path) << Replaced(kBallbar, "0.0182", "x");
  EXPECT_EQ(std::string(ReadSessionFile(path).status().message()),
            path +
                ": line 11, column 8 (dL_mm): 'x' is no number, expected mm within +-10 (are these um?) with a decimal "
                "point and no blanks");
  EXPECT_THAT(std::string(ReadSessionFile(folder_.string()).status().message()), HasSubstr("is not a file"));
}

TEST_F(ReadSessionFiles, AFileBeyondTheLimitIsRefusedBeforeItIsRead) {
  const std::string path = (folder_ / "big.csv").string();
  std::ofstream(path) << kBallbar;
  std::filesystem::resize_file(path, size_t{1} << 30);  // sparse: costs no disk
  const absl::Status status = ReadSessionFile(path).status();
  EXPECT_EQ(status.code(), absl::StatusCode::kInvalidArgument);
  EXPECT_THAT(std::string(status.message()),
              HasSubstr("1073741824 bytes, a session file has at most 268435456 (256 MB)"));
}

// The plan of a session: readings empty or missing, and left out where they are there.
TEST(ReadPlan, ReadingsMayBeEmptyOrMissing) {
  const std::string rods =
      "# machine: mt\n# session: s\n# instrument: tool-setter\n# sigma_um: 1\n# tool_tip_mm: 0 0 0\n# beam: 0.2 0 0\n"
      "# rod one: 5 0.03 90 0 133.7 0\n";
  for (const char* const rows : {"rod,readout,Z_mm\none,1,\none,2,\n", "rod,readout\none,1\none,2\n",
                                 "rod,readout,Z_mm\none,1,-376.5\none,2,-376.6\n"}) {
    const auto plan = ReadPlanText(rods + rows, "plan.csv");
    ASSERT_TRUE(plan.ok()) << plan.status();
    ASSERT_EQ(plan->columns.size(), 2u);
    EXPECT_EQ(plan->columns[1].values, std::vector<double>({1, 2}));
  }
  EXPECT_FALSE(ReadSessionText(rods + "rod,readout,Z_mm\none,1,\n", "s.csv").ok());
  EXPECT_FALSE(ReadSessionText(rods + "rod,readout\none,1\n", "s.csv").ok());
  EXPECT_EQ(ReadPlanText(rods + "readout,Z_mm\n1,\n", "plan.csv").status().message(),
            "plan.csv: line 8: column rod is missing, instrument tool-setter needs it");
  EXPECT_EQ(ReadPlanText(rods + "rod,readout,Z_mm\none,,\n", "plan.csv").status().message(),
            "plan.csv: line 9, column 2 (readout): is empty, expected the number of the readout within +-1e+06");
}

}  // namespace
}  // namespace axiscal::session
