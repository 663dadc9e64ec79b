#include "core/plan/session_builder.h"

#include <cmath>

#include "core/base/units.h"
#include "core/instruments/centres/centres_model.h"

namespace axiscal::plan {
namespace {

std::string Number(double number) { return absl::StrFormat("%.10g", number); }

std::string PointText(const Eigen::Vector3d& point_mm) {
  return absl::StrCat(Number(point_mm.x()), " ", Number(point_mm.y()), " ", Number(point_mm.z()));
}

}  // namespace

double Rounded(double number) {
  constexpr double kPerUnit = 1e4;
  return std::round(number * kPerUnit) / kPerUnit + 0.0;  // + 0.0: no negative zero
}

std::vector<session::HeaderEntry> HeaderOf(const machine::Machine& machine, const std::string& session,
                                           const Eigen::Vector3d& tip_mm, const Eigen::Vector3d& ball_mm, double bar_mm,
                                           double sigma_mm) {
  std::vector<session::HeaderEntry> header = {{"machine", machine.id},
                                              {"session", session},
                                              {"instrument", bar_mm > 0.0 ? "ballbar" : "rtest"},
                                              {"sigma_um", Number(sigma_mm * base::kUmPerMm)},
                                              {"tool_tip_mm", PointText(tip_mm)},
                                              {"table_ball_mm", PointText(ball_mm)}};
  if (bar_mm > 0.0) header.push_back({"bar_length_mm", Number(bar_mm)});
  return header;
}

std::vector<session::Column> ColumnsOf(const Situation& situation) {
  std::vector<session::Column> columns = {{"t_s", {}, {}}};
  for (const machine::Axis& axis : situation.machine->axes)
    columns.push_back({axis.name + (axis.kind == machine::AxisKind::kRotary ? "_deg" : "_mm"), {}, {}});
  if (situation.has_temperature) columns.push_back({"temp_C", {}, {}});
  return columns;
}

SessionBuilder::SessionBuilder(const Situation& situation, const std::string& session, const Eigen::Vector3d& tip_mm,
                               const Eigen::Vector3d& ball_mm, double bar_mm)
    : situation_(situation),
      tip_mm_(tip_mm),
      ball_mm_(ball_mm),
      use_(bar_mm > 0.0 ? situation.ballbar : situation.rtest) {
  session_.header = HeaderOf(*situation.machine, session, tip_mm, ball_mm, bar_mm, use_.sigma_mm);
  session_.columns = ColumnsOf(situation);
}

void SessionBuilder::Add(const std::vector<double>& positions, const Eigen::Vector3d& offset_mm) {
  const machine::Machine& machine = *situation_.machine;
  std::vector<double> commands = positions;
  if (!centres::SolveNominalCommands(machine, tip_mm_, ball_mm_ + offset_mm, commands.data()).ok()) {
    is_possible_ = false;
    return;
  }
  const double count = static_cast<double>(session_.columns[0].values.size());
  session_.columns[0].values.push_back(Rounded(situation_.start_s + count * use_.seconds_per_reading));
  for (int axis = 0; axis < machine.axis_count(); ++axis) {
    const bool is_rotary = machine.axes[axis].kind == machine::AxisKind::kRotary;
    session_.columns[1 + axis].values.push_back(Rounded(commands[axis] * (is_rotary ? base::kDegPerRad : 1.0)));
  }
  if (situation_.has_temperature) session_.columns.back().values.push_back(Rounded(situation_.temperature_celsius));
}

void SessionBuilder::AddInBed(const std::vector<double>& positions, const Eigen::Vector3d& offset_mm) {
  std::vector<double> turned = positions;
  for (const int axis : centres::LinearAxes(*situation_.machine)) turned[axis] = 0.0;
  const auto pose = machine::EvaluateChain<double>(*situation_.machine, turned.data(), {});
  Add(positions, pose.bed_from_table.rotation.transpose() * offset_mm);
}

}  // namespace axiscal::plan
