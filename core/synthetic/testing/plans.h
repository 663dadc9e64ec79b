// Planned sessions for tests: a multi-tasking machine whose B and C turn to and fro while the tool follows the table's
// ball.
#ifndef AXISCAL_CORE_SYNTHETIC_TESTING_PLANS_H_
#define AXISCAL_CORE_SYNTHETIC_TESTING_PLANS_H_

#include <cmath>
#include <string>

#include "core/base/demand.h"
#include "core/base/units.h"
#include "core/instruments/centres/centres_model.h"
#include "core/machine/testing/machines.h"
#include "core/session/session.h"
#include "core/synthetic/history.h"

namespace axiscal::synthetic::testing {

// `instrument`: rtest, ballbar (a bar of 100 mm along x + y) or tracker. B swings by 40 deg, C by 170 deg with another
// period; a reading every half second.
inline session::Session Swing(const std::string& name, const std::string& instrument, int readings, double start_s) {
  const machine::Machine machine = machine::testing::MultiTasking();
  const Eigen::Vector3d tip_mm(0, 0, -300), ball_mm(120, 40, 60);
  session::Session session;
  session.header = {{"machine", "mt"},
                    {"session", name},
                    {"instrument", instrument},
                    {"sigma_um", "0.5"},
                    {"tool_tip_mm", "0 0 -300"}};
  if (instrument != "tracker") session.header.push_back({"table_ball_mm", "120 40 60"});
  if (instrument == "ballbar") session.header.push_back({"bar_length_mm", "100"});
  session.columns = {{"t_s", {}, {}}};
  for (const machine::Axis& axis : machine.axes)
    session.columns.push_back({axis.name + (axis.kind == machine::AxisKind::kLinear ? "_mm" : "_deg"), {}, {}});
  for (int k = 0; k < readings; ++k) {
    const double b_deg = std::round(4e5 * std::sin(0.031 * k)) / 1e4,
                 c_deg = std::round(17e5 * std::sin(0.017 * k)) / 1e4;
    std::vector<double> positions = {0, 0, 0, b_deg * base::kRadPerDeg, c_deg * base::kRadPerDeg};
    Eigen::Vector3d target_mm = ball_mm;
    if (instrument == "ballbar") target_mm += 100.0 / std::sqrt(2.0) * Eigen::Vector3d(1, 1, 0);
    DEMAND(centres::SolveNominalCommands(machine, tip_mm, target_mm, positions.data()).ok());
    session.columns[0].values.push_back(start_s + 0.5 * k);
    for (int axis = 0; axis < 3; ++axis) session.columns[1 + axis].values.push_back(positions[axis]);
    session.columns[4].values.push_back(b_deg);
    session.columns[5].values.push_back(c_deg);
  }
  return session;
}

// A history of which every axis takes the same path; temperatures 20 deg C unless set afterwards.
inline History Moving(const std::vector<double>& time_s, const std::vector<double>& path) {
  instruments::MeasuringRun run;
  run.axis_count = machine::testing::MultiTasking().axis_count();
  run.has_time = true;
  run.time_s = time_s;
  run.measured_mm.setZero(1, static_cast<Eigen::Index>(path.size()));
  for (const double q : path) run.positions.insert(run.positions.end(), run.axis_count, q);
  instruments::DeriveMotion(&run);
  History history;
  Append(run, {{"temp_C", std::vector<double>(path.size(), 20.0)}}, &history);
  return history;
}

}  // namespace axiscal::synthetic::testing

#endif  // AXISCAL_CORE_SYNTHETIC_TESTING_PLANS_H_
