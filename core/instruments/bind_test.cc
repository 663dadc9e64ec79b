#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "core/instruments/run.h"
#include "core/machine/testing/machines.h"
#include "core/session/check_machine.h"
#include "core/session/read_session.h"

namespace axiscal::instruments {
namespace {

using ::testing::HasSubstr;

const machine::Machine kMachine = machine::testing::MultiTasking();

session::Session Read(const std::string& header, const std::string& columns, const std::string& row) {
  const auto session = session::ReadSessionText(
      "# machine: mt\n# session: a\n# instrument: rtest\n# sigma_um: 1\n# tool_tip_mm: 0 0 -350\n"
      "# table_ball_mm: 0 0 60\n" +
          header + "X_mm,Y_mm,Z_mm,B_deg,C_deg,dx_mm,dy_mm,dz_mm" + columns + "\n1,2,3,4,5,0.1,0.2,0.3" + row + "\n",
      "a");
  EXPECT_TRUE(session.ok()) << session.status();
  return *session;
}

TEST(BindSession, CarriesWhatIsRecordedBesideCommandsAndTime) {
  const auto session = Read("# payload_kg: 12.5\n# gravity: 0 0 -1\n# setup: ball\n",
                            ",temp_C,T_spindle_C,T_Y-column2_C,X_enc_mm,B_enc_deg", ",21,30,25,1.002,180");
  ASSERT_TRUE(session::CheckAgainstMachine(session, kMachine).ok());
  const auto run = BindSession(session, kMachine);
  ASSERT_TRUE(run.ok()) << run.status();
  EXPECT_FALSE(run->has_time);
  EXPECT_EQ(run->temperature_celsius[0], 21.0);
  ASSERT_EQ(run->temperatures.size(), 2u);
  EXPECT_EQ(run->temperatures[0].name, "spindle");
  EXPECT_EQ(run->temperatures[0].celsius[0], 30.0);
  EXPECT_EQ(run->temperatures[1].name, "Y-column2");
  const int x = machine::FindAxis(kMachine, "X"), b = machine::FindAxis(kMachine, "B"),
            y = machine::FindAxis(kMachine, "Y");
  EXPECT_EQ(run->encoder_positions[x], 1.002);
  EXPECT_NEAR(run->encoder_positions[b], std::numbers::pi, 1e-12);
  EXPECT_TRUE(std::isnan(run->encoder_positions[y]));
  EXPECT_EQ(run->PositionsOf(0)[x], 1.0);
  EXPECT_EQ(run->payload_kg, 12.5);
  EXPECT_EQ(*run->gravity_direction, Eigen::Vector3d(0, 0, -1));
  EXPECT_TRUE(run->is_setup_stated);
  EXPECT_EQ(run->setup_name, "ball");
  const auto bare = BindSession(Read("", "", ""), kMachine);
  ASSERT_TRUE(bare.ok()) << bare.status();
  EXPECT_TRUE(bare->temperatures.empty() && bare->encoder_positions.empty());
  EXPECT_FALSE(bare->payload_kg || bare->gravity_direction || bare->is_setup_stated);
}

TEST(BindSession, ASenseIsThatOfItsAxis) {
  const auto session = Read("", ",X_sense,B_sense", ",-1,0");
  ASSERT_TRUE(session::CheckAgainstMachine(session, kMachine).ok());
  const auto run = BindSession(session, kMachine);
  ASSERT_TRUE(run.ok()) << run.status();
  EXPECT_EQ(run->AxisStatesOf(0)[machine::FindAxis(kMachine, "X")].sense, -1.0);
  EXPECT_EQ(run->AxisStatesOf(0)[machine::FindAxis(kMachine, "B")].sense, 0.0);
  EXPECT_THAT(std::string(session::CheckAgainstMachine(Read("", ",A_sense", ",1"), kMachine).message()),
              HasSubstr("column 9 (A_sense): machine mt has no axis A"));
}

TEST(BindSession, AnEncoderIsOfAnAxisOfTheMachine) {
  EXPECT_THAT(std::string(session::CheckAgainstMachine(Read("", ",A_enc_deg", ",1"), kMachine).message()),
              HasSubstr("column 9 (A_enc_deg): machine mt has no axis A"));
  EXPECT_THAT(std::string(session::CheckAgainstMachine(Read("", ",X_enc_deg", ",1"), kMachine).message()),
              HasSubstr("column 9 (X_enc_deg): X is linear, expected X_enc_mm"));
}

}  // namespace
}  // namespace axiscal::instruments
