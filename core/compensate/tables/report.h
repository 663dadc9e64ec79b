// What is said about a table: in the file, for people, and in the report.
#ifndef AXISCAL_CORE_COMPENSATE_TABLES_REPORT_H_
#define AXISCAL_CORE_COMPENSATE_TABLES_REPORT_H_

#include <string>
#include <vector>

#include "core/compensate/table_check.h"
#include "core/compensate/tables/plan.h"
#include "core/reports/table.h"

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
// In the terms and units of the report that is stored, sent and printed.
reports::Table ReportOf(const Plan& plan, const TableReport& found);

}  // namespace axiscal::tables

#endif  // AXISCAL_CORE_COMPENSATE_TABLES_REPORT_H_
