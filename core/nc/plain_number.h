// A plain decimal number in text that is not split into words: arguments of cycles, frames, definitions.
#ifndef AXISCAL_CORE_NC_PLAIN_NUMBER_H_
#define AXISCAL_CORE_NC_PLAIN_NUMBER_H_

#include <optional>
#include <string_view>

#include "core/nc/decimal.h"

namespace axiscal::nc {

// "-20.5", "+2", " 3 ". Nothing for anything else, for more than twelve digits, or five in front of the point.
std::optional<Decimal> PlainNumber(std::string_view text);

// The same in ticks of a unit.
std::optional<Ticks> PlainTicks(std::string_view text, Ticks unit);

}  // namespace axiscal::nc

#endif  // AXISCAL_CORE_NC_PLAIN_NUMBER_H_
