// The report of a compensated NC program (docs/formats.md, "Compensation report"). Plain data in the terms and units of
// the JSON.
#ifndef AXISCAL_CORE_REPORTS_REWRITE_H_
#define AXISCAL_CORE_REPORTS_REWRITE_H_

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "core/base/json_like.h"
#include "core/base/status.h"
#include "core/reports/axis_range.h"
#include "core/reports/loop.h"
#include "core/reports/warning.h"

namespace axiscal::reports {

// Over all corrected blocks.
struct Spread {
  double max_um = 0.0, rms_um = 0.0;
  int64_t count = 0;
};
struct AngleSpread {
  double max_urad = 0.0, rms_urad = 0.0;
  int64_t count = 0;
};

// A block and why it was not corrected, or not fully.
struct Finding {
  int64_t line = 0;  // of the source, from 1
  std::string block = {}, reason = {};
};

// Lines of the source from the first to the last block that was not corrected; no block between them was.
struct LineRange {
  int64_t first = 0, last = 0;  // from 1
  std::string reason = {};      // of the first block
};

struct Blocks {
  int64_t read = 0, corrected = 0, split = 0, inserted = 0, passed = 0, refused = 0;
  int64_t going_back = 0;  // of `inserted`: ways back
};

// A move that was added in front of a block which is left as it is: from the corrected position to where the program
// says that this block begins.
struct WayBack {
  int64_t line = 0;        // of the source, from 1: the block that it stands in front of
  std::string block = {};  // as it was added
  double way_um = 0.0;     // of all linear axes together
};

// Where the tool's direction was corrected too.
struct Orientation {
  double max_rotary_correction_deg = 0.0;    // the bound
  base::Named<AngleSpread> correction = {};  // of each rotary axis
  AngleSpread error_before = {}, error_after = {};
  int64_t blocks_not_reached = 0;
  std::vector<Finding> not_reached = {};  // the first of them
};

// What words cannot take away, where the program has any: at the bottom of holes of drilling cycles; along contours
// that the control offsets by the cutter's radius.
struct Leftovers {
  int64_t corrected = 0;           // holes, or moves
  double left_max_um = 0.0;        // of the tool point
  int64_t not_exact = 0;           // of them, at which more is left than the rounding of words
  std::vector<Finding> left = {};  // the first of them
};

// By how much moves of one tool in one work offset are shifted, all linear axes together.
struct Shift {
  std::string tool = {};         // "T5"; "": the program names none
  std::string work_offset = {};  // "G54"; "": none is stated
  int64_t moves = 0;
  double max_um = 0.0, rms_um = 0.0;
  int64_t line = 0;             // of the largest
  base::Named<double> at = {};  // where: programmed axis positions, mm and deg
};

// Corrections of one axis, corrected less programmed.
struct Extremes {
  double low_um = 0.0, high_um = 0.0;
};

// Moves that follow each other, with the extremes of what was done to them.
struct Stretch {
  // Lines of the source, from 1, of its first and its last move; of moves in a subprogram those of its file.
  int64_t first = 0, last = 0;
  // Of the program from its first corrected position to the end of this stretch: straight ways of the linear axes
  // between the ends of corrected moves.
  double way_mm = 0.0;
  base::Named<Extremes> correction = {};           // of each linear axis, at the ends of its moves
  double before_max_um = 0.0, after_max_um = 0.0;  // predicted error of the tool point there
};

// What a note is about, by a stable name.
struct NoteKind {
  std::string kind = {};
  std::optional<int64_t> line = {};  // of the source, from 1
};

struct Rewrite {
  std::string calibration = {};
  // What its own report warns of, and what that says is no error of the machine: the correction may be wrong by it.
  std::vector<Warning> calibration_warnings = {};
  std::vector<Cause> calibration_causes = {};
  std::string dialect = {};      // as which the program was read
  bool null_correction = false;  // the output is the input, byte for byte
  Blocks blocks = {};
  base::Named<Spread> correction = {};  // of each linear axis
  std::vector<Shift> shifts = {};
  // Rotary axes that the program never names, and where the options say that they stand.
  base::Named<double> rotary_stood_deg = {};
  std::vector<std::string> missing = {};       // options, in the words to add: --tool-length H5=...
  Spread error_before = {}, error_after = {};  // of the tool point, at block ends
  double path_before_at_most_um = 0.0, path_after_at_most_um = 0.0;
  std::vector<Stretch> path = {};  // all that was corrected, in order, in at most a few hundred stretches
  double max_tilt_left_urad = 0.0;
  std::optional<Orientation> orientation = {};
  std::optional<Leftovers> holes = {}, contours = {};
  double max_departure_um = 0.0;
  std::vector<AxisRange> positions = {};  // of each axis, at the ends of what was corrected; empty: nothing was
  std::vector<Finding> passed = {}, refused = {};  // the first of each
  std::vector<WayBack> ways_back = {};             // the first of them; blocks.going_back is their number
  int64_t ranges_not_corrected = 0;
  std::vector<LineRange> not_corrected = {};  // the first of them; none of a null correction, which corrects nothing
  std::vector<std::string> notes = {};
  std::vector<NoteKind> note_kinds = {};          // of each of them; none in a report of an older version
  std::optional<std::string> source_crc32c = {};  // eight hexadecimal digits
};

std::string ToJson(const Rewrite& report);
// INVALID_ARGUMENT naming line and column, or the member that is wrong.
absl::StatusOr<Rewrite> ReadRewrite(const std::string& text);

}  // namespace axiscal::reports

#endif  // AXISCAL_CORE_REPORTS_REWRITE_H_
