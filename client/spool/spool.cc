#include "client/spool/spool.h"

#include <fcntl.h>
#include <sys/file.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cstring>
#include <filesystem>
#include <system_error>

#include "absl/strings/numbers.h"
#include "core/base/error_detail.h"
#include "core/base/files.h"
#include "core/base/sha256.h"

namespace axiscal::spool {
namespace {

namespace fs = std::filesystem;

constexpr size_t kMaxEntryBytes = size_t{1} << 20;
constexpr size_t kNumberDigits = 12;  // of "%012d"
constexpr char kContent[] = "content", kEntry[] = "entry.json", kTemplate[] = "template", kPlan[] = "plan";
constexpr char kReason[] = "reason.json", kReceipt[] = "receipt.json";

absl::Status Failure(const std::string& path, int error) {
  const std::string what = absl::StrCat(path, ": ", std::strerror(error));
  if (error == ENOENT) return absl::NotFoundError(what);
  if (error == ENOSPC || error == EDQUOT) return absl::ResourceExhaustedError(what);
  return absl::FailedPreconditionError(what);
}

absl::Status Sync(const std::string& folder) {
  const int handle = open(folder.c_str(), O_RDONLY | O_DIRECTORY | O_CLOEXEC);
  if (handle < 0) return Failure(folder, errno);
  const int result = fsync(handle), error = errno;
  close(handle);
  return result == 0 ? absl::OkStatus() : Failure(folder, error);
}

absl::Status MakeFolder(const std::string& folder) {
  std::error_code error;
  fs::create_directories(folder, error);
  return error ? Failure(folder, error.value()) : absl::OkStatus();
}

// The rename, and then the two folders, are on the disk.
absl::Status Rename(const fs::path& from, const fs::path& to) {
  if (rename(from.c_str(), to.c_str()) != 0) return Failure(from.string(), errno);
  RETURN_IF_ERROR(Sync(to.parent_path().string()));
  return Sync(from.parent_path().string());
}

// While it lives nobody else changes the spool.
class ChangeLock {
 public:
  static absl::StatusOr<ChangeLock> Take(const std::string& folder) {
    const std::string path = folder + "/lock";
    const int descriptor = open(path.c_str(), O_RDWR | O_CREAT | O_CLOEXEC, 0660);
    if (descriptor < 0) return Failure(path, errno);
    while (flock(descriptor, LOCK_EX) != 0) {
      if (errno == EINTR) continue;
      const int error = errno;
      close(descriptor);
      return Failure(path, error);
    }
    return ChangeLock(descriptor);
  }
  ChangeLock(ChangeLock&& other) noexcept : descriptor_(std::exchange(other.descriptor_, -1)) {}
  ChangeLock& operator=(ChangeLock&&) = delete;
  ~ChangeLock() {
    if (descriptor_ >= 0) close(descriptor_);
  }

 private:
  explicit ChangeLock(int descriptor) : descriptor_(descriptor) {}
  int descriptor_;
};

// "000000000017-<id>".
struct Name {
  int64_t number = 0;
  std::string text;
  std::string id;
};

// Of one place, in order; what bears no such name is not looked at.
absl::StatusOr<std::vector<Name>> NamesIn(const std::string& folder) {
  std::vector<Name> names;
  std::error_code error;
  for (fs::directory_iterator it(folder, error), end; !error && it != end; it.increment(error)) {
    Name name{0, it->path().filename().string(), ""};
    if (name.text.size() != kNumberDigits + 1 + 64 || name.text[kNumberDigits] != '-') continue;
    if (!absl::SimpleAtoi(name.text.substr(0, kNumberDigits), &name.number)) continue;
    name.id = name.text.substr(kNumberDigits + 1);
    names.push_back(std::move(name));
  }
  if (error) return Failure(folder, error.value());
  std::sort(names.begin(), names.end(), [](const Name& a, const Name& b) { return a.text < b.text; });
  return names;
}

int64_t BytesIn(const std::string& folder) {
  int64_t bytes = 0;
  std::error_code error;
  for (fs::directory_iterator it(folder, error), end; !error && it != end; it.increment(error)) {
    const auto size = it->file_size(error);
    if (!error) bytes += static_cast<int64_t>(size);
    error.clear();
  }
  return bytes;
}

absl::Status Damaged(const std::string& path, const std::string& what) {
  return base::Error(absl::StatusCode::kDataLoss, absl::StrCat(path, ": ", what, ": the disk has changed it"),
                     {"SPOOL_DAMAGED", {}});
}

absl::Status Check(const Item& item, const std::string& bytes, int64_t max_bytes) {
  const auto refuse = [&](const std::string& text) {
    return base::Error(absl::StatusCode::kInvalidArgument, absl::StrCat(item.name, ": ", text),
                       {"SPOOL_FILE_INVALID", {}});
  };
  if (item.name.empty() || item.name.find('/') != std::string::npos) return refuse("must be a name without folders");
  if (bytes.empty()) return refuse("is empty");
  if (static_cast<int64_t>(bytes.size()) > max_bytes)
    return refuse(absl::StrCat(bytes.size(), " bytes, at most ", max_bytes, " are taken"));
  if (item.is_log && (item.machine.empty() || item.form.template_text.empty()))
    return refuse("a log needs a machine and a template");
  return absl::OkStatus();
}

// Once the server has what was there: a file that has changed meanwhile stays.
bool RemoveSource(const Entry& entry, int64_t max_bytes) {
  if (!entry.item.removes_source || entry.item.source.empty()) return false;
  const absl::StatusOr<std::string> now = base::ReadFile(entry.item.source, static_cast<size_t>(max_bytes));
  return now.ok() && base::Sha256Hex(*now) == entry.sha256 && unlink(entry.item.source.c_str()) == 0;
}

}  // namespace

std::string Spool::FolderOf(Place place) const {
  switch (place) {
    case Place::kWaiting:
      return options_.folder + "/waiting";
    case Place::kRefused:
      return options_.folder + "/refused";
    case Place::kSent:
      return options_.folder + "/sent";
  }
  return "";
}

absl::StatusOr<Spool> Spool::Open(const SpoolOptions& options) {
  if (options.folder.empty()) return absl::InvalidArgumentError("the spool's folder is not named");
  Spool spool(options);
  for (const Place place : {Place::kWaiting, Place::kRefused, Place::kSent})
    RETURN_IF_ERROR(MakeFolder(spool.FolderOf(place)));
  RETURN_IF_ERROR(MakeFolder(options.folder + "/tmp"));
  RETURN_IF_ERROR(Sync(options.folder));
  return spool;
}

absl::StatusOr<Added> Spool::Add(const Item& item, const std::string& bytes) {
  RETURN_IF_ERROR(Check(item, bytes, options_.max_file_bytes));
  Entry entry{0, "", item, base::Sha256Hex(bytes), static_cast<int64_t>(bytes.size())};
  entry.id = EntryId(item, entry.sha256);
  ASSIGN_OR_RETURN(const ChangeLock lock, ChangeLock::Take(options_.folder));
  for (const Place place : {Place::kWaiting, Place::kRefused, Place::kSent}) {
    ASSIGN_OR_RETURN(const std::vector<Name> names, NamesIn(FolderOf(place)));
    for (const Name& name : names) {
      entry.number = std::max(entry.number, name.number);
      if (name.id != entry.id) continue;
      // Killed before it was removed.
      if (place == Place::kSent) RemoveSource(entry, options_.max_file_bytes);
      return Added{name.number, true, place};
    }
  }
  ++entry.number;
  const std::string entry_text = WriteEntry(entry);
  // No copies: the content may be as long as a file may be.
  std::vector<std::pair<const char*, const std::string*>> files = {{kContent, &bytes}, {kEntry, &entry_text}};
  if (item.is_log) files.emplace_back(kTemplate, &item.form.template_text);
  if (!item.form.plan_text.empty()) files.emplace_back(kPlan, &item.form.plan_text);
  int64_t needed = 0;
  for (const auto& [name, text] : files) needed += static_cast<int64_t>(text->size());
  RETURN_IF_ERROR(MakeRoom(needed));
  const fs::path tmp = fs::path(options_.folder) / "tmp";
  std::error_code error;
  // What somebody who was killed has left.
  for (fs::directory_iterator it(tmp, error), end; !error && it != end; it.increment(error)) {
    std::error_code ignored;
    fs::remove_all(it->path(), ignored);
  }
  const std::string name = absl::StrCat(absl::StrFormat("%012d", entry.number), "-", entry.id);
  RETURN_IF_ERROR(MakeFolder((tmp / name).string()));
  for (const auto& [file, text] : files) {
    const absl::Status written = base::WriteFileAtomically((tmp / name / file).string(), *text);
    if (written.ok()) continue;
    fs::remove_all(tmp / name, error);
    return written;
  }
  RETURN_IF_ERROR(Sync((tmp / name).string()));
  RETURN_IF_ERROR(Rename(tmp / name, fs::path(FolderOf(Place::kWaiting)) / name));
  return Added{entry.number, false, Place::kWaiting};
}

absl::StatusOr<std::vector<int64_t>> Spool::Numbers(Place place) const {
  ASSIGN_OR_RETURN(const std::vector<Name> names, NamesIn(FolderOf(place)));
  std::vector<int64_t> numbers;
  for (const Name& name : names) numbers.push_back(name.number);
  return numbers;
}

absl::StatusOr<Usage> Spool::Measure() const {
  Usage usage;
  const std::pair<Place, std::pair<int64_t*, int64_t*>> places[] = {
      {Place::kWaiting, {&usage.waiting, &usage.waiting_bytes}},
      {Place::kRefused, {&usage.refused, &usage.refused_bytes}},
      {Place::kSent, {&usage.sent, &usage.sent_bytes}}};
  const base::MutexLock lock(sizes_->mutex);
  for (const auto& [place, counts] : places) {
    ASSIGN_OR_RETURN(const std::vector<Name> names, NamesIn(FolderOf(place)));
    *counts.first = static_cast<int64_t>(names.size());
    std::unordered_map<std::string, int64_t>& known = sizes_->bytes[static_cast<size_t>(place)];
    std::unordered_map<std::string, int64_t> present;
    for (const Name& name : names) {
      const auto found = known.find(name.text);
      const int64_t bytes =
          found == known.end() ? BytesIn(absl::StrCat(FolderOf(place), "/", name.text)) : found->second;
      *counts.second += bytes;
      present.emplace(name.text, bytes);
    }
    known = std::move(present);
  }
  return usage;
}

absl::StatusOr<std::string> Spool::Find(Place place, int64_t number) const {
  ASSIGN_OR_RETURN(const std::vector<Name> names, NamesIn(FolderOf(place)));
  for (const Name& name : names) {
    if (name.number == number) return absl::StrCat(FolderOf(place), "/", name.text);
  }
  return base::Error(absl::StatusCode::kNotFound, absl::StrCat(FolderOf(place), ": has no entry ", number),
                     {"SPOOL_ENTRY_NOT_FOUND", {}});
}

absl::StatusOr<Entry> Spool::Get(Place place, int64_t number) const {
  ASSIGN_OR_RETURN(const std::string path, Find(place, number));
  const absl::StatusOr<std::string> text = base::ReadFile(absl::StrCat(path, "/", kEntry), kMaxEntryBytes);
  if (!text.ok()) return Damaged(path, std::string(text.status().message()));
  absl::StatusOr<Entry> entry = ReadEntry(*text);
  if (!entry.ok()) return Damaged(path, std::string(entry.status().message()));
  const auto read = [&](const char* file, size_t max, std::string* to) -> absl::Status {
    absl::StatusOr<std::string> bytes = base::ReadFile(absl::StrCat(path, "/", file), max);
    if (absl::IsNotFound(bytes.status())) return absl::OkStatus();
    if (!bytes.ok()) return Damaged(path, std::string(bytes.status().message()));
    *to = *std::move(bytes);
    return absl::OkStatus();
  };
  RETURN_IF_ERROR(read(kTemplate, records::kMaxTemplateBytes, &entry->item.form.template_text));
  RETURN_IF_ERROR(read(kPlan, records::kMaxPlanBytes, &entry->item.form.plan_text));
  // Covers template, plan and all that says what is to be done.
  if (EntryId(entry->item, entry->sha256) != entry->id) return Damaged(path, "what is to be done with it");
  return entry;
}

absl::StatusOr<std::string> Spool::Content(Place place, int64_t number) const {
  ASSIGN_OR_RETURN(const Entry entry, Get(place, number));
  ASSIGN_OR_RETURN(const std::string path, Find(place, number));
  absl::StatusOr<std::string> bytes =
      base::ReadFile(absl::StrCat(path, "/", kContent), static_cast<size_t>(records::kMaxLogBytes));
  if (!bytes.ok()) return Damaged(path, std::string(bytes.status().message()));
  if (base::Sha256Hex(*bytes) != entry.sha256) return Damaged(path, "its bytes");
  return bytes;
}

Note Spool::NoteOf(Place place, int64_t number) const {
  const absl::StatusOr<std::string> path = Find(place, number);
  if (!path.ok()) return {};
  const char* const file = place == Place::kSent ? kReceipt : kReason;
  const absl::StatusOr<std::string> text = base::ReadFile(absl::StrCat(*path, "/", file), kMaxEntryBytes);
  if (!text.ok()) return {};
  return ReadNote(*text).value_or(Note());
}

absl::Status Spool::Move(Place from, Place to, int64_t number, const std::string& note_file, const Note& note) {
  ASSIGN_OR_RETURN(const std::string path, Find(from, number));
  // Without room for the note the entry moves all the same: it is what counts.
  if (!note_file.empty())
    static_cast<void>(base::WriteFileAtomically(absl::StrCat(path, "/", note_file), WriteNote(note)));
  return Rename(path, fs::path(FolderOf(to)) / fs::path(path).filename());
}

// Out of sight first: half of an entry is never there.
absl::Status Spool::Remove(const std::string& path) const {
  const fs::path gone = fs::path(options_.folder) / "tmp" / fs::path(path).filename();
  std::error_code error;
  fs::remove_all(gone, error);
  RETURN_IF_ERROR(Rename(path, gone));
  fs::remove_all(gone, error);
  return error ? Failure(path, error.value()) : absl::OkStatus();
}

absl::Status Spool::MakeRoom(int64_t bytes) const {
  ASSIGN_OR_RETURN(const Usage usage, Measure());
  int64_t held = usage.bytes(), sent = usage.sent;
  ASSIGN_OR_RETURN(const std::vector<Name> copies, NamesIn(FolderOf(Place::kSent)));
  for (const Name& copy : copies) {
    if (held + bytes <= options_.max_bytes && sent <= options_.max_sent) break;
    const std::string path = absl::StrCat(FolderOf(Place::kSent), "/", copy.text);
    held -= BytesIn(path);
    --sent;
    RETURN_IF_ERROR(Remove(path));
  }
  if (held + bytes <= options_.max_bytes) return absl::OkStatus();
  return base::Error(absl::StatusCode::kResourceExhausted,
                     absl::StrCat(options_.folder, ": holds ", held, " bytes that the server has not, and ", bytes,
                                  " more are over its ", options_.max_bytes),
                     {"SPOOL_FULL", {}});
}

absl::Status Spool::MarkSent(int64_t number, const Note& receipt) {
  ASSIGN_OR_RETURN(const ChangeLock lock, ChangeLock::Take(options_.folder));
  const absl::StatusOr<Entry> entry = Get(Place::kWaiting, number);
  RETURN_IF_ERROR(Move(Place::kWaiting, Place::kSent, number, kReceipt, receipt));
  if (entry.ok()) RemoveSource(*entry, options_.max_file_bytes);
  // Copies beyond their number go; what else there is to say of room, Add() says.
  static_cast<void>(MakeRoom(0));
  return absl::OkStatus();
}

absl::StatusOr<int> Spool::RemoveSentSources() {
  ASSIGN_OR_RETURN(const ChangeLock lock, ChangeLock::Take(options_.folder));
  ASSIGN_OR_RETURN(const std::vector<int64_t> numbers, Numbers(Place::kSent));
  int count = 0;
  for (const int64_t number : numbers) {
    const absl::StatusOr<Entry> entry = Get(Place::kSent, number);
    if (entry.ok() && RemoveSource(*entry, options_.max_file_bytes)) ++count;
  }
  return count;
}

absl::Status Spool::Refuse(int64_t number, const Note& reason) {
  ASSIGN_OR_RETURN(const ChangeLock lock, ChangeLock::Take(options_.folder));
  return Move(Place::kWaiting, Place::kRefused, number, kReason, reason);
}

absl::Status Spool::Retry(int64_t number) {
  ASSIGN_OR_RETURN(const ChangeLock lock, ChangeLock::Take(options_.folder));
  return Move(Place::kRefused, Place::kWaiting, number, "", {});
}

absl::StatusOr<int> Spool::SendAgain() {
  ASSIGN_OR_RETURN(const ChangeLock lock, ChangeLock::Take(options_.folder));
  ASSIGN_OR_RETURN(const std::vector<Name> copies, NamesIn(FolderOf(Place::kSent)));
  const fs::path from(FolderOf(Place::kSent)), to(FolderOf(Place::kWaiting));
  for (const Name& copy : copies) RETURN_IF_ERROR(Rename(from / copy.text, to / copy.text));
  return static_cast<int>(copies.size());
}

absl::Status Spool::Drop(int64_t number) {
  ASSIGN_OR_RETURN(const ChangeLock lock, ChangeLock::Take(options_.folder));
  ASSIGN_OR_RETURN(const std::string path, Find(Place::kRefused, number));
  return Remove(path);
}

absl::StatusOr<SenderLock> SenderLock::Take(const std::string& folder) {
  const std::string path = folder + "/sender";
  const int descriptor = open(path.c_str(), O_RDWR | O_CREAT | O_CLOEXEC, 0660);
  if (descriptor < 0) return Failure(path, errno);
  if (flock(descriptor, LOCK_EX | LOCK_NB) == 0) return SenderLock(descriptor);
  close(descriptor);
  return base::Error(absl::StatusCode::kUnavailable, folder + ": another process sends from this spool",
                     {"SPOOL_BUSY", {}});
}

SenderLock::~SenderLock() {
  if (descriptor_ >= 0) close(descriptor_);
}

}  // namespace axiscal::spool
