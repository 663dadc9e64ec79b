// The comment that a compensated program carries, so that it is never compensated twice:
//   (AXISCAL COMPENSATED BY mt v3 SOURCE CRC32C 1A2B3C4D)
// and, where RewriteOptions::machine is stated, behind it what its words hold for:
//   (AXISCAL MACHINE mt)
//   (AXISCAL ITS CALIBRATION WARNS OF size nominal - READ ITS REPORT)
//   (AXISCAL OFFSET G54 X-490 Y0 Z0)
//   (AXISCAL TOOL LENGTH 1 IS 120.5 MM)
//   (AXISCAL TOOL RADIUS 1 IS 5 MM)
//   (AXISCAL START B0 C90 DEG)
//   (AXISCAL TOOL CHANGES LEAVE B C)
//   (AXISCAL TEMPERATURE 24.5 DEG C)
//   (AXISCAL ERROR TABLES AND VOLUMETRIC COMPENSATION OF THE CONTROL MUST BE OFF)
#ifndef AXISCAL_CORE_NC_MARK_H_
#define AXISCAL_CORE_NC_MARK_H_

#include <cstdint>
#include <string>
#include <string_view>

#include "core/compensate/compensator.h"
#include "core/nc/dialect.h"
#include "core/nc/options.h"

namespace axiscal::nc {

// Whether a comment's inside [begin, end) is a mark; case and blanks around it do not matter.
bool HasMark(const char* begin, const char* end);

// The mark as a comment of the dialect, without line end.
std::string MarkComment(const Dialect& dialect, const std::string& calibration, uint32_t source_crc32c);

// The mark and what follows it, each line with its end.
std::string HeadComments(const Dialect& dialect, const compensate::Compensator& compensator,
                         const RewriteOptions& options, uint32_t source_crc32c, const std::string& line_end);

// The machine that the head of a compensated program names; "": it names none, or the program has no mark.
std::string MarkedMachine(std::string_view program);

}  // namespace axiscal::nc

#endif  // AXISCAL_CORE_NC_MARK_H_
