// What an error is, in words: those of ISO 230-1 where a machine's axes are the ones that ISO 841 names, else of joints
// and links. X, Y, Z are the directions of the machine's frame, with all axes at zero.
#ifndef AXISCAL_CORE_SHEET_ERROR_WORDS_H_
#define AXISCAL_CORE_SHEET_ERROR_WORDS_H_

#include <optional>
#include <string>

#include "core/machine/machine.h"
#include "core/sheet/sheet.h"

namespace axiscal::sheet {

// Most axes are not what their letters say in ISO 841 (X moves along X, B turns about Y ...): J1 to J6, or A1 to A6 of
// which few turn about X.
bool IsArm(const machine::Machine& machine);

// "squareness error of Y to X" of "EC0Y"; of an arm "joint 3: zero offset", "link between joints 2 and 3: length along
// X". Without a machine by the letters of the axes. A text that is no symbol: empty.
std::string ErrorWords(const std::string& symbol, const std::optional<machine::Machine>& machine, Language language);

// Of a part of an error, which its name has behind the colon: "harmonic(45).cos", in German "Harmonische(45).cos".
std::string PartWords(const std::string& part, Language language);

}  // namespace axiscal::sheet

#endif  // AXISCAL_CORE_SHEET_ERROR_WORDS_H_
