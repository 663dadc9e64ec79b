#include "server/storage/chunks.h"

#include "server/storage/chunk_codec.h"
#include "server/storage/refusal.h"
#include "server/storage/sessions.h"

namespace axiscal::storage {
namespace {

std::string Place(SessionId id, int64_t seq) { return absl::StrCat("session ", id.number(), ", chunk ", seq); }

absl::Status Damaged(SessionId id, int64_t seq, const std::string& what) {
  return base::Error(absl::StatusCode::kDataLoss,
                     absl::StrCat(Place(id, seq), " is damaged: ", what,
                                  "; restore a backup, or send the session again, which makes a new one"),
                     {"CHUNK_DAMAGED", {{"session", std::to_string(id.number())}, {"seq", std::to_string(seq)}}});
}

// Of a chunk that a session should have.
absl::Status Missing(Connection& connection, SessionId id, int64_t seq) {
  ASSIGN_OR_RETURN(const bool is_detached, connection.HasDetached(id));
  if (!is_detached) return Damaged(id, seq, "missing");
  return base::Error(absl::StatusCode::kFailedPrecondition,
                     absl::StrCat("the readings of session ", id.number(),
                                  " were detached from the database with those of sessions of its time: whoever looks "
                                  "after it can attach them again (docs/scale.md)"),
                     {kReadingsDetached, {{"session", std::to_string(id.number())}}});
}

// The readings of a row, exactly as they were appended.
absl::StatusOr<records::Chunk> DecodeRow(SessionId id, int64_t seq, const std::vector<ColumnSpec>& specs,
                                         const std::string& content, int64_t crc32c, int64_t reading_count) {
  absl::StatusOr<std::vector<session::Column>> columns = DecodeChunk(content, specs);
  if (!columns.ok()) return Damaged(id, seq, std::string(columns.status().message()));
  records::Chunk chunk = records::Chunk::Seal(seq, *std::move(columns));
  if (chunk.crc32c() != crc32c) return Damaged(id, seq, "checksum differs");
  if (chunk.reading_count() != reading_count) return Damaged(id, seq, "number of readings differs");
  return chunk;
}

// A chunk that was appended before. What is stored must be whole: a good copy is no repeat of a damaged one.
absl::StatusOr<AppendResult> CheckRepeat(Connection& connection, SessionId id, const EncodedChunk& chunk,
                                         int64_t next_seq) {
  ASSIGN_OR_RETURN(Statement row,
                   connection.Ask("SELECT crc32c, reading_count, content FROM chunk WHERE session_id = ?1 AND seq = ?2",
                                  id, chunk.seq));
  ASSIGN_OR_RETURN(const bool found, row.Step());
  if (!found) return Missing(connection, id, chunk.seq);
  const bool is_same = row.Int(0) == chunk.crc32c && row.Int(1) == chunk.reading_count;
  const std::string content = row.Text(2);
  // Written by another version, equal readings may be other bytes.
  if (!is_same || content != chunk.content) {
    ASSIGN_OR_RETURN(const std::vector<ColumnSpec> specs, GetSessionColumns(connection, id));
    RETURN_IF_ERROR(DecodeRow(id, chunk.seq, specs, content, row.Int(0), row.Int(1)).status());
  }
  if (!is_same) {
    return base::Error(absl::StatusCode::kAlreadyExists, Place(id, chunk.seq) + " is there with other content",
                       {"CHUNK_CONFLICT", {{"next_seq", std::to_string(next_seq)}}});
  }
  return AppendResult{next_seq, true};
}

// Of a chunk that is not the next one of an open session: a repeat, or why it is refused.
absl::StatusOr<AppendResult> NotAppended(Connection& connection, SessionId id, const EncodedChunk& chunk) {
  SessionState state;
  int64_t next_seq;
  {
    ASSIGN_OR_RETURN(Statement row, connection.Ask("SELECT state, next_seq FROM session WHERE id = ?1", id));
    ASSIGN_OR_RETURN(const bool found, row.Step());
    if (!found) return NotFound("session", "SESSION", std::to_string(id.number()));
    state = row.As<SessionState>(0);
    next_seq = row.Int(1);
  }
  if (chunk.seq < next_seq) return CheckRepeat(connection, id, chunk, next_seq);
  if (state != SessionState::kOpen)
    return FailedPrecondition(Place(id, chunk.seq) + ": the session is closed", "SESSION_CLOSED");
  return base::Error(absl::StatusCode::kOutOfRange, absl::StrCat(Place(id, chunk.seq), ": expected seq ", next_seq),
                     {"SEQ_GAP", {{"next_seq", std::to_string(next_seq)}}});
}

}  // namespace

absl::StatusOr<EncodedChunk> PrepareChunk(const records::Chunk& chunk, const std::vector<ColumnSpec>& specs) {
  if (!chunk.HasColumns(specs)) {
    return InvalidArgument(absl::StrCat("chunk ", chunk.seq(), ": its columns are not the session's"), "CHUNK_INVALID");
  }
  return EncodedChunk{chunk.seq(), chunk.reading_count(), chunk.crc32c(), EncodeChunk(chunk.columns())};
}

absl::StatusOr<AppendResult> AppendChunk(Connection& connection, const Moment& now, SessionId id,
                                         const EncodedChunk& chunk) {
  // One statement where all is well: an answer of a server takes longer than the row.
  RETURN_IF_ERROR(
      connection.Run("UPDATE session SET next_seq = next_seq + 1, reading_count = reading_count + ?2, "
                     "last_seen_at_utc_us = ?3, last_seen_up_us = ?4 WHERE id = ?1 AND state = 1 AND next_seq = ?5",
                     id, chunk.reading_count, now.utc, now.up_us, chunk.seq));
  if (connection.changed_rows() == 0) return NotAppended(connection, id, chunk);
  RETURN_IF_ERROR(
      connection.Run("INSERT INTO chunk (session_id, seq, reading_count, crc32c, content) VALUES (?1, ?2, ?3, ?4, ?5)",
                     id, chunk.seq, chunk.reading_count, static_cast<int64_t>(chunk.crc32c), Blob{chunk.content}));
  return AppendResult{chunk.seq + 1, false};
}

absl::StatusOr<std::optional<records::Chunk>> ReadChunk(Connection& connection, const SessionRecord& session,
                                                        int64_t seq) {
  if (seq >= session.next_seq) return std::nullopt;
  ASSIGN_OR_RETURN(Statement row,
                   connection.Ask("SELECT crc32c, reading_count, content FROM chunk WHERE session_id = ?1 AND seq = ?2",
                                  session.id, seq));
  ASSIGN_OR_RETURN(const bool found, row.Step());
  if (!found) return Missing(connection, session.id, seq);
  return DecodeRow(session.id, seq, session.columns, row.Text(2), row.Int(0), row.Int(1));
}

}  // namespace axiscal::storage
