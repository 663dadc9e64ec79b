// Words whose number is a variable that the program set, or an expression of such.
#include "core/nc/variables.h"

#include "core/nc/testing/rewritten.h"
#include "core/nc/verify.h"

namespace axiscal::nc {
namespace {

using testing::kAtZero;
using testing::Outcome;
using testing::Rewritten;

RewriteOptions In(const std::string& dialect) {
  RewriteOptions options = kAtZero;
  options.dialect = dialect;
  return options;
}

TEST(Variables, WordsOfKnownVariablesAreCorrected) {
  for (const char* dialect : {"fanuc", "haas", "linuxcnc"}) {
    EXPECT_REWRITTEN(In(dialect), "#100=5.\n#101=-2.5\nG1 X#100 Y#101 F100\nX-#101\nX[#100+2*#101-1] Y#101\n",
                     "#100=5.\n#101=-2.5\nG1 X5.0417 Y#101 F100\nX2.5417\nX-0.9583 Y#101\n");
    EXPECT_REWRITTEN(In(dialect), "#1=10\n#2=#1/4\nG1 X[SQRT[16]] Y[ABS[-#2]] F100\nX[#1*COS[60]]\n",
                     "#1=10\n#2=#1/4\nG1 X4.0417 Y[ABS[-#2]] F100\nX5.0417\n");
  }
  EXPECT_REWRITTEN(In("linuxcnc"), "#<depth>=2.5\nG1 X[#<Depth> * 2] F100\n", "#<depth>=2.5\nG1 X5.0417 F100\n");
  EXPECT_REWRITTEN(In("sinumerik"), "R1=3 R2=4\n_W=R1*(R2-1)\nG1 X=R1 F100\nX=_W+R2 Y=IC(R2)\n",
                   "R1=3 R2=4\n_W=R1*(R2-1)\nG1 X=3.0417 F100\nX=13.0417 Y=IC(R2)\n");
  EXPECT_REWRITTEN(In("heidenhain"), "1 Q1 = +5\n2 Q2 = Q1 * 3 - 1\n3 L X+Q1 Y-Q2 F100\n4 L X-Q2\n",
                   "1 Q1 = +5\n2 Q2 = Q1 * 3 - 1\n3 L X+5.0417 Y-Q2 F100\n4 L X-13.9583\n");
  // Numbers that choose.
  RewriteOptions lengths = kAtZero;
  lengths.tool_lengths = {{3, 100.0}};
  EXPECT_REWRITTEN(lengths, "#5=3\nG43 H#5\nG1 X1. Z0 F100\n", "#5=3\nG43 H#5\nG1 X1.0533 Z0 F100\n");
}

TEST(Variables, WhatIsNotKnownIsRefused) {
  for (const std::string blocks :
       {"G1 X#100 F100\n", "#100=5.\n/#100=6.\nG1 X#100 F100\n", "#100=5. G1 X#100 F100\n", "#100=#5221\nG1 X#100\n",
        "#100=5.\nM98 P9\nG90 G94 G17 G21 G1 X#100\n", "#5221=5.\nG1 X#5221\n", "#100=5.\nG1 X#100+1 F100\n",
        "#100=1/0\nG1 X#100 F100\n", "#100=5.\n#[#1]=7.\nG1 X#100 F100\n", "#1=5.\nM98 P8\nM30\nO8\nM99\nO9\nX#1\n"})
    EXPECT_REFUSED(kAtZero, blocks, "refused");
  EXPECT_REFUSED(In("heidenhain"), "1 Q200 = +5\n2 CYCL DEF 200 DRILL ~\n Q200=+2\n3 L X+Q200 F100\n", "line 4");
  EXPECT_REFUSED(In("heidenhain"), "1 L X+Q10 F100\n", "the value of Q10 is not known here");
  EXPECT_REFUSED(In("heidenhain"), "1 Q1 = +5\n2 FN 5: Q1 = SQRT +4\n3 L X+Q1 F100\n", "line 3");
  EXPECT_REFUSED(In("heidenhain"), "1 Q1 = +5\n2 FN 1: Q1 = +Q1 + +Q9\n3 L X+Q1 F100\n", "line 3");
  // Locals of a macro are its own.
  EXPECT_REFUSED(kAtZero, "#1=5.\nG65 P8 B7.\nM30\nO8\nG1 X#1 F100\nM99\n", "line 5");
  EXPECT_REFUSED(kAtZero, "G65 P8 A7\nM30\nO8\nG1 X#1 F100\nM99\n", "line 4");  // 7 of which unit?
  EXPECT_REFUSED(kAtZero, "G65 P8 I7. I8.\nM30\nO8\nG1 X#4 F100\nM99\n", "line 4");
  EXPECT_REFUSED(kAtZero, "M98 P8\nM30\nO8\nG65 P9 A7.\nG1 X#1 F100\nM99\nO9\nM99\n", "line 5");
  EXPECT_REWRITTEN(kAtZero, "#101=5.\nM98 P8\nM30\nO8\nG1 X#101 F100\nM99\n",
                   "#101=5.\nM98 P8\nM30\nO8\nG1 X5.0417 F100\nM99\n");
}

TEST(Variables, ArgumentsOfMacrosAreKnownInThem) {
  EXPECT_REWRITTEN(kAtZero, "G65 P8 A7. X2. L2\nM30\nO8\nG1 X[#1+#24] F100\nM99\n",
                   "G65 P8 A7. X2. L2\nM30\nO8\nG1 X9.0417 F100\nM99\n");
}

// "Z=R168Y5" would be another name.
TEST(Variables, WordsBehindANameStandApartInPackedBlocksToo) {
  EXPECT_REWRITTEN(In("sinumerik"), "R168=4\nG1Y5F100 Z=R168\n", "R168=4\nG1Y5F100 Z=R168 X0.0417\n");
}

// Tools and cycles that wait for their call have parameters of their own.
TEST(Variables, OfKlartextOutliveToolsAndDefinitions) {
  RewriteOptions options = In("heidenhain");
  options.tool_lengths = {{4, 10.0}};
  const std::string head =
      "1 Q10 = 40 ; CIRCLE\n2 TOOL CALL 4 Z S2500\n3 CYCL DEF 200 DRILLING ~\n Q200=2 ~\n Q201=-20 ~\n Q203=+0\n";
  EXPECT_REWRITTEN(options, head + "4 L X+Q10 Y+0 Z+0 B+0 C+0 R0 FMAX\n",
                   head + "4 L X+40.0428 Y+0 Z+0 B+0 C+0 R0 FMAX\n");
}

TEST(Variables, ArithmeticOfKlartextIsFollowed) {
  EXPECT_REWRITTEN(In("heidenhain"),
                   "1 FN 0: Q1 = +5\n2 FN 1: Q2 = +Q1 + +2\n3 FN 4: Q3 = +Q2 DIV +2\n4 FN 3: Q4 = +Q3 * -Q1\n"
                   "5 FN 2: Q5 = +Q4 - -20\n6 L X+Q5 F100\n",
                   "1 FN 0: Q1 = +5\n2 FN 1: Q2 = +Q1 + +2\n3 FN 4: Q3 = +Q2 DIV +2\n4 FN 3: Q4 = +Q3 * -Q1\n"
                   "5 FN 2: Q5 = +Q4 - -20\n6 L X+2.5417 F100\n");
}

TEST(Variables, VerifyReadsThem) {
  const std::string program = "#100=5.\nG1 X#100 Y0. F100\nB[#100*9]\nX[#100+1]\n";
  const Outcome outcome = Rewritten(program, kAtZero);
  ASSERT_TRUE(outcome.status.ok()) << outcome.status;
  const compensate::Compensator compensator = testing::LeaningHead();
  VerifyOptions verify;
  verify.tool_tip_mm = {0, 0, -testing::kToolMm};
  verify.reading = kAtZero;
  const auto report = VerifyText(program, outcome.text, compensator.machine(), compensator.carried(), verify);
  ASSERT_TRUE(report.ok()) << report.status();
  EXPECT_EQ(report->moves, 3);
  EXPECT_GT(report->end_before.max_mm, 0.04);
  EXPECT_LT(report->end_after.max_mm, 1.5e-4);
}

}  // namespace
}  // namespace axiscal::nc
