// What gRPC streams, as plain files: session files and programs up by POST, down by GET (docs/http.md); and pages to
// print (sheet_page.cc). The calls behind them are those of the API, with its roles and limits.
#ifndef AXISCAL_SERVER_HTTP_PLAIN_H_
#define AXISCAL_SERVER_HTTP_PLAIN_H_

#include <grpcpp/grpcpp.h>

#include <atomic>
#include <memory>
#include <string>

#include "server/handlers/core.h"
#include "server/http/exchange.h"

namespace axiscal::http {

// Bytes that bodies and files may hold at a time. Safe from any thread.
class Budget {
 public:
  explicit Budget(int64_t bytes) : left_(bytes) {}
  bool Take(int64_t bytes) {
    if (left_.fetch_sub(bytes) >= bytes) return true;
    left_ += bytes;
    return false;
  }
  void Give(int64_t bytes) { left_ += bytes; }

 private:
  std::atomic<int64_t> left_;
};

// What is taken of the budget for as long as this lives.
class Share {
 public:
  explicit Share(Budget& budget) : budget_(budget) {}
  ~Share() { budget_.Give(bytes_); }
  Share(const Share&) = delete;
  Share& operator=(const Share&) = delete;

  // RESOURCE_EXHAUSTED QUEUE_FULL.
  absl::Status Take(int64_t bytes);

 private:
  Budget& budget_;
  int64_t bytes_ = 0;
};

// What all of them need. `credentials` are those of the request.
struct PlainCall {
  handlers::Core& core;
  const std::shared_ptr<grpc::Channel>& channel;
  const Request& request;
  const access::Credentials& credentials;
  Exchange& exchange;
  Budget& budget;
};

// A session file for a machine: Session as JSON, 201 when it was stored now, 200 when it was there.
void PutSession(const PlainCall& call, const std::string& machine);
// The session file; its ETag is its checksum.
void GetSession(const PlainCall& call, int64_t id);
// A program under a name: Program as JSON, 201.
void PutProgram(const PlainCall& call, const std::string& name);
// The program's bytes, or those from "Range: bytes=N-" on; its ETag is its checksum.
void GetProgram(const PlainCall& call, int64_t id);
// A calibration's page to print, as HTML; German by ?language=de.
void GetSheet(const PlainCall& call, int64_t id);

// What a monitoring system asks for (Admin.GetMetrics), as it wants it.
void GetMetrics(const PlainCall& call);

}  // namespace axiscal::http

#endif  // AXISCAL_SERVER_HTTP_PLAIN_H_
