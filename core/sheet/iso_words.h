// What ISO 230-1 calls an error of this symbol.
#ifndef AXISCAL_CORE_SHEET_ISO_WORDS_H_
#define AXISCAL_CORE_SHEET_ISO_WORDS_H_

#include <string>

#include "core/sheet/sheet.h"

namespace axiscal::sheet {

// "squareness error of Y to X" of "EC0Y". Axes go by their letters as in ISO 841 (U V beside X Y; A B C about X Y Z):
// of others, as J1, it only says where the error acts. A text that is no symbol: empty.
std::string IsoWords(const std::string& symbol, Language language);

}  // namespace axiscal::sheet

#endif  // AXISCAL_CORE_SHEET_ISO_WORDS_H_
