// What a plan will reach, printed: `axiscal plan --certify`.
#ifndef AXISCAL_CLIENT_CLI_PLAN_CERTIFICATE_H_
#define AXISCAL_CLIENT_CLI_PLAN_CERTIFICATE_H_

#include <string>
#include <vector>

#include "client/cli/context.h"
#include "core/plan/situation.h"

namespace axiscal::cli {

struct CertificateArguments {
  std::vector<std::string> sessions;  // files of plans, or names of the registry's sessions and tests
  std::vector<std::string> setups;    // "artefact_x 2"
  std::vector<std::string> box;       // "X -200 300"
};

// `model`: the errors that count as unknown. INVALID_ARGUMENT naming option and value, NOT_FOUND for a session that is
// neither a file nor one that the machine can run.
absl::Status PrintCertificate(Context& context, const plan::Situation& situation, const machine::ErrorModel& model,
                              const CertificateArguments& arguments);

}  // namespace axiscal::cli

#endif  // AXISCAL_CLIENT_CLI_PLAN_CERTIFICATE_H_
