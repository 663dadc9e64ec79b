// What is said about a table: in the file, for people, and as JSON.
#ifndef AXISCAL_CORE_COMPENSATE_TABLES_REPORT_H_
#define AXISCAL_CORE_COMPENSATE_TABLES_REPORT_H_

#include <string>
#include <vector>

#include "core/compensate/table_check.h"
#include "core/compensate/tables/plan.h"

namespace axiscal::tables {

// One function of the table: what it should be, and what interpolation and rounding leave of it. mm or rad.
struct ColumnReport {
  std::string name;
  bool is_angle = false;
  bool by_sense = false;
  std::vector<std::string> arguments;
  std::vector<size_t> points;
  std::vector<double> from, to;  // mm or deg
  compensate::Deviation wanted, left;
};

struct TableReport {
  std::vector<ColumnReport> columns;
  // Tool point, each axis alone from the reference; and all axes within their ranges.
  compensate::PointError along, within;
  std::vector<std::string> not_carried;
};

// A tool that stays tilted against the table, where it matters.
void AddTilt(double tilt_rad, std::vector<std::string>* not_carried);
// Lines for the file.
std::vector<std::string> NotesOf(const Plan& plan, const TableReport& report);
std::string ToJson(const Plan& plan, const TableReport& report);

}  // namespace axiscal::tables

#endif  // AXISCAL_CORE_COMPENSATE_TABLES_REPORT_H_
