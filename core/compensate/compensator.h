// The exact inverse of the chain at a pose: the linear-axis commands whose predicted tool point, on this machine, is
// the programmed one.
//
// Find q' with  tip_in_table(q'; machine with errors) = tip_in_table(q; nominal machine),  q' = q on rotary axes.
// One affine step is exact for constant errors (the tool point is affine in the linear axes at a rotary pose); errors
// that vary with the position are evaluated at the command that the machine gets, q', so the step is repeated to
// kToleranceMm.
#ifndef AXISCAL_CORE_COMPENSATE_COMPENSATOR_H_
#define AXISCAL_CORE_COMPENSATE_COMPENSATOR_H_

#include <Eigen/Core>
#include <array>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "core/base/status.h"
#include "core/machine/error_model.h"

namespace axiscal::compensate {

struct TurnColumns;  // folded_chain.h

struct Options {
  // Nominal tool point at home (all axes at zero), machine frame. A longer tool needs another compensator.
  Eigen::Vector3d tool_tip_mm = Eigen::Vector3d::Zero();
  // When and at which temperature the program runs. Errors that depend on either are left out, and listed by
  // not_carried(), when it is unknown.
  std::optional<double> time_s;
  std::optional<double> temperature_celsius;
};

inline constexpr double kToleranceMm = 1e-5;  // 0.01 um

// In the order of machine.axes: mm, rad.
using AxisValues = std::array<double, machine::kMaxAxes>;

// Commands. `sense` is the direction of each axis' last motion: +1, -1, or 0 where it
// is not known.
struct Pose {
  AxisValues position{};
  AxisValues sense{};
};

struct Correction {
  AxisValues corrected{};      // commands to give instead, mm, rad; rotary axes as programmed
  double before_mm = 0;        // predicted tool-point error without correction, table frame
  double after_mm = 0;         // with it, <= kToleranceMm
  double tilt_before_rad = 0;  // only CorrectTurned sets it: as below, without any correction
  double tilt_left_rad =
      0;  // angle between the predicted and the programmed tool direction, table frame; linear axes cannot change it
  // [k]: the tool point's motion in the table frame per mm of linear_axes()[k]. For the effect of rounding a command.
  std::array<Eigen::Vector3d, machine::kMaxAxes> tip_per_mm;
};

class Compensator {
 public:
  // INVALID_ARGUMENT when the machine, a term or the tool tip is not valid, or the tip stands on the other side than
  // the machine's tool_direction points to (CheckToolTip).
  static absl::StatusOr<Compensator> Create(const machine::Machine& machine, const machine::ErrorModel& errors,
                                            const Options& options);
  Compensator(Compensator&&) noexcept;
  Compensator& operator=(Compensator&&) noexcept;
  ~Compensator();

  // The same machine with a tool that is longer by `length_mm`. Errors of Create.
  absl::StatusOr<Compensator> WithLongerTool(double length_mm) const;

  // FAILED_PRECONDITION: the linear axes reach fewer than three directions, or no convergence (errors too large), with
  // the pose in the text. INVALID_ARGUMENT: a position that is not finite. Thread safe.
  absl::StatusOr<Correction> Correct(const Pose& pose) const;
  // The same without copying the result; `correction` is undefined after an error.
  absl::Status Correct(const Pose& pose, Correction* correction) const;
  // The same, starting the iteration at a correction that is near (mm of each axis), such as the last block's: one step
  // is then enough in most cases. The result is the same to kToleranceMm / 100.
  absl::Status Correct(const Pose& pose, const AxisValues& near_mm, Correction* correction) const;

  // The linear-axis commands with which the tool point is the programmed one while the rotary axes get the commands of
  // `turned` instead of the programmed ones (orientation.h chooses them). `near_mm` as above; Correction::before_mm and
  // tilt_before_rad are those of the programmed commands. Errors as above.
  absl::Status CorrectTurned(const Pose& pose, const AxisValues& turned, const AxisValues& near_mm,
                             Correction* correction) const;
  // The programmed tool direction: of the nominal machine, table frame, unit.
  Eigen::Vector3d NominalDirection(const Pose& pose) const;
  // The tool direction of the machine with its errors at these commands, and how the tool moves when rotary axes turn.
  void Aim(const Pose& commanded, TurnColumns* columns) const;

  // How far the correction between two poses departs from its linear interpolation, at most (mm at the tool point, all
  // axes moving linearly). Cheap: for skipping moves that need no splitting.
  double DepartureBound(const AxisValues& from, const AxisValues& to) const;
  // The same for corrections that turn the tool too (orientation.h), none of them at its bound: the departure of the
  // commands in terms of the point, and `direction_rad` in terms of the direction. `least_turn`: the least turn of the
  // tool per rad of a rotary change at either end of the move. Infinity where that may fall to zero on the way.
  double TurnDepartureBound(const AxisValues& from, const AxisValues& to, double least_turn,
                            double* direction_rad) const;
  // Travel of one axis (mm or rad) over which the correction bends so little that samples at this distance show it.
  double smooth_travel(int axis) const;

  const machine::Machine& machine() const;
  const Options& options() const;               // tool_tip_mm with what WithLongerTool added
  const Eigen::Vector3d& tool_tip_mm() const;   // Options::tool_tip_mm, with what WithLongerTool added
  const std::vector<int>& linear_axes() const;  // indices into machine().axes
  bool is_constant() const;                     // no error depends on positions or senses
  bool is_null() const;                         // no error term differs from zero: every correction is zero
  // True for an axis whose sense of motion matters (backlash).
  bool uses_sense(int axis) const;
  // The terms that differ from zero and are not left out.
  const machine::ErrorModel& carried() const;
  // Terms that are left out, with the reason: "EXX:drift: no time is stated".
  const std::vector<std::string>& not_carried() const;

 private:
  struct Impl;
  explicit Compensator(std::unique_ptr<Impl> impl);
  std::unique_ptr<Impl> impl_;
};

}  // namespace axiscal::compensate

#endif  // AXISCAL_CORE_COMPENSATE_COMPENSATOR_H_
