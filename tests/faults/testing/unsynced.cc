#include "tests/faults/testing/unsynced.h"

#include <fcntl.h>
#include <sys/syscall.h>
#include <unistd.h>

#include <algorithm>
#include <filesystem>
#include <fstream>
#include <utility>

#include "core/base/demand.h"

namespace axiscal::testing {
namespace {

constexpr int64_t kSectorBytes = 512;
constexpr unsigned kExchange = 1u << 1;  // RENAME_EXCHANGE

// The system's own, as in Keep(): rename() and link() are operations of the disk in this process.
void Rename(const std::string& from, const std::string& to, unsigned flags = 0) {
  DEMAND(syscall(SYS_renameat2, AT_FDCWD, from.c_str(), AT_FDCWD, to.c_str(), flags) == 0);
}

// As the system names it.
std::string FolderOf(const std::string& path) {
  return std::filesystem::canonical(std::filesystem::absolute(path).parent_path()).string();
}

// Puts back what one write has replaced, wholly or in some sectors.
void TakeBackBytes(const std::string& path, const Replaced& replaced, std::mt19937& random) {
  const int how = static_cast<int>(random() % 4);
  if (how == 0) return;  // it had reached the disk
  std::fstream file(path, std::ios::in | std::ios::out | std::ios::binary);
  if (!file) return;
  std::string old_bytes = replaced.old_bytes;
  old_bytes.resize(static_cast<size_t>(replaced.end - replaced.offset), '\0');
  const int64_t size = static_cast<int64_t>(std::filesystem::file_size(path));
  for (int64_t at = replaced.offset; at < replaced.end; at += kSectorBytes - at % kSectorBytes) {
    if (how == 1 && random() % 2 == 0) continue;
    const int64_t end = std::min(replaced.end, at + kSectorBytes - at % kSectorBytes);
    file.seekp(at);
    file.write(old_bytes.data() + (at - replaced.offset), end - at);
  }
  file.close();
  const bool was_last = size <= replaced.end;
  if (how != 1 && was_last && replaced.old_size < replaced.end)
    std::filesystem::resize_file(path, static_cast<uintmax_t>(std::max(replaced.old_size, replaced.offset)));
}

}  // namespace

void Unsynced::Forget(const Name& name) {
  if (!name.kept.empty()) std::filesystem::remove(name.kept);
}

void Unsynced::Clear() {
  std::for_each(names_.begin(), names_.end(), &Forget);
  names_.clear();
  bytes_.clear();
}

void Unsynced::Wrote(const std::string& path, Replaced replaced) { bytes_[path].push_back(std::move(replaced)); }

void Unsynced::SyncedFile(const std::string& path) { bytes_.erase(path); }

void Unsynced::SyncedFolderOf(const std::string& path) { SyncedFolder(FolderOf(path)); }

void Unsynced::SyncedFolder(const std::string& folder) {
  std::erase_if(names_, [&](const Name& name) {
    const bool is_there = FolderOf(name.path) == folder;
    if (is_there) Forget(name);
    return is_there;
  });
}

std::string Unsynced::Keep(const std::string& path) {
  if (!std::filesystem::exists(path)) return "";
  const std::string kept = path + "~kept" + std::to_string(++kept_);
  DEMAND(syscall(SYS_linkat, AT_FDCWD, path.c_str(), AT_FDCWD, kept.c_str(), 0) == 0);
  return kept;
}

void Unsynced::Made(const std::string& path) { names_.push_back({Name::Kind::kMade, path, "", ""}); }

void Unsynced::Exchanged(const std::string& a, const std::string& b) {
  std::swap(bytes_[a], bytes_[b]);
  names_.push_back({Name::Kind::kExchanged, a, b, ""});
}

void Unsynced::WillRename(const std::string& from, const std::string& to) {
  names_.push_back({Name::Kind::kRenamed, from, to, Keep(to)});
  // What was written to either has the new name; what is kept counts as synced.
  bytes_[to] = std::exchange(bytes_[from], {});
}

void Unsynced::WillRemove(const std::string& path) {
  names_.push_back({Name::Kind::kRemoved, path, "", Keep(path)});
  bytes_.erase(path);
}

void Unsynced::UndoLast() {
  Forget(names_.back());
  names_.pop_back();
}

void Unsynced::TakeBackName(const Name& name) {
  switch (name.kind) {
    case Name::Kind::kMade:
      std::filesystem::remove(name.path);
      return;
    case Name::Kind::kExchanged:
      Rename(name.path, name.to, kExchange);
      return;
    case Name::Kind::kRenamed:
      Rename(name.to, name.path);
      if (!name.kept.empty()) Rename(name.kept, name.to);
      return;
    case Name::Kind::kRemoved:
      if (!name.kept.empty()) Rename(name.kept, name.path);
      return;
  }
}

void Unsynced::TakeBack(std::mt19937& random) {
  for (auto& [path, all] : bytes_) {
    for (auto replaced = all.rbegin(); replaced != all.rend(); ++replaced) TakeBackBytes(path, *replaced, random);
    // Memory that the processes had in common.
    if (path.ends_with("-wal")) std::filesystem::remove(path.substr(0, path.size() - 4) + "-shm");
  }
  for (size_t lost = random() % (names_.size() + 1); lost > 0; --lost) {
    TakeBackName(names_.back());
    names_.pop_back();
  }
  Clear();
}

}  // namespace axiscal::testing
