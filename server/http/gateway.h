// What answers requests: the Connect protocol for the API's methods, plain files, pages, and browsers' sign-in. Who may
// do what is decided by the handlers' gate (server/access), as for every call.
#ifndef AXISCAL_SERVER_HTTP_GATEWAY_H_
#define AXISCAL_SERVER_HTTP_GATEWAY_H_

#include <grpcpp/grpcpp.h>

#include <memory>
#include <optional>
#include <string>

#include "server/handlers/core.h"
#include "server/http/exchange.h"
#include "server/http/pages.h"
#include "server/http/plain.h"
#include "server/http/sign_in.h"

namespace axiscal::http {

// What may follow the head of a request: a body of so many bytes, or nothing but this answer.
struct BodyRule {
  int64_t most_bytes = 0;
  std::optional<Answer> refusal = {};
  std::string counted_as = {};  // as Request has it
  bool is_known = false;        // the caller has shown who he is, or is not asked
};

// Safe from any thread.
class Gateway {
 public:
  // `core` must outlive it. `own_host`: a name for this machine that Host may have (CheckOrigin). `max_bytes`: of all
  // bodies, files and messages at a time.
  Gateway(handlers::Core& core, std::shared_ptr<grpc::Channel> channel, const std::string& own_host, int64_t max_bytes)
      : core_(core), channel_(std::move(channel)), own_host_(own_host), budget_(max_bytes) {}

  // Of a request without its body yet.
  BodyRule RuleFor(const Request& head) const;
  // What is refused before it is a call of the API counts as one of whoever is at that address: the answer to who calls
  // too often (RATE_EXCEEDED), nothing otherwise.
  std::optional<Answer> Count(const Request& request) const;
  // Whether the log shall hear of one of those: once a second.
  bool TellsOfTooOften() const;
  // Answers it. Blocks until the caller has the answer.
  void Serve(const Request& request, Exchange& exchange);

  // Of all bodies, files and messages at a time.
  handlers::Budget& budget() { return budget_; }

 private:
  absl::StatusOr<access::Credentials> CredentialsOf(const Request& request) const;
  BodyRule RuleFor(const Request& head, const absl::StatusOr<access::Identity>& caller) const;
  absl::StatusOr<access::Identity> CallerOf(const Request& request) const;
  // The answer to what is refused before it is a call; the audit hears of it where it was denied.
  Answer Refusal(const Request& request, const absl::Status& status) const;
  void ServePlain(const Request& request, const std::vector<std::string>& place, Exchange& exchange);

  handlers::Core& core_;
  const std::shared_ptr<grpc::Channel> channel_;
  const std::string own_host_;
  const Pages pages_{EmbeddedPages()};
  SignIns sign_ins_;
  handlers::Budget budget_;
};

}  // namespace axiscal::http

#endif  // AXISCAL_SERVER_HTTP_GATEWAY_H_
