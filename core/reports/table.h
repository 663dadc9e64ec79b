// The report of a compensation table (docs/formats.md). Plain data in the terms and units of the JSON.
#ifndef AXISCAL_CORE_REPORTS_TABLE_H_
#define AXISCAL_CORE_REPORTS_TABLE_H_

#include <array>
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "core/base/json_like.h"
#include "core/base/status.h"

namespace axiscal::reports {

// One function of the table: what it should be, and what interpolation and rounding leave of it.
struct Column {
  std::string of = {};
  std::vector<std::string> over = {};
  std::vector<uint64_t> points = {};     // per argument
  std::vector<double> from = {}, to = {};  // per argument, mm or deg
  bool by_sense = false;
  std::string unit = {};  // um or urad
  double largest = 0.0, left_max = 0.0, left_rms = 0.0;
};

struct PointSpread {
  double max_um = 0.0, rms_um = 0.0;
};
struct PointError {
  PointSpread before = {}, after = {};
};

struct Table {
  std::string format = {}, machine = {}, calibration = {}, values = {};
  std::array<double, 3> tool_tip_mm = {};
  base::Named<double> reference = {};              // "X_mm", "C_deg"
  base::Named<std::array<double, 2>> ranges = {};  // from, to
  std::vector<Column> tables = {};
  // Of the tool point: each axis alone from the reference, and all axes within their ranges.
  std::optional<PointError> along_axes = {}, within_ranges = {};
  std::vector<std::string> not_carried = {}, cannot_carry = {}, notes = {};
};

std::string ToJson(const Table& report);
// INVALID_ARGUMENT naming line and column, or the member that is wrong.
absl::StatusOr<Table> ReadTable(const std::string& text);

}  // namespace axiscal::reports

#endif  // AXISCAL_CORE_REPORTS_TABLE_H_
