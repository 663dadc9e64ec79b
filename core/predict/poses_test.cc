#include "core/predict/poses.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <filesystem>
#include <fstream>
#include <sstream>

#include "core/base/units.h"
#include "core/instruments/run.h"
#include "core/machine/testing/machines.h"
#include "core/session/read_session.h"

namespace axiscal::predict {
namespace {

using machine::Machine;
using ::testing::HasSubstr;

const Eigen::Vector3d kTip(0, 0, -350);
constexpr char kErrors[] =
    R"({"EX0C": 53.1, "EA0B": -101.2, "terms": [{"symbol": "EXX", "shape": "backlash", "amplitude": -6},)"
    R"({"symbol": "EYX", "shape": "reversal", "length_mm": 4, "amplitude": 5},)"
    R"({"symbol": "EZY", "shape": "lag", "amplitude": 2},)"
    R"({"symbol": "EZT", "shape": "drift", "amplitude": 9}, {"symbol": "EXT", "shape": "thermal", "amplitude": 1.5}]})";

class Poses : public ::testing::Test {
 protected:
  Poses() {
    std::string name = (std::filesystem::temp_directory_path() / "axiscal-poses-XXXXXX").string();
    EXPECT_NE(mkdtemp(name.data()), nullptr);
    folder_ = name;
  }
  ~Poses() override { std::filesystem::remove_all(folder_); }

  absl::StatusOr<PredictedPoses> Predict(const std::string& poses, const std::string& errors = kErrors) const {
    std::ofstream(folder_ / "poses.csv", std::ios::binary) << poses;
    const auto known = machine::ReadKnownErrors(errors, machine_);
    EXPECT_TRUE(known.ok()) << known.status();
    return PredictPoses(folder_ / "poses.csv", folder_ / "out.csv", machine_, *known, kTip);
  }
  std::vector<std::string> Lines() const {
    std::vector<std::string> lines;
    std::ifstream in(folder_ / "out.csv");
    for (std::string line; std::getline(in, line);) lines.push_back(line);
    return lines;
  }
  static std::vector<double> Numbers(const std::string& line) {
    std::vector<double> numbers;
    std::stringstream text(line);
    for (std::string cell; std::getline(text, cell, ',');) numbers.push_back(cell.empty() ? NAN : std::stod(cell));
    return numbers;
  }

  const Machine machine_ = machine::testing::MultiTasking();
  std::filesystem::path folder_;
};

// To and fro with rests, over more rows than one block holds; Y begins to move after thousands of rows.
std::string Rows(int count, bool is_session) {
  std::string text;
  for (int k = 0; k < count; ++k) {
    const double x = -300.0 + 40.0 * std::sin(0.05 * k) + (k % 7 == 0 ? 0.0 : 0.1), y = k < 6000 ? 5.0 : 5.0 - 0.01 * k;
    absl::StrAppendFormat(&text, "%.3f,%.4f,%.4f,%.4f,%.4f,%.4f,%.3f%s\n", 0.25 * k, x, y, 400.0, 0.5 * (k % 90),
                          -0.1 * k, 20.0 + 1e-3 * k, is_session ? ",0" : "");
  }
  return text;
}

// A body that follows its channel late, over more rows than one block holds.
TEST_F(Poses, ALateWarmthRemembersTheRowsBefore) {
  const std::string errors =
      R"({"terms": [{"symbol": "EZT", "shape": "thermal-lag", "channel": "T_spindle_C", "tau_s": 1000,)"
      R"( "amplitude": 2}]})";
  constexpr int kRows = 5000;
  std::string text = "t_s,X_mm,Y_mm,Z_mm,B_deg,C_deg,T_spindle_C\n";
  for (int k = 0; k < kRows; ++k) absl::StrAppendFormat(&text, "%d,0,0,0,0,0,%.6f\n", k, 20.0 + 0.001 * k);
  ASSERT_TRUE(Predict(text, errors).ok());
  const std::vector<std::string> lines = Lines();
  ASSERT_EQ(lines.size(), kRows + 1u);
  for (const int k : {0, 100, 4999}) {
    const double late = 0.001 * (k - 1000.0 * -std::expm1(-k / 1000.0));
    EXPECT_NEAR(Numbers(lines[static_cast<size_t>(k) + 1])[2], 2.0 * late, 1e-5) << k;
  }
  EXPECT_THAT(
      std::string(Predict("t_s,X_mm,Y_mm,Z_mm,B_deg,C_deg,temp_C\n0,0,0,0,0,0,20\n", errors).status().message()),
      HasSubstr("column T_spindle_C is missing"));
  EXPECT_THAT(std::string(Predict("X_mm,Y_mm,Z_mm,B_deg,C_deg,T_spindle_C\n0,0,0,0,0,20\n", errors).status().message()),
              HasSubstr("column t_s is missing"));
}

TEST_F(Poses, EveryRowHasTheStateThatAReadingOfASessionHas) {
  constexpr int kRows = 9000;
  const auto made = Predict("t_s,X_mm,Y_mm,Z_mm,B_deg,C_deg,temp_C\n" + Rows(kRows, false));
  ASSERT_TRUE(made.ok()) << made.status();
  EXPECT_EQ(made->rows, kRows);
  EXPECT_FALSE(made->has_sigma);
  const auto session = session::ReadSessionText(
      "# machine: mt\n# session: a\n# instrument: ballbar\n# sigma_um: 1\n# tool_tip_mm: 0 0 -350\n"
      "# table_ball_mm: 0 0 65\n# bar_length_mm: 100\nt_s,X_mm,Y_mm,Z_mm,B_deg,C_deg,temp_C,dL_mm\n" +
          Rows(kRows, true),
      "a");
  ASSERT_TRUE(session.ok()) << session.status();
  const auto run = instruments::BindSession(*session, machine_);
  ASSERT_TRUE(run.ok()) << run.status();
  const auto known = machine::ReadKnownErrors(kErrors, machine_);
  ToolPoint tool(machine_, *known, kTip);
  const std::vector<std::string> lines = Lines();
  ASSERT_EQ(lines.size(), kRows + 1u);
  EXPECT_EQ(lines[0],
            "ex_um,ey_um,ez_um,ea_urad,eb_urad,ec_urad,ex_sigma_um,ey_sigma_um,ez_sigma_um,ea_sigma_urad,eb_sigma_urad,"
            "ec_sigma_urad");
  double squares = 0.0;
  for (int k = 0; k < kRows; ++k) {
    const ToolPointError error = tool.ErrorAt(run->StateOf(k));
    const std::vector<double> row = Numbers(lines[k + 1]);
    ASSERT_THAT(lines[k + 1], ::testing::EndsWith(",,,,,,"));
    for (int i = 0; i < 6; ++i) ASSERT_NEAR(row[i], error[i] * (i < 3 ? 1e3 : 1e6), 1e-6) << k << " " << i;
    squares += error.head<3>().squaredNorm();
  }
  EXPECT_NEAR(made->rms_mm, std::sqrt(squares / kRows), 1e-12);
}

TEST_F(Poses, ColumnsStandInAnyOrderAndStatesThatNoErrorNeedsMayBeMissing) {
  const std::string errors = R"({"EX0C": 53.1, "covariance": {"of": ["EX0C"], "sigma": [2], "correlation": [[]]}})";
  const auto made = Predict("# machine: mt\n# note: any\nC_deg,B_deg,Z_mm,Y_mm,X_mm\n0,0,1,2,3\n90,0,1,2,3\n", errors);
  ASSERT_TRUE(made.ok()) << made.status();
  EXPECT_TRUE(made->has_sigma);
  EXPECT_THAT(Lines(), ::testing::ElementsAre(HasSubstr("ex_um"),
                                              "-53.100000,0.000000,0.000000,0.000000,0.000000,0.000000,"
                                              "2.000000,0.000000,0.000000,0.000000,0.000000,0.000000",
                                              "0.000000,53.100000,0.000000,0.000000,0.000000,0.000000,"
                                              "0.000000,2.000000,0.000000,0.000000,0.000000,0.000000"));
}

TEST_F(Poses, ARowAtWhichAnErrorIsWithoutBoundIsRefused) {
  const auto made = Predict("t_s,X_mm,Y_mm,Z_mm,B_deg,C_deg\n-1e9,0,0,0,0,0\n0,0,0,0,0,0\n",
                            R"({"terms": [{"symbol": "EZT", "shape": "drift-exp", "tau_s": 600, "amplitude": 9}]})");
  EXPECT_THAT(std::string(made.status().message()), HasSubstr("poses.csv: pose 1 (t_s = -1e+09)"));
  EXPECT_FALSE(std::filesystem::exists(folder_ / "out.csv"));
}

TEST_F(Poses, BadInputIsRefusedWithItsPlaceAndWritesNothing) {
  const std::string names = "t_s,X_mm,Y_mm,Z_mm,B_deg,C_deg,temp_C\n", row = "0,1,2,3,4,5,20\n";
  const auto refusal = [&](const std::string& text, const std::string& errors = kErrors) {
    return std::string(Predict(text, errors).status().message());
  };
  EXPECT_THAT(refusal(names + row + "1,1,2,x,4,5,20\n"),
              HasSubstr("poses.csv: line 3, column 4 (Z_mm): 'x' is no number"));
  EXPECT_THAT(refusal(names + row + "1,1,2,nan,4,5,20\n"),
              HasSubstr("line 3, column 4 (Z_mm): 'nan', expected mm from"));
  EXPECT_THAT(refusal(names + row + "-1,1,2,3,4,5,20\n"),
              HasSubstr("line 3, column 1 (t_s): '-1', expected at least 0"));
  EXPECT_THAT(refusal(names + row + "1,1,2,3,4,5\n"), HasSubstr("line 3, column 7 (temp_C): the line has 6 cells"));
  EXPECT_THAT(refusal(names + "0,1,2,3,4,5,20"), HasSubstr("has no line end"));
  EXPECT_THAT(refusal(names), HasSubstr("no poses follow the column names"));
  EXPECT_THAT(refusal(""), HasSubstr("the file is empty"));
  EXPECT_THAT(refusal("# machine: tt\n" + names + row), HasSubstr("line 1: machine: 'tt', expected 'mt'"));
  EXPECT_THAT(refusal("t_s,X_mm,Y_mm,Z_mm,B_deg,temp_C\n0,1,2,3,4,20\n"),
              HasSubstr("line 1: axis C of machine mt has no column, expected C_deg"));
  EXPECT_THAT(refusal("t_s,X_mm,Y_mm,Z_mm,B_mm,C_deg,temp_C\n" + row),
              HasSubstr("column 5 (B_mm): B is rotary, expected deg"));
  EXPECT_THAT(refusal("t_s,X_mm,X_mm,Z_mm,B_deg,C_deg,temp_C\n" + row),
              HasSubstr("column 3 (X_mm): the same name as column 2"));
  EXPECT_THAT(refusal("t_s,X_mm,Y_mm,Z_mm,B_deg,C_deg,temp_C,dL_mm\n0,1,2,3,4,5,20,0\n"),
              HasSubstr("column 8 (dL_mm): unknown column for poses"));
  EXPECT_THAT(refusal("X_mm,Y_mm,Z_mm,B_deg,C_deg,temp_C\n1,2,3,4,5,20\n"),
              HasSubstr("column t_s is missing: the error EZY:lag depends on the time"));
  EXPECT_FALSE(std::filesystem::exists(folder_ / "out.csv"));
}

}  // namespace
}  // namespace axiscal::predict
