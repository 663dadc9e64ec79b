#include "server/storage/sql_store.h"

#include <algorithm>

#include "core/base/sha256.h"
#include "core/session/checksum.h"
#include "server/storage/refusal.h"
#include "server/storage/seal.h"
#include "server/storage/transaction.h"

namespace axiscal::storage {
namespace {

// Of several processes the caretaker says so often that it is still there; silent for the lease, another one takes its
// place. It goes by a shorter time itself: the clocks of two processes go together to within a beat or two.
constexpr std::chrono::microseconds kCaretakerLease = std::chrono::seconds(15);
constexpr std::chrono::seconds kCaretakerBeat(2), kCaretakerSure(10);

}  // namespace

absl::StatusOr<std::unique_ptr<Database>> SqlStore::Open(const StoreOptions& options, std::unique_ptr<Engine> engine,
                                                         std::unique_ptr<Connection> connection) {
  RETURN_IF_ERROR(SealOldRows(*connection));
  ASSIGN_OR_RETURN(const std::chrono::microseconds up, ReadUpTime(*connection));
  std::unique_ptr<SqlStore> store(new SqlStore(options, up, std::move(engine), std::move(connection)));
  // Beside others a lease that is over may be one that its owner could not prolong, as the store was away for both: the
  // job runner gives it time to.
  ASSIGN_OR_RETURN(const std::vector<JobRecord> rescued, store->RescueJobsOnOpen());
  if (options.rescued) std::for_each(rescued.begin(), rescued.end(), options.rescued);
  RETURN_IF_ERROR(store->writer_.Run([](Connection& c) { return c.LetOthersIn(); }));
  return store;
}

absl::Status SqlStore::FallInStep(Connection& connection) {
  const std::chrono::microseconds up = UpTime();
  ASSIGN_OR_RETURN(const std::chrono::microseconds furthest, KeepUpTime(connection, up));
  if (furthest > up) up_of_others_us_ += (furthest - up).count();
  return absl::OkStatus();
}

// A lease on the time that all processes count together: one that stands still loses it. It stands beside the numbers
// that are given without gaps, as those of the process and of the moment.
absl::Status SqlStore::KeepRole(Connection& connection, bool leaves) {
  RETURN_IF_ERROR(FallInStep(connection));
  const base::SteadyTime began = options_.clock->SteadyNow();
  const int64_t now_us = UpTime().count(), until_us = leaves ? 0 : now_us + kCaretakerLease.count();
  // 60 bits of a number that is new for every opening.
  const int64_t self = std::stoll(owner_id_.substr(0, 15), nullptr, 16);
  bool is_self = false, is_taken = false;
  {
    ASSIGN_OR_RETURN(Statement row,
                     connection.Ask("SELECT c.seq, u.seq FROM given_number AS c JOIN given_number AS u ON "
                                    "u.name = 'caretaker_until_up_us' WHERE c.name = 'caretaker'"));
    ASSIGN_OR_RETURN(const bool found, row.Step());
    is_self = found && row.Int(0) == self;
    is_taken = found && row.Int(1) > now_us;
  }
  if ((is_taken || leaves) && !is_self) {
    caretaker_until_ = base::SteadyTime{};
    return absl::OkStatus();
  }
  for (const auto& [name, number] : {std::pair("caretaker", self), {"caretaker_until_up_us", until_us}}) {
    RETURN_IF_ERROR(
        connection.Run("INSERT INTO given_number (name, seq) VALUES (?1, ?2) ON CONFLICT (name) DO UPDATE "
                       "SET seq = excluded.seq",
                       std::string(name), number));
  }
  caretaker_until_ = leaves ? base::SteadyTime{} : began + kCaretakerSure;
  return absl::OkStatus();
}

void SqlStore::Beat() {
  // What fails is tried again; meanwhile the role runs out.
  static_cast<void>(writer_.Run([this](Connection& c) { return KeepRole(c, false); }));
}

void SqlStore::Follow(std::function<void(const News&)> heard) {
  if (!engine_->is_shared()) return;
  {
    const base::MutexLock lock(follow_mutex_);
    if (follows_) return;
    follows_ = true;
  }
  Beat();
  beats_ = std::thread([this] {
    const base::MutexLock lock(follow_mutex_);
    while (follows_) {
      stop_following_.WaitUntil(follow_mutex_, std::chrono::steady_clock::now() + kCaretakerBeat);
      if (!follows_) return;
      follow_mutex_.Unlock();
      Beat();
      follow_mutex_.Lock();
    }
  });
  listener_ = engine_->Listen([heard = std::move(heard)](const std::string& word) {
    News news;
    news.jobs = word.empty() || word == kJobsChanged;
    news.events = word.empty() || word == kEventsChanged;
    news.routines = word == kRoutinesChanged;
    if (word.rfind(kLookAt, 0) == 0) news.machine = MachineId(word.substr(sizeof(kLookAt) - 1));
    heard(news);
  });
}

void SqlStore::StopFollowing() {
  {
    const base::MutexLock lock(follow_mutex_);
    if (!follows_) return;
    follows_ = false;
    stop_following_.NotifyAll();
  }
  listener_.reset();
  beats_.join();
  static_cast<void>(writer_.Run([this](Connection& c) { return KeepRole(c, true); }));
}

bool SqlStore::IsCaretaker() { return !engine_->is_shared() || options_.clock->SteadyNow() < caretaker_until_.load(); }

void SqlStore::TellOthers(const std::optional<MachineId>& machine) {
  if (!engine_->is_shared()) return;
  const std::string word = machine ? kLookAt + machine->text() : kRoutinesChanged;
  writer_.Start([word](Connection& c) { return c.Tell(word); }, [](const absl::Status&) {});
}

// Of a claim nobody outside hears who would rely on it, so its commit waits for no disk: where it is lost with the
// server, the job waits as before, and what its worker says has no lease. The end of the job waits for the disk, and
// takes the claim with it. Nobody is told either: what is told is told by one commit at a time.
absl::StatusOr<std::optional<JobRecord>> SqlStore::ClaimJob(std::chrono::microseconds lease) {
  using Claimed = std::optional<JobRecord>;
  if (!engine_->is_shared()) {
    const auto claim = [&](Connection& c) { return storage::ClaimJob(c, Owner(c), lease); };
    return Write<Claimed>(Growth::kStays, claim, Writer::Durable::kSoon);
  }
  const base::MutexLock lock(claims_mutex_);
  if (claims_ == nullptr) {
    ASSIGN_OR_RETURN(claims_, engine_->OpenBesideWriter());
  }
  absl::StatusOr<Claimed> claimed = ClaimBeside(lease);
  for (int runs = 1; !claimed.ok() && claims_->was_undone() && runs < Writer::kMostRuns; ++runs)
    claimed = ClaimBeside(lease);
  return claimed;
}

absl::StatusOr<std::optional<JobRecord>> SqlStore::ClaimBeside(std::chrono::microseconds lease) {
  ASSIGN_OR_RETURN(Transaction transaction, Transaction::BeginWrite(*claims_));
  ASSIGN_OR_RETURN(std::optional<JobRecord> job, storage::ClaimJob(*claims_, Owner(*claims_), lease));
  RETURN_IF_ERROR(transaction.CommitSoon());
  return job;
}

absl::Status SqlStore::CheckWhole(const SessionRecord& session) {
  std::vector<uint32_t> crcs;
  const absl::Status visited = VisitChunks(session, 0, [&](const records::Chunk& chunk) {
    crcs.push_back(chunk.crc32c());
    return absl::OkStatus();
  });
  // It has been here, and whoever looks after the database has it.
  if (base::ErrorReason(visited) == kReadingsDetached) return absl::OkStatus();
  RETURN_IF_ERROR(visited);
  if (session.state != SessionState::kComplete || session::SessionHash(crcs) == session.hash) return absl::OkStatus();
  return base::Error(absl::StatusCode::kDataLoss,
                     absl::StrCat("session ", session.id.number(), " is damaged: its chunks are not those of its hash"),
                     {"SESSION_DAMAGED", {{"session", std::to_string(session.id.number())}}});
}

absl::StatusOr<SessionRecord> SqlStore::CreateSession(const NewSession& session) {
  std::vector<SessionId> damaged;
  while (true) {
    ASSIGN_OR_RETURN(SessionRecord record, Write<SessionRecord>(Growth::kGrows, [&](Connection& c) {
                       return storage::CreateSession(c, Present(), session, damaged);
                     }));
    // What is there already is read, outside the writer's turn: who sends it again must not be told that it is safe.
    const absl::Status whole = CheckWhole(record);
    if (whole.ok()) return record;
    if (!absl::IsDataLoss(whole)) return whole;
    // Given up between the two, it has no content any more: that is no damage.
    ASSIGN_OR_RETURN(const auto present, GetSession(record.id));
    if (present.state != record.state) continue;
    TellDamage(whole);
    damaged.push_back(record.id);
  }
}

absl::StatusOr<SqlStore::SharedSpecs> SqlStore::Specs(SessionId id) {
  constexpr size_t kMaxRemembered = 4096;
  {
    const base::MutexLock lock(specs_mutex_);
    const auto found = specs_.find(id);
    if (found != specs_.end()) return found->second;
  }
  ASSIGN_OR_RETURN(std::vector<ColumnSpec> columns,
                   readers_.Run([&](Connection& c) { return GetSessionColumns(c, id); }));
  const SharedSpecs specs = std::make_shared<const std::vector<ColumnSpec>>(std::move(columns));
  const base::MutexLock lock(specs_mutex_);
  if (specs_.size() >= kMaxRemembered) specs_.clear();
  specs_[id] = specs;
  return specs;
}

absl::StatusOr<EncodedChunk> SqlStore::Encode(SessionId id, const records::Chunk& chunk) {
  RETURN_IF_ERROR(CheckRoom(Growth::kGrows));
  ASSIGN_OR_RETURN(const SharedSpecs specs, Specs(id));
  return PrepareChunk(chunk, *specs);
}

absl::StatusOr<AppendResult> SqlStore::AppendChunk(SessionId id, const records::Chunk& chunk) {
  ASSIGN_OR_RETURN(const EncodedChunk encoded, Encode(id, chunk));
  return Write<AppendResult>(Growth::kStays,
                             [&](Connection& c) { return storage::AppendChunk(c, Present(), id, encoded); });
}

void SqlStore::AppendChunkAsync(SessionId id, const records::Chunk& chunk,
                                std::function<void(absl::StatusOr<AppendResult>)> done) {
  // A refusal goes through the writer too, so that answers keep the order of the calls.
  auto encoded = std::make_shared<absl::StatusOr<EncodedChunk>>(Encode(id, chunk));
  auto result = std::make_shared<AppendResult>();
  writer_.Start(
      [this, id, encoded, result](Connection& connection) {
        if (!encoded->ok()) return Separate(encoded->status());
        absl::StatusOr<AppendResult> appended = storage::AppendChunk(connection, Present(), id, **encoded);
        if (!appended.ok()) return std::move(appended).status();
        *result = *appended;
        return absl::OkStatus();
      },
      [result, done = std::move(done)](absl::Status written) {
        if (written.ok()) return done(*result);
        done(std::move(written));
      });
}

// Some at a time, so that other writes go on between.
absl::StatusOr<int> SqlStore::ExpireReadings(std::chrono::microseconds age) {
  int count = 0;
  for (std::optional<SessionId> after = SessionId(0); after.has_value();) {
    ASSIGN_OR_RETURN(const ExpiredReadings expired, Write<ExpiredReadings>(Growth::kStays, [&](Connection& c) {
                       return storage::ExpireReadings(c, Present(), age, *after);
                     }));
    count += expired.count;
    after = expired.after;
  }
  while (true) {
    ASSIGN_OR_RETURN(const int dropped, Write<int>(Growth::kStays, [](Connection& c) { return DropExpiredChunks(c); }));
    if (dropped == 0) return count;
  }
}

absl::Status SqlStore::VisitChunks(const SessionRecord& session, int64_t first_seq,
                                   const std::function<absl::Status(const records::Chunk&)>& visit) {
  // One short read per chunk: what is durable cannot change, and a slow visitor must not keep the log from being
  // merged.
  for (int64_t seq = std::max<int64_t>(first_seq, 0);; ++seq) {
    ASSIGN_OR_RETURN(const std::optional<records::Chunk> chunk,
                     readers_.Run([&](Connection& c) { return ReadChunk(c, session, seq); }));
    if (!chunk.has_value()) return absl::OkStatus();
    RETURN_IF_ERROR(visit(*chunk));
  }
}

// What was given up or has expired meanwhile is not damaged.
absl::Status SqlStore::NotDamagedIfGone(const SessionRecord& session, const absl::Status& status) {
  if (!absl::IsDataLoss(status)) return status;
  const absl::StatusOr<SessionRecord> present = GetSession(session.id);
  if (!present.ok() || present->state == session.state) return status;
  return FailedPrecondition(absl::StrCat("session ", session.id.number(), " has no readings any more"),
                            "SESSION_NOT_COMPLETE");
}

absl::Status SqlStore::ReadChunks(SessionId id, int64_t first_seq,
                                  const std::function<absl::Status(const records::Chunk&)>& visit) {
  ASSIGN_OR_RETURN(const SessionRecord session, GetSession(id));
  if (session.state != SessionState::kComplete && session.state != SessionState::kOpen) {
    return FailedPrecondition(absl::StrCat("session ", id.number(), " is not complete"), "SESSION_NOT_COMPLETE");
  }
  RETURN_IF_ERROR(readers_.Run([&](Connection& c) { return CheckSessionBody(c, session); }));
  return NotDamagedIfGone(session, VisitChunks(session, first_seq, visit));
}

absl::StatusOr<session::Session> SqlStore::ReadSession(SessionId id) {
  ASSIGN_OR_RETURN(const SessionRecord record, GetSession(id));
  if (record.state != SessionState::kComplete) {
    return FailedPrecondition(absl::StrCat("session ", id.number(), " is not complete"), "SESSION_NOT_COMPLETE");
  }
  RETURN_IF_ERROR(readers_.Run([&](Connection& c) { return CheckSessionBody(c, record); }));
  session::Session session;
  session.header = record.header;
  for (const ColumnSpec& spec : record.columns) session.columns.push_back({spec.name, {}, {}});
  const absl::Status read = VisitChunks(record, 0, [&](const records::Chunk& chunk) {
    for (size_t i = 0; i < session.columns.size(); ++i) {
      session::Column& whole = session.columns[i];
      const session::Column& part = chunk.columns()[i];
      whole.values.insert(whole.values.end(), part.values.begin(), part.values.end());
      whole.texts.insert(whole.texts.end(), part.texts.begin(), part.texts.end());
    }
    return absl::OkStatus();
  });
  RETURN_IF_ERROR(NotDamagedIfGone(record, read));
  return session;
}

absl::Status SqlStore::VisitParts(const ProgramRecord& program, int64_t offset,
                                  const std::function<absl::Status(const std::string&)>& visit) {
  while (true) {
    ASSIGN_OR_RETURN(const std::optional<std::string> bytes,
                     readers_.Run([&](Connection& c) { return ReadPart(c, program, offset); }));
    if (!bytes.has_value()) return absl::OkStatus();
    RETURN_IF_ERROR(visit(*bytes));
    offset += static_cast<int64_t>(bytes->size());
  }
}

absl::Status SqlStore::ReadProgram(ProgramId id, int64_t offset,
                                   const std::function<absl::Status(const std::string& bytes)>& visit) {
  if (offset < 0) return InvalidArgument(absl::StrCat("offset = ", offset, ", must be >= 0"), "PART_INVALID");
  ASSIGN_OR_RETURN(const ProgramRecord program, GetProgram(id));
  if (program.state != ProgramState::kComplete) {
    return FailedPrecondition(absl::StrCat("program ", id.number(), " is not complete"), "PROGRAM_NOT_COMPLETE");
  }
  return VisitParts(program, offset, visit);
}

absl::Status SqlStore::CheckWhole(const ProgramRecord& program) {
  base::Sha256 sha;
  RETURN_IF_ERROR(VisitParts(program, 0, [&](const std::string& bytes) {
    sha.Add(bytes);
    return absl::OkStatus();
  }));
  if (program.state != ProgramState::kComplete || sha.HexDigest() == program.sha256) return absl::OkStatus();
  return base::Error(
      absl::StatusCode::kDataLoss,
      absl::StrCat("program ", program.id.number(), " is damaged: its bytes are not those of its sha256"),
      {"PART_DAMAGED", {{"program", std::to_string(program.id.number())}, {"offset", "0"}}});
}

absl::StatusOr<ProgramRecord> SqlStore::BeginProgram(const NewProgram& program) {
  std::vector<ProgramId> damaged;
  while (true) {
    ASSIGN_OR_RETURN(ProgramRecord record, Write<ProgramRecord>(Growth::kGrows, [&](Connection& c) {
                       return storage::BeginProgram(c, Present(), program, damaged);
                     }));
    const absl::Status whole = CheckWhole(record);
    if (whole.ok()) return record;
    if (!absl::IsDataLoss(whole)) return whole;
    // Given up between the two, it has no content any more: that is no damage.
    ASSIGN_OR_RETURN(const auto present, GetProgram(record.id));
    if (present.state != record.state) continue;
    TellDamage(whole);
    damaged.push_back(record.id);
  }
}

absl::StatusOr<ProgramRecord> SqlStore::FinishProgram(ProgramId id, int64_t byte_count, const std::string& sha256) {
  ASSIGN_OR_RETURN(const ProgramRecord program, GetProgram(id));
  // Parts are only ever added, so their hash may be taken outside the writer's turn.
  base::Sha256 sha;
  RETURN_IF_ERROR(VisitParts(program, 0, [&](const std::string& bytes) {
    sha.Add(bytes);
    return absl::OkStatus();
  }));
  const std::string computed = sha.HexDigest();
  if (!sha256.empty() && sha256 != computed) {
    return FailedPrecondition(
        absl::StrCat("program ", id.number(), ": totals say sha256 ", sha256, ", stored is ", computed),
        "TOTALS_MISMATCH");
  }
  ASSIGN_OR_RETURN(const std::optional<ProgramId> same,
                   readers_.Run([&](Connection& c) { return FindContent(c, computed, program.kind); }));
  std::optional<ProgramId> damaged;
  if (same.has_value() && *same != program.id) {
    ASSIGN_OR_RETURN(const ProgramRecord twin, GetProgram(*same));
    const absl::Status whole = CheckWhole(twin);
    if (!whole.ok() && !absl::IsDataLoss(whole)) return whole;
    if (!whole.ok()) {
      TellDamage(whole);
      damaged = same;
    }
  }
  return Write<ProgramRecord>(Growth::kStays, [&](Connection& c) -> absl::StatusOr<ProgramRecord> {
    ASSIGN_OR_RETURN(const ProgramRecord present, storage::GetProgram(c, id));
    if (present.byte_count != program.byte_count)
      return FailedPrecondition("parts were added while it was finished", "TOTALS_MISMATCH");
    return storage::FinishProgram(c, id, byte_count, computed, damaged);
  });
}

}  // namespace axiscal::storage
