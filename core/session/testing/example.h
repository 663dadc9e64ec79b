// Small session files for tests.
#ifndef AXISCAL_CORE_SESSION_TESTING_EXAMPLE_H_
#define AXISCAL_CORE_SESSION_TESTING_EXAMPLE_H_

#include <gtest/gtest.h>

#include <string>

namespace axiscal::session::testing {

inline constexpr char kBallbar[] =
    "# machine: mt\n"
    "# session: BX\n"
    "# instrument: ballbar\n"
    "# sigma_um: 0.3\n"
    "# tool_tip_mm: 0 0 -356.4\n"
    "# table_ball_mm: 0 0 65.5\n"
    "# bar_length_mm: 100\n"
    "# operator: night shift\n"
    "t_s,X_mm,Y_mm,Z_mm,B_deg,C_deg,temp_C,dL_mm\n"
    "0.000,100.0000,0.0000,421.9000,0.0000,0.0000,20.000,0.0179\n"
    "0.250,103.1101,0.0000,421.8864,0.5000,0.0000,20.000,0.0182\n"
    "0.500,106.2200,0.0000,421.8457,1.0000,0.0000,20.000,-0.0181\n";

inline constexpr char kTouch[] =
    "# machine: mt\n"
    "# session: touches\n"
    "# instrument: touch\n"
    "# sigma_um: 0.5\n"
    "# tool_tip_mm: 0 0 -200\n"
    "# stylus_radius_mm: 3\n"
    "# sphere ball: 0 0 50 12.7\n"
    "# plane top: 0 0 40 0 0 1\n"
    "t_s,X_mm,B_deg,nx,ny,nz,feature\n"
    "0,1.5,0,0,0,-1,top\n"
    "1,2.5,0,0,0,-1,ball\n";

inline constexpr char kEccentricity[] =
    "# machine: mt\n"
    "# session: runs\n"
    "# instrument: eccentricity\n"
    "# sigma_um: 0.5\n"
    "# tool_tip_mm: 0 0 -356.4\n"
    "run,sense,ex_um,ey_um,ez_um\n"
    "BX,1,-51.4,,-41.3\n"
    "BX,-1,-52.1,,-42\n";

// `text` with the first `from` replaced; a test that names what is not there fails.
inline std::string Replaced(std::string text, const std::string& from, const std::string& to) {
  const size_t at = text.find(from);
  EXPECT_NE(at, std::string::npos) << from;
  if (at != std::string::npos) text.replace(at, from.size(), to);
  return text;
}

}  // namespace axiscal::session::testing

#endif  // AXISCAL_CORE_SESSION_TESTING_EXAMPLE_H_
