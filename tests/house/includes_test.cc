// The walls between the rooms: who may include whom. A rule is one test here.
#include "tests/house/includes.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <set>
#include <iterator>

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

TEST(Walls, WireAndClientKnowNothingOfTheServer) {
  EXPECT_THAT(Breaches(FilesBelow({"client", "proto"}),
                       [](const SourceFile& file, const Include& include) {
                         return IsBelow(include.path, "server") && file.path != "client/cli/embedded.cc";
                       }),
              IsEmpty());
}

TEST(Walls, ClientHeadersReachCoreAndStandardHeadersOnly) {
  // The two that hold the channel and the stubs, for the client's own sources.
  const std::vector<std::string> internal = {"client/client_impl.h", "client/connection.h"};
  const auto is_fine = [](const Reached& reached) {
    if (reached.is_quoted) return IsAnyOf(reached.path, {"absl", "client", "core"});
    return reached.path.find_first_of("./") == std::string::npos || IsBelow(reached.path, "Eigen");
  };
  std::vector<std::string> ways;
  int headers = 0;
  for (const SourceFile& file : FilesBelow({"client"})) {
    const bool is_header = file.path.size() > 2 && file.path.substr(file.path.size() - 2) == ".h";
    if (!is_header || IsBelow(file.path, "client/cli")) continue;
    if (std::find(internal.begin(), internal.end(), file.path) != internal.end()) continue;
    ++headers;
    for (const Reached& reached : ReachedFrom(file.path)) {
      if (!is_fine(reached)) ways.push_back(WayTo(reached));
    }
  }
  EXPECT_THAT(ways, IsEmpty());
  EXPECT_GE(headers, 2);  // client.h and options.h
}

// service -> handlers -> jobs -> inputs -> storage.
TEST(Walls, RoomsOfTheServerLookDownOnly) {
  const auto breaches = [](const std::string& room, const std::vector<std::string>& above) {
    return Breaches(FilesBelow({room}), [&](const SourceFile&, const Include& include) {
      return IsAnyOf(include.path, above) || include.path == "server/service.h" || include.path == "server/server.h";
    });
  };
  EXPECT_THAT(breaches("server/handlers", {}), IsEmpty());
  EXPECT_THAT(breaches("server/jobs", {"server/handlers"}), IsEmpty());
  EXPECT_THAT(breaches("server/inputs", {"server/handlers", "server/jobs"}), IsEmpty());
  EXPECT_THAT(breaches("server/storage", {"server/handlers", "server/jobs", "server/inputs", "proto", "axiscal"}),
              IsEmpty());
}

// A file of the product, not of its tests.
bool IsProduct(const std::string& path) {
  return !path.ends_with("_test.cc") && path.find("/testing/") == std::string::npos;
}

// Files that include nlohmann/json, themselves or through a header of the checkout.
std::vector<std::string> FilesWithJson(const std::vector<SourceFile>& files) {
  std::set<std::string> with_json;
  for (size_t before = std::string::npos; before != with_json.size();) {
    before = with_json.size();
    for (const SourceFile& file : files) {
      const bool has_json = std::any_of(file.includes.begin(), file.includes.end(), [&](const Include& include) {
        return IsBelow(include.path, "nlohmann") || with_json.contains(include.path);
      });
      if (has_json) with_json.insert(file.path);
    }
  }
  std::vector<std::string> product;
  std::copy_if(with_json.begin(), with_json.end(), std::back_inserter(product), IsProduct);
  return product;
}

TEST(FilesWithJson, AreFoundThroughHeaders) {
  const std::vector<SourceFile> files = {{"core/a.h", {{1, "core/b.h", true}}},
                                         {"core/a_test.cc", {{1, "nlohmann/json.hpp", false}}},
                                         {"core/b.h", {{1, "nlohmann/json_fwd.hpp", false}}},
                                         {"core/c.cc", {{1, "core/a.h", true}}},
                                         {"core/d.cc", {{1, "core/json.h", true}}}};
  EXPECT_THAT(FilesWithJson(files), ElementsAre("core/a.h", "core/b.h", "core/c.cc"));
}

// JSON is read and written here and nowhere else; all others use the types that these files fill. A reader or writer of
// a new format is added to the list, a search in a report is not.
TEST(Walls, OnlyReadersAndWritersIncludeJson) {
  EXPECT_THAT(FilesWithJson(FilesBelow({"client", "core", "proto", "server"})),
              ElementsAre("client/cell/status.cc",                    // the status file
                          "client/cli/json.cc",                       //
                          "client/spool/entry.cc",                    // entries of a spool
                          "core/base/json_members.h",                 // members of a struct, told once for both ways
                          "core/base/strict_json.cc",                 //
                          "core/base/strict_json.h",                  //
                          "core/compare/side_json.cc",                //
                          "core/compensate/tables/formats_json.cc",   //
                          "core/identify/budget_json.cc",             //
                          "core/identify/held_json.cc",               //
                          "core/machine/error_covariance.cc",         //
                          "core/machine/error_covariance_json.h",     //
                          "core/machine/error_json.cc",               //
                          "core/machine/error_map_json.cc",           //
                          "core/machine/error_map_json.h",            //
                          "core/machine/machine_json.cc",             //
                          "core/nc/verify_json.cc",                   //
                          "core/reports/calibration_json.cc",         //
                          "core/reports/fitted_json.h",               //
                          "core/reports/identification_json.cc",      //
                          "core/reports/loop_json.cc",                //
                          "core/reports/report_json.h",               //
                          "core/reports/rewrite_json.cc",             //
                          "core/reports/table_json.cc",               //
                          "core/reports/tool_setter_json.cc",         //
                          "core/synthetic/scenario_json.cc",          //
                          "core/toolsetter/cutter_keys.cc",           // cutter.json
                          "server/http/error_json.cc",                // errors of the Connect protocol
                          "server/jobs/asked_json.cc",                // how a calibration was asked for
                          "server/log.cc"));
}

}  // namespace
}  // namespace axiscal::house
