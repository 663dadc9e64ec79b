// The error that a table leaves: that of the tool point on the machine's one chain, before and with the table, at poses
// between the nodes. Errors are relative to the reference pose (mean of both senses): a constant shift is taken for
// part of the work offset, with and without a table.
#ifndef AXISCAL_CORE_COMPENSATE_TABLE_CHECK_H_
#define AXISCAL_CORE_COMPENSATE_TABLE_CHECK_H_

#include <cmath>
#include <functional>
#include <vector>

#include "core/compensate/table.h"

namespace axiscal::compensate {

struct Deviation {
  double largest = 0.0;  // mm or rad
  double square_sum = 0.0;
  long count = 0;

  void Add(double size) {
    largest = largest > size ? largest : size;
    square_sum += size * size;
    ++count;
  }
  double rms() const { return count == 0 ? 0.0 : std::sqrt(square_sum / static_cast<double>(count)); }
};

// The travel over which a table is made, per axis of the machine; an axis without one stays at the reference.
struct TableRange {
  bool is_set = false;
  double min = 0.0, max = 0.0;  // mm or rad
};
using TableRanges = std::array<TableRange, machine::kMaxAxes>;

// Poses with one axis moved from `reference`, both senses, at positions that are no nodes: along that axis alone.
std::vector<Pose> PosesAlong(const Pose& reference, int axis, const TableRange& range,
                             const std::vector<double>& nodes);
// Poses spread evenly over all ranges (additive recurrence), senses mixed.
std::vector<Pose> PosesWithin(const machine::Machine& machine, const Pose& reference, const TableRanges& ranges,
                              int count);

struct PointError {
  Deviation before, after;  // mm
  double tilt_rad = 0.0;    // largest angle between the tool's direction with the table and the programmed one
};

// What is commanded where `pose` is programmed.
using Commander = std::function<absl::StatusOr<Positions>(const Pose& pose)>;

class TableChecker {
 public:
  // `errors` are those that can be carried at all (Compensator::carried). The arguments must outlive it.
  TableChecker(const machine::Machine& machine, const machine::ErrorModel& errors, const Options& options,
               const Pose& reference);
  // Errors of the commanders.
  absl::StatusOr<PointError> Check(const Commander& without, const Commander& with,
                                   const std::vector<Pose>& poses) const;

 private:
  struct Seen {
    Eigen::Vector3d tip_mm, direction;
  };
  Seen See(const Positions& commanded, const Pose& pose) const;
  absl::StatusOr<Eigen::Vector3d> AtReference(const Commander& command) const;

  const machine::Machine& machine_;
  const machine::ErrorModel& errors_;
  const Options& options_;
  const Pose reference_;
};

}  // namespace axiscal::compensate

#endif  // AXISCAL_CORE_COMPENSATE_TABLE_CHECK_H_
