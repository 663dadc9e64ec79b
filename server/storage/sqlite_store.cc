#include "server/storage/sqlite_store.h"

#include <algorithm>
#include <random>

#include "core/base/sha256.h"
#include "server/storage/refusal.h"

namespace axiscal::storage {

std::string SqliteStore::MakeOwnerId() {
  std::random_device random;
  return absl::StrFormat("%08x%08x%08x", random(), random(), random());
}

absl::Status SqliteStore::CheckDisk(Growth growth) const {
  if (growth == Growth::kStays) return absl::OkStatus();
  const int64_t free_bytes = options_.free_bytes();
  if (free_bytes >= options_.min_free_bytes) return absl::OkStatus();
  return base::Error(absl::StatusCode::kResourceExhausted,
                     absl::StrCat(options_.path, ": ", free_bytes, " bytes free on the disk, at least ",
                                  options_.min_free_bytes, " must stay free"),
                     {"DISK_LOW", {{"free_bytes", std::to_string(free_bytes)}}});
}

absl::StatusOr<SqliteStore::SharedSpecs> SqliteStore::Specs(SessionId id) {
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

absl::StatusOr<EncodedChunk> SqliteStore::Encode(SessionId id, const records::Chunk& chunk) {
  RETURN_IF_ERROR(CheckDisk(Growth::kGrows));
  ASSIGN_OR_RETURN(const SharedSpecs specs, Specs(id));
  return PrepareChunk(chunk, *specs);
}

absl::StatusOr<AppendResult> SqliteStore::AppendChunk(SessionId id, const records::Chunk& chunk) {
  ASSIGN_OR_RETURN(const EncodedChunk encoded, Encode(id, chunk));
  return Write<AppendResult>(Growth::kStays,
                             [&](Connection& c) { return storage::AppendChunk(c, Present(), id, encoded); });
}

void SqliteStore::AppendChunkAsync(SessionId id, const records::Chunk& chunk,
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

absl::Status SqliteStore::VisitChunks(const SessionRecord& session, int64_t first_seq,
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

absl::Status SqliteStore::ReadChunks(SessionId id, int64_t first_seq,
                                     const std::function<absl::Status(const records::Chunk&)>& visit) {
  ASSIGN_OR_RETURN(const SessionRecord session, GetSession(id));
  if (session.state != SessionState::kComplete && session.state != SessionState::kOpen) {
    return FailedPrecondition(absl::StrCat("session ", id.number(), " is not complete"), "SESSION_NOT_COMPLETE");
  }
  RETURN_IF_ERROR(readers_.Run([&](Connection& c) { return CheckSessionBody(c, session); }));
  return VisitChunks(session, first_seq, visit);
}

absl::StatusOr<session::Session> SqliteStore::ReadSession(SessionId id) {
  ASSIGN_OR_RETURN(const SessionRecord record, GetSession(id));
  if (record.state != SessionState::kComplete) {
    return FailedPrecondition(absl::StrCat("session ", id.number(), " is not complete"), "SESSION_NOT_COMPLETE");
  }
  RETURN_IF_ERROR(readers_.Run([&](Connection& c) { return CheckSessionBody(c, record); }));
  session::Session session;
  session.header = record.header;
  for (const ColumnSpec& spec : record.columns) session.columns.push_back({spec.name, {}, {}});
  RETURN_IF_ERROR(VisitChunks(record, 0, [&](const records::Chunk& chunk) {
    for (size_t i = 0; i < session.columns.size(); ++i) {
      session::Column& whole = session.columns[i];
      const session::Column& part = chunk.columns()[i];
      whole.values.insert(whole.values.end(), part.values.begin(), part.values.end());
      whole.texts.insert(whole.texts.end(), part.texts.begin(), part.texts.end());
    }
    return absl::OkStatus();
  }));
  return session;
}

absl::Status SqliteStore::VisitParts(const ProgramRecord& program, int64_t offset,
                                     const std::function<absl::Status(const std::string&)>& visit) {
  while (true) {
    ASSIGN_OR_RETURN(const std::optional<std::string> bytes,
                     readers_.Run([&](Connection& c) { return ReadPart(c, program, offset); }));
    if (!bytes.has_value()) return absl::OkStatus();
    RETURN_IF_ERROR(visit(*bytes));
    offset += static_cast<int64_t>(bytes->size());
  }
}

absl::Status SqliteStore::ReadProgram(ProgramId id, int64_t offset,
                                      const std::function<absl::Status(const std::string& bytes)>& visit) {
  if (offset < 0) return InvalidArgument(absl::StrCat("offset = ", offset, ", must be >= 0"), "PART_INVALID");
  ASSIGN_OR_RETURN(const ProgramRecord program, GetProgram(id));
  if (program.state != ProgramState::kComplete) {
    return FailedPrecondition(absl::StrCat("program ", id.number(), " is not complete"), "PROGRAM_NOT_COMPLETE");
  }
  return VisitParts(program, offset, visit);
}

absl::StatusOr<ProgramRecord> SqliteStore::FinishProgram(ProgramId id, int64_t byte_count, const std::string& sha256) {
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
  return Write<ProgramRecord>(Growth::kStays, [&](Connection& c) -> absl::StatusOr<ProgramRecord> {
    ASSIGN_OR_RETURN(const ProgramRecord present, storage::GetProgram(c, id));
    if (present.byte_count != program.byte_count)
      return FailedPrecondition("parts were added while it was finished", "TOTALS_MISMATCH");
    return storage::FinishProgram(c, id, byte_count, computed);
  });
}

}  // namespace axiscal::storage
