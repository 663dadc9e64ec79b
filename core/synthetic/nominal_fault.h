// Wrong nominal data: what machine.json and the headers and columns of sessions say is not what stood there. The
// simulation runs on the true machine; these change what is written.
#ifndef AXISCAL_CORE_SYNTHETIC_NOMINAL_FAULT_H_
#define AXISCAL_CORE_SYNTHETIC_NOMINAL_FAULT_H_

#include <Eigen/Core>
#include <optional>
#include <string>
#include <vector>

#include "core/base/status.h"
#include "core/machine/machine.h"
#include "core/session/session.h"

namespace axiscal::synthetic {

enum class NominalKind {
  kDirection,   // machine.json has another direction of an axis; where none is given, the opposite one
  kPivot,       // machine.json has the point of a rotary axis elsewhere
  kToolLength,  // sessions state another tool point
  kSwapped,     // two columns of a session have each other's numbers
  kUnit,        // a column is written in another unit: its numbers times a factor; -1 turns its sign
};
// "direction", "pivot" ... in the enumeration's order, ended by nullptr.
const char* const* NominalWords();

struct NominalFault {
  NominalKind kind = NominalKind::kDirection;
  int axis = -1;                                        // of kDirection, kPivot
  std::optional<Eigen::Vector3d> direction;             // of kDirection, unit
  Eigen::Vector3d offset_mm = Eigen::Vector3d::Zero();  // of kPivot, kToolLength: stated - true
  std::vector<std::string> columns;                     // of kSwapped two, of kUnit one
  double factor = 1.0;                                  // of kUnit
  std::vector<std::string> sessions;                    // all that have the columns where empty
};

// What the description says.
machine::Machine Misdescribe(const machine::Machine& machine, const std::vector<NominalFault>& faults);
// What the session's file says. INVALID_ARGUMENT where a session that was named lacks a column or the tool point.
absl::Status Misstate(const std::vector<NominalFault>& faults, session::Session* session);

}  // namespace axiscal::synthetic

#endif  // AXISCAL_CORE_SYNTHETIC_NOMINAL_FAULT_H_
