// The errors that a machine's calibrations have: a misspelt one in a mark or a tolerance would be passed over in
// silence.
#ifndef AXISCAL_SERVER_HANDLERS_KNOWN_ERRORS_H_
#define AXISCAL_SERVER_HANDLERS_KNOWN_ERRORS_H_

#include <set>
#include <string>

#include "core/machine/machine.h"
#include "server/storage/database.h"

namespace axiscal::handlers {

class KnownErrors {
 public:
  static absl::StatusOr<KnownErrors> Of(storage::Database& database, const MachineId& machine);
  // FIELD_INVALID naming `field` and the error, where no calibration of the machine has it; of a machine without a
  // calibration, where it is no symbol or of an axis that the machine has not.
  absl::Status Require(const std::string& field, const std::string& symbol) const;

 private:
  MachineId machine_;
  std::set<std::string> symbols_;  // empty: it has no calibration yet
  machine::Machine described_;     // where that is so
};

}  // namespace axiscal::handlers

#endif  // AXISCAL_SERVER_HANDLERS_KNOWN_ERRORS_H_
