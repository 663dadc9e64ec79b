// What the pages (client/web) must say a second time, as they share no code with the engine.
#include <gtest/gtest.h>

#include <cstdlib>
#include <regex>

#include "tests/house/page.h"

namespace axiscal::house {
namespace {

double NumberIn(const std::string& page, const std::string& pattern) {
  std::smatch found;
  const std::string text = ReadPage(page);
  return std::regex_search(text, found, std::regex(pattern)) ? std::strtod(found[1].str().c_str(), nullptr) : -1;
}

TEST(Pages, TheFormOfProgramsStatesTheLimitOfTheEngine) {
  const double engine_mm = NumberIn("core/nc/options.h", "double max_correction_mm = ([0-9.]+);");
  EXPECT_GT(engine_mm, 0);
  EXPECT_EQ(NumberIn("client/web/src/pages/programs.tsx", "kMaxCorrectionUm = ([0-9.]+);"), 1000 * engine_mm);
}

}  // namespace
}  // namespace axiscal::house
