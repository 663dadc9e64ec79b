// The comment that a compensated program carries, so that it is never compensated twice:
//   (AXISCAL COMPENSATED BY mt v3 SOURCE CRC32C 1A2B3C4D)
#ifndef AXISCAL_CORE_NC_MARK_H_
#define AXISCAL_CORE_NC_MARK_H_

#include <cstdint>
#include <string>

#include "core/nc/dialect.h"

namespace axiscal::nc {

// Whether a comment's inside [begin, end) is a mark; case and blanks around it do not matter.
bool HasMark(const char* begin, const char* end);

// The mark as a comment of the dialect, without line end.
std::string MarkComment(const Dialect& dialect, const std::string& calibration, uint32_t source_crc32c);

}  // namespace axiscal::nc

#endif  // AXISCAL_CORE_NC_MARK_H_
