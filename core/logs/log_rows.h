// The rows of a controller's log: what each line holds by the names of a session's columns, and which line or pose of
// the planned session it is. Where the columns of the session come from is reduce.cc.
#ifndef AXISCAL_CORE_LOGS_LOG_ROWS_H_
#define AXISCAL_CORE_LOGS_LOG_ROWS_H_

#include <istream>
#include <optional>
#include <string>
#include <vector>

#include "core/logs/log_reader.h"
#include "core/logs/reduce.h"
#include "core/logs/sphere_centres.h"
#include "core/session/instrument_format.h"

namespace axiscal::logs {

// "X_mm", "B_deg".
std::string ColumnName(const machine::Axis& axis);
bool IsAxisName(const std::string& column);
// A mark and the rule `feature` name what was touched, or the rod that was measured.
bool IsFeature(const std::string& column);

class LogRows {
 public:
  // All of them outlive the rows.
  LogRows(const std::string& log_name, const LogTemplate& log_template, const ReduceOptions& options)
      : log_name_(log_name), template_(log_template), options_(options) {}

  // Reads the log of a session of `format`. INVALID_ARGUMENT where template, plan and machine do not say what its lines
  // hold, or a line is not of that form.
  absl::Status Read(std::istream& in, const session::InstrumentFormat& format);

  const Log& log() const { return log_; }
  const LinePattern& pattern() const { return pattern_; }
  const std::vector<LogReading>& readings() const { return log_.readings; }
  std::string LineOf(size_t reading) const;

  // A log of positions alone, in place of the centres that are computed from them.
  bool AreTouchesOfCentres() const;
  // Of the pattern, or -1.
  int FieldIndex(const std::string& name) const;
  // As logged; an axis' by its scale and offset.
  std::vector<double> NumbersOf(int field) const;
  // What the log itself says in a column of names.
  std::optional<std::string> LoggedName(const std::string& column, size_t reading) const;
  // An axis column of the session, which a reading of the same name is not.
  bool IsAxis(const std::string& column) const;
  // Axis columns in the machine's order, else in the plan's, else in the line's.
  std::vector<std::string> KnownAxes() const;
  // The plan's column, or null.
  const session::Column* Planned(const std::string& column) const;

  // Axes beside `names` that the log holds read 0, as LinuxCNC prints those that a machine does not have.
  absl::Status CheckForeignAxes(const std::vector<std::string>& names) const;

  // Reading k is line k of the plan: positions within kMaxOffPlanMm and kMaxOffPlanDeg, the same names. Of an axis that
  // rolls over (machine::RollOver) a position is the same whole turns away, and `axes` gets that of the plan's turn;
  // those in `from_plan` are the plan's own and are cut to the log's length. Notes what is missing.
  absl::Status CheckPlan(const std::vector<std::string>& from_plan, std::vector<session::Column>* axes,
                         std::vector<std::string>* notes) const;

  // Without a plan: each position of an axis that rolls over is taken on the turn that is nearest to the one before, so
  // that sense and travel are those of the axis: behind 359 deg comes 361 and not 1. Of one that goes by the difference
  // and never across 0 only a jump of a whole turn (within kMaxOffPlanDeg) is none. Notes where that was done.
  void CountOn(const std::string& column, std::vector<double>* positions_deg, std::vector<std::string>* notes) const;

  // Touches in order, those at one rotary pose together; pose k is that of the plan's line k. `axes`: positions by the
  // machine's axes, mm and deg; those of axes that roll over get the turn of their pose.
  absl::StatusOr<std::vector<TouchedPose>> Poses(std::vector<std::vector<double>>* axes) const;

 private:
  absl::Status MakePattern();
  absl::Status CheckFields() const;
  absl::Status CheckReadings() const;
  bool IsColumn(const std::string& field) const;
  absl::Status CheckPlannedNames(bool* is_any) const;
  absl::Status OffPlan(size_t reading, const std::string& column, double number, size_t plan_line,
                       double planned) const;
  machine::RollOver RollOverOf(const std::string& column) const;
  double AtTurnOf(double place, const std::string& column, double number) const;

  const std::string& log_name_;
  const LogTemplate& template_;
  const ReduceOptions& options_;
  const session::InstrumentFormat* format_ = nullptr;
  LinePattern pattern_;
  Log log_;
};

}  // namespace axiscal::logs

#endif  // AXISCAL_CORE_LOGS_LOG_ROWS_H_
