// Rules of single fields of a machine that Validate() and the reader of machine.json share: the reader names all that
// is wrong at once, where Validate() ends at the first.
#ifndef AXISCAL_CORE_MACHINE_MACHINE_LIMITS_H_
#define AXISCAL_CORE_MACHINE_MACHINE_LIMITS_H_

#include <string>

namespace axiscal::machine {

bool IsMachineId(const std::string& id);
inline constexpr char kMachineIdRule[] = "id must be 1 to 100 letters, digits, '-', '_' or '.'";

inline constexpr double kFarthestPointMm = 1e6;  // of a point on an axis, each coordinate

}  // namespace axiscal::machine

#endif  // AXISCAL_CORE_MACHINE_MACHINE_LIMITS_H_
