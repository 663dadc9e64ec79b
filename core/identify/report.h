// What an identification found, in the terms and units of its report.
#ifndef AXISCAL_CORE_IDENTIFY_REPORT_H_
#define AXISCAL_CORE_IDENTIFY_REPORT_H_

#include "core/identify/monte_carlo.h"
#include "core/identify/result.h"
#include "core/reports/identification.h"

namespace axiscal::identify {

// Errors, sessions, outliers, warnings: what the loop's report has too. Without budget and simulation.
reports::Fitted FittedOf(const Result& result);

// The same with rank, correlations, statistics and held errors. Without `before`, budget and simulation.
reports::Identification ReportOf(const Result& result);

// `before` of a report: the fit without the machine errors that are asked for.
reports::Statistics BeforeOf(const Result& without_errors);

reports::MonteCarlo ReportOf(const MonteCarloResult& result);

}  // namespace axiscal::identify

#endif  // AXISCAL_CORE_IDENTIFY_REPORT_H_
