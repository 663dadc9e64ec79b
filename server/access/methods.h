// The table of methods: what each needs of whoever calls it. A method that is not in it may be called by nobody.
#ifndef AXISCAL_SERVER_ACCESS_METHODS_H_
#define AXISCAL_SERVER_ACCESS_METHODS_H_

#include <string>
#include <vector>

#include "core/records/access.h"

namespace axiscal::access {

// Whether whoever holds `held` may do what `needed` may: a technician, an approver and an admin are viewers too, an
// admin a technician and a cell, but no approver.
bool Includes(records::Role held, records::Role needed);

// For what a role must hold.
enum class Reach {
  kAnyone,   // no role is needed
  kNamed,    // all machines, sessions ... that the request names; where it names none, any machine
  kList,     // the machine that the request names; where it names none, any, and the answer has only what may be seen
  kService,  // all machines: it is about the service itself
};

struct MethodRule {
  std::string method;  // "Calibrations.ApproveCalibration"
  Reach reach = Reach::kService;
  std::vector<records::Role> any_of;  // one of these, or one that includes it
  bool four_eyes = false;             // not by whoever identified the calibration, where the machine asks for it
};

const std::vector<MethodRule>& Methods();
// Null: not in the table.
const MethodRule* FindMethod(const std::string& method);

}  // namespace axiscal::access

#endif  // AXISCAL_SERVER_ACCESS_METHODS_H_
