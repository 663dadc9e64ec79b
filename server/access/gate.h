// The one place where it is decided who may do what: whom a caller's token or certificate stands for, and whether the
// table of methods lets that principal make this call.
#ifndef AXISCAL_SERVER_ACCESS_GATE_H_
#define AXISCAL_SERVER_ACCESS_GATE_H_

#include <optional>
#include <string>
#include <vector>

#include "core/base/clock.h"
#include "server/access/methods.h"
#include "server/access/named.h"
#include "server/storage/database.h"

namespace axiscal::access {

// What a caller shows. Nothing of it is a name that the caller merely states.
struct Credentials {
  std::optional<std::string> authorization;     // the metadata of that name
  std::optional<std::string> certificate_name;  // the common name of a certificate that TLS has verified
  std::optional<base::UtcTime> certificate_ends;
  std::string login;  // of a caller on this machine, as the operating system tells
};

struct Identity {
  std::string name;       // the principal's, or "local:LOGIN"
  bool is_local = false;  // of a service that asks nobody: may do everything
  std::vector<records::Grant> grants;
};

// 256 bits from the operating system's generator, as text ("axt_...") that is shown once.
std::string NewToken();
// As it is stored.
std::string HashOfToken(const std::string& token);

// What a refusal of Gate::Admit() was about ("calibrations/12", "machines/mt"), for the audit: also of a NOT_FOUND that
// hides what is there. It stays in this process; nothing of it is sent. Nothing of other statuses.
std::optional<std::string> DeniedResource(const absl::Status& status);

// Safe from any thread.
class Gate {
 public:
  // `asks`: callers must show who they are; else everybody is local.
  Gate(storage::Database& database, bool asks, base::Clock& clock = base::SystemClock())
      : database_(database), asks_(asks), clock_(clock) {}

  // UNAUTHENTICATED IDENTITY_MISSING, TOKEN_INVALID (unknown, revoked or over: not told apart), PRINCIPAL_UNKNOWN
  // (that a certificate names), CERTIFICATE_ENDED.
  absl::StatusOr<Identity> Identify(const Credentials& credentials) const;

  // What lists may show. `named` is what the request names (NamedIn()); nothing before the first message of a stream,
  // where the method alone is decided. What is outside every scope of the caller: the NOT_FOUND of what does not exist;
  // in scope with too small a role: PERMISSION_DENIED ROLE_MISSING, which names the role, or FOUR_EYES.
  absl::StatusOr<storage::Visible> Admit(const Identity& identity, const std::string& method,
                                         const std::optional<std::vector<storage::Resource>>& named) const;
  // Whether a principal may still do what it was let do before, as Admit(). A name that is no principal's may: it is
  // from a time in which nobody was asked.
  absl::Status MayStill(const std::string& name, const std::string& method,
                        const std::vector<storage::Resource>& named) const;
  bool asks() const { return asks_; }

 private:
  absl::Status AdmitNamed(const Identity& identity, const MethodRule& rule, const storage::Resource& named) const;

  storage::Database& database_;
  const bool asks_;
  base::Clock& clock_;
};

}  // namespace axiscal::access

#endif  // AXISCAL_SERVER_ACCESS_GATE_H_
