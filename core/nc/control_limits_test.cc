// What controls make of corrected blocks: the meaning of F, the length of a block, and the radii of arcs.
#include <array>
#include <cmath>
#include <cstdlib>
#include <sstream>

#include "core/machine/error_symbol.h"
#include "core/machine/testing/machines.h"
#include "core/nc/testing/rewritten.h"

namespace axiscal::nc {
namespace {

using ::testing::HasSubstr;
using testing::kAtZero;

RewriteOptions In(const std::string& dialect) {
  RewriteOptions options = kAtZero;
  options.dialect = dialect;
  return options;
}

// LinuxCNC takes F for mm/min as soon as X, Y or Z moves, and for deg/min else.
TEST(ControlLimits, AFeedMoveOfRotaryAxesAloneKeepsTheMeaningOfF) {
  for (const char* dialect : {"linuxcnc", "haas", "sinumerik"}) {
    EXPECT_REFUSED(In(dialect), "G94 G1 B90 F360\n", "a feed move of rotary axes alone");
    EXPECT_REFUSED(In(dialect), "G94 G1 X1 F100\nG1 X1 B90 F360\n", "a feed move of rotary axes alone");
    // C needs no other word, rapids have no F, G93 states the time, and with X and Z on their way F is theirs.
    for (const char* fine : {"G94 G1 X1\nG1 C90 F360\n", "G0 B90\n", "G93 G1 B90 F2\n", "G94 G1 X10 B90 F360\n"})
      EXPECT_TRUE(testing::Rewritten(fine, In(dialect)).status.ok()) << dialect << fine;
  }
  EXPECT_REFUSED(In("heidenhain"), "L B+90 R0 F360\n", "a feed move of rotary axes alone");
  EXPECT_TRUE(testing::Rewritten("L B+90 R0 FMAX\n", In("heidenhain")).status.ok());
  // Fanuc counts degrees as mm in one speed of all axes.
  for (const char* dialect : {"fanuc", "mazak"})
    EXPECT_TRUE(testing::Rewritten("G94 G1 B90. F360\n", In(dialect)).status.ok()) << dialect;
}

TEST(ControlLimits, AFeedMoveOfRotaryAxesAloneIsPassedWhereThatMovesNothingElse) {
  RewriteOptions passing = In("linuxcnc");
  passing.on_unsupported = OnUnsupported::kPass;
  // X stands at 1 before it: no linear axis moves at the F of a rotary one, whether the block names it or not.
  EXPECT_REWRITTEN(passing, "G1 X1 F100\nB90 F360\nG0 X2\n",
                   "G1 X1.0417 F100\nG01 X1.0000\nB90 F360\nG0 X2 Z-0.0417\n");
  EXPECT_REWRITTEN(passing, "G1 X1 F100\nX1 B90 F360\nG0 X2\n",
                   "G1 X1.0417 F100\nG01 X1.0000\nX1 B90 F360\nG0 X2 Z-0.0417\n");
}

TEST(ControlLimits, BlocksAreNoLongerThanTheControlReads) {
  // LinuxCNC reads 252 characters and a line end.
  const auto block = [](size_t size) {
    std::string text = "G1 X1.5 (";
    text += std::string(size - text.size() - 1, 'c') + ")";
    return text + "\n";
  };
  // Three decimals more: X1.5417.
  const testing::Outcome fits = testing::Rewritten(block(249), In("linuxcnc"));
  ASSERT_TRUE(fits.status.ok()) << fits.status;
  EXPECT_EQ(fits.text.size(), 253u);
  EXPECT_REFUSED(In("linuxcnc"), block(250), "the block has 254 bytes with its line end, and the control reads 253");
  EXPECT_REFUSED(In("linuxcnc"), "(" + std::string(300, 'c') + ")\nG1 X1.5\n", "line 1");
  EXPECT_TRUE(testing::Rewritten(block(400), In("fanuc")).status.ok());
  const std::string comment = "; " + std::string(500, 'c');
  EXPECT_REFUSED(In("sinumerik"), "G1 X1.5 " + comment + "\n", "the control reads 512");
  EXPECT_TRUE(testing::Rewritten("G1 X1.5 ; " + std::string(480, 'c') + "\n", In("sinumerik")).status.ok());
}

// Arcs of a written program, from its words alone.
struct ArcCount {
  int arcs = 0;
  double worst_share = 0;  // of what the control takes, of the ends' difference in radius
};

// Arcs in XY with a centre, every word of a move written on its own line; `least_mm` and 0.1 % is what the control
// takes.
ArcCount ArcsOf(const std::string& program, double mm_per_unit, double least_mm) {
  ArcCount count;
  std::array<double, 2> at = {0, 0}, pole = {0, 0};
  bool is_arc = false, is_absolute = false;
  std::istringstream lines(program);
  for (std::string line; std::getline(lines, line);) {
    if (line[0] == '(' || line[0] == ';' || line[0] == 'M' || line.find("PGM") != std::string::npos) continue;
    std::array<double, 2> end = at, centre = at;
    bool has_centre = false;
    const bool is_pole = line.starts_with("CC");
    for (size_t i = 0; i < line.size(); ++i) {
      const char letter = line[i];
      size_t from = i + 1;
      const bool says_absolute = line.compare(from, 4, "=AC(") == 0;
      if (says_absolute) from += 4;
      const double number = std::strtod(line.c_str() + from, nullptr);
      const size_t index = letter == 'Y' || letter == 'J' ? 1 : 0;
      if (letter == 'G' && number == 90.1) is_absolute = true;
      if (letter == 'G' && number < 4) is_arc = number >= 2;
      if (letter == 'L') is_arc = false;
      if (letter == 'X' || letter == 'Y') (is_pole ? pole : end)[index] = number;
      if (letter == 'I' || letter == 'J') {
        centre[index] = is_absolute || says_absolute ? number : at[index] + number;
        has_centre = true;
      }
    }
    if (is_pole) continue;
    if (line.find("DR") != std::string::npos) {
      is_arc = has_centre = true;
      centre = pole;
    }
    if (is_arc) {
      EXPECT_TRUE(has_centre) << line;
      const double first_mm = std::hypot(at[0] - centre[0], at[1] - centre[1]) * mm_per_unit;
      const double last_mm = std::hypot(end[0] - centre[0], end[1] - centre[1]) * mm_per_unit;
      ++count.arcs;
      count.worst_share = std::max(
          count.worst_share, std::abs(first_mm - last_mm) / std::max(least_mm, 1e-3 * std::max(first_mm, last_mm)));
    }
    at = end;
  }
  return count;
}

// Quarters and three quarters of circles with exact radii of 0.2 to 4 mm, here and there.
std::string SmallArcs(const std::string& dialect, bool is_inch, bool is_absolute, int decimals) {
  const bool has_poles = dialect == "heidenhain";
  std::string program = has_poles                ? (is_inch ? "BEGIN PGM P INCH\n" : "BEGIN PGM P MM\n")
                        : dialect == "sinumerik" ? (is_inch ? "G90 G700\n" : "G90 G710\n")
                                                 : (is_inch ? "G90 G20\n" : "G90 G21\n");
  if (is_absolute && !has_poles) program += dialect == "sinumerik" ? "" : "G90.1\n";
  const double unit_mm = is_inch ? 25.4 : 1.0;
  const auto number = [&](double value) { return absl::StrFormat(has_poles ? "%+.*f" : "%.*f", decimals, value); };
  for (int k = 0; k < 400; ++k) {
    const double grain = std::pow(10.0, -decimals);
    const double radius = std::ceil((0.2 + 3.8 * k / 400.0) / unit_mm / grain) * grain;
    const double x = std::round(std::fmod(37.0 * k, 150.0) / unit_mm / grain) * grain;
    const double y = std::round(std::fmod(53.0 * k, 110.0) / unit_mm / grain) * grain;
    const std::string head = has_poles ? "L X" : "G1 X", end_y = number(k % 3 == 0 ? y + radius : y - radius);
    program += absl::StrCat(head, number(x + radius), " Y", number(y), " F500\n");
    if (has_poles) {
      program += absl::StrCat("CC X", number(x), " Y", number(y), "\nC X", number(x), " Y", end_y, " DR+\n");
    } else if (is_absolute && dialect == "sinumerik") {
      program += absl::StrCat("G3 X", number(x), " Y", end_y, " I=AC(", number(x), ") J=AC(", number(y), ")\n");
    } else if (is_absolute) {
      program += absl::StrCat("G3 X", number(x), " Y", end_y, " I", number(x), " J", number(y), "\n");
    } else {
      program += absl::StrCat("G3 X", number(x), " Y", end_y, " I", number(-radius), " J", number(0), "\n");
    }
  }
  return program + (has_poles ? "END PGM P\n" : "M30\n");
}

// Words of 0.0001 inch put the ends of an arc 3 um off its circle: more than LinuxCNC takes for rounding.
TEST(ControlLimits, BothEndsOfAnArcHaveTheRadiusThatTheControlAsks) {
  const machine::Machine machine = machine::testing::MultiTasking();
  machine::ErrorModel errors = testing::ConstantErrors(machine, {{"EX0C", 0.03}, {"EC0Y", 3e-4}});
  for (const std::string axis : {"X", "Y"}) {
    machine::ErrorTerm scale = machine::ConstantTerm(machine, *machine::ParseErrorSymbol("E" + axis + axis), 0.05);
    scale.shape = shapes::Linear{machine::FindAxis(machine, axis), 100.0};
    errors.terms.push_back(scale);
  }
  const compensate::Compensator compensator = testing::MustCreate(machine, errors, {0, 0, -150});
  struct Control {
    const char* dialect;
    double least_mm;
    bool takes_finer_words, has_absolute_centres;
  };
  for (const Control& control : {Control{"linuxcnc", 0.00127, true, true}, Control{"sinumerik", 0.005, true, true},
                                 Control{"fanuc", 0.005, false, false}, Control{"heidenhain", 0.005, false, false}}) {
    for (const bool is_inch : {true, false}) {
      for (const bool is_absolute : {false, true}) {
        if (is_absolute && !control.has_absolute_centres) continue;
        for (const int decimals : {2, 3}) {
          RewriteOptions options = In(control.dialect);
          options.unit = ProgramUnit::kUnstated;
          options.tolerance_mm = 0.05;
          options.decimals_mm = decimals;
          options.decimals_inch = decimals + 1;
          const std::string program =
              SmallArcs(control.dialect, is_inch, is_absolute, is_inch ? decimals + 1 : decimals);
          const testing::Outcome written = testing::Rewritten(program, options, compensator);
          ASSERT_TRUE(written.status.ok()) << written.status;
          const ArcCount before = ArcsOf(program, is_inch ? 25.4 : 1.0, control.least_mm);
          const ArcCount after = ArcsOf(written.text, is_inch ? 25.4 : 1.0, control.least_mm);
          const std::string name =
              absl::StrCat(control.dialect, is_inch ? " inch " : " mm ", is_absolute ? "absolute " : "", decimals);
          EXPECT_EQ(before.arcs, 400) << name;
          EXPECT_LT(before.worst_share, 1e-6) << name;
          EXPECT_LE(after.worst_share, 1.0) << name;
          // All stay arcs but the smallest in words of 0.001 inch: 395 where words may be finer, else 385.
          EXPECT_GE(after.arcs, decimals == 3 || !is_inch ? 400 : control.takes_finer_words ? 395 : 385) << name;
        }
      }
    }
  }
}

}  // namespace
}  // namespace axiscal::nc
