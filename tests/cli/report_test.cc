// axiscal report: the page to sign, of a stored calibration and of a report file, read back as a reader of PDF would.
#include <gmock/gmock.h>

#include "tests/cli/command_line.h"

namespace axiscal {
namespace {

using ::testing::AllOf;
using ::testing::HasSubstr;
using testing::Outcome;
using testing::Source;

class Report : public testing::CommandLine {
 protected:
  void SetUp() override {
    std::filesystem::copy(Source("deploy/examples/integrex"), folder_);
    ASSERT_EQ(Run("machine add machine.json").exit_code, 0);
    ASSERT_EQ(Run("upload B-short-run1.csv B-long-run1.csv").exit_code, 0);
    const Outcome made =
        Run("identify --machine integrex-i200 --json --sessions B-short-run1,B-long-run1 --declare EZ0T,EX0T");
    ASSERT_EQ(made.exit_code, 0) << made.err;
  }

  // The text of a PDF in the test's folder (poppler-utils).
  std::string TextOf(const std::string& pdf) const {
    const std::string in = "cd '" + folder_.string() + "' && ";
    EXPECT_EQ(std::system((in + "pdftotext -layout " + pdf + " text.txt && pdfinfo " + pdf + " >info.txt").c_str()), 0);
    EXPECT_THAT(Read("info.txt"), AllOf(HasSubstr("Pages:           1\n"), HasSubstr("(A4)")));
    return Read("text.txt");
  }
};

TEST_F(Report, OfAStoredCalibrationIsAPage) {
  const Outcome written = Run("report 1 -o page.pdf");
  ASSERT_EQ(written.exit_code, 0) << written.err;
  EXPECT_THAT(written.out, HasSubstr("one page is in page.pdf"));
  const std::string text = TextOf("page.pdf");
  for (const char* said : {"Geometric errors of a machine tool", "ISO 230-1", "integrex-i200, w-C'bZYXB(C1)-t", "EZ0T",
                           "offset of spindle and tool in Z", "B-short-run1", "touch probe (sphere centres)",
                           "B-short-run1: tool point (0; 0; -382.95) mm, table ball at (-490; 0; -472) mm",
                           "U (k = ", "candidate", "Approved: date, name, signature"})
    EXPECT_THAT(text, HasSubstr(said));
  ASSERT_EQ(Run("report 1 -o page.html --language de").exit_code, 0);
  EXPECT_THAT(Read("page.html"), AllOf(HasSubstr("<html lang=\"de\">"), HasSubstr("Versatz von Spindel und Werkzeug")));
}

TEST_F(Report, OfAReportFileSaysWhatItsFilesSay) {
  const auto calibration = Run("calibration show 1 --json").Json();
  Write("report.json", calibration["report"].dump());
  std::string session = Read("B-short-run1.csv");
  session.insert(session.find("# sigma_um"), "# serial: S-77\n# operator: Ann\n# started: 2026-03-04T05:06:00Z\n");
  Write("with-serial.csv", session);
  ASSERT_EQ(Run("report report.json -o page.pdf").exit_code, 0);
  EXPECT_THAT(TextOf("page.pdf"), AllOf(HasSubstr("not stated"), HasSubstr("EZ0T")));
  const Outcome written =
      Run("report report.json --machine machine.json --sessions with-serial.csv --language de -o full.pdf --json");
  ASSERT_EQ(written.exit_code, 0) << written.err;
  EXPECT_EQ(written.Json()["file"], "full.pdf");
  EXPECT_THAT(TextOf("full.pdf"),
              AllOf(HasSubstr("Messtaster"), HasSubstr("(Kugelmitten), S-77"), HasSubstr("2026-03-04 05:06 UTC"),
                    HasSubstr("Ann"), HasSubstr("integrex-i200"), HasSubstr("Restfehler der Messwerte"),
                    HasSubstr("EZ0T bei 3183 µm: eine Maschine von")));
}

TEST_F(Report, SaysWhatIsWrong) {
  Outcome outcome = Run("report 1 -o page.doc");
  EXPECT_EQ(outcome.exit_code, 3);
  EXPECT_THAT(outcome.err, HasSubstr("--output page.doc: expected a name that ends in .pdf or .html"));
  EXPECT_EQ(Run("report 99 -o page.pdf").exit_code, 4);
  EXPECT_EQ(Run("report missing.json -o page.pdf").exit_code, 4);
  outcome = Run("report 1 --machine machine.json -o page.pdf");
  EXPECT_EQ(outcome.exit_code, 3);
  EXPECT_THAT(outcome.err, HasSubstr("with a report file only"));
  Write("bad.json", "{\"verdict\": \"none\"}");
  outcome = Run("report bad.json -o page.pdf");
  EXPECT_EQ(outcome.exit_code, 3);
  EXPECT_THAT(outcome.err, HasSubstr("bad.json"));
  EXPECT_FALSE(Exists("page.pdf"));
}

// axiscal volumetric: of one calibration, of a part, and all of a machine.
TEST_F(Report, TheVolumetricErrorIsPrintedBeforeAndAfter) {
  const Outcome one = Run("volumetric 1");
  ASSERT_EQ(one.exit_code, 0) << one.err;
  EXPECT_THAT(one.out, AllOf(HasSubstr("calibration 1 (candidate), tool point over Z "), HasSubstr("machine as it is"),
                             HasSubstr("corrected for 1"), HasSubstr("less work offset and tool, um [95 % interval]")));
  const auto json = Run("volumetric 1 --json").Json();
  EXPECT_EQ(json["calibration"], 1);
  EXPECT_EQ(json["known_share"], 1.0);
  EXPECT_FALSE(json.contains("before"));
  EXPECT_LE(json["after"]["rms"]["low_um"], json["after"]["rms"]["high_um"]);

  const Outcome part = Run("volumetric 1 --box 'X -900 -50' --json");
  ASSERT_EQ(part.exit_code, 0) << part.err;
  EXPECT_LT(part.Json()["known_share"], 1.0);
  ASSERT_EQ(Run("approve 1").exit_code, 0);
  ASSERT_EQ(Run("identify --machine integrex-i200 --sessions B-short-run1,B-long-run1 --declare EZ0T").exit_code, 0);
  const auto history = Run("volumetric --machine integrex-i200 --json").Json();
  ASSERT_EQ(history["errors"].size(), 2u);
  EXPECT_EQ(history["errors"][0]["calibration"], 2);
  EXPECT_EQ(history["errors"][0]["before_calibration"], 1);
  EXPECT_TRUE(history["errors"][0].contains("before"));
  EXPECT_EQ(history["errors"][1]["state"], "approved");
  const Outcome table = Run("volumetric --machine integrex-i200 --page-size 1");
  EXPECT_THAT(table.out, AllOf(HasSubstr("as it is, um rms"), HasSubstr("more: --page ")));

  EXPECT_EQ(Run("volumetric").exit_code, 3);
  EXPECT_EQ(Run("volumetric 1 --machine integrex-i200").exit_code, 2);
  EXPECT_EQ(Run("volumetric 99").exit_code, 4);
  const Outcome refused = Run("volumetric 1 --box 'X 5 1'");
  EXPECT_EQ(refused.exit_code, 3);
  EXPECT_THAT(refused.err, HasSubstr("--box 'X 5 1': expected \"AXIS MIN MAX\""));
}

}  // namespace
}  // namespace axiscal
