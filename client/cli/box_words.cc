#include "client/cli/box_words.h"

#include "core/base/units.h"
#include "core/session/text.h"

namespace axiscal::cli {
namespace {

bool IsRotary(const machine::Machine& machine, size_t axis) {
  return machine.axes[axis].kind == machine::AxisKind::kRotary;
}

double InFileUnit(const machine::Machine& machine, size_t axis, double position) {
  return IsRotary(machine, axis) ? position * base::kDegPerRad : position;
}

const char* FileUnit(const machine::Machine& machine, size_t axis) { return IsRotary(machine, axis) ? "deg" : "mm"; }

}  // namespace

absl::Status SetBoxRange(const std::string& text, const machine::Machine& machine, predict::Box* box) {
  const size_t blank = text.find(' ');
  std::vector<double> range;
  const bool is_range = blank != std::string::npos && session::ParseNumbers(text.substr(blank + 1), &range) &&
                        range.size() == 2 && range[0] <= range[1];
  const int axis = machine::FindAxis(machine, text.substr(0, blank));
  if (!is_range || axis < 0)
    return absl::InvalidArgumentError(absl::StrCat("--box '", text, "': expected \"AXIS MIN MAX\", an axis of machine ",
                                                   machine.id, " and its range in mm or deg"));
  const double unit = IsRotary(machine, static_cast<size_t>(axis)) ? base::kRadPerDeg : 1.0;
  box->low[axis] = unit * range[0];
  box->high[axis] = unit * range[1];
  return absl::OkStatus();
}

std::string BoxText(const machine::Machine& machine, const predict::Box& box) {
  std::string text;
  for (size_t i = 0; i < machine.axes.size(); ++i)
    absl::StrAppend(&text, text.empty() ? "" : ", ", machine.axes[i].name, " ",
                    NumberText(InFileUnit(machine, i, box.low[i])), " to ",
                    NumberText(InFileUnit(machine, i, box.high[i])), " ", FileUnit(machine, i));
  return text;
}

Json BoxJson(const machine::Machine& machine, const predict::Box& box) {
  Json list = Json::Array();
  for (size_t i = 0; i < machine.axes.size(); ++i)
    list.push_back({{"axis", machine.axes[i].name},
                    {"from", InFileUnit(machine, i, box.low[i])},
                    {"to", InFileUnit(machine, i, box.high[i])},
                    {"unit", FileUnit(machine, i)}});
  return list;
}

std::string PoseText(const machine::Machine& machine, const std::vector<double>& positions) {
  std::string at;
  for (size_t i = 0; i < positions.size(); ++i)
    absl::StrAppend(&at, at.empty() ? "" : " ", machine.axes[i].name, NumberText(InFileUnit(machine, i, positions[i])));
  return at;
}

Json PoseJson(const machine::Machine& machine, const std::vector<double>& positions) {
  Json at = Json::Object();
  for (size_t i = 0; i < positions.size(); ++i) at[machine.axes[i].name] = InFileUnit(machine, i, positions[i]);
  return at;
}

Json VectorJson(const Eigen::Vector3d& mm) {
  Json list = Json::Array();
  for (const double one : mm) list.push_back(one * base::kUmPerMm);
  return list;
}

}  // namespace axiscal::cli
