#include "client/cell/watcher.h"

#include <fnmatch.h>
#include <sys/stat.h>

#include <algorithm>
#include <filesystem>
#include <fstream>
#include <set>

#include "absl/strings/numbers.h"

namespace axiscal::cell {
namespace {

namespace fs = std::filesystem;

}  // namespace

// "SIZE TIME PATH", a line each: a path with a line end in it is not kept, and read again after a restart.
std::string WriteKnown(const KnownFiles& known) {
  std::string text;
  for (const auto& [path, look] : known) {
    if (path.find('\n') == std::string::npos)
      absl::StrAppend(&text, look.size_bytes, " ", look.changed_ns, " ", path, "\n");
  }
  return text;
}

KnownFiles ReadKnown(const std::string& text) {
  KnownFiles known;
  for (size_t at = 0; at < text.size();) {
    const size_t end = text.find('\n', at), first = text.find(' ', at);
    const size_t second = first == std::string::npos ? first : text.find(' ', first + 1);
    if (end == std::string::npos || second == std::string::npos || second > end) return {};
    Look look;
    if (!absl::SimpleAtoi(text.substr(at, first - at), &look.size_bytes) ||
        !absl::SimpleAtoi(text.substr(first + 1, second - first - 1), &look.changed_ns))
      return {};
    known[text.substr(second + 1, end - second - 1)] = look;
    at = end + 1;
  }
  return known;
}

Look FolderWatcher::LookAt(const std::string& path) {
  struct stat info;
  if (stat(path.c_str(), &info) != 0 || !S_ISREG(info.st_mode)) return {-1, 0};
  return {info.st_size, int64_t{info.st_mtim.tv_sec} * 1'000'000'000 + info.st_mtim.tv_nsec};
}

bool FolderWatcher::IsMeant(const std::string& name) const {
  if (name.starts_with(".") || name.ends_with("~")) return false;
  if (name.ends_with(".tmp") || name.ends_with(".part")) return false;
  return fnmatch(watch_.files.c_str(), name.c_str(), 0) == 0;
}

// Whether its last line that is not blank is the one that ends a file.
bool FolderWatcher::HasEnd(const std::string& path) const {
  if (watch_.end_line.empty()) return true;
  std::ifstream in(path, std::ios::binary | std::ios::ate);
  if (!in) return false;
  const std::streamoff size = in.tellg(), tail = static_cast<std::streamoff>(watch_.end_line.size()) + 64;
  in.seekg(std::max<std::streamoff>(0, size - tail));
  std::string text((std::istreambuf_iterator<char>(in)), std::istreambuf_iterator<char>());
  while (!text.empty() && (text.back() == '\n' || text.back() == '\r' || text.back() == ' ')) text.pop_back();
  if (!text.ends_with(watch_.end_line)) return false;
  text.resize(text.size() - watch_.end_line.size());
  return text.empty() || text.back() == '\n';
}

Found FolderWatcher::LookThrough(base::SteadyTime now, KnownFiles& known) {
  Found found;
  std::set<std::string> there;
  std::vector<std::pair<int64_t, std::string>> whole;
  std::error_code error;
  for (fs::directory_iterator it(watch_.folder, error), end; !error && it != end; it.increment(error)) {
    const std::string path = it->path().string();
    if (!IsMeant(it->path().filename().string())) continue;
    const Look look = LookAt(path);
    if (look.size_bytes < 0) continue;
    there.insert(path);
    const auto old = known.find(path);
    if (old != known.end() && old->second == look) continue;
    Seen& seen = seen_.try_emplace(path, Seen{look, now}).first->second;
    if (!(seen.look == look)) seen = {look, now};
    const bool has_settled = look.size_bytes > 0 && now - seen.since >= settle_;
    const bool is_whole = has_settled && HasEnd(path);
    if (is_whole) {
      whole.emplace_back(look.changed_ns, path);
    } else {
      ++found.growing;
      found.without_end += has_settled ? 1 : 0;
    }
  }
  if (error) {
    // A mount that is away: what was known of its files still holds.
    found.status = absl::UnavailableError(absl::StrCat(watch_.folder, ": ", error.message()));
    return found;
  }
  std::erase_if(seen_, [&](const auto& seen) { return there.count(seen.first) == 0; });
  const fs::path folder = fs::path(watch_.folder + "/x").parent_path();
  std::erase_if(known, [&](const auto& file) {
    const fs::path path(file.first);
    return path.parent_path() == folder && IsMeant(path.filename().string()) && there.count(file.first) == 0;
  });
  std::sort(whole.begin(), whole.end());
  for (auto& [changed_ns, path] : whole) found.whole.push_back(std::move(path));
  return found;
}

}  // namespace axiscal::cell
