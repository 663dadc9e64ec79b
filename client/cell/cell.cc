#include "client/cell/cell.h"

#include <unistd.h>

#include <algorithm>
#include <cstdio>
#include <set>

#include "core/base/error_detail.h"
#include "core/base/files.h"
#include "core/base/utf8.h"

namespace axiscal::cell {
namespace {

constexpr size_t kMaxKnownBytes = size_t{16} << 20;
// How often the service hears how the cell stands: a few times within the shortest silence that it takes note of.
constexpr std::chrono::seconds kTellEvery(30);
// What a round may take before somebody should look: a mount that hangs, or a file that takes its time.
constexpr std::chrono::minutes kLongRound(10);
constexpr std::chrono::seconds kReportDeadline(5);
// A session file is read here before it is sent, and takes six times its size; a log goes up as it is.
constexpr int64_t kSessionFilePart = 8;
constexpr size_t kMaxProblemBytes = 500;  // convert::kMaxCellProblemBytes

// Names of files may hold ends of lines.
std::string OneLine(std::string text) {
  std::replace_if(text.begin(), text.end(), [](unsigned char c) { return c < 0x20 || c == 0x7f; }, ' ');
  return text;
}

// A line of the log, which is the journal's.
void Say(const std::string& text) {
  std::printf("%s\n", OneLine(text).c_str());
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

Cell::Cell(Config config, spool::Spool spool, client::Client client, client::Client reporter)
    : config_(std::move(config)),
      spool_(std::move(spool)),
      client_(std::move(client)),
      reporter_(std::move(reporter)),
      sender_(spool_, client_),
      random_(std::random_device()()),
      next_attempt_(Now()),
      next_held_(Now()) {
  for (const Watch& watch : config_.watches) watchers_.emplace_back(watch, config_.settle);
  status_.cell = config_.name;
  status_.server = config_.server;
  status_.version = AXISCAL_VERSION;
  status_.max_bytes = config_.spool.max_bytes;
}

absl::StatusOr<std::unique_ptr<Cell>> Cell::Create(const Config& config) {
  ASSIGN_OR_RETURN(spool::Spool spool, spool::Spool::Open(config.spool));
  ASSIGN_OR_RETURN(client::Client client, client::Client::Connect(config.server, config.client));
  client::Options options = config.client;
  options.call_deadline = kReportDeadline;
  ASSIGN_OR_RETURN(client::Client reporter, client::Client::Connect(config.server, options));
  std::unique_ptr<Cell> cell(new Cell(config, std::move(spool), std::move(client), std::move(reporter)));
  cell->known_text_ = base::ReadFile(KnownPath(config), kMaxKnownBytes).value_or("");
  cell->known_ = ReadKnown(cell->known_text_);
  ASSIGN_OR_RETURN(const int removed, cell->spool_.RemoveSentSources());
  if (removed > 0) Say(absl::StrCat("removed ", removed, " files that were sent before"));
  cell->Report();
  cell->teller_ = std::thread([cell = cell.get()] { cell->Tell(); });
  return cell;
}

Cell::~Cell() {
  {
    const base::MutexLock lock(mutex_);
    is_over_ = true;
    wakes_.NotifyAll();
  }
  if (teller_.joinable()) teller_.join();
}

void Cell::Step(const std::function<bool()>& stops) {
  status_.alarms.clear();
  Look();
  if (!stops()) Send(stops);
  Do("");
  Report();
}

std::chrono::milliseconds Cell::Pause() const {
  const auto until = std::chrono::duration_cast<std::chrono::milliseconds>(next_attempt_ - Now());
  if (status_.looks_on) return std::chrono::milliseconds(1);
  const bool waits = status_.spool.waiting > 0 && !sender_.holds();
  return std::clamp(waits ? until : config_.look_every, std::chrono::milliseconds(1), config_.look_every);
}

// ---- in

void Cell::Look() {
  status_.folders.clear();
  status_.looks_on = false;
  const base::SteadyTime end = Now() + config_.look_every;
  for (FolderWatcher& watcher : watchers_) {
    Do("looks through " + watcher.watch().folder);
    Found found = watcher.LookThrough(Now(), known_);
    FolderStatus folder{watcher.watch().folder, found.growing, found.without_end, found.links, ""};
    for (size_t i = 0; i < found.whole.size(); ++i) {
      if (!found.status.ok()) break;
      // What is sent and known does not wait for a large folder; of each folder one file is taken in a round at least.
      if (i > 0 && Now() >= end) {
        status_.looks_on = true;
        break;
      }
      found.status = TakeIn(watcher.watch(), found.whole[i], found.looks[i]);
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
    if (folder.links > 0) {
      status_.alarms.push_back(absl::StrCat(folder.folder, ": ", folder.links,
                                            " symbolic links are not followed: name the folder that they lead to"));
    }
    if (watcher.watch().removes && folder.problem.empty() && access(folder.folder.c_str(), W_OK) != 0) {
      status_.alarms.push_back(folder.folder +
                               ": remove_sent is set, but files cannot be removed there: rights of the "
                               "folder, ReadWritePaths= of the unit");
    }
    status_.folders.push_back(std::move(folder));
  }
  const std::string text = WriteKnown(known_);
  // Lost, it only makes us read the files again.
  if (text != known_text_ && base::WriteFileAtomically(KnownPath(config_), text).ok()) known_text_ = text;
}

absl::Status Cell::TakeIn(const Watch& watch, const std::string& path, const axiscal::cell::Look& look) {
  const bool is_log = !watch.log_template.empty();
  const int64_t most = config_.spool.max_file_bytes / (is_log ? 1 : kSessionFilePart);
  if (look.size_bytes > most) {
    return absl::InvalidArgumentError(absl::StrCat(
        path, ": ", look.size_bytes, " bytes, at most ", most, " are taken (",
        is_log ? "" : "of session files an eighth of ", "spool.max_file_megabytes)"));
  }
  const absl::StatusOr<std::string> bytes = ReadAsFound(path, look);
  if (absl::IsUnavailable(bytes.status())) return absl::OkStatus();  // the next look sees what it is now
  RETURN_IF_ERROR(bytes.status());
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
    if (!lock.ok()) return Wait(lock.status(), false);
    lock_.emplace(*std::move(lock));
  }
  const base::SteadyTime end = Now() + config_.look_every;
  if (Now() >= next_held_) {
    sender_.TryAllAgain();
    held_ = absl::OkStatus();
  }
  while (!stops() && Now() < end) {
    Do(absl::StrCat("sends file ", status_.sent + status_.refused + 1, " since it was started"));
    const absl::StatusOr<std::optional<spool::Attempt>> attempt = sender_.SendNext();
    if (!attempt.ok()) return Wait(attempt.status(), false);
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
    } else if (done.fate == spool::Fate::kNotHere) {
      if (times_held_ == 0) Say(absl::StrCat("held ", done.number, " ", done.name, ": ", done.status.message()));
      if (held_.ok()) next_held_ = Now() + WaitAfter(++times_held_);
      held_ = base::Within(done.name, done.status);
      continue;
    } else {
      return Wait(done.status, done.fate == spool::Fate::kLater);
    }
    failures_ = 0;
    status_.problem.clear();
  }
  // What was wrong with what waits no longer is.
  if (const auto left = spool_.Numbers(spool::Place::kWaiting); left.ok() && left->empty()) status_.problem.clear();
  if (!held_.ok()) {
    status_.problem = std::string(held_.message());
    status_.is_later = false;
  } else {
    times_held_ = 0;
  }
}

void Cell::Wait(const absl::Status& why, bool is_later) {
  status_.is_connected = false;
  if (failures_ == 0) Say(absl::StrCat("not sent: ", why.message()));
  ++failures_;
  status_.problem = std::string(why.message());
  status_.is_later = is_later;
  next_attempt_ = Now() + WaitAfter(failures_);
}

std::chrono::milliseconds Cell::WaitAfter(int failures) {
  const int64_t longest = LongestWait(config_, failures).count();
  const int64_t least = std::min<int64_t>(config_.first_wait.count(), longest) / 2;
  std::uniform_int_distribution<int64_t> wait(least, longest);
  return std::chrono::milliseconds(wait(random_));
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
  for (const std::string& alarm : status_.alarms) {
    if (!said_.contains(alarm)) Say("alarm: " + alarm);
  }
  if (status_.alarms.empty() && !said_.empty()) Say("no alarm any more");
  said_ = {status_.alarms.begin(), status_.alarms.end()};
  const base::MutexLock lock(mutex_);
  const bool is_news =
      (status_.alarms.empty() && status_.problem.empty()) != (told_.alarms.empty() && told_.problem.empty());
  status_.not_told = not_told_;
  told_ = status_;
  const absl::Status written = WriteFile(told_);
  if (!written.ok()) std::fprintf(stderr, "axiscal-cell: status: %s\n", std::string(written.message()).c_str());
  if (is_news) wakes_.NotifyAll();
}

absl::Status Cell::WriteFile(const Status& status) const {
  return base::WriteFileAtomically(config_.status_file, WriteStatus(status));
}

void Cell::Do(const std::string& what) {
  const base::MutexLock lock(mutex_);
  status_.doing = told_.doing = what;
  status_.doing_since = told_.doing_since = base::SystemClock().UtcNow();
}

void Cell::Tell() {
  base::SteadyTime next_word = Now();
  while (true) {
    Status status;
    {
      const base::MutexLock lock(mutex_);
      if (!is_over_) wakes_.WaitUntil(mutex_, std::min(next_word, Now() + kTellEvery));
      if (is_over_) return;
      told_.at = base::SystemClock().UtcNow();
      if (!told_.doing.empty() && told_.at - told_.doing_since > kLongRound) {
        const std::string text = told_.doing + " for longer than ten minutes";
        if (std::find(told_.alarms.begin(), told_.alarms.end(), text) == told_.alarms.end())
          told_.alarms.push_back(text);
      }
      // What cannot be written, Report() has said.
      static_cast<void>(WriteFile(told_));
      status = told_;
    }
    TellService(status);
    next_word = Now() + kTellEvery;
  }
}

void Cell::TellService(const Status& status) {
  records::CellReport report;
  report.name = config_.name;
  report.version = status.version;
  report.silent_after = config_.silent_after;
  // That the server is not there it need not be told when it is.
  report.problem = !status.alarms.empty() ? status.alarms.front() : status.is_later ? "" : status.problem;
  if (report.problem.size() > kMaxProblemBytes) report.problem.resize(kMaxProblemBytes);
  report.problem = OneLine(base::ToUtf8(report.problem));
  while (report.problem.size() > kMaxProblemBytes) report.problem.resize(kMaxProblemBytes - 3);
  report.waiting_files = status.spool.waiting;
  report.waiting_bytes = status.spool.waiting_bytes;
  report.quarantined_files = status.spool.refused;
  report.quarantined_bytes = status.spool.refused_bytes;
  report.max_bytes = status.max_bytes;
  std::set<std::string> machines;
  for (const Watch& watch : config_.watches) {
    if (!watch.machine.empty()) machines.insert(watch.machine);
  }
  std::string not_told = machines.empty() ? "no watch names its machine" : "";
  for (const std::string& machine : machines) {
    report.machine = MachineId(machine);
    const absl::StatusOr<records::CellRecord> told = reporter_.ReportCell(report);
    if (!told.ok()) not_told = machine + ": " + std::string(told.status().message());
    if (absl::IsUnavailable(told.status()) || absl::IsDeadlineExceeded(told.status())) break;
  }
  const base::MutexLock lock(mutex_);
  not_told_ = told_.not_told = not_told;
}

}  // namespace axiscal::cell
