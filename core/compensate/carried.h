// Which terms of an error model a program or a table can carry.
#ifndef AXISCAL_CORE_COMPENSATE_CARRIED_H_
#define AXISCAL_CORE_COMPENSATE_CARRIED_H_

#include <string>
#include <vector>

#include "core/compensate/compensator.h"

namespace axiscal::compensate {

// Appends the terms that differ from zero to `carried`, or to `not_carried` with the reason: "EXX:drift: no time is
// stated". INVALID_ARGUMENT for a term of a joint or axis that the machine lacks, or that is not finite (at
// the stated time), and for a time or temperature that is not.
absl::Status SelectCarried(const machine::Machine& machine, const machine::ErrorModel& errors, const Options& options,
                           machine::ErrorModel* carried, std::vector<std::string>* not_carried);

// How a carried term acts while a program runs, whose time and temperature are stated: what depends on them is
// constant, or linear in the position that multiplies it (shapes::Times).
machine::ErrorTerm AsStated(const machine::ErrorTerm& term, const Options& options);

}  // namespace axiscal::compensate

#endif  // AXISCAL_CORE_COMPENSATE_CARRIED_H_
