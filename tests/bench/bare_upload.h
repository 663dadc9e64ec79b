// The least that a durable upload can be: a gRPC stream of bytes into one table of SQLite or PostgreSQL. It waits for
// the disk as the service does (at most kGroup chunks of what waits in one transaction, kWindow chunks of a stream
// under way) and does nothing else: no checks, no checksums, no compression.
#ifndef AXISCAL_TESTS_BENCH_BARE_UPLOAD_H_
#define AXISCAL_TESTS_BENCH_BARE_UPLOAD_H_

#include <grpcpp/grpcpp.h>

#include <memory>
#include <string>
#include <vector>

#include "bare_upload.grpc.pb.h"
#include "core/session/session.h"

namespace axiscal::bench {

// A table with one thread that writes to it.
class BareTable {
 public:
  virtual ~BareTable() = default;
  // Returns when they are durable: one transaction.
  virtual void Write(const std::vector<BareChunk>& group) = 0;
};

// Made in a new file; WAL, synchronous=FULL.
std::unique_ptr<BareTable> NewSqliteTable(const std::string& path);

class BareServer {
 public:
  BareServer(std::unique_ptr<BareTable> table, const std::string& address);
  ~BareServer();

 private:
  class Queue;
  class Service;

  std::unique_ptr<Queue> queue_;
  std::unique_ptr<Service> service_;
  std::unique_ptr<grpc::Server> server_;
};

// All readings of `session`, `chunk_readings` at a time, over a stream of its own; returns when they are durable.
void BareUploadAll(BareUpload::Stub& stub, const session::Session& session, int chunk_readings);

}  // namespace axiscal::bench

#endif  // AXISCAL_TESTS_BENCH_BARE_UPLOAD_H_
