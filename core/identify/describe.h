// The third stage of a fit: solution and judgement in the words of the report (result.h).
#ifndef AXISCAL_CORE_IDENTIFY_DESCRIBE_H_
#define AXISCAL_CORE_IDENTIFY_DESCRIBE_H_

#include "core/identify/identify.h"
#include "core/identify/judge.h"
#include "core/identify/solve.h"

namespace axiscal::identify {

// Values and uncertainties of all errors, no number where there is none, and what is known of those together; sessions
// with their set-ups, outliers, warnings.
Fit Describe(SolvedProblem solved, const Judgement& judgement, const Options& options);

}  // namespace axiscal::identify

#endif  // AXISCAL_CORE_IDENTIFY_DESCRIBE_H_
