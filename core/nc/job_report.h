// Keeps the report of a rewriting while it runs: findings, statistics of what was written, limits.
#ifndef AXISCAL_CORE_NC_JOB_REPORT_H_
#define AXISCAL_CORE_NC_JOB_REPORT_H_

#include <set>
#include <string>

#include "core/nc/block_writer.h"
#include "core/nc/coordinates.h"
#include "core/nc/move_corrector.h"
#include "core/nc/report.h"

namespace axiscal::nc {

// The block that is read now.
struct BlockText {
  const char* text = nullptr;
  size_t size = 0;       // line end included
  size_t text_size = 0;  // without
  int64_t line = 0;
};

class JobReport {
 public:
  JobReport(const compensate::Compensator& compensator, const RewriteOptions& options);

  const RewriteReport& report() const { return report_; }
  RewriteReport& report() { return report_; }
  bool is_refused() const { return report_.blocks_refused > 0; }

  // Of the blocks that follow: the file of a subprogram, "": the program itself.
  void SetSource(const std::string& name) {
    if (name != source_) report_.not_corrected.End();
    source_ = name;
  }
  void Note(const BlockText& block, const std::string& kind, const std::string& text);
  // The block stays as it is: listed unless it follows from another one, counted always.
  void Passed(const BlockText& block, const std::string& reason, bool is_consequence);
  // A block was added in front of this one, which brings the control back by so much.
  void WentBack(const BlockText& block, const std::string& added, double way_mm);
  // Because of this block the program is refused.
  void Refused(const BlockText& block, const std::string& reason, bool is_consequence);

  // The moves that follow are of this tool in the work offset that is in force (Shift).
  void SetPlace(int64_t tool, const Coordinates& coordinates) {
    const std::string& work_offset = coordinates.active_offset();
    if (tool != place_tool_ || work_offset != place_offset_ || place_ == kNowhere) FindPlace(tool, work_offset);
  }
  // An option is missing, in the words to add.
  void Ask(const std::string& option);
  // Axes whose position a move needs, and that nothing states.
  void AskStart(const std::vector<int>& axes);
  // Rotary axes whose position a move needs, and that a tool change may have moved.
  void AskKept(const std::vector<int>& axes);
  // One written piece that departs from the nominal path by at most `departure_mm` inside: its statistics, and limits,
  // which refuse.
  void Account(const BlockText& block, const Piece& piece, const Commanded& commanded, double departure_mm);
  // A hole was written, and the tool point is off by so much at its bottom: `help` says what the cycle has no word for.
  void Drilled(const BlockText& block, double left_mm, double rounding_mm, const std::string& help);
  // A move of a contour that the control offsets (G41), and what is left along it. `is_limited`: more than
  // cutter_tolerance_mm refuses.
  void Contoured(const BlockText& block, double left_mm, double rounding_mm, bool is_limited, const std::string& help);
  // The tool's direction was not reached in this block: `turned` is the worst of its pieces.
  void Tilted(const BlockText& block, const compensate::Turned& turned);
  // The next piece does not begin where the last one ended.
  void BreakPath() { last_before_mm_ = last_after_mm_ = 0; }

  // FAILED_PRECONDITION with the number of refused blocks and the first of them: UNIT_NOT_STATED, CORRECTION_TOO_LARGE,
  // else PROGRAM_REFUSED.
  absl::Status Refusal() const;

  // The program is read.
  void Finish();

 private:
  static constexpr size_t kNowhere = static_cast<size_t>(-1);
  void FindPlace(int64_t tool, const std::string& work_offset);
  void AddFinding(const BlockText& block, const std::string& reason, std::vector<Finding>* findings);
  void AddShift(const BlockText& block, const Piece& piece, double shift_mm2);
  void AddPositions(const Piece& piece);
  void AccountRotary(const Piece& piece, const Commanded& commanded);
  void CheckTravel(const BlockText& block, int axis, double commanded);

  const compensate::Compensator& compensator_;
  const RewriteOptions& options_;
  RewriteReport report_;
  std::vector<int> rotary_axes_;  // with orientation
  int64_t place_tool_ = 0;
  std::string place_offset_;
  size_t place_ = kNowhere;                        // among report_.shifts
  std::set<int> start_axes_, kept_axes_;           // asked for
  double last_before_mm_ = 0, last_after_mm_ = 0;  // at the end of the last piece
  bool has_travel_limits_ = false;
  bool has_exceeded_limit_ = false;  // listed once, counted on
  std::string source_;
  std::vector<double> corrections_mm_, ends_mm_;  // of the piece that is accounted for
};

// Of a block in a message: its first bytes, as UTF-8 without control characters ('?' stands for what is none), whatever
// the program holds.
std::string Shown(const BlockText& block);

}  // namespace axiscal::nc

#endif  // AXISCAL_CORE_NC_JOB_REPORT_H_
