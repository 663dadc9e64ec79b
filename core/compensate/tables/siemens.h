// What Siemens' two table formats share: lines `$NAME[index,...]=value` between comments.
#ifndef AXISCAL_CORE_COMPENSATE_TABLES_SIEMENS_H_
#define AXISCAL_CORE_COMPENSATE_TABLES_SIEMENS_H_

#include <optional>
#include <string>
#include <vector>

#include "core/compensate/table.h"
#include "core/compensate/tables/format.h"

namespace axiscal::tables {

struct Assignment {
  size_t line = 0;
  std::string name;                  // "$AA_ENC_COMP"
  std::vector<std::string> indices;  // "0", "12", "X"
  std::string value;
};

// The assignments of an archive; INVALID_ARGUMENT with the line of anything else that is no comment, header or M17.
absl::StatusOr<std::vector<Assignment>> ReadAssignments(const std::string& text);
absl::StatusOr<double> NumberOf(const Assignment& assignment);
// A whole number from 0 to 99999.
absl::StatusOr<int> IndexOf(const Assignment& assignment, size_t which);

// MIN, STEP and MAX of a table, and its values by number, in the file's units.
struct SiemensTable {
  size_t line = 0;
  std::vector<std::optional<double>> values;
  std::optional<double> min, max, step;
  // Sets value number n, once.
  absl::Status SetValue(int n, const Assignment& assignment);
  // Sets a field, once.
  absl::Status Set(std::optional<double>* field, const Assignment& assignment);
  // The nodes, once STEP, MIN and MAX are there and give as many as there are values without a gap.
  absl::StatusOr<std::vector<double>> Nodes(const std::string& name) const;
};

}  // namespace axiscal::tables

#endif  // AXISCAL_CORE_COMPENSATE_TABLES_SIEMENS_H_
