#include "core/session/check_machine.h"

#include <gtest/gtest.h>

#include "core/base/units.h"
#include "core/machine/testing/machines.h"
#include "core/session/read_session.h"
#include "core/session/testing/example.h"

namespace axiscal::session {
namespace {

using testing::kBallbar;
using testing::Replaced;

std::string Problem(const std::string& text, const machine::Machine& machine) {
  const auto session = ReadSessionText(text, "a");
  EXPECT_TRUE(session.ok()) << session.status();
  const absl::Status status = CheckAgainstMachine(*session, machine);
  EXPECT_EQ(status.code(), absl::StatusCode::kInvalidArgument);
  return std::string(status.message());
}

TEST(CheckAgainstMachine, ASessionOfTheMachinePasses) {
  EXPECT_TRUE(CheckAgainstMachine(*ReadSessionText(kBallbar, "a"), machine::testing::MultiTasking()).ok());
}

TEST(CheckAgainstMachine, AnotherMachineIsRefused) {
  EXPECT_EQ(Problem(kBallbar, machine::testing::TiltingTable()), "line 1: machine: 'mt', expected 'tt'");
}

TEST(CheckAgainstMachine, AxesAndUnitsAreTheMachines) {
  const auto machine = machine::testing::MultiTasking();
  EXPECT_EQ(Problem(Replaced(kBallbar, "B_deg", "B_mm"), machine),
            "line 9, column 5 (B_mm): B is rotary, expected B_deg");
  EXPECT_EQ(Problem(Replaced(kBallbar, "Y_mm", "Y_deg"), machine),
            "line 9, column 3 (Y_deg): Y is linear, expected Y_mm");
  EXPECT_EQ(Problem(Replaced(kBallbar, "B_deg", "A_deg"), machine),
            "line 9, column 5 (A_deg): machine mt has no axis A");
  std::string text = Replaced(kBallbar, "C_deg,temp_C", "temp_C");
  for (const char* cells : {"0.0000,20.000,0.0179", "0.0000,20.000,0.0182", "0.0000,20.000,-0.0181"}) {
    text = Replaced(text, cells, std::string(cells).substr(7));
  }
  EXPECT_EQ(Problem(text, machine), "line 9: axis C of machine mt has no column, instrument ballbar needs C_deg");
}

TEST(CheckAgainstMachine, TheDatumIsOfLinearAxes) {
  const auto machine = machine::testing::MultiTasking();
  const auto with = [](const std::string& axes) {
    return Replaced(kBallbar, "# sigma_um: 0.3\n", "# sigma_um: 0.3\n# datum: free " + axes + "\n");
  };
  EXPECT_TRUE(CheckAgainstMachine(*ReadSessionText(with("X Z"), "a"), machine).ok());
  EXPECT_EQ(Problem(with("X C"), machine), "line 5: datum: 'free X C': C is a rotary axis, expected linear axes");
  EXPECT_EQ(Problem(with("W"), machine), "line 5: datum: 'free W': W is no axis of machine mt, expected linear axes");
}

TEST(CheckAgainstMachine, PositionsBeyondTheTravelAreRefused) {
  auto machine = machine::testing::MultiTasking();
  machine.axes[2].min_position = -10;
  machine.axes[2].max_position = 103.1101;  // the second reading stands on it
  EXPECT_EQ(Problem(kBallbar, machine),
            "line 12, column 2 (X_mm): 106.22 is beyond the travel of X, expected -10 to 103.11");
  machine = machine::testing::MultiTasking();
  machine.axes[3].min_position = 0;
  machine.axes[3].max_position = 0.75 * base::kRadPerDeg;
  EXPECT_EQ(Problem(kBallbar, machine), "line 12, column 5 (B_deg): 1 is beyond the travel of B, expected 0 to 0.75");
}

constexpr char kCentres[] =
    "# machine: mt\n# session: B\n# instrument: centres\n# sigma_um: 0.5\n# tool_tip_mm: 0 0 -382.95\n"
    "# table_ball_mm: -490 0 "
    "-472\nt_s,B_deg,C_deg,cx_mm,cy_mm,cz_mm\n0,0,0,-490,0,-471.9958\n1,90,0,-493.2167,0.0343,-468.8545\n";

TEST(CheckAgainstMachine, CentresHaveTheRotaryAxesOnly) {
  const auto machine = machine::testing::MultiTasking();
  EXPECT_TRUE(CheckAgainstMachine(*ReadSessionText(kCentres, "a"), machine).ok());
  const std::string one_missing =
      Replaced(Replaced(Replaced(kCentres, ",C_deg", ""), "0,0,0,-490", "0,0,-490"), "1,90,0,", "1,90,");
  EXPECT_EQ(Problem(one_missing, machine),
            "line 7: axis C of machine mt has no column, instrument centres needs C_deg");
  EXPECT_EQ(
      std::string(ReadSessionText(Replaced(kCentres, "C_deg", "X_mm"), "a").status().message()),
      "a: line 7, column 3 (X_mm): unknown column for instrument centres, expected t_s, rotary axis columns such as "
      "B_deg, encoder columns such as X_enc_mm or B_enc_deg, senses such as X_sense, temp_C, T_NAME_C, cx_mm, cy_mm, "
      "cz_mm");
}

}  // namespace
}  // namespace axiscal::session
