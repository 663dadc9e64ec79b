// The walls between the rooms: who may include whom. A rule is one test here.
#include "tests/house/includes.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>

namespace axiscal::house {
namespace {

using ::testing::ElementsAre;
using ::testing::IsEmpty;

// ---- the reader that the rules stand on

TEST(IncludesOf, FindsBothFormsAndNoComment) {
  const std::string text =
      "// #include \"not/this.h\"\n"
      "#include <vector>\n"
      "\n"
      "  #  include \"core/base/ids.h\"  // why\n"
      "#include MACRO\n"
      "std::string s = \"#include <x>\";\n";
  EXPECT_THAT(IncludesOf(text), ElementsAre(Include{2, "vector", false}, Include{4, "core/base/ids.h", true}));
}

TEST(Breaches, NameFileLineAndInclude) {
  const std::vector<SourceFile> files = {{"core/a.h", {{3, "vector", false}, {5, "server/b.h", true}}},
                                         {"core/c.cc", {{1, "grpcpp/channel.h", false}}}};
  EXPECT_THAT(Breaches(files, [](const SourceFile& file, const Include& include) { return include.path != "vector"; }),
              ElementsAre("core/a.h:5: includes \"server/b.h\"", "core/c.cc:1: includes <grpcpp/channel.h>"));
}

TEST(FilesBelow, ReadsTheCheckout) {
  const std::vector<SourceFile> files = FilesBelow({"core/base/testing", "tests/house"});
  const auto found = std::find_if(files.begin(), files.end(),
                                  [](const SourceFile& file) { return file.path == "tests/house/includes.h"; });
  ASSERT_NE(found, files.end());
  EXPECT_EQ(files.front().path, "core/base/testing/fake_clock.h");
  std::vector<std::string> paths;
  for (const Include& include : found->includes) paths.push_back(include.path);
  EXPECT_THAT(paths, ElementsAre("functional", "string", "vector"));
}

TEST(ReachedFrom, FollowsHeadersOfTheCheckout) {
  std::vector<std::string> ways;
  for (const Reached& reached : ReachedFrom("core/base/testing/source_path.cc")) ways.push_back(WayTo(reached));
  EXPECT_THAT(ways, ElementsAre("core/base/testing/source_path.cc > core/base/testing/source_path.h",
                                "core/base/testing/source_path.cc > core/base/testing/source_path.h > string",
                                "core/base/testing/source_path.cc > core/base/testing/source_path.h > string_view"));
}

// ---- the rules

bool IsAnyOf(const std::string& path, const std::vector<std::string>& folders) {
  return std::any_of(folders.begin(), folders.end(), [&](const std::string& folder) { return IsBelow(path, folder); });
}

TEST(Walls, CoreKnowsNothingAboveIt) {
  EXPECT_THAT(Breaches(FilesBelow({"core"}),
                       [](const SourceFile& file, const Include& include) {
                         return IsAnyOf(include.path, {"axiscal", "client", "google", "grpc", "grpcpp", "proto",
                                                       "server", "spdlog"}) ||
                                include.path == "sqlite3.h";
                       }),
              IsEmpty());
}

// A std::mutex is unknown to the analysis that proves the locks (tests/locks).
TEST(Walls, LocksAreThoseThatAreProved) {
  EXPECT_THAT(Breaches(FilesBelow({"core", "proto", "server", "client"}),
                       [](const SourceFile& file, const Include& include) {
                         return (include.path == "mutex" || include.path == "shared_mutex" ||
                                 include.path == "condition_variable") &&
                                file.path != "core/base/mutex.h" && !file.path.ends_with("_test.cc");
                       }),
              IsEmpty());
}

}  // namespace
}  // namespace axiscal::house
