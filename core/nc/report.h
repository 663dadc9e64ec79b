// What a rewriting did to a program, as it is counted while it runs. Lengths in mm.
#ifndef AXISCAL_CORE_NC_REPORT_H_
#define AXISCAL_CORE_NC_REPORT_H_

#include <cstdint>
#include <string>
#include <utility>
#include <vector>

#include "core/nc/options.h"
#include "core/nc/remark.h"
#include "core/reports/rewrite.h"

namespace axiscal::nc {

// One block and why it was not corrected. Long blocks are cut for the report, never in the program.
struct Finding {
  int64_t line = 0;  // of the source, from 1
  std::string block;
  std::string reason;
};

// A block that was added in front of `line`, which is left as it is, to bring the control back to where the program
// says.
struct WayBack {
  int64_t line = 0;   // of the source, from 1
  std::string block;  // as it was added
  double way_mm = 0;  // of all linear axes together
};

// Largest and root mean square of a quantity over all corrected blocks.
struct Spread {
  double max_mm = 0;
  double sum_squares_mm2 = 0;
  int64_t count = 0;

  void Add(double value_mm) {
    const double size_mm = value_mm < 0 ? -value_mm : value_mm;
    if (size_mm > max_mm) max_mm = size_mm;
    sum_squares_mm2 += value_mm * value_mm;
    ++count;
  }
  double rms_mm() const;
};

// What moves of one tool in one work offset are shifted by, all linear axes together.
struct Shift {
  int64_t tool = 0;         // Interpreter::tool
  std::string work_offset;  // its code; "": none that is stated
  int64_t count = 0;
  double max_mm = 0, sum_squares_mm2 = 0;
  int64_t line = 0;        // of the largest
  std::vector<double> at;  // where, per axis of the machine, mm or deg
};

inline constexpr size_t kMaxShifts = 200;  // listed

struct AxisSpread {
  std::string axis;  // linear axes only
  Spread correction;
};

// The same of an angle.
struct AngleSpread {
  double max_rad = 0;
  double sum_squares_rad2 = 0;
  int64_t count = 0;

  void Add(double value_rad) {
    const double size_rad = value_rad < 0 ? -value_rad : value_rad;
    if (size_rad > max_rad) max_rad = size_rad;
    sum_squares_rad2 += value_rad * value_rad;
    ++count;
  }
  double rms_rad() const;
};

struct RotaryAxisSpread {
  std::string axis;
  AngleSpread correction;
};

inline constexpr size_t kMaxRanges = 1000;  // listed; the count goes on
inline constexpr int kMaxFindings = 100;    // listed per kind; the counts go on

// Blocks in ranges of lines: a range ends with the last of them in front of a block that is none of them.
struct LineRanges {
  std::vector<reports::LineRange> listed;  // the first kMaxRanges
  int64_t count = 0;
  bool is_open = false;

  void Add(int64_t line, const std::string& reason) {
    const bool goes_back = is_open && static_cast<int64_t>(listed.size()) == count && line < listed.back().last;
    if (!is_open || goes_back) {
      ++count;
      is_open = true;
      if (listed.size() < kMaxRanges) listed.push_back({line, line, reason});
    } else if (static_cast<int64_t>(listed.size()) == count) {
      listed.back().last = line;
    }
  }
  void End() { is_open = false; }
};

// Pieces that follow each other along what is corrected.
struct Stretch {
  int64_t first_line = 0, last_line = 0;
  int64_t pieces = 0;
  double way_mm = 0;                          // of the whole path, to its end
  std::vector<double> least_mm, greatest_mm;  // corrections of AxisSpread's axes
  double before_max_mm = 0, after_max_mm = 0;
};

// What is corrected from the first piece to the last, in stretches of as many pieces each. When there are too many of
// them, every two become one: the cost stays linear and the memory bounded.
class Path {
 public:
  static constexpr size_t kMostStretches = 300;

  // `corrections_mm`, `end_mm`: of the linear axes; the end as programmed.
  void Add(int64_t line, const std::vector<double>& corrections_mm, const std::vector<double>& end_mm, double before_mm,
           double after_mm);
  const std::vector<Stretch>& stretches() const { return stretches_; }

 private:
  void Halve();

  std::vector<Stretch> stretches_;
  std::vector<double> last_mm_;
  int64_t pieces_ = 1;  // of a stretch
  double way_mm_ = 0;
};

struct RewriteReport {
  std::string calibration;
  // What the calibration's own report says against it, where whoever rewrites knows of one.
  std::vector<reports::Warning> calibration_warnings;
  std::vector<reports::Cause> calibration_causes;
  bool is_null_correction = false;  // the output is the input, byte for byte
  int64_t blocks_read = 0;          // lines that hold at least one word
  int64_t blocks_corrected = 0;  // moves whose end point was computed, also where rounding left the bytes as they were
  int64_t blocks_split = 0;
  int64_t blocks_inserted = 0;  // pieces added by splitting
  int64_t blocks_passed = 0;    // moves left uncorrected (kPass, null correction, skipped blocks)
  int64_t blocks_refused = 0;
  int64_t blocks_going_back = 0;         // of blocks_inserted
  std::vector<WayBack> ways_back;        // the first kMaxFindings
  std::vector<Finding> passed, refused;  // the first kMaxFindings of each
  LineRanges not_corrected;              // of a null correction: empty
  std::vector<Remark> notes;             // tool changes, text after the program's end, effects not carried
  std::string dialect;
  std::vector<Shift> shifts;            // the first kMaxShifts tools and offsets
  std::vector<std::string> axis_names;  // of `shifts`, `least`, `greatest`
  std::vector<bool> axis_is_rotary;     // likewise
  // Options that were missing, in the words to add: --offset "G54 X=... Y=..."; the first kMaxAdvice.
  std::vector<std::string> missing;
  // Rotary axes that the program never names, and where they were stated to stand, deg.
  std::vector<std::pair<std::string, double>> rotary_stood;
  std::vector<AxisSpread> axes;
  // Predicted tool-point error at block ends, in the table's frame, without the correction, and with it as written
  // (rounding included).
  Spread error_before, error_after;
  // Along the whole path (G01 and arcs), at most: the larger end of each piece and its departure inside.
  double path_before_max_mm = 0, path_after_max_mm = 0;
  Path path;
  double max_tilt_left_rad = 0;  // orientation error that the corrected axes leave
  // With orientation: corrections of rotary axes, predicted error of the tool's direction at block ends without the
  // correction and with it as written, and the blocks where it was not reached (the first kMaxFindings).
  bool has_orientation = false;
  double max_rotary_correction_rad = 0;  // the bound
  std::vector<RotaryAxisSpread> rotary_axes;
  AngleSpread tilt_before, tilt_after;
  int64_t blocks_tilted = 0;
  std::vector<Finding> tilted;
  // Holes of drilling cycles: how far off the tool point is at the bottom with the correction as written, and the holes
  // where that is more than their words' rounding (the first kMaxFindings).
  int64_t holes = 0, holes_left = 0;
  double max_hole_left_mm = 0;
  std::vector<Finding> left;
  // Moves of contours that the control offsets by the cutter's radius (G41), as the same.
  int64_t contour_moves = 0, contour_moves_left = 0;
  double max_contour_left_mm = 0;
  std::vector<Finding> contour_left;
  // Per axis of the machine, where the axes stand at the ends of what was corrected, mm or deg; empty: nothing was.
  std::vector<double> least, greatest;
  double max_departure_mm = 0;  // largest departure of the correction along a written piece, at most
  // Files of RewriteOptions::subprograms that the program runs, corrected, and copies for calls that need others.
  std::vector<Subprogram> subprograms;
  uint32_t source_crc32c = 0;
  bool has_source_crc32c = false;
};

// In the terms and units of the report that is stored, sent and printed. The JSON replaces what is no UTF-8: programs
// hold bytes of any encoding.
reports::Rewrite ReportOf(const RewriteReport& found);
// RewriteReport::least and `greatest` in the terms of reports.
std::vector<reports::AxisRange> PositionsOf(const RewriteReport& found);

}  // namespace axiscal::nc

#endif  // AXISCAL_CORE_NC_REPORT_H_
