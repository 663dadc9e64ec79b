// What gRPC streams, as plain files: session files and programs up by POST, down by GET (docs/http.md); and pages to
// print (sheet_page.cc). The calls behind them are those of the API, with its roles and limits.
#ifndef AXISCAL_SERVER_HTTP_PLAIN_H_
#define AXISCAL_SERVER_HTTP_PLAIN_H_

#include <grpcpp/grpcpp.h>

#include <memory>
#include <string>

#include "server/handlers/budget.h"
#include "server/handlers/core.h"
#include "server/http/exchange.h"

namespace axiscal::http {

// What all of them need. `credentials` are those of the request.
struct PlainCall {
  handlers::Core& core;
  const std::shared_ptr<grpc::Channel>& channel;
  const Request& request;
  const access::Credentials& credentials;
  Exchange& exchange;
  handlers::Budget& budget;
};

// A session file for a machine: Session as JSON, 201 when it was stored now, 200 when it was there.
void PutSession(const PlainCall& call, const std::string& machine);
// A controller's log for a machine, as a form (multipart/form-data): PutLogResponse as JSON, 201 when it was stored
// now, 200 when it was there.
void PutLog(const PlainCall& call, const std::string& machine);
// The session file; its ETag is its checksum.
void GetSession(const PlainCall& call, int64_t id);
// A program under a name: Program as JSON, 201.
void PutProgram(const PlainCall& call, const std::string& name);
// The program's bytes, or those from "Range: bytes=N-" on; its ETag is its checksum.
void GetProgram(const PlainCall& call, int64_t id);
// A program up and corrected down, nothing stored (rewrite.cc); its report instead where JSON is wanted.
void RewriteProgram(const PlainCall& call, const std::string& machine);
// A calibration's page to print, as HTML; German by ?language=de.
void GetSheet(const PlainCall& call, int64_t id);

// What a monitoring system asks for (Admin.GetMetrics), as it wants it.
void GetMetrics(const PlainCall& call);

}  // namespace axiscal::http

#endif  // AXISCAL_SERVER_HTTP_PLAIN_H_
