// A plan's functions as a table within the format's limits: nodes placed, values fitted and rounded to the controller's
// steps.
#ifndef AXISCAL_CORE_COMPENSATE_TABLES_SAMPLE_H_
#define AXISCAL_CORE_COMPENSATE_TABLES_SAMPLE_H_

#include "core/compensate/tables/format.h"
#include "core/compensate/tables/plan.h"

namespace axiscal::tables {

// Notes are left empty. FAILED_PRECONDITION when a value is beyond the controller's largest.
absl::StatusOr<Content> SampleTable(const Plan& plan);

// The points that a kinematic transformation needs for the constant terms of `errors`, mm: where the rotary axes really
// are as seen from the tool point.
std::vector<Eigen::Vector3d> PointsOf(const Plan& plan, const machine::ErrorModel& errors);

// The sum of the terms of one error component over the position of `argument` (-1: the constant terms), mm or rad.
double ComponentAt(const machine::Machine& machine, const machine::ErrorModel& errors,
                   const compensate::Options& options, int target, int argument, double position, double sense);

}  // namespace axiscal::tables

#endif  // AXISCAL_CORE_COMPENSATE_TABLES_SAMPLE_H_
