// Poses: a file with the axis columns of a machine, and the time and temperature columns of a session, in time order
// and without readings (docs/formats.md, "Poses"). It is read in blocks: a file of any length costs one block of
// memory.
#ifndef AXISCAL_CORE_SESSION_POSE_READER_H_
#define AXISCAL_CORE_SESSION_POSE_READER_H_

#include <fstream>
#include <memory>
#include <string>
#include <vector>

#include "core/base/status.h"
#include "core/machine/machine.h"
#include "core/session/line_reader.h"
#include "core/session/row_parser.h"

namespace axiscal::session {

// Rows that follow each other.
struct PoseBlock {
  size_t count = 0;
  std::vector<double> positions;             // entry k * axes + i: axis i of the machine at row k, mm or rad
  std::vector<double> time_s;                // empty without the column
  std::vector<double> temperature_celsius;   // empty without the column
  std::vector<std::vector<double>> celsius;  // of every column of a temperature, as PoseReader::channels()
};

class PoseReader {
 public:
  // NOT_FOUND when there is no such file. INVALID_ARGUMENT with file, line, column, value and rule: a header line that
  // names another machine, a column that is missing, twice or none of a pose, an axis in the other unit.
  static absl::StatusOr<std::unique_ptr<PoseReader>> Open(const std::string& path, const machine::Machine& machine);

  bool has_time() const { return time_ >= 0; }
  bool has_temperature() const { return temperature_ >= 0; }
  // Columns of temperatures by name: "temp_C", "T_spindle_C".
  const std::vector<std::string>& channels() const { return channels_; }

  // The next rows, none at the end. INVALID_ARGUMENT with the place for a cell that breaks its column's rule, a
  // position beyond the travel that the machine's description states, time that runs back, and a file without rows.
  absl::Status Next(PoseBlock* block);
  // Share of the file that was read, 0 to 1.
  double fraction() const;

 private:
  PoseReader(const std::string& path, const machine::Machine& machine);
  absl::Status ReadColumns();
  absl::StatusOr<ColumnRule> RuleOf(const std::string& name, const std::string& place) const;
  absl::Status RequireAxes(size_t line) const;
  absl::Status ReadRows(PoseBlock* block);

  const std::string path_;
  const machine::Machine& machine_;
  std::ifstream in_;
  double bytes_ = 1.0;
  std::unique_ptr<LineReader> lines_;
  std::vector<ColumnRule> rules_;
  std::vector<Column> columns_;
  std::unique_ptr<RowParser> rows_;
  std::vector<int> column_of_axis_;
  int time_ = -1, temperature_ = -1;  // columns
  std::vector<std::string> channels_;
  std::vector<size_t> column_of_channel_;
  size_t rows_read_ = 0;
};

}  // namespace axiscal::session

#endif  // AXISCAL_CORE_SESSION_POSE_READER_H_
