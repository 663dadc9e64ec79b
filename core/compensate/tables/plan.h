// What is to be made of a request for a machine and a format: which axes, from where to where.
#ifndef AXISCAL_CORE_COMPENSATE_TABLES_PLAN_H_
#define AXISCAL_CORE_COMPENSATE_TABLES_PLAN_H_

#include <string>
#include <vector>

#include "core/compensate/correction_target.h"
#include "core/compensate/table_check.h"
#include "core/compensate/tables/format.h"
#include "core/compensate/tables/request.h"

namespace axiscal::tables {

// The correction of one axis over the position of one.
struct Function {
  int corrected = 0, argument = 0;
  bool operator==(const Function&) const = default;
};

struct Plan {
  const machine::Machine& machine;
  const Format& format;
  const TableRequest& request;
  machine::ErrorModel carried = {};  // what can be carried at the stated time and temperature
  machine::ErrorModel sampled = {};  // the same without what the format's points cannot follow
  compensate::Pose reference = {};
  compensate::TableRanges ranges{};
  std::vector<Function> functions = {};  // of kOwnAxis and kAnyAxis
  std::vector<int> arguments = {};       // of kGrid and kComponents: the axes with nodes; of all: the axes that matter
  std::vector<int> together = {};  // of kComponents: axes whose positions are arguments of one block
  std::array<bool, machine::kMaxAxes> corrected_rotary{};
  int max_points = 0;
  std::vector<std::string> not_carried = {};

  double value_step(int axis) const;     // mm or rad
  double position_step(int axis) const;  // mm or rad
  double tolerance(bool is_angle) const;
  absl::StatusOr<compensate::CorrectionTarget> Target(const machine::ErrorModel& errors) const;
};

// INVALID_ARGUMENT and FAILED_PRECONDITION of MakeTable.
absl::StatusOr<Plan> MakePlan(const machine::Machine& machine, const machine::ErrorModel& errors, const Format& format,
                              const TableRequest& request);

}  // namespace axiscal::tables

#endif  // AXISCAL_CORE_COMPENSATE_TABLES_PLAN_H_
