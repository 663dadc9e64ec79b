// A database in a directory of its own that goes with the test.
#ifndef AXISCAL_SERVER_STORAGE_TESTING_TEMP_DATABASE_H_
#define AXISCAL_SERVER_STORAGE_TESTING_TEMP_DATABASE_H_

#include <filesystem>
#include <memory>
#include <string>
#include <vector>

#include "core/base/demand.h"
#include "core/base/testing/fake_clock.h"
#include "core/session/checksum.h"
#include "server/storage/check.h"
#include "server/storage/postgres_connection.h"
#include "server/storage/postgres_database.h"
#include "server/storage/sqlite_connection.h"
#include "server/storage/sqlite_database.h"

namespace axiscal::storage {

class TempDirectory {
 public:
  TempDirectory() {
    std::string name = (std::filesystem::temp_directory_path() / "axiscal-test-XXXXXX").string();
    DEMAND(mkdtemp(name.data()) != nullptr);
    path_ = name;
  }
  ~TempDirectory() { std::filesystem::remove_all(path_); }
  TempDirectory(const TempDirectory&) = delete;
  std::string File(const std::string& name) const { return (path_ / name).string(); }

 private:
  std::filesystem::path path_;
};

// A database server that tests are run against instead of SQLite.
class TestServer {
 public:
  virtual ~TestServer() = default;
  // A new database, empty or with the present schema: its URL.
  virtual std::string MakeDatabase(bool has_schema) = 0;
  virtual void DropDatabase(const std::string& url) = 0;

  static inline TestServer* present = nullptr;
};

// Open from the start; Close() and Open() play a restart.
class TempDatabase {
 public:
  TempDatabase() : url_(TestServer::present == nullptr ? "" : TestServer::present->MakeDatabase(true)) { Open(); }
  ~TempDatabase() {
    Close();
    if (!url_.empty()) TestServer::present->DropDatabase(url_);
  }
  TempDatabase(const TempDatabase&) = delete;
  Database* operator->() { return database_.get(); }
  Database& operator*() { return *database_; }
  void Close() { database_.reset(); }
  void Open() {
    absl::StatusOr<std::unique_ptr<Database>> opened = url_.empty() ? OpenFile() : OpenServer();
    DEMAND(opened.ok());
    database_ = *std::move(opened);
  }
  const std::string& url() const { return url_; }  // empty: of a file
  // Of SQLite alone.
  std::string path() const { return directory_.File("test.db"); }

  // What writes beside the store.
  std::unique_ptr<Connection> Beside() const {
    if (url_.empty()) return *SqliteConnection::Open(path(), Access::kWrite);
    std::unique_ptr<Connection> connection = *PostgresConnection::Open(url_, Access::kReadOnly);
    DEMAND(connection->Execute("SET default_transaction_read_only = off").ok());
    return connection;
  }
  // The same as somebody would who has the file, or is the server's owner: past triggers and references.
  std::unique_ptr<Connection> PastGuards() const {
    std::unique_ptr<Connection> connection = Beside();
    if (!url_.empty()) {
      DEMAND(connection->Execute("SET session_replication_role = replica").ok());
      return connection;
    }
    std::string drop = "PRAGMA foreign_keys = OFF;";
    {
      absl::StatusOr<Statement> row = connection->Ask("SELECT name FROM sqlite_schema WHERE type = 'trigger'");
      while (*row->Step()) drop += "DROP TRIGGER " + row->Text(0) + ";";
    }
    DEMAND(connection->Execute(drop).ok());
    return connection;
  }
  // What is damaged in a store that is closed (a file) or open or closed (of a server).
  CheckReport Check() const {
    if (url_.empty()) return *CheckStoreFile(path());
    return *CheckStoreOnServer(url_);
  }

  base::FakeClock clock;
  int64_t free_bytes = int64_t{1} << 40;
  std::vector<absl::Status> damages;  // as told; by the test's own thread alone

 private:
  absl::StatusOr<std::unique_ptr<Database>> OpenFile() {
    SqliteOptions options;
    options.path = path();
    options.clock = &clock;
    options.free_bytes = [this] { return free_bytes; };
    options.damaged = [this](const absl::Status& status) { damages.push_back(status); };
    return OpenSqlite(options);
  }
  absl::StatusOr<std::unique_ptr<Database>> OpenServer() {
    PostgresOptions options;
    options.url = url_;
    options.clock = &clock;
    options.damaged = [this](const absl::Status& status) { damages.push_back(status); };
    return OpenPostgres(options);
  }

  const std::string url_;  // empty: a SQLite file
  TempDirectory directory_;
  std::unique_ptr<Database> database_;
};

inline Caller Cell(const std::string& request_id) { return {"cell", request_id}; }

// Two number columns and a text column, different for every seq.
inline std::vector<session::Column> TestColumns(int64_t seq, int count) {
  std::vector<session::Column> columns = {{"t_s", {}, {}}, {"X_mm", {}, {}}, {"feature", {}, {}}};
  for (int i = 0; i < count; ++i) {
    columns[0].values.push_back(static_cast<double>(seq * count + i) / 1000.0);
    columns[1].values.push_back(1.0 / static_cast<double>(seq + i + 3));
    columns[2].texts.push_back("sphere " + std::to_string((seq + i) % 5));
  }
  return columns;
}

inline NewSession TestSession(const std::string& request_id) {
  NewSession session;
  session.machine = MachineId("mt");
  session.name = "CR";
  session.instrument = "touch";
  session.header = {{"machine", "mt"}, {"sigma_um", "0.3"}, {"plane A", "0 0 0 0 0 1"}};
  session.columns = {{"t_s", false}, {"X_mm", false}, {"feature", true}};
  session.caller = Cell(request_id);
  return session;
}

inline absl::StatusOr<AppendResult> Append(Database& database, SessionId id, int64_t seq,
                                           const std::vector<session::Column>& columns) {
  return database.AppendChunk(id, records::Chunk::Seal(seq, columns));
}

// A complete session of `chunks` chunks of 10 readings of machine "mt", which is made when it is missing.
inline SessionId StoreSession(Database& database, int chunks) {
  DEMAND(database.CreateMachine(MachineId("mt"), "{}", Cell("")).ok());
  const absl::StatusOr<SessionRecord> session = database.CreateSession(TestSession(""));
  DEMAND(session.ok());
  std::vector<uint32_t> crcs;
  for (int seq = 0; seq < chunks; ++seq) {
    const std::vector<session::Column> columns = TestColumns(seq, 10);
    crcs.push_back(session::ChunkCrc32c(columns));
    DEMAND(Append(database, session->id, seq, columns).ok());
  }
  DEMAND(database.FinishSession(session->id, {chunks, chunks * 10, session::SessionHash(crcs)}).ok());
  return session->id;
}

inline NewCalibration TestCalibration(UtcTime measured_at, double ea0b_urad) {
  NewCalibration calibration;
  calibration.machine = MachineId("mt");
  calibration.machine_revision = 1;
  calibration.measured_at = measured_at;
  calibration.model_json = "{\"EA0B\":1}";
  calibration.options_json = "{}";
  calibration.report_json = "{\"rank\":2}";
  calibration.engine_version = "test";
  calibration.rank = 2;
  calibration.rms_after_um = 2.97;
  calibration.created_by = "cell";
  calibration.estimates = {{"EX0C", EstimateUnit::kUm, true, 53.1, 0.5},
                           {"EA0B", EstimateUnit::kUrad, true, ea0b_urad, 0.6},
                           {"EC0C", EstimateUnit::kUrad, false, std::nullopt, std::nullopt}};
  return calibration;
}

}  // namespace axiscal::storage

#endif  // AXISCAL_SERVER_STORAGE_TESTING_TEMP_DATABASE_H_
