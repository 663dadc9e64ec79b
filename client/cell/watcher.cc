#include "client/cell/watcher.h"

#include <fcntl.h>
#include <fnmatch.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <set>
#include <tuple>

#include "absl/strings/numbers.h"

namespace axiscal::cell {
namespace {

namespace fs = std::filesystem;

// Size -1 where it is no file.
Look LookOf(const struct stat& info) {
  if (!S_ISREG(info.st_mode)) return {-1, 0};
  return {info.st_size, int64_t{info.st_mtim.tv_sec} * 1'000'000'000 + info.st_mtim.tv_nsec};
}

// What is at `descriptor` must still be as `look`.
absl::Status MustLook(int descriptor, const std::string& path, const Look& look) {
  struct stat info;
  if (fstat(descriptor, &info) == 0 && LookOf(info) == look) return absl::OkStatus();
  return absl::UnavailableError(path + ": is being written again");
}

}  // namespace

absl::StatusOr<std::string> ReadAsFound(const std::string& path, const Look& look) {
  // What has become a link or a pipe since is neither followed nor waited for.
  const int descriptor = open(path.c_str(), O_RDONLY | O_NOFOLLOW | O_NONBLOCK | O_CLOEXEC);
  if (descriptor < 0) {
    const std::string what = absl::StrCat(path, ": ", std::strerror(errno));
    if (errno == ENOENT || errno == ELOOP || errno == ENXIO) return absl::UnavailableError(what);
    return absl::FailedPreconditionError(what);
  }
  const auto read_all = [&]() -> absl::StatusOr<std::string> {
    RETURN_IF_ERROR(MustLook(descriptor, path, look));
    std::string bytes(static_cast<size_t>(look.size_bytes), '\0');
    for (size_t at = 0; at < bytes.size();) {
      const ssize_t count = read(descriptor, bytes.data() + at, bytes.size() - at);
      if (count < 0 && errno == EINTR) continue;
      if (count < 0) return absl::FailedPreconditionError(absl::StrCat(path, ": ", std::strerror(errno)));
      if (count == 0) return absl::UnavailableError(path + ": is being written again");
      at += static_cast<size_t>(count);
    }
    RETURN_IF_ERROR(MustLook(descriptor, path, look));
    return bytes;
  };
  absl::StatusOr<std::string> bytes = read_all();
  close(descriptor);
  return bytes;
}

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
  return lstat(path.c_str(), &info) == 0 ? LookOf(info) : Look{-1, 0};
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
  std::vector<std::pair<std::string, Look>> whole;
  std::error_code error;
  for (fs::directory_iterator it(watch_.folder, error), end; !error && it != end; it.increment(error)) {
    const std::string path = it->path().string();
    if (!IsMeant(it->path().filename().string())) continue;
    const Look look = LookAt(path);
    if (look.size_bytes < 0) {
      std::error_code ignored;
      found.links += it->is_symlink(ignored) ? 1 : 0;
      continue;
    }
    there.insert(path);
    const auto old = known.find(path);
    if (old != known.end() && old->second == look) continue;
    Seen& seen = seen_.try_emplace(path, Seen{look, now}).first->second;
    if (!(seen.look == look)) seen = {look, now};
    const bool has_settled = now - seen.since >= settle_;
    if (look.size_bytes == 0 && has_settled) continue;  // there is nothing to send, and nothing is known to come
    const bool is_whole = has_settled && HasEnd(path);
    if (is_whole) {
      whole.emplace_back(path, look);
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
  std::sort(whole.begin(), whole.end(), [](const auto& a, const auto& b) {
    return std::tie(a.second.changed_ns, a.first) < std::tie(b.second.changed_ns, b.first);
  });
  for (auto& [path, look] : whole) {
    found.whole.push_back(std::move(path));
    found.looks.push_back(look);
  }
  return found;
}

}  // namespace axiscal::cell
