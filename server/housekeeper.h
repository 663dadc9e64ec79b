// Drops what uploaders have left and what has passed its age, and warns of certificates that end.
#ifndef AXISCAL_SERVER_HOUSEKEEPER_H_
#define AXISCAL_SERVER_HOUSEKEEPER_H_

#include <functional>
#include <utility>
#include <vector>

#include "server/certificates.h"
#include "server/rounds.h"
#include "server/server_options.h"
#include "server/storage/database.h"

namespace axiscal::server {

class Housekeeper {
 public:
  // By the ages of `options`. Both outlive this. `certificates`: those in use.
  Housekeeper(storage::Database& database, const ServerOptions& options,
              std::function<std::vector<Certificate>()> certificates)
      : database_(database), options_(options), certificates_(std::move(certificates)) {}

  // At once, and every ten minutes until Stop().
  void Start();
  void Stop() { rounds_.Stop(); }

 private:
  void KeepHouse();
  void ExpireAudit();
  void WarnOfCertificates();

  storage::Database& database_;
  const ServerOptions& options_;
  const std::function<std::vector<Certificate>()> certificates_;
  EndWarnings end_warnings_;  // the thread's alone
  Rounds rounds_;
};

}  // namespace axiscal::server

#endif  // AXISCAL_SERVER_HOUSEKEEPER_H_
