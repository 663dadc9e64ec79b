// What a fit found, put into the words of its report (result.h).
#ifndef AXISCAL_CORE_IDENTIFY_DESCRIBE_H_
#define AXISCAL_CORE_IDENTIFY_DESCRIBE_H_

#include <vector>

#include "core/identify/held.h"
#include "core/identify/honesty.h"
#include "core/identify/reduction.h"
#include "core/identify/solver.h"

namespace axiscal::identify {

// Readings that were set aside, with the gate that rejected them if one did.
std::vector<Outlier> ListOutliers(const Problem& problem, const std::vector<Eigen::MatrixXd>& residuals_mm);

std::vector<SessionFit> ListSessions(const Problem& problem, const Point& point, const Covariance& covariance,
                                     const std::vector<Eigen::MatrixXd>& residuals_mm);

// Values and uncertainties of all errors, no number where there is none, and what is known of those together.
void DescribeErrors(const Problem& problem, const Solution& solution, const NullSpace& null_space,
                    const OwedToPriors& owed, const Covariance& covariance, const std::vector<Parameter>& parameters,
                    Result* result);

// After DescribeErrors. `covariance`: of the fitted errors and the held ones.
void DescribeHeldErrors(const HeldErrors& held, const Covariance& covariance, Result* result);

}  // namespace axiscal::identify

#endif  // AXISCAL_CORE_IDENTIFY_DESCRIBE_H_
