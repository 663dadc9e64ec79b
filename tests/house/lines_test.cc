// No line of C++ is longer than the 120 columns of .clang-format, which leaves strings and comments of one word alone.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <sstream>
#include <string>
#include <vector>

#include "tests/house/includes.h"
#include "tests/house/page.h"

namespace axiscal::house {
namespace {

using ::testing::ElementsAre;
using ::testing::IsEmpty;

constexpr std::ptrdiff_t kColumns = 120;

// "core/a.h:3: 127 columns" of each line that is too long. A character of several bytes is one column.
std::vector<std::string> LongLines(const std::string& path, const std::string& text) {
  std::vector<std::string> found;
  std::istringstream lines(text);
  int number = 0;
  for (std::string line; std::getline(lines, line);) {
    ++number;
    const auto columns = std::count_if(line.begin(), line.end(), [](char c) { return (c & 0xC0) != 0x80; });
    if (columns > kColumns)
      found.push_back(path + ":" + std::to_string(number) + ": " + std::to_string(columns) + " columns");
  }
  return found;
}

TEST(LongLines, CountCharactersNotBytes) {
  const std::string fits(120, 'c'), letter = "\xCE\xBC";  // the Greek letter of micrometres
  std::string greek(119, 'c');
  greek.append(letter);
  EXPECT_THAT(LongLines("a.h", fits + "\n" + greek + "\n"), IsEmpty());
  EXPECT_THAT(LongLines("a.h", "\n" + fits + "c\n" + greek + letter),
              ElementsAre("a.h:2: 121 columns", "a.h:3: 121 columns"));
}

TEST(House, NoLineIsLongerThan120Columns) {
  std::vector<std::string> found;
  size_t read = 0;
  for (const SourceFile& file : FilesBelow({"core", "proto", "server", "client", "tests"})) {
    const std::vector<std::string> of_file = LongLines(file.path, ReadPage(file.path));
    found.insert(found.end(), of_file.begin(), of_file.end());
    ++read;
  }
  EXPECT_GT(read, 700u);
  EXPECT_THAT(found, IsEmpty());
}

}  // namespace
}  // namespace axiscal::house
