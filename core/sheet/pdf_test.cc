#include "core/sheet/pdf.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <unistd.h>

#include <cstdio>
#include <memory>

#include "core/base/files.h"

namespace axiscal::sheet {
namespace {

using ::testing::HasSubstr;

// What a program says of a PDF file, as a reader of it would (poppler-utils).
std::string Told(const std::string& program, const std::string& pdf, const std::string& arguments) {
  const std::string path = ::testing::TempDir() + "/sheet_" + std::to_string(getpid()) + ".pdf";
  EXPECT_TRUE(base::WriteFileAtomically(path, pdf).ok());
  const std::string command = program + " " + path + " " + arguments + " 2>&1";
  const std::unique_ptr<FILE, int (*)(FILE*)> pipe(popen(command.c_str(), "r"), pclose);
  std::string text;
  char part[4096];
  for (size_t n = 0; (n = fread(part, 1, sizeof(part), pipe.get())) > 0;) text.append(part, n);
  std::remove(path.c_str());
  return text;
}

Sheet ASheet(size_t rows) {
  Sheet sheet;
  sheet.title = "Geometrische Abweichungen";
  sheet.subtitle = "ISO 230-1";
  sheet.facts = {{"Maschine", "Fräse №7 <b>"}, {"Kalibrierung", "18"}, {"Gemessen", "2026"}};
  Section section = {"Abweichungen", "ttn", {"", "ISO 230-1", "U (k = 2)"}, {}, {"und 3 weitere"}};
  const std::string word = std::string(100, 'w') + " µm";
  for (size_t i = 0; i < rows; ++i) section.rows.push_back({absl::StrCat("E", i), word, "-22,24"});
  sheet.sections = {section};
  sheet.signatures = {"Gemessen: Datum", "Freigegeben: Datum"};
  sheet.footer = "u: Standardunsicherheit";
  return sheet;
}

TEST(Pdf, IsAPageOfA4WithItsText) {
  const auto pdf = ToPdf(ASheet(3));
  ASSERT_TRUE(pdf.ok()) << pdf.status();
  const std::string about = Told("pdfinfo", *pdf, "");
  EXPECT_THAT(about, HasSubstr("Pages:           1\n"));
  EXPECT_THAT(about, HasSubstr("(A4)"));
  EXPECT_THAT(about, HasSubstr("Title:           Geometrische Abweichungen"));
  const std::string text = Told("pdftotext -layout", *pdf, "-");
  for (const char* said : {"Fräse №7 <b>", "µm", "-22,24", "E2", "und 3 weitere", "Freigegeben: Datum", "U (k = 2)",
                           "Standardunsicherheit"})
    EXPECT_THAT(text, HasSubstr(said));
}

// Rows that hardly fit, and more than fit in any size that can be read.
TEST(Pdf, StaysAPageWhateverItHolds) {
  for (const size_t rows : {60, 400}) {
    const auto pdf = ToPdf(ASheet(rows));
    ASSERT_TRUE(pdf.ok()) << pdf.status();
    EXPECT_THAT(Told("pdfinfo", *pdf, ""), HasSubstr("Pages:           1\n")) << rows;
    const std::string last = "E" + std::to_string(rows - 1) + " ";
    const std::string text = Told("pdftotext -layout", *pdf, "-");
    EXPECT_THAT(text, HasSubstr(last)) << rows;
    // Nothing went below the edge: the footer is the last on the page's text within it.
    EXPECT_THAT(Told("pdftotext -layout -x 0 -y 0 -W 595 -H 842", *pdf, "-"), HasSubstr("Standardunsicherheit"))
        << rows;
  }
}

}  // namespace
}  // namespace axiscal::sheet
