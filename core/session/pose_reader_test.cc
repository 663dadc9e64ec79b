#include "core/session/pose_reader.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <filesystem>

#include "core/base/files.h"
#include "core/machine/testing/machines.h"

namespace axiscal::session {
namespace {

using ::testing::HasSubstr;

class PoseFile : public ::testing::Test {
 protected:
  PoseFile() {
    std::string name = (std::filesystem::temp_directory_path() / "axiscal-pose-XXXXXX").string();
    EXPECT_NE(mkdtemp(name.data()), nullptr);
    folder_ = name;
  }
  ~PoseFile() override { std::filesystem::remove_all(folder_); }

  std::string Write(const std::string& text) const {
    const std::string path = folder_ / "poses.csv";
    EXPECT_TRUE(base::WriteFileAtomically(path, text).ok());
    return path;
  }

  std::filesystem::path folder_;
};

TEST_F(PoseFile, GivesBlocksInTheMachinesOrderAndUnits) {
  const machine::Machine machine = machine::testing::MultiTasking();
  std::string text = "X_mm,Y_mm,Z_mm,B_deg,C_deg,X_enc_mm,T_spindle_C\n";
  for (int k = 0; k < 5000; ++k) absl::StrAppend(&text, k, ",2,3,180,-90,1.5,21\n");
  const auto reader = PoseReader::Open(Write(text), machine);
  ASSERT_TRUE(reader.ok()) << reader.status();
  EXPECT_FALSE((*reader)->has_time());
  EXPECT_FALSE((*reader)->has_temperature());
  PoseBlock block;
  size_t rows = 0;
  do {
    ASSERT_TRUE((*reader)->Next(&block).ok());
    for (size_t k = 0; k < block.count; ++k, ++rows) {
      const double* const at = &block.positions[5 * k];  // Z Y X B C
      ASSERT_EQ(at[0], 3.0);
      ASSERT_EQ(at[2], static_cast<double>(rows));
      ASSERT_NEAR(at[3], 3.14159265358979, 1e-12);
      ASSERT_NEAR(at[4], -1.570796326794897, 1e-12);
    }
  } while (block.count > 0);
  EXPECT_EQ(rows, 5000u);
  EXPECT_EQ((*reader)->fraction(), 1.0);
}

TEST_F(PoseFile, BeyondTheTravelIsRefused) {
  machine::Machine machine = machine::testing::MultiTasking();
  machine.axes[2].min_position = -600.0;
  machine.axes[2].max_position = 50.0;
  const auto reader = PoseReader::Open(Write("X_mm,Y_mm,Z_mm,B_deg,C_deg\n50.001,0,0,0,0\n51,0,0,0,0\n"), machine);
  ASSERT_TRUE(reader.ok()) << reader.status();
  PoseBlock block;
  EXPECT_THAT(std::string((*reader)->Next(&block).message()),
              HasSubstr("poses.csv: line 3, column 1 (X_mm): '51', expected mm from -600 to 50, the travel of X"));
  EXPECT_TRUE(absl::IsNotFound(PoseReader::Open(folder_ / "none.csv", machine).status()));
}

}  // namespace
}  // namespace axiscal::session
