// Whoever handles a failed call finds its reason in proto/README.md.
#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>
#include <regex>
#include <set>
#include <sstream>

#include "core/base/testing/source_path.h"
#include "tests/house/page.h"

namespace axiscal::house {
namespace {

namespace fs = std::filesystem;

// Reasons as a source names them: a text of capitals with at least one underscore. Environment variables are no
// reasons.
std::set<std::string> ReasonsIn(const std::string& source) {
  static const std::regex reason("\"([A-Z]+(_[A-Z]+)+)\"");
  // Variables of the environment are written likewise.
  static const std::regex variable("getenv\\(\"[A-Z_]+\"\\)");
  const std::string text = std::regex_replace(source, variable, "");
  std::set<std::string> found;
  for (std::sregex_iterator match(text.begin(), text.end(), reason), end; match != end; ++match) {
    if (!std::regex_search((*match)[1].str(), std::regex("^AXISCALD?_"))) found.insert((*match)[1]);
  }
  return found;
}

// Where errors of calls and jobs are made.
std::set<std::string> ReasonsInTree() {
  std::set<std::string> found;
  for (const std::string folder : {"server", "client", "proto/convert", "core/base", "core/records"}) {
    for (const fs::directory_entry& entry : fs::recursive_directory_iterator(base::SourcePath("/") + folder)) {
      const std::string path = entry.path().string(), name = entry.path().filename().string();
      const bool is_source = name.ends_with(".cc") || name.ends_with(".h");
      if (!is_source || name.ends_with("_test.cc") || path.find("/testing/") != std::string::npos) continue;
      std::ostringstream text;
      text << std::ifstream(path).rdbuf();
      found.merge(ReasonsIn(text.str()));
    }
  }
  return found;
}

TEST(ReasonsIn, AreTextsOfCapitals) {
  EXPECT_EQ(ReasonsIn("Refuse(\"a b\", \"SEQ_GAP\"); {\"CHUNK_INVALID\", {}}; std::getenv(\"NOTIFY_SOCKET\"); "
                      "Env(\"AXISCAL_DB\"); \"DONE\""),
            (std::set<std::string>{"CHUNK_INVALID", "SEQ_GAP"}));
}

TEST(Reasons, StandInTheReadmeOfTheApi) {
  const std::string errors = Section(ReadPage("proto/README.md"), "## Errors");
  const std::set<std::string> reasons = ReasonsInTree();
  EXPECT_GT(reasons.size(), 40u);
  for (const std::string& reason : reasons) {
    EXPECT_TRUE(std::regex_search(errors, std::regex("\\b" + reason + "\\b"))) << reason;
  }
}

}  // namespace
}  // namespace axiscal::house
