#include "server/storage/sql_store.h"

#include <algorithm>
#include <random>

#include "core/base/sha256.h"
#include "core/session/checksum.h"
#include "server/storage/refusal.h"
#include "server/storage/seal.h"

namespace axiscal::storage {

std::string SqlStore::MakeOwnerId() {
  std::random_device random;
  return absl::StrFormat("%08x%08x%08x", random(), random(), random());
}

absl::StatusOr<std::unique_ptr<Database>> SqlStore::Open(const StoreOptions& options, std::unique_ptr<Engine> engine,
                                                         std::unique_ptr<Connection> connection) {
  RETURN_IF_ERROR(SealOldRows(*connection));
  ASSIGN_OR_RETURN(const std::chrono::microseconds up, ReadUpTime(*connection));
  std::unique_ptr<SqlStore> store(new SqlStore(options, up, std::move(engine), std::move(connection)));
  ASSIGN_OR_RETURN(const std::vector<JobRecord> rescued, store->RescueJobs());
  if (options.rescued) std::for_each(rescued.begin(), rescued.end(), options.rescued);
  return store;
}

absl::Status SqlStore::CheckWhole(const SessionRecord& session) {
  std::vector<uint32_t> crcs;
  RETURN_IF_ERROR(VisitChunks(session, 0, [&](const records::Chunk& chunk) {
    crcs.push_back(chunk.crc32c());
    return absl::OkStatus();
  }));
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
        if (!encoded->ok()) return std::move(*encoded).status();
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
