// Programs as a shop has them, the way a technician takes them: the machine and its sessions go up, a calibration is
// identified and approved, what holds for all programs is stated once (profile), and each program is corrected on the
// service, downloaded and verified.
#include <gmock/gmock.h>

#include "tests/cli/command_line.h"

namespace axiscal {
namespace {

using ::testing::AllOf;
using ::testing::HasSubstr;
using ::testing::Not;
using testing::Outcome;
using testing::Source;

// Of holes whose heights are those of a definition, which holds for all of them: --cycle-tolerance-um.
constexpr double kDepths = 60.0;

class ShopPrograms : public testing::CommandLine {
 protected:
  void SetUp() override {
    std::filesystem::copy(Source("tests/data/shop"), folder_);
    ASSERT_EQ(Run("upload " + Source("tests/data/loop/case-000")).exit_code, 0);
    const Outcome identified = Run("identify --machine mt --all --json");
    ASSERT_EQ(identified.exit_code, 0) << identified.err;
    ASSERT_EQ(Run("approve " + identified.Json()["id"].dump()).exit_code, 0);
    const Outcome put =
        Run("machine profile put mt --unit mm --tool-tip '0 0 -150' --offset 'G54 X=20 Y=-15 Z=40' --offset 'G154 P1 "
            "X=120 Y=60 Z=-30' --offset 'G154 P2 X=150 Y=60 Z=-30' --offset 'PRESET X=10 Y=5 Z=12' --tool-table "
            "tools.nc");
    ASSERT_EQ(put.exit_code, 0) << put.err;
  }

  // Up, corrected, down, verified: at the ends of moves and holes `most_um` are left. What `compensate` says, and the
  // program.
  std::pair<Outcome, std::string> Taken(const std::string& name, double most_um, const std::string& more = "") const {
    const Outcome done = Run("compensate --machine mt --keep " + name + " -o out.nc --report report.json " + more);
    EXPECT_EQ(done.exit_code, 0) << done.err;
    if (done.exit_code != 0) return {done, ""};
    const auto programs = Run("program list --json").Json()["programs"];
    EXPECT_EQ(Run("program get " + programs.front()["id"].dump() + " -o copy.nc").exit_code, 0);
    EXPECT_EQ(Read("copy.nc"), Read("out.nc"));
    const Outcome verified = Run("verify --machine mt " + name + " copy.nc --json " + more);
    EXPECT_EQ(verified.exit_code, 0) << verified.err;
    const auto report = verified.Json();
    EXPECT_GT(report["moves"].get<int>(), 30);
    EXPECT_GT(report["end"]["before"]["max_um"].get<double>(), 20.0);
    EXPECT_LT(report["end"]["after"]["max_um"].get<double>(), most_um);
    EXPECT_LT(report["path"]["after"]["max_um"].get<double>(), 1.2);
    return {done, Read("out.nc")};
  }
};

TEST_F(ShopPrograms, AnImpellerUnderToolCentrePointControl) {
  const auto [said, program] = Taken("impeller.nc", 0.2);
  EXPECT_THAT(said.out,
              AllOf(HasSubstr("dialect: fanuc"), HasSubstr("; the same program as for haas\n"), HasSubstr("\nT4 "),
                    HasSubstr("of the machine's profile: --tool-tip, --unit, --offset G54, G154 P1, G154 P2, PRESET, "
                              "--tool-length 1, ")));
  EXPECT_THAT(program, AllOf(HasSubstr("(AXISCAL MACHINE mt)\n"), HasSubstr("(AXISCAL OFFSET G54 X20 Y-15 Z40 MM)"),
                             HasSubstr("(AXISCAL TOOL LENGTH 4 IS 136.208 MM)"), HasSubstr("MUST BE OFF"),
                             HasSubstr("\nG43.4 H4 X0.")));
  // For another machine it is refused.
  Write("errors.json", R"({"EX0C": 1.0})");
  std::filesystem::copy(Source("deploy/examples/integrex/machine.json"), folder_ / "other.json");
  const Outcome other =
      Run("verify --machine other.json --errors errors.json --tool-tip '0 0 -150' --dialect fanuc impeller.nc out.nc");
  EXPECT_EQ(other.exit_code, 5);
  EXPECT_THAT(other.err, HasSubstr("was corrected for machine mt, and --machine is integrex-i200"));
  EXPECT_EQ(Run("compensate --machine mt out.nc -o twice.nc").exit_code, 3);
}

TEST_F(ShopPrograms, AFixturePlateDrilledInTiltedPlanes) {
  const auto [said, program] = Taken("fixture-plate.nc", kDepths, "--cycle-tolerance-um 60");
  EXPECT_THAT(said.out, AllOf(HasSubstr("dialect: heidenhain, found by line 1: '0 BEGIN PGM FIXTURE MM'"),
                              HasSubstr("14 holes of drilling cycles")));
  EXPECT_THAT(program, HasSubstr("PLANE SPATIAL SPA+0 SPB-30 SPC+0 TURN FMAX SEQ+\n"));
  EXPECT_THAT(program, HasSubstr("\n;AXISCAL MACHINE mt\n"));
}

TEST_F(ShopPrograms, SixToolsWithSubprograms) {
  const auto [said, program] = Taken("valve-block.nc", 2.0);
  EXPECT_THAT(said.out, AllOf(HasSubstr("dialect: haas, found by line 11: 'G187 P3'"), HasSubstr("G154 P2")));
  for (int tool = 1; tool <= 6; ++tool) EXPECT_THAT(said.out, HasSubstr("\nT" + std::to_string(tool) + " "));
  const auto report = nlohmann::json::parse(Read("report.json"), nullptr, false);
  EXPECT_EQ(report["shifts"].size(), 7u);  // tool 5 in two offsets
  EXPECT_EQ(report["dialect"], "haas");
}

// What is missing is said in the words to add; with them it is corrected.
TEST_F(ShopPrograms, WhatIsMissingIsSaidInTheWordsToAdd) {
  ASSERT_EQ(Run("machine profile put mt --unit mm --tool-tip '0 0 -150'").exit_code, 0);
  const Outcome shown = Run("machine profile show mt");
  EXPECT_EQ(shown.out, "--tool-tip \"0 0 -150\"\n--unit mm\n");
  const Outcome asked = Run("compensate --machine mt valve-block.nc -o out.nc");
  EXPECT_EQ(asked.exit_code, 5);
  EXPECT_THAT(asked.err,
              AllOf(HasSubstr("--offset \"G154 P1 X=... Y=... Z=... B=... C=...\""), HasSubstr("--tool-length H1=..."),
                    HasSubstr("--tool-length H6=..."), HasSubstr("read as haas, found by line 11")));
  EXPECT_FALSE(Exists("out.nc"));
  const std::string added = "--tool-table tools.nc --offset 'G154 P1 X=120 Y=60 Z=-30' --offset 'G154 P2 X=150'";
  EXPECT_EQ(Run("compensate --machine mt valve-block.nc -o out.nc " + added).exit_code, 0);
  ASSERT_EQ(Run("machine profile put mt").exit_code, 0);
  EXPECT_EQ(Run("machine profile show mt").out, "machine mt has no profile\n");
  const Outcome without = Run("compensate --machine mt impeller.nc -o out.nc");
  EXPECT_EQ(without.exit_code, 3);
  EXPECT_THAT(without.err, HasSubstr("--tool-tip: '', expected the nominal tool point"));
  const Outcome bad = Run("machine profile put mt --dialect fanux");
  EXPECT_EQ(bad.exit_code, 3);
  EXPECT_THAT(bad.err, HasSubstr("dialect = 'fanux', must be one of: fanuc"));
}

// What the technician states goes before the profile, however it is spelt, and never half of each.
TEST_F(ShopPrograms, WhatIsStatedGoesBeforeTheProfile) {
  const auto head = [this](const std::string& more) {
    std::filesystem::remove(folder_ / "out.nc");
    const Outcome done = Run("compensate --machine mt impeller.nc -o out.nc " + more);
    return done.exit_code == 0 ? Read("out.nc") : done.err;
  };
  for (const char* spelt : {"'G54  X=21 Y=-15 Z=40'", "'g54 X=21 Y=-15 Z=40'", "'G54 Z=40 Y=-15 X=21'"}) {
    const std::string program = head(std::string("--offset ") + spelt);
    EXPECT_THAT(program, HasSubstr("AXISCAL OFFSET G54 ")) << spelt;
    EXPECT_THAT(program, HasSubstr(" X21 ")) << spelt;
    EXPECT_THAT(program, Not(HasSubstr(" X20 "))) << spelt;
  }
  EXPECT_THAT(head("--offset 'G154  P01 X=1 Y=2 Z=3'"),
              AllOf(HasSubstr("AXISCAL OFFSET G154 P1 X1 Y2 Z3 MM"), Not(HasSubstr("G154 P1 X120"))));
  EXPECT_THAT(head("--offset 'G54 X=21'"),
              HasSubstr("'G54' does not state all that the machine's profile states of it (Y, Z)"));
  EXPECT_THAT(head("--tool-length H04=130"), HasSubstr("AXISCAL TOOL LENGTH 4 IS 130 MM"));
  ASSERT_EQ(
      Run("machine profile put mt --unit mm --tool-tip '0 0 -150' --integer-words increments --decimals 3").exit_code,
      0);
  EXPECT_THAT(head("--dialect fanuc --decimals 4"), HasSubstr("they say together what X100 means, state both"));
}

// Fanuc's F is of all axes together, Haas' is not: the same words, and nobody is asked to guess.
TEST_F(ShopPrograms, WhereControlsDifferTheDialectIsAskedFor) {
  Write("turn.nc", "%\nO7 (TURN)\nG90 G21 G94\nG0 X10. Y0. Z0. B0. C0.\nG1 B30. F500\nM30\n%\n");
  const Outcome asked = Run("compensate --machine mt turn.nc -o out.nc");
  EXPECT_EQ(asked.exit_code, 3);
  EXPECT_THAT(asked.err, AllOf(HasSubstr("fits fanuc, haas and linuxcnc, which take it differently"),
                               HasSubstr("state --dialect fanuc, haas or linuxcnc"), HasSubstr("fanuc: corrected"),
                               HasSubstr("haas: refused, ")));
  EXPECT_FALSE(Exists("out.nc"));
  const Outcome stated = Run("compensate --machine mt turn.nc -o out.nc --dialect fanuc");
  EXPECT_EQ(stated.exit_code, 0) << stated.err;
  EXPECT_THAT(stated.out, HasSubstr("dialect: fanuc, as --dialect says"));
}

}  // namespace
}  // namespace axiscal
