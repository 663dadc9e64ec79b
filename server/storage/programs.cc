#include "server/storage/programs.h"

#include <algorithm>

#include "core/base/crc32c.h"
#include "server/storage/access.h"
#include "server/storage/machines.h"
#include "server/storage/page_token.h"
#include "server/storage/refusal.h"
#include "server/storage/request.h"
#include "server/storage/zstd_bytes.h"

namespace axiscal::storage {
namespace {

constexpr char kSelectProgram[] =
    "SELECT p.id, p.kind, p.name, p.state, p.byte_count, p.sha256, p.created_by, p.created_at_utc_us FROM program AS "
    "p ";

std::string Place(ProgramId id) { return absl::StrCat("program ", id.number()); }

ProgramRecord ReadProgram(const Statement& row) {
  return {ProgramId(row.Int(0)), row.Text(1), row.Text(2), row.As<ProgramState>(3), row.Int(4),
          row.Text(5),           row.Text(6), row.Time(7)};
}

absl::Status Damaged(ProgramId id, int64_t first_byte, const std::string& what) {
  return base::Error(
      absl::StatusCode::kDataLoss, absl::StrCat(Place(id), ", part at byte ", first_byte, " is damaged: ", what),
      {"PART_DAMAGED", {{"program", std::to_string(id.number())}, {"offset", std::to_string(first_byte)}}});
}

// A part that was appended before.
absl::Status CheckRepeat(Connection& connection, ProgramId id, const EncodedPart& part) {
  ASSIGN_OR_RETURN(
      Statement row,
      connection.Ask("SELECT byte_count, crc32c FROM program_part WHERE program_id = ?1 AND first_byte = ?2", id,
                     part.first_byte));
  ASSIGN_OR_RETURN(const bool found, row.Step());
  if (found && row.Int(0) == part.byte_count && row.Int(1) == part.crc32c) return absl::OkStatus();
  return base::Error(absl::StatusCode::kAlreadyExists,
                     absl::StrCat(Place(id), " has other content at byte ", part.first_byte), {"PART_CONFLICT", {}});
}

// Those that the principal sent, and those of the machines that it sees.
absl::StatusOr<std::string> NewestVisible(Connection& connection, const Visible& visible, const std::string& kind,
                                          const PageStart& start) {
  const auto sql = [](const std::string& table, const std::string& key) {
    return absl::StrCat(
        "SELECT v.program_id FROM ", table, " AS v CROSS JOIN program AS p ON p.id = v.program_id WHERE v.", key,
        " = ?1 AND v.program_id < ?2 AND v.program_id > ?3 AND p.state = 2 AND (?5 = '' OR p.kind = ?5) "
        "ORDER BY v.program_id DESC LIMIT ?4");
  };
  ASSIGN_OR_RETURN(std::vector<int64_t> ids,
                   NewestIds(connection, sql("program_holder", "holder"), std::vector<std::string>{visible.principal},
                             start.before_id, start.row_limit(), kind));
  ASSIGN_OR_RETURN(const std::vector<int64_t> machines, MachinesIn(connection, visible.scopes));
  ASSIGN_OR_RETURN(ids, NewestIds(connection, sql("program_machine", "machine_id"), machines, start.before_id,
                                  start.row_limit(), kind, std::move(ids)));
  return JsonOf(ids);
}

absl::Status DropParts(Connection& connection, ProgramId id) {
  return connection.Run("DELETE FROM program_part WHERE program_id = ?1", id);
}

}  // namespace

absl::StatusOr<std::optional<ProgramId>> FindContent(Connection& connection, const std::string& sha256,
                                                     const std::string& kind) {
  ASSIGN_OR_RETURN(Statement row,
                   connection.Ask("SELECT id FROM program WHERE sha256 = ?1 AND kind = ?2", sha256, kind));
  ASSIGN_OR_RETURN(const bool found, row.Step());
  if (!found) return std::nullopt;
  return ProgramId(row.Int(0));
}

absl::StatusOr<EncodedPart> PreparePart(int64_t offset, const std::string& bytes) {
  if (bytes.empty() || bytes.size() > kMaxPartBytes || offset < 0) {
    return InvalidArgument(
        absl::StrCat("part of ", bytes.size(), " bytes at ", offset, ", must be 1 .. ", kMaxPartBytes, " at >= 0"),
        "PART_INVALID");
  }
  return EncodedPart{offset, static_cast<int64_t>(bytes.size()), base::Crc32c(0, bytes.data(), bytes.size()),
                     Compress(bytes)};
}

absl::StatusOr<ProgramRecord> BeginProgram(Connection& connection, const Moment& now, const NewProgram& program,
                                           const std::vector<ProgramId>& damaged) {
  BodyHash hash;
  const std::string body_sha256 = hash.Add(program.kind).Add(program.name).Hex();
  ASSIGN_OR_RETURN(const std::optional<int64_t> same, FindRequest(connection, "program", program.caller, body_sha256));
  if (same.has_value()) {
    ASSIGN_OR_RETURN(ProgramRecord present, GetProgram(connection, ProgramId(*same)));
    // What was given up, or what the disk has changed, can be sent again.
    const bool is_damaged = std::find(damaged.begin(), damaged.end(), present.id) != damaged.end();
    if (present.state != ProgramState::kExpired && !is_damaged) return present;
  }
  ASSIGN_OR_RETURN(
      const int64_t number,
      connection.Insert(
          "INSERT INTO program (kind, name, state, byte_count, created_by, request_id, body_sha256, created_at_utc_us, "
          "last_seen_at_utc_us, last_seen_up_us) "
          "VALUES (?1, ?2, 1, 0, ?3, ?4, ?5, ?6, ?6, ?7)",
          program.kind, program.name, program.caller.principal, RequestId(program.caller), body_sha256, now.utc,
          now.up_us));
  const ProgramId id(number);
  RETURN_IF_ERROR(
      connection.Run("INSERT INTO program_holder (holder, program_id) VALUES (?1, ?2)", program.caller.principal, id));
  if (program.machine) {
    ASSIGN_OR_RETURN(const int64_t machine, LiveMachineKey(connection, *program.machine));
    RETURN_IF_ERROR(
        connection.Run("INSERT INTO program_machine (machine_id, program_id) VALUES (?1, ?2)", machine, id));
  }
  return GetProgram(connection, id);
}

absl::StatusOr<ProgramRecord> AppendProgram(Connection& connection, const Moment& now, ProgramId id,
                                            const EncodedPart& part) {
  ASSIGN_OR_RETURN(const ProgramRecord program, GetProgram(connection, id));
  if (program.state == ProgramState::kExpired) return FailedPrecondition(Place(id) + " was given up", "PROGRAM_CLOSED");
  if (part.first_byte < program.byte_count) {
    RETURN_IF_ERROR(CheckRepeat(connection, program.id, part));
    return program;
  }
  if (program.state != ProgramState::kOpen) return FailedPrecondition(Place(id) + " is complete", "PROGRAM_CLOSED");
  if (part.first_byte > program.byte_count) {
    return base::Error(absl::StatusCode::kOutOfRange,
                       absl::StrCat(Place(id), ": offset ", part.first_byte, ", expected ", program.byte_count),
                       {"OFFSET_GAP", {{"next_offset", std::to_string(program.byte_count)}}});
  }
  RETURN_IF_ERROR(connection.Run(
      "INSERT INTO program_part (program_id, first_byte, byte_count, crc32c, content) VALUES (?1, ?2, ?3, ?4, ?5)", id,
      part.first_byte, part.byte_count, static_cast<int64_t>(part.crc32c), Blob{part.content}));
  RETURN_IF_ERROR(
      connection.Run("UPDATE program SET byte_count = byte_count + ?2, last_seen_at_utc_us = ?3, "
                     "last_seen_up_us = ?4 WHERE id = ?1",
                     id, part.byte_count, now.utc, now.up_us));
  return GetProgram(connection, id);
}

absl::StatusOr<ProgramRecord> FinishProgram(Connection& connection, ProgramId id, int64_t byte_count,
                                            const std::string& sha256, std::optional<ProgramId> damaged) {
  ASSIGN_OR_RETURN(const ProgramRecord program, GetProgram(connection, id));
  if (program.state == ProgramState::kExpired) return FailedPrecondition(Place(id) + " was given up", "PROGRAM_CLOSED");
  if (program.byte_count != byte_count || (program.state == ProgramState::kComplete && program.sha256 != sha256)) {
    return FailedPrecondition(absl::StrFormat("%s: totals say %d bytes, sha256 %s; stored are %d bytes", Place(id),
                                              byte_count, sha256, program.byte_count),
                              "TOTALS_MISMATCH");
  }
  if (program.state == ProgramState::kComplete) return program;
  ASSIGN_OR_RETURN(const std::optional<ProgramId> same, FindContent(connection, sha256, program.kind));
  if (same.has_value()) {
    if (same == damaged) {
      RETURN_IF_ERROR(DropParts(connection, *same));
      RETURN_IF_ERROR(connection.Run("UPDATE program_part SET program_id = ?2 WHERE program_id = ?1", id, *same));
      RETURN_IF_ERROR(connection.Run("UPDATE program SET byte_count = ?2 WHERE id = ?1", *same, byte_count));
    } else {
      RETURN_IF_ERROR(DropParts(connection, id));
    }
    RETURN_IF_ERROR(connection.Run("UPDATE program SET state = 3, same_as = ?2 WHERE id = ?1", id, *same));
    // Who sent it has what it was merged into.
    RETURN_IF_ERROR(
        connection.Run("INSERT INTO program_holder (holder, program_id) "
                       "SELECT holder, ?2 FROM program_holder WHERE holder = ?3 AND program_id = ?1 "
                       "ON CONFLICT DO NOTHING",
                       id, *same, program.created_by));
    RETURN_IF_ERROR(
        connection.Run("DELETE FROM program_holder WHERE holder = ?2 AND program_id = ?1", id, program.created_by));
    RETURN_IF_ERROR(
        connection.Run("INSERT INTO program_machine (machine_id, program_id) "
                       "SELECT machine_id, ?2 FROM program_machine WHERE program_id = ?1 ON CONFLICT DO NOTHING",
                       id, *same));
    RETURN_IF_ERROR(connection.Run("DELETE FROM program_machine WHERE program_id = ?1", id));
  } else {
    RETURN_IF_ERROR(connection.Run("UPDATE program SET state = 2, sha256 = ?2 WHERE id = ?1", id, sha256));
  }
  return GetProgram(connection, id);
}

absl::StatusOr<ProgramRecord> GetProgram(Connection& connection, ProgramId id) {
  ASSIGN_OR_RETURN(
      Statement row,
      connection.Ask(std::string(kSelectProgram) +
                         "WHERE p.id = (SELECT coalesce(q.same_as, q.id) FROM program AS q WHERE q.id = ?1)",
                     id));
  ASSIGN_OR_RETURN(const bool found, row.Step());
  if (!found) return NotFound("program", "PROGRAM", std::to_string(id.number()));
  return ReadProgram(row);
}

absl::StatusOr<Page<ProgramRecord>> ListPrograms(Connection& connection, const ProgramFilter& filter,
                                                 const PageRequest& request, const Visible& visible) {
  ASSIGN_OR_RETURN(const PageStart start, StartPageById(request, "programs|" + filter.kind));
  std::string sql = std::string(kSelectProgram) + "WHERE p.id < ?1 AND p.state = 2";
  if (!filter.kind.empty()) sql += " AND p.kind = ?2";
  std::string ids;
  if (!visible.everything) {
    ASSIGN_OR_RETURN(ids, NewestVisible(connection, visible, filter.kind, start));
    sql += " AND p.id IN (SELECT value FROM json_each(?4))";
  }
  ASSIGN_OR_RETURN(Statement row, connection.Ask(sql + " ORDER BY p.id DESC LIMIT ?3", start.before_id, filter.kind,
                                                 start.row_limit(), ids));
  Page<ProgramRecord> page;
  while (true) {
    ASSIGN_OR_RETURN(const bool more, row.Step());
    if (!more) break;
    page.rows.push_back(ReadProgram(row));
  }
  EndPage(
      start, [](const ProgramRecord& program) { return std::to_string(program.id.number()); },
      [](const ProgramRecord& program) { return program.name.size(); }, page);
  return page;
}

absl::StatusOr<int> ExpirePrograms(Connection& connection, const Moment& now, std::chrono::microseconds idle) {
  std::vector<ProgramId> left;
  {
    ASSIGN_OR_RETURN(Statement row,
                     connection.Ask("SELECT id FROM program WHERE state = 1 AND last_seen_up_us < ?1 ORDER BY id",
                                    now.up_us - static_cast<int64_t>(idle.count())));
    while (true) {
      ASSIGN_OR_RETURN(const bool more, row.Step());
      if (!more) break;
      left.push_back(ProgramId(row.Int(0)));
    }
  }
  for (const ProgramId id : left) {
    RETURN_IF_ERROR(DropParts(connection, id));
    RETURN_IF_ERROR(connection.Run("UPDATE program SET state = 4, byte_count = 0 WHERE id = ?1", id));
    RETURN_IF_ERROR(connection.Run(
        "DELETE FROM program_holder WHERE program_id = ?1 AND holder = (SELECT created_by FROM program WHERE id = ?1)",
        id));
  }
  return static_cast<int>(left.size());
}

absl::StatusOr<std::optional<std::string>> ReadPart(Connection& connection, const ProgramRecord& program,
                                                    int64_t offset) {
  if (offset >= program.byte_count) return std::nullopt;
  ASSIGN_OR_RETURN(
      Statement row,
      connection.Ask("SELECT first_byte, byte_count, crc32c, content FROM program_part WHERE program_id = ?1 "
                     "AND first_byte <= ?2 ORDER BY first_byte DESC LIMIT 1",
                     program.id, offset));
  ASSIGN_OR_RETURN(const bool found, row.Step());
  if (!found || row.Int(0) + row.Int(1) <= offset) return Damaged(program.id, offset, "missing");
  const std::string content = row.Text(3);
  if (row.Int(1) > static_cast<int64_t>(kMaxPartBytes)) return Damaged(program.id, row.Int(0), "impossible size");
  absl::StatusOr<std::string> bytes = Decompress(content.data(), content.size(), row.Int(1));
  if (!bytes.ok()) return Damaged(program.id, row.Int(0), std::string(bytes.status().message()));
  if (base::Crc32c(0, bytes->data(), bytes->size()) != row.Int(2))
    return Damaged(program.id, row.Int(0), "checksum differs");
  return bytes->substr(offset - row.Int(0));
}

}  // namespace axiscal::storage
