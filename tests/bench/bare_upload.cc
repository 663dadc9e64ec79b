#include "tests/bench/bare_upload.h"

#include <sqlite3.h>

#include <algorithm>
#include <condition_variable>
#include <deque>
#include <mutex>
#include <thread>
#include <vector>

#include "core/base/demand.h"

namespace axiscal::bench {
namespace {

constexpr size_t kWindow = 8, kGroup = 32;  // server/handlers/core.h, server/storage/writer.h
constexpr int kMergeLogPages = 4096;        // server/storage/writer.cc

class SqliteTable final : public BareTable {
 public:
  explicit SqliteTable(const std::string& path) {
    DEMAND(sqlite3_open(path.c_str(), &db_) == SQLITE_OK);
    Run("PRAGMA journal_mode = WAL; PRAGMA synchronous = FULL; PRAGMA wal_autocheckpoint = 0;"
        "PRAGMA journal_size_limit = 67108864; PRAGMA cache_size = -16000;"
        "CREATE TABLE chunk (id INTEGER PRIMARY KEY, seq INTEGER NOT NULL, cells BLOB NOT NULL);");
    sqlite3_wal_hook(
        db_,
        [](void* pages, sqlite3*, const char*, int count) {
          *static_cast<int*>(pages) = count;
          return SQLITE_OK;
        },
        &log_pages_);
    DEMAND(sqlite3_prepare_v2(db_, "INSERT INTO chunk (seq, cells) VALUES (?1, ?2)", -1, &insert_, nullptr) ==
           SQLITE_OK);
  }
  ~SqliteTable() override {
    sqlite3_finalize(insert_);
    sqlite3_close(db_);
  }

  void Write(const std::vector<BareChunk>& group) override {
    Run("BEGIN IMMEDIATE");
    for (const BareChunk& chunk : group) {
      sqlite3_bind_int64(insert_, 1, chunk.seq());
      sqlite3_bind_blob64(insert_, 2, chunk.cells().data(), chunk.cells().size(), SQLITE_STATIC);
      DEMAND(sqlite3_step(insert_) == SQLITE_DONE);
      sqlite3_reset(insert_);
    }
    Run("COMMIT");
    if (log_pages_ < kMergeLogPages) return;
    if (sqlite3_wal_checkpoint_v2(db_, nullptr, SQLITE_CHECKPOINT_PASSIVE, nullptr, nullptr) == SQLITE_OK)
      log_pages_ = 0;
  }

 private:
  void Run(const char* sql) { DEMAND(sqlite3_exec(db_, sql, nullptr, nullptr, nullptr) == SQLITE_OK); }

  sqlite3* db_ = nullptr;
  sqlite3_stmt* insert_ = nullptr;
  int log_pages_ = 0;
};

}  // namespace

std::unique_ptr<BareTable> NewSqliteTable(const std::string& path) { return std::make_unique<SqliteTable>(path); }

// What waits for the table, and the thread that writes it there.
class BareServer::Queue {
 public:
  explicit Queue(std::unique_ptr<BareTable> table) : table_(std::move(table)) {
    thread_ = std::thread([this] { Loop(); });
  }
  ~Queue() {
    {
      const std::lock_guard lock(mutex_);
      closing_ = true;
    }
    changed_.notify_all();
    thread_.join();
  }

  // Blocks while kWindow chunks of the stream wait or are being written; `under_way` counts them.
  void Put(BareChunk chunk, size_t& under_way) {
    std::unique_lock lock(mutex_);
    changed_.wait(lock, [&] { return under_way < kWindow; });
    ++under_way;
    waiting_.push_back({std::move(chunk), &under_way});
    changed_.notify_all();
  }
  void WaitForAll(const size_t& under_way) {
    std::unique_lock lock(mutex_);
    changed_.wait(lock, [&] { return under_way == 0; });
  }

 private:
  struct Waiting {
    BareChunk chunk;
    size_t* under_way;
  };

  void Loop() {
    std::vector<BareChunk> group;
    std::vector<size_t*> streams;
    while (true) {
      {
        std::unique_lock lock(mutex_);
        for (size_t* const under_way : streams) --*under_way;
        changed_.notify_all();
        group.clear();
        streams.clear();
        changed_.wait(lock, [this] { return closing_ || !waiting_.empty(); });
        for (; !waiting_.empty() && group.size() < kGroup; waiting_.pop_front()) {
          group.push_back(std::move(waiting_.front().chunk));
          streams.push_back(waiting_.front().under_way);
        }
      }
      if (group.empty()) return;
      table_->Write(group);
    }
  }

  const std::unique_ptr<BareTable> table_;
  std::mutex mutex_;
  std::condition_variable changed_;
  std::deque<Waiting> waiting_;  // guarded by mutex_, as are what they point to and:
  bool closing_ = false;
  std::thread thread_;
};

class BareServer::Service final : public BareUpload::Service {
 public:
  explicit Service(Queue& queue) : queue_(queue) {}

  grpc::Status Put(grpc::ServerContext* context, grpc::ServerReader<BareChunk>* reader, BareStored* stored) override {
    int64_t chunks = 0;
    size_t under_way = 0;
    for (BareChunk chunk; reader->Read(&chunk); ++chunks) queue_.Put(std::move(chunk), under_way);
    queue_.WaitForAll(under_way);
    stored->set_chunks(chunks);
    return grpc::Status::OK;
  }

 private:
  Queue& queue_;
};

BareServer::BareServer(std::unique_ptr<BareTable> table, const std::string& address)
    : queue_(std::make_unique<Queue>(std::move(table))), service_(std::make_unique<Service>(*queue_)) {
  grpc::ServerBuilder builder;
  builder.AddListeningPort(address, grpc::InsecureServerCredentials());
  builder.RegisterService(service_.get());
  server_ = builder.BuildAndStart();
  DEMAND(server_ != nullptr);
}

BareServer::~BareServer() { server_->Shutdown(std::chrono::system_clock::now()); }

void BareUploadAll(BareUpload::Stub& stub, const session::Session& session, int chunk_readings) {
  const size_t readings = session.reading_count(), step = static_cast<size_t>(chunk_readings);
  grpc::ClientContext context;
  BareStored stored;
  const std::unique_ptr<grpc::ClientWriter<BareChunk>> writer = stub.Put(&context, &stored);
  BareChunk chunk;
  int64_t seq = 0;
  for (size_t begin = 0; begin < readings; begin += step, ++seq) {
    const size_t count = std::min(step, readings - begin);
    chunk.set_seq(seq);
    chunk.mutable_cells()->clear();
    for (const session::Column& column : session.columns)
      chunk.mutable_cells()->append(reinterpret_cast<const char*>(&column.values[begin]), count * sizeof(double));
    DEMAND(writer->Write(chunk));
  }
  writer->WritesDone();
  DEMAND(writer->Finish().ok());
  DEMAND(stored.chunks() == seq);
}

}  // namespace axiscal::bench
