// The least that a durable upload can be: a gRPC stream of bytes into one SQLite table. It waits for the disk as the
// service does (WAL, synchronous=FULL, at most kGroup chunks of what waits in one transaction, kWindow chunks under
// way) and does nothing else: no checks, no checksums, no compression.
#ifndef AXISCAL_TESTS_BENCH_BARE_UPLOAD_H_
#define AXISCAL_TESTS_BENCH_BARE_UPLOAD_H_

#include <grpcpp/grpcpp.h>

#include <memory>
#include <string>

#include "bare_upload.grpc.pb.h"
#include "core/session/session.h"

namespace axiscal::bench {

class BareServer {
 public:
  // Its table is made in a new file `database_path`.
  BareServer(const std::string& database_path, const std::string& address);
  ~BareServer();

 private:
  class Table;
  class Service;

  std::unique_ptr<Table> table_;
  std::unique_ptr<Service> service_;
  std::unique_ptr<grpc::Server> server_;
};

// All readings of `session`, `chunk_readings` at a time, over a stream of its own; returns when they are durable.
void BareUploadAll(BareUpload::Stub& stub, const session::Session& session, int chunk_readings);

}  // namespace axiscal::bench

#endif  // AXISCAL_TESTS_BENCH_BARE_UPLOAD_H_
