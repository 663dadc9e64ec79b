// The map of docs/architecture.md is the house: each room includes what the map says, and nothing else.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <filesystem>
#include <map>
#include <set>

#include "absl/strings/str_cat.h"
#include "core/base/testing/source_path.h"
#include "tests/house/includes.h"
#include "tests/house/page.h"

namespace axiscal::house {
namespace {

using ::testing::ElementsAre;
using ::testing::IsEmpty;

struct Room {
  std::string folder;                  // "core/machine"
  std::vector<std::string> may_enter;  // folders of the rooms whose headers it may include
};

// In the order of the map. A room of core may be named without "core/".
std::vector<Room> RoomsOf(const std::string& page) {
  std::vector<Room> rooms;
  std::set<std::string> folders;
  for (const std::vector<std::string>& row : TableRows(Section(page, "## The map"))) {
    Room room;
    const std::vector<std::string> name = row.size() == 3 ? Quoted(row[0]) : std::vector<std::string>();
    if (name.size() != 1) {
      ADD_FAILURE() << "a row of the map is not `room` | what | includes: " << ::testing::PrintToString(row);
      continue;
    }
    room.folder = name[0];
    folders.insert(room.folder);
    for (const std::string& word : Quoted(row[2]))
      room.may_enter.push_back(folders.contains("core/" + word) ? "core/" + word : word);
    rooms.push_back(room);
  }
  return rooms;
}

// The room with the longest folder that `path` is below; "" for headers of libraries. Generated messages belong to the
// room of their .proto files.
std::string RoomOf(const std::vector<Room>& rooms, const std::string& path) {
  if (IsBelow(path, "axiscal/v1")) return RoomOf(rooms, "proto/" + path);
  std::string longest;
  for (const Room& room : rooms) {
    if (IsBelow(path, room.folder) && room.folder.size() > longest.size()) longest = room.folder;
  }
  return longest;
}

bool IsProduct(const SourceFile& file) {
  return file.path.find("/testing/") == std::string::npos && !file.path.ends_with("_test.cc");
}

bool MayEnter(const std::vector<Room>& rooms, const std::string& from, const std::string& to) {
  return std::any_of(rooms.begin(), rooms.end(), [&](const Room& room) {
    return room.folder == from &&
           std::find(room.may_enter.begin(), room.may_enter.end(), to) != room.may_enter.end();
  });
}

// Includes for which the map has no arrow.
std::vector<std::string> AgainstTheMap(const std::vector<Room>& rooms, const std::vector<SourceFile>& files) {
  return Breaches(files, [&](const SourceFile& file, const Include& include) {
    if (!IsProduct(file) || !include.is_quoted) return false;
    const std::string from = RoomOf(rooms, file.path), to = RoomOf(rooms, include.path);
    return !to.empty() && from != to && !MayEnter(rooms, from, to);
  });
}

// Arrows of the map that no include needs: "core/nc -> core/machine".
std::vector<std::string> Unused(const std::vector<Room>& rooms, const std::vector<SourceFile>& files) {
  std::set<std::pair<std::string, std::string>> used;
  for (const SourceFile& file : files) {
    if (!IsProduct(file)) continue;
    for (const Include& include : file.includes) used.emplace(RoomOf(rooms, file.path), RoomOf(rooms, include.path));
  }
  std::vector<std::string> unused;
  for (const Room& room : rooms) {
    for (const std::string& to : room.may_enter) {
      if (!used.contains({room.folder, to})) unused.push_back(absl::StrCat(room.folder, " -> ", to));
    }
  }
  return unused;
}

// Arrows that do not point to a row above.
std::vector<std::string> NotUpwards(const std::vector<Room>& rooms) {
  std::set<std::string> above;
  std::vector<std::string> wrong;
  for (const Room& room : rooms) {
    for (const std::string& to : room.may_enter) {
      if (!above.contains(to)) wrong.push_back(absl::StrCat(room.folder, " -> ", to));
    }
    above.insert(room.folder);
  }
  return wrong;
}

// ---- the comparison itself

constexpr char kPage[] =
    "## The map\n\n| room | what | includes |\n|---|---|---|\n"
    "| `core/base` | b | |\n| `core/nc` | n | `base` |\n| `proto/axiscal/v1` | w | |\n"
    "| `server` | s | `nc`, `proto/axiscal/v1` |\n\n"
    "## Another\n\n| `not` | a | `room` |\n";

TEST(Map, AnIncludeWithoutArrowIsFound) {
  const std::vector<Room> rooms = RoomsOf(kPage);
  const std::vector<SourceFile> files = {
      {"core/base/a.h", {{3, "core/nc/b.h", true}, {4, "vector", false}, {5, "absl/x.h", true}}},
      {"core/base/a_test.cc", {{1, "server/s.h", true}}},
      {"server/s.cc", {{1, "core/base/a.h", true}, {2, "core/nc/b.h", true}, {3, "axiscal/v1/job.pb.h", true}}}};
  EXPECT_THAT(AgainstTheMap(rooms, files), ElementsAre("core/base/a.h:3: includes \"core/nc/b.h\"",
                                                       "server/s.cc:1: includes \"core/base/a.h\""));
}

TEST(Map, AnArrowWithoutIncludeIsFound) {
  const std::vector<SourceFile> files = {{"core/nc/b_test.cc", {{1, "core/base/a.h", true}}},
                                         {"server/s.cc", {{2, "core/nc/b.h", true}}}};
  EXPECT_THAT(Unused(RoomsOf(kPage), files), ElementsAre("core/nc -> core/base", "server -> proto/axiscal/v1"));
}

TEST(Map, AnArrowDownwardsIsFound) {
  const std::vector<Room> rooms = {{"core/a", {"core/b"}}, {"core/b", {"core/a"}}, {"core/c", {"core/c"}}};
  EXPECT_THAT(NotUpwards(rooms), ElementsAre("core/a -> core/b", "core/c -> core/c"));
}

// ---- the page

class ThePage : public ::testing::Test {
 protected:
  const std::vector<Room> rooms_ = RoomsOf(ReadPage("docs/architecture.md"));
  const std::vector<SourceFile> files_ = FilesBelow({"core", "proto/convert", "proto/guard", "server", "client"});
};

TEST_F(ThePage, HasARoomForEveryFolder) {
  std::set<std::string> with_files, without_room;
  for (const SourceFile& file : files_) {
    const std::string room = RoomOf(rooms_, file.path);
    (room.empty() ? without_room.insert(file.path) : with_files.insert(room));
  }
  EXPECT_THAT(without_room, IsEmpty());
  for (const Room& room : rooms_) {
    if (room.folder == "proto/axiscal/v1") continue;  // messages: no source file
    EXPECT_TRUE(with_files.contains(room.folder)) << room.folder << " is on the map and holds no source file";
  }
}

TEST_F(ThePage, EveryIncludeIsAnArrow) { EXPECT_THAT(AgainstTheMap(rooms_, files_), IsEmpty()); }

TEST_F(ThePage, EveryArrowIsAnInclude) { EXPECT_THAT(Unused(rooms_, files_), IsEmpty()); }

TEST_F(ThePage, NoCircles) { EXPECT_THAT(NotUpwards(rooms_), IsEmpty()); }

}  // namespace
}  // namespace axiscal::house
