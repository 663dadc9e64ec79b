#include "server/storage/check.h"

#include <functional>
#include <map>
#include <optional>
#include <utility>
#include <vector>

#include "core/base/files.h"
#include "core/base/sha256.h"
#include "core/base/utf8.h"
#include "core/session/checksum.h"
#include "server/storage/audit.h"
#include "server/storage/calibrations.h"
#include "server/storage/chunks.h"
#include "server/storage/estimates.h"
#include "server/storage/file_lock.h"
#include "server/storage/jobs.h"
#include "server/storage/machines.h"
#include "server/storage/migrate.h"
#include "server/storage/postgres_check.h"
#include "server/storage/postgres_connection.h"
#include "server/storage/programs.h"
#include "server/storage/refusal.h"
#include "server/storage/sessions.h"
#include "server/storage/transaction.h"

namespace axiscal::storage {
namespace {

// Tables, indexes and triggers by kind and name, with the text that made them: without blanks and quotes, which SQLite
// writes in its own way when a migration changes a table.
using SchemaTexts = std::map<std::string, std::string>;

absl::StatusOr<SchemaTexts> ReadSchema(Connection& connection) {
  SchemaTexts texts;
  ASSIGN_OR_RETURN(Statement row, connection.Ask("SELECT type, name, tbl_name, sql FROM sqlite_schema"));
  while (true) {
    ASSIGN_OR_RETURN(const bool more, row.Step());
    if (!more) return texts;
    const std::string name = row.Text(1);
    if (name.rfind("sqlite_", 0) == 0) continue;  // SQLite's own
    std::string text = row.Text(2) + " " + row.Text(3);
    std::erase_if(text, [](unsigned char c) { return c <= ' ' || c == '"'; });
    texts[row.Text(0) + " " + name] = text;
  }
}

// As the migrations make it.
const absl::StatusOr<SchemaTexts>& PresentSchema() {
  static const auto& texts = *new absl::StatusOr<SchemaTexts>([]() -> absl::StatusOr<SchemaTexts> {
    ASSIGN_OR_RETURN(const std::unique_ptr<SqliteConnection> connection,
                     SqliteConnection::Open(":memory:", Access::kWrite));
    RETURN_IF_ERROR(Migrate(*connection, EmbeddedMigrations(), base::UtcTime()));
    return ReadSchema(*connection);
  }());
  return texts;
}

// One look at a database. Whatever fails is a damage of the thing that was looked at, and the next one follows.
class Check {
 public:
  explicit Check(Connection& connection) : connection_(connection) {}

  CheckReport File(bool is_present_schema) {
    Note("file", Structure());
    Note("file", References());
    if (!is_present_schema) return std::move(report_);
    Note("schema", Schema());
    return Rows();
  }
  // Of a server, in a transaction that reads. UNAVAILABLE where it goes away meanwhile.
  absl::StatusOr<CheckReport> Server(bool is_present_schema) {
    // A statement that fails ends all that follow it in a transaction: what is damaged must not hide the rest.
    RETURN_IF_ERROR(connection_.Execute("SAVEPOINT look"));
    goes_back_ = true;
    const NoteDamage tell = [this](const std::string& of, const std::string& what) { Note(of, what); };
    if (is_present_schema) Note("schema", CheckPostgresObjects(connection_, PostgresMigrations(), tell));
    Note("file", CheckPostgresReferences(connection_, tell));
    CheckReport report = is_present_schema ? Rows() : std::move(report_);
    RETURN_IF_ERROR(away_);
    return report;
  }
  CheckReport Rows() {
    Descriptions();
    ForEach("session", "sessions/", "", [&](int64_t id) { return OneSession(SessionId(id)); });
    ForEach("job", "jobs/", "", [&](int64_t id) { return OneJob(JobId(id)); });
    ForEach("calibration", "calibrations/", "", [&](int64_t id) { return OneCalibration(CalibrationId(id)); });
    ForEach("machine", "machines/", "", [&](int64_t key) { return History(key); });
    // Those that were given up or merged have no content.
    ForEach("program", "programs/", " AND state IN (1, 2)", [&](int64_t id) { return OneProgram(ProgramId(id)); });
    const absl::StatusOr<AuditHead> audit = CheckAudit(connection_);
    if (audit.ok()) report_.audit = *audit;
    Note("audit", audit.status());
    return std::move(report_);
  }

 private:
  void Note(const std::string& resource, const absl::Status& status) {
    if (status.ok()) return;
    if (goes_back_ && away_.ok()) {
      const absl::Status back = connection_.Execute("ROLLBACK TO look");
      // What is not there now may be whole: a standby, too, ends a look for the sake of what it has to follow.
      away_ = absl::IsUnavailable(status) ? status : back;
    }
    Note(resource, std::string(status.message()));
  }
  void Note(const std::string& resource, const std::string& text) {
    ++report_.damage_count;
    if (report_.damages.size() < CheckReport::kMaxDamages) report_.damages.push_back({resource, text});
  }

  absl::Status Structure() {
    ASSIGN_OR_RETURN(Statement row, connection_.Ask("PRAGMA integrity_check(100)"));
    while (true) {
      ASSIGN_OR_RETURN(const bool more, row.Step());
      if (!more) return absl::OkStatus();
      if (row.Text(0) != "ok") Note("file", row.Text(0));
    }
  }
  absl::Status References() {
    ASSIGN_OR_RETURN(Statement row, connection_.Ask("SELECT \"table\", rowid, parent FROM pragma_foreign_key_check"));
    while (true) {
      ASSIGN_OR_RETURN(const bool more, row.Step());
      if (!more) return absl::OkStatus();
      Note("file", absl::StrCat("table ", row.Text(0), ", row ", row.Text(1), ": names a row of ", row.Text(2),
                                " that is not there"));
    }
  }

  // A trigger or a rule that is not what it was lets through what it shall refuse.
  absl::Status Schema() {
    ASSIGN_OR_RETURN(const SchemaTexts expected, PresentSchema());
    ASSIGN_OR_RETURN(SchemaTexts found, ReadSchema(connection_));
    for (const auto& [name, text] : expected) {
      const auto at = found.find(name);
      if (at == found.end()) {
        Note("schema", name + " is not there");
        continue;
      }
      if (at->second != text) Note("schema", name + " is not what the migrations made");
      found.erase(at);
    }
    for (const auto& [name, text] : found) Note("schema", base::ToUtf8(name) + " is none of the migrations'");
    return absl::OkStatus();
  }

  // Each row of a table in the order of its numbers. `condition` is SQL.
  void ForEach(const std::string& table, const std::string& place, const std::string& condition,
               const std::function<absl::Status(int64_t)>& look) {
    int64_t id = 0;
    while (true) {
      absl::StatusOr<std::optional<int64_t>> next = Next(table, condition, id);
      if (!next.ok()) return Note("table " + table, next.status());
      if (!next->has_value()) return;
      id = **next;
      Note(absl::StrCat(place, id), look(id));
    }
  }
  absl::StatusOr<std::optional<int64_t>> Next(const std::string& table, const std::string& condition, int64_t after) {
    ASSIGN_OR_RETURN(
        Statement row,
        connection_.Ask("SELECT id FROM " + table + " WHERE id > ?1" + condition + " ORDER BY id LIMIT 1", after));
    ASSIGN_OR_RETURN(const bool found, row.Step());
    if (!found) return std::nullopt;
    return row.Int(0);
  }

  void Descriptions() {
    absl::StatusOr<std::vector<std::pair<std::string, int64_t>>> all = ListDescriptions();
    if (!all.ok()) return Note("table machine_revision", all.status());
    for (const auto& [machine, revision] : *all) {
      Note(absl::StrCat("machines/", machine, ", revision ", revision),
           GetMachineRevision(connection_, MachineId(machine), revision).status());
      ++report_.descriptions;
    }
  }
  absl::StatusOr<std::vector<std::pair<std::string, int64_t>>> ListDescriptions() {
    std::vector<std::pair<std::string, int64_t>> all;
    ASSIGN_OR_RETURN(Statement row, connection_.Ask("SELECT m.name, r.revision FROM machine_revision AS r JOIN machine "
                                                    "AS m ON m.id = r.machine_id ORDER BY m.id, r.revision"));
    while (true) {
      ASSIGN_OR_RETURN(const bool more, row.Step());
      if (!more) return all;
      all.push_back({row.Text(0), row.Int(1)});
    }
  }

  absl::Status OneSession(SessionId id) {
    ++report_.sessions;
    ASSIGN_OR_RETURN(const SessionRecord session, GetSession(connection_, id));
    Note(absl::StrCat("sessions/", id.number()), CheckSessionBody(connection_, session));
    std::vector<uint32_t> crcs;
    int64_t readings = 0;
    for (int64_t seq = 0; seq < session.next_seq; ++seq) {
      const absl::StatusOr<std::optional<records::Chunk>> chunk = ReadChunk(connection_, session, seq);
      if (base::ErrorReason(chunk.status()) == kReadingsDetached) {
        --report_.sessions;
        return absl::OkStatus();
      }
      ++report_.chunks;
      // All that are damaged are named.
      if (!chunk.ok()) {
        Note(absl::StrCat("sessions/", id.number(), "/chunks/", seq), chunk.status());
        continue;
      }
      crcs.push_back((*chunk)->crc32c());
      readings += (*chunk)->reading_count();
    }
    if (static_cast<int64_t>(crcs.size()) < session.next_seq) return absl::OkStatus();
    ASSIGN_OR_RETURN(Statement row, connection_.Ask("SELECT count(*) FROM chunk WHERE session_id = ?1", id));
    RETURN_IF_ERROR(row.Step().status());
    if (row.Int(0) != session.next_seq || readings != session.reading_count) {
      return absl::DataLossError(absl::StrCat("has ", row.Int(0), " chunks with ", readings, " readings, its row says ",
                                              session.next_seq, " with ", session.reading_count));
    }
    if (session.state == SessionState::kComplete && session::SessionHash(crcs) != session.hash)
      return absl::DataLossError("its chunks are not those of its hash");
    return absl::OkStatus();
  }

  absl::Status OneJob(JobId id) {
    ++report_.jobs;
    ASSIGN_OR_RETURN(const JobRecord job, GetJob(connection_, id));
    return CheckJobBody(connection_, job);
  }

  absl::Status OneCalibration(CalibrationId id) {
    ++report_.calibrations;
    return GetCalibration(connection_, id).status();
  }

  // What histories are drawn from: estimates, which are compared with their calibrations, and their sums.
  absl::Status History(int64_t machine_key) {
    ASSIGN_OR_RETURN(Statement row, connection_.Ask("SELECT name FROM machine WHERE id = ?1", machine_key));
    RETURN_IF_ERROR(row.Step().status());
    const std::string place = absl::StrCat("machines/", row.Text(0), ", history of ");
    return CheckHistory(connection_, machine_key,
                        [&](const std::string& where, const std::string& what) { Note(place + where, what); });
  }

  absl::Status OneProgram(ProgramId id) {
    ++report_.programs;
    ASSIGN_OR_RETURN(const ProgramRecord program, GetProgram(connection_, id));
    base::Sha256 sha;
    int64_t offset = 0;
    while (true) {
      ASSIGN_OR_RETURN(const std::optional<std::string> part, ReadPart(connection_, program, offset));
      if (!part.has_value()) break;
      sha.Add(*part);
      offset += static_cast<int64_t>(part->size());
    }
    if (program.state == ProgramState::kComplete && sha.HexDigest() != program.sha256)
      return absl::DataLossError("its bytes are not those of its sha256");
    return absl::OkStatus();
  }

  Connection& connection_;
  bool goes_back_ = false;  // to a savepoint, after a statement that failed
  absl::Status away_;       // why the store cannot be looked at any more
  CheckReport report_;
};

// While it lives, statements of the connection end where `go_on` says so.
class Interruptible {
 public:
  Interruptible(SqliteConnection& connection, const std::function<absl::Status()>& go_on)
      : connection_(connection), go_on_(go_on) {
    constexpr int kSteps = 100'000;  // of SQLite's virtual machine: some milliseconds
    if (go_on_) sqlite3_progress_handler(connection.handle(), kSteps, &Ask, this);
  }
  ~Interruptible() { sqlite3_progress_handler(connection_.handle(), 0, nullptr, nullptr); }
  Interruptible(const Interruptible&) = delete;
  Interruptible& operator=(const Interruptible&) = delete;
  absl::Status status() const { return go_on_ ? go_on_() : absl::OkStatus(); }

 private:
  static int Ask(void* self) { return static_cast<Interruptible*>(self)->status().ok() ? 0 : 1; }

  SqliteConnection& connection_;
  const std::function<absl::Status()>& go_on_;
};

}  // namespace

absl::StatusOr<CheckReport> CheckStore(SqliteConnection& connection, const std::function<absl::Status()>& go_on) {
  const Interruptible asked(connection, go_on);
  ASSIGN_OR_RETURN(const Transaction snapshot, Transaction::BeginRead(connection));
  int64_t version = 0;
  {
    ASSIGN_OR_RETURN(Statement row, connection.Ask("PRAGMA user_version"));
    RETURN_IF_ERROR(row.Step().status());
    version = row.Int(0);
  }
  CheckReport report = Check(connection).File(version == static_cast<int64_t>(EmbeddedMigrations().size()));
  report.schema_version = static_cast<int>(version);
  RETURN_IF_ERROR(asked.status());
  return report;
}

CheckReport CheckRows(Connection& connection) { return Check(connection).Rows(); }

absl::StatusOr<CheckReport> CheckStoreFile(const std::string& path) {
  RETURN_IF_ERROR(base::RequireFile(path));
  ASSIGN_OR_RETURN(const FileLock lock, LockStoreFile(path, EmbeddedMigrations()));
  ASSIGN_OR_RETURN(const std::unique_ptr<SqliteConnection> connection,
                   SqliteConnection::Open(lock.path(), Access::kReadOnly));
  return CheckStore(*connection);
}

absl::StatusOr<CheckReport> CheckStoreOnServer(const std::string& url) {
  ASSIGN_OR_RETURN(const std::unique_ptr<PostgresConnection> connection,
                   PostgresConnection::Open(url, Access::kReadOnly));
  ASSIGN_OR_RETURN(const Transaction snapshot, Transaction::BeginRead(*connection));
  ASSIGN_OR_RETURN(const bool is_ours, connection->HasTable("migration"));
  if (!is_ours) return FailedPrecondition("not an Axiscal database", "NOT_A_DATABASE");
  int64_t version = 0;
  {
    ASSIGN_OR_RETURN(Statement row, connection->Ask("SELECT coalesce(max(version), 0) FROM migration"));
    RETURN_IF_ERROR(row.Step().status());
    version = row.Int(0);
  }
  RETURN_IF_ERROR(CheckMigrations(*connection, PostgresMigrations(), version));
  ASSIGN_OR_RETURN(CheckReport report, Check(*connection).Server(version == PostgresMigrations().back().version));
  report.schema_version = static_cast<int>(version);
  return report;
}

}  // namespace axiscal::storage
