#include "client/cell/cell.h"

#include <algorithm>
#include <cstdio>

#include "core/base/error_detail.h"
#include "core/base/files.h"

namespace axiscal::cell {
namespace {

constexpr size_t kMaxKnownBytes = size_t{16} << 20;

// A line of the log, which is the journal's.
void Say(const std::string& text) {
  std::printf("%s\n", text.c_str());
  std::fflush(stdout);
}

std::string KnownPath(const Config& config) { return config.spool.folder + "/known"; }

base::SteadyTime Now() { return base::SystemClock().SteadyNow(); }

}  // namespace

std::chrono::milliseconds LongestWait(const Config& config, int failures) {
  std::chrono::milliseconds wait = config.first_wait;
  for (int i = 1; i < failures && wait < config.last_wait; ++i) wait *= 2;
  return std::min(wait, config.last_wait);
}

Cell::Cell(Config config, spool::Spool spool, client::Client client)
    : config_(std::move(config)),
      spool_(std::move(spool)),
      client_(std::move(client)),
      sender_(spool_, client_),
      random_(std::random_device()()),
      next_attempt_(Now()) {
  for (const Watch& watch : config_.watches) watchers_.emplace_back(watch, config_.settle);
  status_.cell = config_.client.user;
  status_.server = config_.server;
  status_.version = AXISCAL_VERSION;
  status_.max_bytes = config_.spool.max_bytes;
}

absl::StatusOr<std::unique_ptr<Cell>> Cell::Create(const Config& config) {
  ASSIGN_OR_RETURN(spool::Spool spool, spool::Spool::Open(config.spool));
  ASSIGN_OR_RETURN(client::Client client, client::Client::Connect(config.server, config.client));
  std::unique_ptr<Cell> cell(new Cell(config, std::move(spool), std::move(client)));
  cell->known_text_ = base::ReadFile(KnownPath(config), kMaxKnownBytes).value_or("");
  cell->known_ = ReadKnown(cell->known_text_);
  return cell;
}

void Cell::Step(const std::function<bool()>& stops) {
  status_.alarms.clear();
  Look();
  if (!stops()) Send(stops);
  Report();
}

std::chrono::milliseconds Cell::Pause() const {
  const auto until = std::chrono::duration_cast<std::chrono::milliseconds>(next_attempt_ - Now());
  const bool waits = status_.spool.waiting > 0;
  return std::clamp(waits ? until : config_.look_every, std::chrono::milliseconds(1), config_.look_every);
}

// ---- in

void Cell::Look() {
  status_.folders.clear();
  for (FolderWatcher& watcher : watchers_) {
    Found found = watcher.LookThrough(Now(), known_);
    FolderStatus folder{watcher.watch().folder, found.growing, found.without_end, ""};
    for (const std::string& path : found.whole) {
      if (!found.status.ok()) break;
      found.status = TakeIn(watcher.watch(), path);
      // One file that cannot be taken holds up no other; a spool without room does.
      if (base::ErrorReason(found.status) == "SPOOL_FULL" || absl::IsResourceExhausted(found.status)) break;
      if (found.status.ok()) continue;
      status_.alarms.push_back(std::string(found.status.message()));
      found.status = absl::OkStatus();
    }
    if (!found.status.ok()) {
      folder.problem = std::string(found.status.message());
      status_.alarms.push_back(folder.problem);
    }
    if (folder.without_end > 0) {
      status_.alarms.push_back(absl::StrCat(folder.folder, ": ", folder.without_end,
                                            " files have not changed for long, but do not end with '",
                                            watcher.watch().end_line, "'"));
    }
    status_.folders.push_back(std::move(folder));
  }
  const std::string text = WriteKnown(known_);
  // Lost, it only makes us read the files again.
  if (text != known_text_ && base::WriteFileAtomically(KnownPath(config_), text).ok()) known_text_ = text;
}

absl::Status Cell::TakeIn(const Watch& watch, const std::string& path) {
  const auto look = FolderWatcher::LookAt(path);
  if (look.size_bytes < 0) return absl::OkStatus();  // it has gone
  if (look.size_bytes > config_.spool.max_file_bytes) {
    return absl::InvalidArgumentError(absl::StrCat(path, ": ", look.size_bytes, " bytes, at most ",
                                                   config_.spool.max_file_bytes,
                                                   " are taken (spool.max_file_megabytes)"));
  }
  const absl::StatusOr<std::string> bytes = base::ReadFile(path, static_cast<size_t>(config_.spool.max_file_bytes));
  if (!bytes.ok()) return bytes.status();
  // Somebody writes it again: it was not whole.
  if (!(FolderWatcher::LookAt(path) == look)) return absl::OkStatus();
  ASSIGN_OR_RETURN(const spool::Item item, ItemOf(watch, path));
  ASSIGN_OR_RETURN(const spool::Added added, spool_.Add(item, *bytes));
  known_[path] = look;
  if (!added.was_there) Say(absl::StrCat("spooled ", added.number, " ", path));
  return absl::OkStatus();
}

// ---- out

void Cell::Send(const std::function<bool()>& stops) {
  if (Now() < next_attempt_) return;
  if (!lock_) {
    absl::StatusOr<spool::SenderLock> lock = spool::SenderLock::Take(config_.spool.folder);
    if (!lock.ok()) return Wait(lock.status());
    lock_.emplace(*std::move(lock));
  }
  const base::SteadyTime end = Now() + config_.look_every;
  while (!stops() && Now() < end) {
    const absl::StatusOr<std::optional<spool::Attempt>> attempt = sender_.SendNext();
    if (!attempt.ok()) return Wait(attempt.status());
    if (!attempt->has_value()) break;
    const spool::Attempt& done = **attempt;
    if (done.fate == spool::Fate::kSent) {
      status_.is_connected = true;
      ++status_.sent;
      status_.last_sent = done.name;
      status_.last_sent_at = base::SystemClock().UtcNow();
      Say(absl::StrCat("sent ", done.number, " ", done.name, ": session ", done.session.id.number(),
                       done.was_there ? ", was there" : ""));
    } else if (done.fate == spool::Fate::kRefused) {
      ++status_.refused;
      Say(absl::StrCat("refused ", done.number, " ", done.name, ": ", done.status.message()));
    } else {
      return Wait(done.status);
    }
    failures_ = 0;
    status_.problem.clear();
  }
  // What was wrong with what waits no longer is.
  if (const auto left = spool_.Numbers(spool::Place::kWaiting); left.ok() && left->empty()) status_.problem.clear();
}

void Cell::Wait(const absl::Status& why) {
  status_.is_connected = false;
  if (failures_ == 0) Say(absl::StrCat("not sent: ", why.message()));
  ++failures_;
  status_.problem = std::string(why.message());
  const int64_t longest = LongestWait(config_, failures_).count();
  const int64_t least = std::min<int64_t>(config_.first_wait.count(), longest) / 2;
  std::uniform_int_distribution<int64_t> wait(least, longest);
  next_attempt_ = Now() + std::chrono::milliseconds(wait(random_));
}

// ---- how it stands

void Cell::Report() {
  status_.at = base::SystemClock().UtcNow();
  const absl::StatusOr<spool::Usage> usage = spool_.Measure();
  if (usage.ok()) status_.spool = *usage;
  if (!usage.ok()) status_.alarms.push_back(std::string(usage.status().message()));
  if (status_.spool.refused > 0) {
    status_.alarms.push_back(absl::StrCat(status_.spool.refused,
                                          " files were refused and wait for a person: axiscal spool list --spool ",
                                          config_.spool.folder));
  }
  const absl::Status written = base::WriteFileAtomically(config_.status_file, WriteStatus(status_));
  if (!written.ok()) std::fprintf(stderr, "axiscal-cell: status: %s\n", std::string(written.message()).c_str());
}

}  // namespace axiscal::cell
