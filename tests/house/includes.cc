#include "tests/house/includes.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <deque>
#include <filesystem>
#include <regex>
#include <set>
#include <sstream>

#include "absl/strings/str_cat.h"
#include "absl/strings/str_join.h"
#include "core/base/files.h"
#include "core/base/testing/source_path.h"

namespace axiscal::house {
namespace {

namespace fs = std::filesystem;

constexpr size_t kMaxBytes = 10 << 20;

std::vector<Include> IncludesOfFile(const std::string& path) {
  const absl::StatusOr<std::string> text = base::ReadFile(base::SourcePath("/" + path), kMaxBytes);
  if (text.ok()) return IncludesOf(*text);
  ADD_FAILURE() << text.status();
  return {};
}

bool IsSource(const fs::path& path) { return path.extension() == ".h" || path.extension() == ".cc"; }

}  // namespace

std::vector<Include> IncludesOf(const std::string& text) {
  static const std::regex form(R"~(\s*#\s*include\s*(?:"([^"]+)"|<([^>]+)>).*)~");
  std::vector<Include> includes;
  std::istringstream lines(text);
  std::string line;
  for (int number = 1; std::getline(lines, line); ++number) {
    std::smatch match;
    if (line.find("include") == std::string::npos || !std::regex_match(line, match, form)) continue;
    includes.push_back({number, match[1].matched ? match[1] : match[2], match[1].matched});
  }
  return includes;
}

std::vector<SourceFile> FilesBelow(const std::vector<std::string>& folders) {
  std::vector<SourceFile> files;
  for (const std::string& folder : folders) {
    const fs::path root = base::SourcePath("/" + folder);
    const size_t before = files.size();
    std::error_code error;
    for (const fs::directory_entry& entry : fs::recursive_directory_iterator(root, error)) {
      if (!IsSource(entry.path())) continue;
      const std::string path = absl::StrCat(folder, "/", fs::relative(entry.path(), root).generic_string());
      files.push_back({path, IncludesOfFile(path)});
    }
    EXPECT_GT(files.size(), before) << folder << " holds no source file " << error.message();
  }
  std::sort(files.begin(), files.end(), [](const SourceFile& a, const SourceFile& b) { return a.path < b.path; });
  return files;
}

std::vector<std::string> Breaches(
    const std::vector<SourceFile>& files,
    const std::function<bool(const SourceFile& file, const Include& include)>& is_breach) {
  std::vector<std::string> breaches;
  for (const SourceFile& file : files) {
    for (const Include& include : file.includes) {
      if (!is_breach(file, include)) continue;
      breaches.push_back(absl::StrCat(file.path, ":", include.line, ": includes ", include.is_quoted ? "\"" : "<",
                                      include.path, include.is_quoted ? "\"" : ">"));
    }
  }
  return breaches;
}

bool IsBelow(const std::string& path, const std::string& folder) { return path.rfind(folder + "/", 0) == 0; }

std::vector<Reached> ReachedFrom(const std::string& path) {
  std::vector<Reached> reached;
  std::set<std::string> met = {path};
  std::deque<Reached> to_read = {{path, true, {}}};
  while (!to_read.empty()) {
    const Reached reader = std::move(to_read.front());
    to_read.pop_front();
    for (const Include& include : IncludesOfFile(reader.path)) {
      if (!met.insert(include.path).second) continue;
      Reached next = {include.path, include.is_quoted, reader.by};
      next.by.push_back(reader.path);
      reached.push_back(next);
      if (include.is_quoted && fs::exists(base::SourcePath("/" + include.path))) to_read.push_back(std::move(next));
    }
  }
  return reached;
}

std::string WayTo(const Reached& reached) {
  return absl::StrCat(absl::StrJoin(reached.by, " > "), " > ", reached.path);
}

}  // namespace axiscal::house
