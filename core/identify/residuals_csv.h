// Every reading of a fit with what the model predicts for it (docs/formats.md, "Residuals").
#ifndef AXISCAL_CORE_IDENTIFY_RESIDUALS_CSV_H_
#define AXISCAL_CORE_IDENTIFY_RESIDUALS_CSV_H_

#include <string>

#include "core/identify/identify.h"

namespace axiscal::identify {

// The line of column names.
std::string ResidualsCsvHeader();
// A line per reading of every session of the fit; `part` says which fit: "fit", "check".
std::string ResidualsCsv(const std::string& part, const Fit& fit);

}  // namespace axiscal::identify

#endif  // AXISCAL_CORE_IDENTIFY_RESIDUALS_CSV_H_
