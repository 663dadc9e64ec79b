// What is known of the set-ups of planned sessions, stated in their headers before they are judged or run: a block that
// stands within 2 um of where it should, a sphere with a certificate.
#ifndef AXISCAL_CORE_PLAN_STATE_SETUPS_H_
#define AXISCAL_CORE_PLAN_STATE_SETUPS_H_

#include <string>
#include <vector>

#include "core/base/status.h"
#include "core/machine/machine.h"
#include "core/session/session.h"

namespace axiscal::plan {

// Each of "artefact_x 2" becomes `# artefact_x_sigma_um: 2` (um, of angles urad) in the sessions whose set-up has that
// offset, in place of what they state; "feature 1", of touches, is all features of an artefact. INVALID_ARGUMENT naming
// the text where it is none or no session of `plan` has the offset, and as PlannedRun.
absl::Status StateSetups(const machine::Machine& machine, const std::vector<std::string>& stated,
                         const std::vector<session::Session*>& plan);

}  // namespace axiscal::plan

#endif  // AXISCAL_CORE_PLAN_STATE_SETUPS_H_
