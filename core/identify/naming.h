// Names of fitted numbers and of the combinations that the data cannot separate, or determines only together.
#ifndef AXISCAL_CORE_IDENTIFY_NAMING_H_
#define AXISCAL_CORE_IDENTIFY_NAMING_H_

#include <string>
#include <vector>

#include "core/identify/problem.h"
#include "core/identify/result.h"

namespace axiscal::identify {

// Name, symbol, unit and factor of a parameter, no value yet.
Estimate NamedEstimate(const machine::Machine& machine, const machine::ErrorModel& model, const Parameter& parameter);

// "EX0B - EX0C", "EX0C + 0.1 EB0C": coefficients in um and urad, the first one made 1, zeros left out.
std::string CombinationName(const std::vector<Estimate>& estimates, const Eigen::VectorXd& coefficients);

}  // namespace axiscal::identify

#endif  // AXISCAL_CORE_IDENTIFY_NAMING_H_
