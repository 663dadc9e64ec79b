// Machines with known errors, and tables made of them, for the tests of the formats.
#ifndef AXISCAL_CORE_COMPENSATE_TABLES_TESTING_MADE_H_
#define AXISCAL_CORE_COMPENSATE_TABLES_TESTING_MADE_H_

#include <gtest/gtest.h>

#include <nlohmann/json.hpp>
#include <string>

#include "core/base/units.h"
#include "core/compensate/tables/format.h"
#include "core/compensate/tables/request.h"
#include "core/machine/error_json.h"
#include "core/machine/testing/machines.h"

namespace axiscal::tables::testing {

// The tilting-table machine with travels: X, Y, Z -300 to 300 mm, A -90 to 30, C 0 to 360 deg.
inline machine::Machine WithTravel() {
  machine::Machine machine = machine::testing::TiltingTable();
  for (machine::Axis& axis : machine.axes) {
    const bool is_rotary = axis.kind == machine::AxisKind::kRotary;
    axis.min_position = is_rotary ? (axis.name == "A" ? -90.0 : 0.0) * base::kRadPerDeg : -300.0;
    axis.max_position = is_rotary ? (axis.name == "A" ? 30.0 : 360.0) * base::kRadPerDeg : 300.0;
  }
  return machine;
}

inline machine::ErrorModel Errors(const machine::Machine& machine, const std::string& json) {
  const auto errors = machine::ReadErrors(json, machine);
  EXPECT_TRUE(errors.ok()) << errors.status();
  return errors.ok() ? *errors : machine::ErrorModel();
}

inline TableRequest Request(const std::string& format, const std::vector<std::string>& axes = {}) {
  TableRequest request;
  request.format = format;
  request.axes = axes;
  return request;
}

struct Made {
  absl::Status status;
  std::string text;
  nlohmann::json report;
  compensate::Table table;  // read back
};

inline Made Make(const machine::Machine& machine, const std::string& errors_json, const TableRequest& request) {
  Made made;
  const auto result = MakeTable(machine, Errors(machine, errors_json), request);
  made.status = result.status();
  if (!result.ok()) return made;
  made.text = result->text;
  made.report = nlohmann::json::parse(result->report_json);
  const auto format = FindFormat(request.format);
  const auto table = (*format)->read(machine, result->text);
  EXPECT_TRUE(table.ok()) << table.status() << "\n" << result->text;
  if (table.ok()) made.table = *table;
  return made;
}

inline Made Make(const std::string& errors_json, const TableRequest& request) {
  return Make(WithTravel(), errors_json, request);
}

// What a controller with this table adds to the command of an axis, mm or rad; `at` names axes with mm or deg.
inline double CorrectionOf(const machine::Machine& machine, const compensate::Table& table, const std::string& axis,
                           const std::map<std::string, double>& at, double sense = 0.0) {
  compensate::Pose pose;
  for (const auto& [name, position] : at) {
    const int i = machine::FindAxis(machine, name);
    pose.position[i] = position * (machine.axes[i].kind == machine::AxisKind::kRotary ? base::kRadPerDeg : 1.0);
  }
  pose.sense.fill(sense);
  const auto commanded = CommandedWith(table, machine, Eigen::Vector3d::Zero(), pose);
  EXPECT_TRUE(commanded.ok()) << commanded.status();
  const int i = machine::FindAxis(machine, axis);
  return commanded.ok() ? (*commanded)[i] - pose.position[i] : std::nan("");
}

inline std::string NotCarried(const Made& made) { return made.report["not_carried"].dump(); }

// A known error: +10 um per metre of X.
inline constexpr char kScale[] = R"({"terms": [{"symbol": "EXX", "shape": "linear", "amplitude": 10}]})";

}  // namespace axiscal::tables::testing

#endif  // AXISCAL_CORE_COMPENSATE_TABLES_TESTING_MADE_H_
