// What the README shows is what the repository holds.
#include <gmock/gmock.h>

#include "tests/cli/command_line.h"

namespace axiscal {
namespace {

using ::testing::HasSubstr;
using testing::Source;

std::string ReadSource(const std::string& name) {
  std::stringstream text;
  text << std::ifstream(Source(name)).rdbuf();
  return text.str();
}

// The first block of the README that starts with ````language`.
std::string Block(const std::string& language) {
  const std::string readme = ReadSource("README.md"), fence = "```" + language + "\n";
  const size_t begin = readme.find(fence);
  EXPECT_NE(begin, std::string::npos) << fence;
  if (begin == std::string::npos) return "";
  const size_t start = begin + fence.size();
  return readme.substr(start, readme.find("```", start) - start);
}

TEST(Readme, TheClientExampleIsTheOneThatIsCompiled) {
  const std::string example = Block("cpp");
  EXPECT_FALSE(example.empty());
  EXPECT_THAT(ReadSource("client/example_upload.cc"), HasSubstr(example));
}

TEST(Readme, TheExitCodesAreThoseOfTheHelp) {
  const std::string readme = ReadSource("README.md");
  for (const char* code : {"0 done", "1 failed", "2 wrong command line", "3 bad input", "4 not found",
                           "5 refused by a rule", "6 not reachable, busy or out of time", "7 cancelled"}) {
    EXPECT_THAT(readme, HasSubstr(code));
    EXPECT_THAT(ReadSource("client/cli/exit_code.h"), HasSubstr(code));
  }
}

}  // namespace
}  // namespace axiscal
