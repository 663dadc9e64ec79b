// "How to add" of docs/architecture.md lists every file that is touched: each list follows an example that is there.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <set>
#include <sstream>

#include "tests/house/includes.h"
#include "tests/house/page.h"

namespace axiscal::house {
namespace {

using ::testing::IsEmpty;
using ::testing::SizeIs;

struct Recipe {
  std::string title;                  // "### A shape"
  std::vector<std::string> examples;  // words of the "Example:" line by which the code knows the example
  struct Row {
    std::string file;
    std::string word;  // what the file has of it
  };
  std::vector<Row> rows;
};

std::vector<Recipe> RecipesOf(const std::string& page) {
  const std::string section = Section(page, "## How to add");
  std::istringstream lines(section);
  std::string line;
  std::vector<Recipe> recipes;
  while (std::getline(lines, line)) {
    if (line.rfind("### ", 0) == 0) recipes.push_back({line, {}, {}});
    if (line.rfind("Example: ", 0) == 0 && !recipes.empty()) recipes.back().examples = Quoted(line);
  }
  for (Recipe& recipe : recipes) {
    for (const std::vector<std::string>& row : TableRows(Section(section, recipe.title))) {
      const std::vector<std::string> file = Quoted(row.front()), words = Quoted(row.back());
      EXPECT_TRUE(row.size() == 2 && file.size() == 1 && !words.empty())
          << recipe.title << ": a row is not `file` | what with `word`: " << ::testing::PrintToString(row);
      if (file.size() == 1 && !words.empty()) recipe.rows.push_back({file[0], words[0]});
    }
  }
  return recipes;
}

bool IsWordCharacter(char c) { return std::isalnum(static_cast<unsigned char>(c)) || c == '_'; }

// Whether `text` has `word` as a whole: "Lag" is not in "LagTime".
bool Names(const std::string& text, const std::string& word) {
  for (size_t at = text.find(word); at != std::string::npos; at = text.find(word, at + 1)) {
    const size_t end = at + word.size();
    const bool begins = at == 0 || !IsWordCharacter(word.front()) || !IsWordCharacter(text[at - 1]);
    const bool ends = end == text.size() || !IsWordCharacter(word.back()) || !IsWordCharacter(text[end]);
    if (begins && ends) return true;
  }
  return false;
}

class TheLists : public ::testing::Test {
 protected:
  const std::vector<Recipe> recipes_ = RecipesOf(ReadPage("docs/architecture.md"));
};

TEST(Names, FindsWholeWords) {
  EXPECT_TRUE(Names("shapes::Lag{axis}", "Lag"));
  EXPECT_FALSE(Names("LagTime kLag", "Lag"));
  EXPECT_TRUE(Names("{\"rtest\", 3}", "\"rtest\""));
}

TEST_F(TheLists, AreThere) {
  EXPECT_THAT(recipes_, SizeIs(5));
  for (const Recipe& recipe : recipes_) {
    EXPECT_FALSE(recipe.examples.empty()) << recipe.title;
    EXPECT_GE(recipe.rows.size(), 3u) << recipe.title;
  }
}

TEST_F(TheLists, NameFilesThatHoldTheExample) {
  for (const Recipe& recipe : recipes_) {
    for (const Recipe::Row& row : recipe.rows) {
      EXPECT_TRUE(Names(ReadPage(row.file), row.word)) << recipe.title << ": no `" << row.word << "` in " << row.file;
    }
  }
}

// Of the sources of the product; documents, build files and tests are what the list says.
TEST_F(TheLists, LeaveNoFileOutThatKnowsTheExample) {
  const std::vector<SourceFile> files = FilesBelow({"core", "proto/convert", "server", "client"});
  for (const Recipe& recipe : recipes_) {
    std::set<std::string> missing;
    for (const SourceFile& file : files) {
      if (file.path.find("/testing/") != std::string::npos || file.path.ends_with("_test.cc")) continue;
      const std::string text = ReadPage(file.path);
      if (std::none_of(recipe.examples.begin(), recipe.examples.end(),
                       [&](const std::string& word) { return Names(text, word); }))
        continue;
      if (std::none_of(recipe.rows.begin(), recipe.rows.end(),
                       [&](const Recipe::Row& row) { return row.file == file.path; }))
        missing.insert(file.path);
    }
    EXPECT_THAT(missing, IsEmpty()) << recipe.title;
  }
}

}  // namespace
}  // namespace axiscal::house
