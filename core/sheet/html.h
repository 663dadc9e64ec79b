// A sheet as a page of HTML to print: alone in one file, without scripts.
#ifndef AXISCAL_CORE_SHEET_HTML_H_
#define AXISCAL_CORE_SHEET_HTML_H_

#include <string>

#include "core/sheet/sheet.h"

namespace axiscal::sheet {

// UTF-8.
std::string ToHtml(const Sheet& sheet);
// What a content policy must allow for it: "'sha256-...'" of its one style.
std::string StyleHash();

}  // namespace axiscal::sheet

#endif  // AXISCAL_CORE_SHEET_HTML_H_
