// Controllers' own words: what is read, what is reported.
#include "core/nc/dialect.h"

#include "core/nc/testing/rewritten.h"

namespace axiscal::nc {
namespace {

using ::testing::HasSubstr;
using testing::kAtZero;
using testing::Outcome;
using testing::Rewritten;

RewriteOptions In(const std::string& dialect) {
  RewriteOptions options = kAtZero;
  options.dialect = dialect;
  return options;
}

TEST(Dialect, TablesHoldWhatTheyMust) {
  EXPECT_EQ(Dialects().size(), 6u);
  for (const Dialect& dialect : Dialects()) {
    EXPECT_EQ(FindDialect(dialect.name), &dialect);
    EXPECT_EQ(dialect.keyword_codes.size(), dialect.keywords.size());
    // A comma in front of a capital is the other form that the lexer looks for.
    for (const Keyword& keyword : dialect.keywords)
      EXPECT_GE(keyword.name[keyword.name[0] == ',' ? 1 : 0], 'A') << keyword.name;
  }
  EXPECT_EQ(FindDialect("basic"), nullptr);
}

TEST(Dialect, SinumerikWordsWithEqualsKeepTheirForm) {
  EXPECT_REWRITTEN(In("sinumerik"), "N10 G0 G90 X=1.5 Y2 Z=3.0 ; start\nN20 MSG(\"X5 Y6\")\nN30 G1 X=2.5 F=500 M8\n",
                   "N10 G0 G90 X=1.5417 Y2 Z=3.0 ; start\nN20 MSG(\"X5 Y6\")\nN30 G1 X=2.5417 F=500 M8\n");
  EXPECT_REWRITTEN(In("sinumerik"), "G1 X10 Y0\nG3 X0 Y10 CR=10\nG2 X10 Y0 CR=10.000\nG500\nSOFT FFWON\nG1 X20\n",
                   "G1 X10.0417 Y0\nG3 X0.0417 Y10 CR=10\nG2 X10.0417 Y0 CR=10.000\nG500\nSOFT FFWON\nG1 X20.0417\n");
  EXPECT_REWRITTEN(In("sinumerik"), "G1 X1\nSUPA G0 Z0 D0\nG0 Z5 X2\n", "G1 X1.0417\nSUPA G0 Z0 D0\nG0 Z5 X2.0417\n");
}

TEST(Dialect, SinumerikArchivesHoldSeveralPrograms) {
  EXPECT_REWRITTEN(In("sinumerik"), "%_N_A_MPF\n;$PATH=/_N_MPF_DIR\nG1 X1\nM30\n%_N_B_SPF\nG1 X2 Y0 Z0 B0 C0\nM17\n",
                   "%_N_A_MPF\n;$PATH=/_N_MPF_DIR\nG1 X1.0417\nM30\n%_N_B_SPF\nG1 X2.0417 Y0 Z0 B0 C0\nM17\n");
}

TEST(Dialect, SinumerikModesAreReported) {
  const struct {
    const char* block;
    const char* reason;
  } kCases[] = {
      {"TRAORI(2)", "tool centre point control"},
      {"TRAORI X5", "tool centre point control"},
      {"CYCLE800(1,\"TC1\",0,57,0,0,0,30,0,0,0,0,0,1)", "tilted plane"},
      {"CYCLE81(R1,0,2,-5)", "cycle"},
      {"TRANS X=R5", "shift of coordinates"},
      {"AROT X30", "rotation"},
      {"MIRROR Z0", "mirror"},
      {"R1=R2+5", "macro or expression"},
      {"X=R1", "without a number"},
      {"L140(2)", "unexpected character"},
      {"IF R1==0 GOTOF ENDE", "condition"},
      {"ENDE:", "without a number"},
      {"G54", "not stated"},
      {"G505", "not stated"},
      {"D1", "tool length 1"},
      {"CIP X10 Y10 I1=5 J1=5", "circular move"},
      {"G110 X5 Y5", "polar"},
      {"G41 X5", "cutter compensation"},
      {"DIAMON", "diameter"},
      {"MCALL CYCLE83(1,2,3)", "modal call"},
      {"G331 Z-5 K1", "rigid tapping"},
  };
  for (const auto& known : kCases) {
    const Outcome outcome = Rewritten("G1 X1\n" + std::string(known.block) + "\n", In("sinumerik"));
    EXPECT_THAT(std::string(outcome.status.message()), HasSubstr(known.reason)) << known.block << outcome.text;
    EXPECT_THAT(std::string(outcome.status.message()), HasSubstr("line 2")) << known.block;
  }
  // Behind a tool change the tool length is not known: rapid moves stay, feed moves refuse, until a D states it.
  EXPECT_REWRITTEN(In("sinumerik"), "G1 X1\nT1 M6\nG0 X1 Y1 Z1 B0 C0\nX2\nZ5 D0\nG1 X3\n",
                   "G1 X1.0417\nT1 M6\nG0 X1 Y1 Z1 B0 C0\nX2\nZ5 X2.0417 D0\nG1 X3.0417\n");
  EXPECT_REFUSED(In("sinumerik"), "G1 X1\nT1 M6\nG0 X1 Y1 Z1 B0 C0\nG1 X2\n",
                 "line 4: 'G1 X2': the tool length is not known");
  EXPECT_REFUSED(In("sinumerik"), "G1 X1\nT1 M6\nG0 X1 Y1 Z1 B0 C0\nG2 X2 Y2 CR=5\n", "the tool length is not known");
}

TEST(Dialect, KlartextLBlocks) {
  EXPECT_REWRITTEN(In("heidenhain"),
                   "0 BEGIN PGM PART MM\n1 BLK FORM 0.1 Z X+0 Y+0 Z-20\n2 L X+1.5 Y-2 Z+0 B+0 C+0 R0 FMAX M3\n"
                   "3 L X+2.5 F2000\n4 ; comment X5\n5 * - structure\n6 L IX+1\n7 CYCL DEF 32.0 TOLERANCE\n8 STOP\n"
                   "9 L Z+100 R0 FMAX M91\n10 END PGM PART MM\n",
                   "0 BEGIN PGM PART MM\n1 BLK FORM 0.1 Z X+0 Y+0 Z-20\n2 L X+1.5417 Y-2 Z+0 B+0 C+0 R0 FMAX M3\n"
                   "3 L X+2.5417 F2000\n4 ; comment X5\n5 * - structure\n6 L IX+1\n7 CYCL DEF 32.0 TOLERANCE\n8 STOP\n"
                   "9 L Z+100 R0 FMAX M91\n10 END PGM PART MM\n");
  // The mark stands behind BEGIN PGM; inserted words and pieces carry signs, pieces their L.
  RewriteOptions options = In("heidenhain");
  options.tolerance_mm = 0.005;
  EXPECT_REWRITTEN(options, "1 L X+0 Y+0 Z+0 B+0 C+0 R0 FMAX\n2 L X+10 B+90 F500\n",
                   "1 L X+0.0417 Y+0 Z+0 B+0 C+0 R0 FMAX\n2 L X+5.0295 B+45.0000 Z-0.0295 F500\n"
                   "L X+10.0000 Z-0.0417 B+90.0000\n");
}

TEST(Dialect, KlartextIsReportedWhereItIsNoLBlock) {
  const struct {
    const char* block;
    const char* reason;
  } kCases[] = {
      {"CT X+10 Y+0", "its centre follows from the block before"},
      {"CP IPA+90 DR-", "polar circular move"},
      {"LP PR+10 PA+30", "polar linear move"},
      {"TOOL CALL 5 Z S2000", "TOOL CALL 5: the tool's length is not stated"},
      {"TOOL CALL \"MILL\" Z S2000", "by name"},
      {"PLANE PROJECTED PROPR+24 PROMIN+24 ROT+30 STAY", "tilted plane"},
      {"CYCL DEF 7.1 IX+5", "shift of coordinates"},
      {"CYCL DEF 247 DATUM SETTING Q339=1", "PRESET 1 is not stated"},
      {"CYCL CALL", "cycle"},
      {"L X+5 M128", "tool centre point control"},
      {"FUNCTION TCPM F TCP AXIS SPAT PATHCTRL AXIS", "tool centre point control"},
      {"LN X+5 Y+5 NX0 NY0 NZ1", "surface normals"},
      {"L X+5 RL F100", "cutter compensation"},
      {"CALL LBL 1", "call"},
      {"FN 9: IF +Q1 EQU +0 GOTO LBL 1", "parameters"},
      {"L X+Q1", "the value of Q1 is not known"},
      {"TCH PROBE 0.0 REF. PLANE Q5 X-", "probing"},
      {"APPR PLT PR+5 PA+20 LEN5 RL", "approach"},
  };
  for (const auto& known : kCases) {
    const Outcome outcome = Rewritten("1 L X+1 R0 FMAX\n2 " + std::string(known.block) + "\n", In("heidenhain"));
    EXPECT_THAT(std::string(outcome.status.message()), HasSubstr(known.reason)) << known.block << outcome.text;
    EXPECT_THAT(std::string(outcome.status.message()), HasSubstr("line 2")) << known.block;
  }
  RewriteOptions options = In("heidenhain");
  options.tool_lengths = {{5, 100.0}};
  EXPECT_REWRITTEN(options, "1 TOOL CALL 5 Z S2000\n2 L X+1 Y+0 Z+0 B+0 C+0 R0 FMAX\n3 TOOL CALL Z S500\n4 L X+2\n",
                   "1 TOOL CALL 5 Z S2000\n2 L X+1.0533 Y+0 Z+0 B+0 C+0 R0 FMAX\n3 TOOL CALL Z S500\n4 L X+2.0533\n");
}

TEST(Dialect, NamedVariablesMayBeSetToNumbers) {
  EXPECT_REWRITTEN(In("linuxcnc"), "#<depth> = -2.5 (d)\nG1 X1.\n#<_feed>=5\nX2.\n",
                   "#<depth> = -2.5 (d)\nG1 X1.0417\n#<_feed>=5\nX2.0417\n");
  EXPECT_REWRITTEN(In("sinumerik"), "N20 _camtolerance=0.01 ; mm\nG1 X1\n_A1=3 _B=-4\nX2\n",
                   "N20 _camtolerance=0.01 ; mm\nG1 X1.0417\n_A1=3 _B=-4\nX2.0417\n");
  EXPECT_REFUSED(In("sinumerik"), "_A=_B+1\nG1 X1\n", "line 1");
  EXPECT_REFUSED(In("sinumerik"), "_A=1 X5\nG1 X1\n", "line 1");
}

TEST(Dialect, LinuxCncWords) {
  EXPECT_REWRITTEN(In("linuxcnc"), "G1 X1. (MSG, hello)\nG64 P0.01 Q0.01\nM62 P1\nG8\nX2.\n",
                   "G1 X1.0417 (MSG, hello)\nG64 P0.01 Q0.01\nM62 P1\nG8\nX2.0417\n");
  for (const std::string block :
       {"o100 sub", "o<probe> call [5]", "O100 if [#1 EQ 0]", "#<x>=#<y>", "X#<x>", "G5 X1 Y1 I1 J1", "G76 P1 Z-5 I1",
        "G7", "M429", "G38.2 Z-5 F10", "G33 Z-5 K1", "M72"}) {
    const Outcome outcome = Rewritten("G1 X1.\n" + block + "\nG1 X2.\n", In("linuxcnc"));
    EXPECT_THAT(std::string(outcome.status.message()), HasSubstr("line 2")) << block;
    EXPECT_EQ(outcome.status.code(), absl::StatusCode::kFailedPrecondition) << block;
  }
}

TEST(Dialect, HaasWords) {
  EXPECT_REWRITTEN(In("haas"), "G1 X1.\nG187 P3 E0.001\nG103 P1\nX2.\n",
                   "G1 X1.0417\nG187 P3 E0.001\nG103 P1\nX2.0417\n");
  for (const std::string block :
       {"G12 I5. F10.", "G234 H1", "G254 X1.", "G154 P3", "G110", "G150 P100", "M97 P100", "G5 P1"})
    EXPECT_REFUSED(In("haas"), block + "\nG1 X1.\n", "line 1: '" + block + "'");
}

}  // namespace
}  // namespace axiscal::nc
