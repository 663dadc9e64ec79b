// Writes moves: the block's own bytes with its words replaced, or a piece of a split move.
//
// Keeps what the controller has been told ("commanded", exact), apart from what the program means ("nominal"), so that
// G91 words are differences of commanded positions and rounding never adds up.
#ifndef AXISCAL_CORE_NC_BLOCK_WRITER_H_
#define AXISCAL_CORE_NC_BLOCK_WRITER_H_

#include <array>
#include <string>
#include <vector>

#include "core/nc/block.h"
#include "core/nc/corrected_word.h"
#include "core/nc/interpreter.h"
#include "core/nc/move_corrector.h"
#include "core/nc/out_buffer.h"

namespace axiscal::nc {

struct Commanded {
  AxisTicks ticks{};
  uint16_t known = 0;  // bit i: axis i

  bool is_known(int axis) const { return known >> axis & 1; }
};

class BlockWriter {
 public:
  BlockWriter(const machine::Machine& machine, const RewriteOptions& options, const Interpreter& interpreter);

  const Commanded& commanded() const { return commanded_; }
  // The block stays as it is: what the controller does with it.
  void Pass(const Block& block, const Step& step);
  void PassHole(const Step& step);
  // Before a move: axes that count from 0 to 360 deg are shifted by the same whole turns as the move's start.
  void Wrap(const Step& step);
  // The words of X, Y and Z stand in another frame from this block on.
  void ChangeFrame(const FrameChange& change);
  // Behind a tool change and blocks that are not followed; axes of `kept` stand where they stood.
  void ForgetAll(uint16_t kept = 0);
  // A program begins, `is_behind_end`: behind the end of another one, which does not run into it.
  void BeginProgram(bool is_behind_end);

  // Of what follows, for programs in which blocks are passed: they must begin where the program says, since an arc from
  // a corrected point would be another one.
  // A corrected move was written.
  void Arrive(const Step& step);
  // Brings the control back to the programmed position by a block of its own, in the state in which it stands in front
  // of the block that is read; the same of the pole. Returns why that cannot be, or "". Nothing is written where the
  // control stands there.
  std::string Return(const StateBefore& before, const std::string& line_end, OutBuffer* out);
  // In front of a move that follows the direction of the one in front of it: a short one between them would turn it.
  // The pole is no move: it is brought back.
  void LeaveAdrift(const char* text, size_t size, const StateBefore& before, const std::string& line_end,
                   OutBuffer* out);
  bool HasDeparted() const { return Departed() != 0; }
  // How far Return brings the linear axes, all together, mm.
  double WayBackMm() const;
  // Axes that may stand at a corrected position which is not known: of a block that may have been skipped.
  uint16_t adrift() const { return adrift_; }
  // The control is in G01 where the program is in G02 or G03, and this block would leave the text with that.
  bool LeavesInChords(const Block& block, const Step& step) const {
    return is_in_chords_ && (step.leaves_text || step.ends_subprogram) && !HasMotionWord(block);
  }
  // The program's own CC block was copied. An incremental one means another place, since the tool stands elsewhere.
  void TakePole(const Pole& pole) {
    pole_ = pole;
    pole_.is_known &= pole.is_absolute;
    is_pole_moved_ = !pole.is_absolute && (Departed() | adrift_) != 0;
  }
  void ForgetPole() { pole_.is_known = false; }
  // After a block that may be skipped: what it changed is unknown.
  void ForgetChanges(const Commanded& before);

  // In G91 a word is a difference, so the axis' commanded position must be known. Index of the first axis whose
  // position is not known, or -1.
  int FirstUnknown(const Block& block, const Step& step) const;

  // Appends `text` (line end included) so that every axis goes to `piece.targets`, rounded to the word's grain.
  // `feed_fraction` < 1: the block is a piece of its move and G93 scales its F word.
  void WriteBlock(const char* text, size_t size, const Block& block, const Step& step, const Piece& piece,
                  double feed_fraction, OutBuffer* out);
  // Appends a piece of the same move, whose block is `text`: axis words, those of the tool's direction, the F word in
  // G93, line end; no N, no other words but the motion code where an arc has straight pieces.
  void WritePiece(const char* text, const Block& block, const Step& step, const Piece& piece, double feed_fraction,
                  bool is_packed, const std::string& line_end, OutBuffer* out);
  // Appends the block of a hole: X and Y as `entry.targets`, the words of R and of the bottom (Z) as both pieces' Z.
  // Words that the control keeps from an earlier block are inserted where they differ.
  void WriteHole(const char* text, size_t size, const Block& block, const Step& step, const Piece& entry,
                 const Piece& bottom, OutBuffer* out);
  // Where the hole's words say that it begins and ends: axis positions of Z.
  Ticks hole_entry() const { return hole_entry_; }
  Ticks hole_bottom() const { return hole_bottom_; }
  void ForgetCycle() { is_cycle_known_ = false; }
  // Appends a block that stays as it is. Where an arc was written as chords and the block relies on the arc's code, the
  // code is put in front of its words.
  void CopyBlock(const char* text, size_t size, const Block& block, const Step& step, OutBuffer* out);

  // Controller's preset (G92) - nominal one: G92 takes its coordinates from where the control stands.
  Ticks preset_shift(int axis) const { return preset_shift_[axis]; }
  // Whether a block without a word of the axis must get one.
  bool NeedsWord(int axis, Ticks target, Ticks grain) const;

  // What the words of this block can hold.
  WordGrain GrainOf(const Block& block, const Step& step) const;
  static bool IsPacked(const char* text, const Block& block);

 private:
  // The usual block: a linear move with all words that it needs, absolute. False, and nothing written, for any other.
  bool WriteSimple(const char* text, size_t size, const Block& block, const Step& step, const Piece& piece,
                   OutBuffer* out);
  // What GrainOf says of the centre.
  void SetCentreGrain(const Block& block, const Step& step, WordGrain* grain) const;
  // Of the axis' word in the block, or of one that is inserted for it.
  WordForm FormOf(const Block& block, const Step& step, int axis) const;
  // What a word of 0 means: the commanded position in G91, the coordinates' origin else.
  Ticks BaseOf(const Block& block, const Step& step, int axis) const;
  // As WordFor; an axis that counts from 0 to 360 deg is told an angle of that range.
  CorrectedWord CorrectedOf(const Step& step, int axis, Ticks target, Ticks base, const WordForm& form) const;
  // Of a called cycle: X and Y alone are words, and Z where it shifts the heights.
  void WriteFixedHole(const char* text, size_t size, const Block& block, const Step& step, const Piece& entry,
                      const Piece& bottom, OutBuffer* out);
  // Where Z stands behind a hole.
  void LeaveHole(const Step& step);
  void SetCommanded(const Step& step, int axis, const CorrectedWord& corrected, Ticks base, Ticks target);
  // Where the word ends, the ')' of X=IC(5) included.
  static uint32_t EndOf(const char* text, size_t size, const Word& word);
  // `word`: that it is written in place of, nullptr: it is inserted.
  void AppendCorrected(const CorrectedWord& corrected, const Word* word, OutBuffer* out) const;
  void AppendDistance(Distance distance, OutBuffer* out) const;
  // A rotary axis that turns by words of the tool's direction.
  void TurnByVector(int axis, Ticks at) {
    commanded_.ticks[axis] = programmed_[axis] = at;
    commanded_.known |= static_cast<uint16_t>(1u << axis);
    adrift_ &= static_cast<uint16_t>(~(1u << axis));
  }
  // Which component of the tool's direction the word states, or -1.
  static int VectorOf(const Block& block, const Step& step, const Word& word);
  // Of the direction at the piece's end.
  void AppendComponent(const Word& word, const Piece& piece, int component, OutBuffer* out) const;
  void AppendVector(const char* text, const Block& block, const Step& step, const Piece& piece, bool is_packed,
                    bool is_first, OutBuffer* out) const;
  void AppendFeed(const Word& word, double fraction, OutBuffer* out) const;
  void InsertWords(const char* text, const Block& block, const Step& step, const AxisTicks& targets, bool is_lower,
                   OutBuffer* out);
  // I, J, K or R of a written arc that began at `start`. False: such a word is not of this arc.
  bool ArcWord(char letter, const Word* word, const Piece& piece, const AxisTicks& start,
               CorrectedWord* corrected) const;
  void WriteArcWord(const char* text, size_t size, const Word& word, const Piece& piece, const AxisTicks& start,
                    uint32_t* copied, OutBuffer* out) const;
  void AppendArcWords(const Block& block, const Piece& piece, const AxisTicks& start, bool is_packed,
                      OutBuffer* out) const;
  void InsertCentre(const char* text, const Block& block, const Piece& piece, const AxisTicks& start, OutBuffer* out);
  // "CC X+1 Y+2" in front of an arc about a pole, unless it is the controller's.
  void AppendPole(const Block& block, const Piece& piece, const std::string& line_end, OutBuffer* out);
  // "G02 ": the code that the controller must be told before a block, "" when it is in force.
  std::string MotionFor(const Block& block, bool wants_arc) const;
  const Word* RadiusOf(const Block& block) const;  // nullptr: none
  // How far the control is from where the program thinks it is; 0 where that is not known.
  Ticks Departure(int axis) const {
    return commanded_.is_known(axis) ? commanded_.ticks[axis] - programmed_[axis] - preset_shift_[axis] : 0;
  }
  uint16_t Departed() const;
  // " X1.5", with the decimals that it needs to be exact. `says_angle`: from 0 to 360 deg, which the axis goes the
  // shorter way.
  void AppendExact(int axis, Ticks target, Ticks base, bool is_inch, bool says_angle, OutBuffer* out) const;
  void ReturnPole(const StateBefore& before, const std::string& line_end, OutBuffer* out);
  // Whether the block has words that move by the motion code in force.
  bool MovesByCode(const char* text, size_t size, const Block& block) const;
  bool HasMotionWord(const Block& block) const;

  const machine::Machine* machine_;
  const Interpreter* interpreter_;
  WordRule rule_;
  std::vector<int> order_;  // axes in the order in which inserted words are written
  std::array<bool, machine::kMaxAxes> is_followed_{}, is_linear_{};  // rotary axes with orientation
  Commanded commanded_;
  Pole pole_;                                     // of the controller
  bool is_pole_moved_ = false;                    // it may be another than the program's
  AxisTicks preset_shift_{}, suspended_shift_{};  // controller's preset (G92) - nominal one
  AxisTicks programmed_{};                        // where the program thinks the axes are
  uint16_t adrift_ = 0;
  uint16_t wrapped_ = 0;        // axes that were last told the way to an angle from 0 to 360 deg
  bool is_last_rapid_ = false;  // of the corrected moves
  // Of the drilling cycle in force: what the control keeps of its words, and where Z stood when it began.
  bool is_cycle_known_ = false, is_cycle_level_known_ = false;
  Ticks hole_entry_ = 0, hole_bottom_ = 0, cycle_level_ = 0;
  bool is_in_chords_ = false;  // the controller is in G01 where the program is in G02 or G03
};

}  // namespace axiscal::nc

#endif  // AXISCAL_CORE_NC_BLOCK_WRITER_H_
