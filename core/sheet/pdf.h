// A sheet as one page of A4 in PDF, with its text to select and search.
#ifndef AXISCAL_CORE_SHEET_PDF_H_
#define AXISCAL_CORE_SHEET_PDF_H_

#include <string>

#include "core/base/status.h"
#include "core/sheet/sheet.h"

namespace axiscal::sheet {

// Laid out by Pango in the system's sans-serif font, in 9 points, smaller where there is much of it.
// FAILED_PRECONDITION where the system has no font.
absl::StatusOr<std::string> ToPdf(const Sheet& sheet);

}  // namespace axiscal::sheet

#endif  // AXISCAL_CORE_SHEET_PDF_H_
