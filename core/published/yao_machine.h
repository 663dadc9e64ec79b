// The machine that Yao's formulas are about.
#ifndef AXISCAL_CORE_PUBLISHED_YAO_MACHINE_H_
#define AXISCAL_CORE_PUBLISHED_YAO_MACHINE_H_

#include "core/base/status.h"
#include "core/machine/machine.h"

namespace axiscal::published {

// FAILED_PRECONDITION where the chain is another one, or turns in another sense.
absl::Status CheckYaoMachine(const machine::Machine& machine);

}  // namespace axiscal::published

#endif  // AXISCAL_CORE_PUBLISHED_YAO_MACHINE_H_
