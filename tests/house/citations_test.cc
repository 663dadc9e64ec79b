// Comments and documents cite files that are there.
#include "tests/house/citations.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <filesystem>
#include <set>

#include "core/base/testing/source_path.h"
#include "tests/house/page.h"

namespace axiscal::house {
namespace {

namespace fs = std::filesystem;

using ::testing::ElementsAre;

// ---- the reader

TEST(CommentsOf, LeavesCodeAndStringsOut) {
  EXPECT_EQ(CommentsOf("int a;  // see b.h\nf(\"// c.h\", '\"');  // d.h\nint e = 1'000;  // f.h\n"),
            "        // see b.h\n"
            "                   // d.h\n"
            "                // f.h\n");
}

TEST(HashCommentsOf, KeepsLines) { EXPECT_EQ(HashCommentsOf("a b.cc\nc  # d.cc\n"), "      \n   # d.cc\n"); }

TEST(CitationsIn, AreFilesAndPathsOfTheCheckout) {
  EXPECT_THAT(CitationsIn("// As a.h and (docs/b.md, \"C\"): c_*.cc, d.{h,cc}.\n"
                          "// core/plan, machine.json, 3.5 mm/s, {1, 2}, x.pb.h, *.h, tests/run.\n"
                          "[page](e.svg) [net](https://x.org/f.h) of client/server\n"),
              ElementsAre(Citation{1, "a.h"}, Citation{1, "docs/b.md"}, Citation{1, "c_*.cc"}, Citation{1, "d.{h,cc}"},
                          Citation{2, "core/plan"}, Citation{2, "tests/run"}, Citation{3, "e.svg"},
                          Citation{3, "client/server"}));
}

TEST(IsThere, FromTheFolderOrOneAboveIt) {
  const std::set<std::string> paths = {"core", "core/a", "core/a/x.h", "core/b", "core/b/y.h", "docs/z.md"};
  const auto exists = [&](const std::string& pattern) {
    return std::any_of(paths.begin(), paths.end(), [&](const std::string& path) { return Fits(path, pattern); });
  };
  EXPECT_TRUE(IsThere("x.h", "core/a/q.cc", exists));
  EXPECT_TRUE(IsThere("b/y.h", "core/a/q.cc", exists));
  EXPECT_TRUE(IsThere("core/b/*.h", "README.md", exists));
  EXPECT_TRUE(IsThere("docs/z.md", "core/a/q.cc", exists));
  EXPECT_FALSE(IsThere("y.h", "core/a/q.cc", exists));
  EXPECT_FALSE(IsThere("z.md", "core/a/q.cc", exists));
  EXPECT_FALSE(IsThere("x.{h,cc}", "core/a/q.cc", exists));
  EXPECT_FALSE(IsThere("core/*.h", "README.md", exists));
}

// ---- the checkout

// Files and folders of the checkout from its root, without what is built; data is not read, but for its documents.
struct Tree {
  std::set<std::string> all;
  std::vector<std::string> to_read;

  Tree() {
    const fs::path root = base::SourcePath("");
    for (auto entry = fs::recursive_directory_iterator(root); entry != fs::recursive_directory_iterator(); ++entry) {
      const std::string path = entry->path().lexically_relative(root).generic_string();
      if (path == "build" || path == ".git") {
        entry.disable_recursion_pending();
        continue;
      }
      all.insert(path);
      if (entry->is_regular_file() && (path.ends_with(".md") || !IsData(path))) to_read.push_back(path);
    }
  }

  // Its texts are no comments of ours; neither are those of others, nor the made-up names of these tests.
  static bool IsData(const std::string& path) {
    for (const char* folder : {"tests/data/", "tests/fuzz/corpus/", "tests/house/", "proto/third_party/"})
      if (path.starts_with(folder)) return true;
    return false;
  }

  bool Exists(const std::string& pattern) const {
    if (pattern.find('*') == std::string::npos) return all.contains(pattern);
    return std::any_of(all.begin(), all.end(), [&](const std::string& path) { return Fits(path, pattern); });
  }
};

// The part of a file in which names are citations.
std::string ReadableText(const std::string& path) {
  if (path.ends_with(".md")) return ReadPage(path);
  if (path.ends_with(".h") || path.ends_with(".cc") || path.ends_with(".proto")) return CommentsOf(ReadPage(path));
  if (path.ends_with("CMakeLists.txt") || path.ends_with(".cmake")) return HashCommentsOf(ReadPage(path));
  return "";
}

// Files of others, and names that stand for any file.
const std::set<std::string>& Others() {
  static const std::set<std::string>& names = *new std::set<std::string>{
      "usrmotintf.cc",  // LinuxCNC
      "NNNN_name.sql", "tests/migrations/vNNNN.sql", "a.cc", "a_test.cc", "a.sql", "b.sql", "a.proto",
  };
  return names;
}

TEST(Citations, AreThere) {
  const Tree tree;
  ASSERT_GT(tree.to_read.size(), 500u);
  const auto exists = [&](const std::string& pattern) { return tree.Exists(pattern); };
  size_t citations = 0;
  for (const std::string& path : tree.to_read) {
    for (const Citation& citation : CitationsIn(ReadableText(path))) {
      ++citations;
      EXPECT_TRUE(Others().contains(citation.name) || IsThere(citation.name, path, exists))
          << path << ":" << citation.line << ": there is no " << citation.name;
    }
  }
  EXPECT_GT(citations, 300u);
}

}  // namespace
}  // namespace axiscal::house
