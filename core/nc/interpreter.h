// Reads a program block by block and keeps the modal state and the position of every axis, as the controller would.
//
// Positions are axis positions in ticks (decimal.h): programmed position plus the selected work offset. A position is
// unknown until it is programmed, and again after every block that may have moved axes in a way that is not followed
// here.
#ifndef AXISCAL_CORE_NC_INTERPRETER_H_
#define AXISCAL_CORE_NC_INTERPRETER_H_

#include <array>
#include <cstdint>
#include <string>
#include <vector>

#include "core/base/status.h"
#include "core/machine/machine.h"
#include "core/nc/block.h"
#include "core/nc/dialect.h"
#include "core/nc/options.h"
#include "core/nc/program_frame.h"

namespace axiscal::nc {

enum class FeedMode : uint8_t { kPerMinute, kInverseTime, kPerTurn };

struct AxisPosition {
  Ticks ticks = 0;
  bool is_known = false;
  int8_t sense = 0;                // of the last motion: +1, -1, 0 unknown
  bool is_consequence = false;     // unknown because of a block that was reported itself
  int64_t unknown_since_line = 0;  // 0: never programmed
};

struct Modal {
  Meaning motion = Meaning::kLinear;  // kRapid, kLinear, kCancelMotion or kOtherMotion. Power-on states are linear.
  const char* motion_text = "";       // of kOtherMotion
  bool is_inch = false;
  bool is_incremental = false;
  FeedMode feed_mode = FeedMode::kPerMinute;
  uint16_t blockers = 0;
  int16_t work_offset = -1;  // index into options.work_offsets, -1: none
};

enum class StepKind : uint8_t {
  kNone,         // moves no axis
  kMove,         // a linear move to `end`
  kUnsupported,  // may move axes otherwise, `reason` says why; all positions are unknown now
};

using AxisTicks = std::array<Ticks, machine::kMaxAxes>;

// What one line does.
struct Step {
  StepKind kind = StepKind::kNone;
  bool has_words = false;
  bool has_other_words = false;  // than N and O: the program proper has begun
  bool is_rapid = false;
  bool may_be_skipped = false;  // block delete, switch unknown
  bool is_consequence = false;  // of a block reported before
  bool is_tool_change = false;
  bool ends_block = false;  // has a code that acts after the move (M00, M05 ...)
  std::string reason;
  std::string note;  // for the report: text after the end of the program
  // Per axis of the machine; valid for kMove.
  std::array<int8_t, machine::kMaxAxes> word_of_axis{};  // index into Block::words, -1: none
  std::array<AxisPosition, machine::kMaxAxes> start{}, end{};
};

class Interpreter {
 public:
  // INVALID_ARGUMENT on an unknown dialect, an axis that the machine lacks, or a value out of range. `machine` and
  // `options` must outlive it.
  static absl::StatusOr<Interpreter> Create(const machine::Machine& machine, const RewriteOptions& options);

  // The next line, without its end. `block` holds its words (none for '%' lines and text outside the program).
  void Read(const char* text, size_t size, Block* block, Step* step);
  // The next line is longer than a block may be.
  void ReadOverlong(Step* step);

  int64_t line() const { return line_; }  // of the last Read, from 1
  const Modal& modal() const { return modal_; }
  const Dialect& dialect() const { return *dialect_; }
  Ticks ticks_per_unit(int axis) const { return modal_.is_inch && is_linear_[axis] ? kTicksPerInch : kTicksPerMm; }
  // Offset that is added to programmed positions of an axis.
  Ticks offset(int axis) const {
    return modal_.work_offset < 0 ? 0 : offsets_[static_cast<size_t>(modal_.work_offset)][axis];
  }
  const std::array<AxisPosition, machine::kMaxAxes>& positions() const { return positions_; }
  // Index of the machine's axis that a capital letter commands, or -1.
  int AxisOf(char letter) const { return axis_of_letter_[static_cast<size_t>(letter - 'A')]; }
  // A word's value by the rule for words without a point.
  Decimal Meant(const Decimal& written) const;

 private:
  enum class Role : uint8_t { kCode, kAxis, kForeignAxis, kLineNumber, kProgramNumber, kPassive, kParameter };
  using Code = CodeMeaning;
  struct Scan;

  Interpreter(const machine::Machine& machine, const RewriteOptions& options, const Dialect& dialect);
  absl::Status TakeOptions();
  absl::StatusOr<AxisTicks> ToAxisTicks(const std::vector<AxisValue>& values, const std::string& field,
                                        std::vector<int>* axes) const;
  void Apply(const Block& block, Step* step);
  void ScanWords(const Block& block, Scan* scan, Step* step);
  void ScanCode(const Word& word, Scan* scan, Step* step);
  void SelectOffset(const Word& word, const Code& code, Scan* scan);
  void CheckAndMove(const Block& block, const Scan& scan, Step* step);
  void Move(const Block& block, Step* step);
  void Unsupported(std::string reason, bool is_consequence, Step* step);
  void ForgetPositions(bool is_consequence);
  void StartProgram();
  const Code& Find(const Word& word) const;

  const machine::Machine* machine_;
  const RewriteOptions* options_;
  const Dialect* dialect_;
  std::array<Role, 26> roles_{};
  std::array<int8_t, 26> axis_of_letter_{};
  std::array<bool, machine::kMaxAxes> is_linear_{};
  std::vector<AxisTicks> offsets_;
  ProgramFrame frame_;
  Modal modal_;
  std::array<AxisPosition, machine::kMaxAxes> positions_{};
  int64_t line_ = 0;
  bool has_moved_ = false;
  bool at_program_end_ = false;  // M30: what follows is another program
};

}  // namespace axiscal::nc

#endif  // AXISCAL_CORE_NC_INTERPRETER_H_
