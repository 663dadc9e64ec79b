// Numbers in texts for people.
#ifndef AXISCAL_CORE_BASE_NUMBER_TEXT_H_
#define AXISCAL_CORE_BASE_NUMBER_TEXT_H_

#include <optional>
#include <string>

namespace axiscal::base {

// Four significant digits, "-" without a number and where it is not finite.
std::string NumberText(const std::optional<double>& number);

}  // namespace axiscal::base

#endif  // AXISCAL_CORE_BASE_NUMBER_TEXT_H_
