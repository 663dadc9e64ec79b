// Writes a planned session pose by pose: rotary positions and where the tool point shall stand to the table ball; the
// linear commands follow from the nominal chain.
#ifndef AXISCAL_CORE_PLAN_SESSION_BUILDER_H_
#define AXISCAL_CORE_PLAN_SESSION_BUILDER_H_

#include <string>
#include <vector>

#include "core/plan/situation.h"
#include "core/session/session.h"

namespace axiscal::plan {

class SessionBuilder {
 public:
  // `bar_mm` > 0: a ball-bar session, else an R-test.
  SessionBuilder(const Situation& situation, const std::string& session, const Eigen::Vector3d& tip_mm,
                 const Eigen::Vector3d& ball_mm, double bar_mm = 0.0);

  // The next reading. `positions`: per axis, mm or rad, of which the rotary ones count. The tool point stands
  // `offset_mm` from the table ball, in the table's frame or, for AddInBed, in the bed's. A pose that the linear axes
  // do not reach makes the session impossible.
  void Add(const std::vector<double>& positions, const Eigen::Vector3d& offset_mm);
  void AddInBed(const std::vector<double>& positions, const Eigen::Vector3d& offset_mm);

  bool is_possible() const { return is_possible_ && !session_.columns[0].values.empty(); }
  // Header and axis columns in time order, no readings.
  session::Session Finish() { return std::move(session_); }

 private:
  const Situation& situation_;
  const Eigen::Vector3d tip_mm_, ball_mm_;
  const InstrumentUse& use_;
  session::Session session_;
  bool is_possible_ = true;
};

// Header of a session on `machine`; `bar_mm` as above.
std::vector<session::HeaderEntry> HeaderOf(const machine::Machine& machine, const std::string& session,
                                           const Eigen::Vector3d& tip_mm, const Eigen::Vector3d& ball_mm, double bar_mm,
                                           double sigma_mm);

// The column names of a session on `machine`: t_s, a column per axis, temp_C where temperatures are kept.
std::vector<session::Column> ColumnsOf(const Situation& situation);

// mm or degrees with four decimals, so that an axis that stands still does not move by rounding.
double Rounded(double number);

}  // namespace axiscal::plan

#endif  // AXISCAL_CORE_PLAN_SESSION_BUILDER_H_
