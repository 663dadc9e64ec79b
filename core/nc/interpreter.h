// Reads a program block by block and keeps the modal state and the position of every axis, as the controller would.
//
// Positions are axis positions in ticks (decimal.h): programmed position plus coordinates.h. A position is unknown
// until it is programmed, and again after every block that may have moved axes in a way that is not followed here.
#ifndef AXISCAL_CORE_NC_INTERPRETER_H_
#define AXISCAL_CORE_NC_INTERPRETER_H_

#include <algorithm>
#include <array>
#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "core/base/status.h"
#include "core/machine/machine.h"
#include "core/nc/arc.h"
#include "core/nc/block.h"
#include "core/nc/coordinates.h"
#include "core/nc/dialect.h"
#include "core/nc/modal.h"
#include "core/nc/options.h"
#include "core/nc/program_frame.h"
#include "core/nc/remark.h"
#include "core/nc/tool_point_frame.h"
#include "core/nc/variables.h"
#include "core/nc/word_frame.h"

namespace axiscal::nc {

enum class StepKind : uint8_t {
  kNone,         // moves no axis
  kMove,         // a linear or circular move to `end`
  kHole,         // a drilling cycle at the end of the block's own move, `hole` says where; Z stands at `end` behind it
  kUntouched,    // moves to machine positions: `reason` says how; the axes that it names are unknown now
  kUnsupported,  // may move axes otherwise, `reason` says why; all positions are unknown now
};

// What the block does to the preset coordinates (G92): they are taken from where the controller stands.
enum class PresetChange : uint8_t { kNone, kSet, kCleared, kSuspended, kRestored };

// What the block does to the frame in which words of X, Y and Z stand, before its own words act.
struct FrameChange {
  enum class To : uint8_t { kSame, kWords, kAxes };
  bool is_changed = false;
  To to = To::kSame;
  uint16_t kept = 0;    // of X, Y and Z: axes whose position is known in the new frame, from where they stood
  Ticks length = 0;     // of the tool
  uint16_t turned = 0;  // rotary axes that the control turned, to where they stand now, or to where is not known
};

// A hole along Z at X and Y of Step::end; heights are axis positions of Z.
struct Hole {
  Ticks entry = 0, bottom = 0;    // where feeding begins and ends
  bool is_first = false;          // of its cycle: the block states both
  bool returns_to_entry = false;  // else to where Z stood when the cycle began
  bool is_return_unsure = false;  // to which of both
  bool is_fixed = false;          // its heights are those of a definition, and no words of this block
  bool is_level_unsure = false;   // that is so near the entry that the corrected entry may be above it
  // Of such a definition: the block's Z shifts its heights, from where 0 leaves them. Axis position that Z says.
  std::optional<Ticks> shifted_to;
};

// What one line does.
struct Step {
  StepKind kind = StepKind::kNone;
  bool has_words = false;
  bool has_other_words = false;  // than N and O: the program proper has begun
  bool is_rapid = false;
  bool is_arc = false;          // valid with kMove: `arc` is its path
  bool may_be_skipped = false;  // block delete, switch unknown
  bool is_consequence = false;  // of a block reported before
  bool is_tool_change = false;
  bool begins_structure = false;  // it calls or is called: nothing of it was read, what follows is for calls.h to order
  bool begins_definition = false;  // of a cycle: its next line may have to be passed, and nothing may stand between
  // A tool or pallet change, or DEP: where axes are behind it is not known.
  bool moves_away = false;
  bool departs = false;     // DEP
  uint16_t kept_away = 0;   // of it: axes that stand where they stood
  bool ends_block = false;  // has a code that acts after the move (M00, M05 ...)
  bool sets_pole = false;
  bool leaves_text = false;      // calls or jumps, or may
  bool jumps_back = false;       // or may
  bool is_curve = false;         // a circle or curve that is not read
  bool is_tangential = false;    // likewise, and it follows the direction of the move in front of it
  bool ends_program = false;     // what follows is another one
  bool ends_subprogram = false;  // likewise, and the control goes on where this one may have been called
  bool is_corner = false;        // the control rounds or chamfers the corner between the moves before and behind
  bool is_at_corner = false;     // the control rounds or chamfers one of its ends: no piece may stand there
  bool is_resolved = false;    // set by who reads: the block is no line of the program (corners.h), its words have more
                               // decimals than the program's
  bool is_tool_point = false;  // of a move: `start`, `end` of X, Y and Z are words in another frame than the axes'
  // Of a move: words of the tool's direction say where `end` has the rotary axes; they are these of Block::words.
  bool has_vector = false;
  std::array<int8_t, 3> word_of_vector{};
  bool takes_no_rotary_words = false;       // of a move: its rotary axes turn by such words alone
  int8_t cutter_side = 0;                   // of a move: Modal::cutter_side
  Ticks cutter_radius = 0;                  // likewise
  std::shared_ptr<const WordFrame> placed;  // which, nullptr: that of tool centre point control; valid with the former
  FrameChange frame;
  uint16_t wrapped = 0;    // axes that count from 0 to 360 deg: their words are turns apart from `start`
  uint16_t downwards = 0;  // of `wrapped`: axes whose word's sign says that they turn in the negative sense
  // Of `wrapped`: whole turns of the number that the word says, -1 for C-10.
  std::array<int16_t, machine::kMaxAxes> word_turns{};
  Hole hole;                   // of kHole
  bool defines_cycle = false;  // states R and Z of a cycle without drilling
  PresetChange preset = PresetChange::kNone;
  uint16_t preset_axes = 0;  // of kSet, where `end` is where they stand, and of kCleared
  int tool_length = -1;      // number of the length in force, -1: none
  std::string reason;
  Remark note;  // for the report; one without text: nothing
  // Per axis of the machine; valid for kMove.
  std::array<int8_t, machine::kMaxAxes> word_of_axis{};  // index into Block::words, -1: none
  Positions start, end;
  Arc arc;
};

// The centre of Klartext's arcs (CC), axis positions of X and Y.
struct Pole {
  std::array<Ticks, 2> ticks{};
  bool is_known = false;
  bool is_absolute = false;  // the words that set it say so: they mean the same to the controller

  bool operator==(const Pole&) const = default;
};

// In which the control reads a block, before any word of it acts.
struct StateBefore {
  Modal modal;
  AxisTicks offsets{};
  Pole pole;
  bool is_at_corner = false;  // the end of the last move is rounded or chamfered
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
  // The next line is no part of a program.
  void SkipLine() { ++line_; }
  // The next line has that number.
  void ReadAs(int64_t line) { line_ = line - 1; }
  // From now on words of corners (RND=) do nothing: somebody else follows them.
  void LeaveCorners() {
    leaves_corners_ = true;
    rounds_corners_ = is_behind_corner_ = false;
  }
  // The first line that calls a subprogram, or begins one that is read over, ends the reading (Step::begins_structure).
  void StopAtCalls() { stops_at_calls_ = true; }
  // From such a line on: the next line's number, whether its return to what called it, or its call, is followed, and
  // why a call in it is not.
  void SetLine(int64_t next, bool is_followed_return, bool is_followed_call, const std::string& call_problem) {
    is_followed_call_ = is_followed_call;
    stops_at_calls_ = false;
    line_ = next - 1;
    is_followed_return_ = is_followed_return;
    if (!call_problem_.empty() || !call_problem.empty()) call_problem_ = call_problem;
  }

  // The block whose call is followed next, and the subprogram that it calls begins or ends: variables of one of them
  // alone are not known in the other, but for the arguments of G65 and of LinuxCNC's O words; behind the latter those
  // of the caller are what they were.
  void NoteCallBlock(const std::string& call) { call_block_ = call; }
  void EnterLevel();
  void LeaveLevel();

  int64_t line() const { return line_; }  // of the last Read, from 1
  const Modal& modal() const { return modal_; }
  const Dialect& dialect() const { return *dialect_; }
  const RewriteOptions& options() const { return *options_; }
  const Coordinates& coordinates() const { return coordinates_; }
  // Number of the tool in the spindle as T words say it; 0: none was named, below 0: by a name.
  int64_t tool() const { return has_changer_ ? loaded_tool_ : called_tool_; }
  Ticks ticks_per_unit(int axis) const { return modal_.is_inch && is_linear_[axis] ? kTicksPerInch : kTicksPerMm; }
  Ticks offset(int axis) const { return coordinates_.Offset(axis); }
  const Pole& pole() const { return pole_; }
  // Of the last Read. It lasts until the next one.
  StateBefore Before() const {
    if (is_before_now_) return {modal_, coordinates_.offsets(), pole_, rounds_corners_ || is_behind_corner_};
    return before_;
  }
  // Programs that began behind another one; what was known of positions holds no longer.
  int64_t programs_begun() const { return programs_begun_; }
  const Positions& positions() const { return positions_; }
  const ToolPointFrame& frame() const { return frame_of_words_; }
  // Takes a position of all axes into the frame that the last block chose. False where it cannot be.
  bool ToFrame(const FrameChange& change, AxisTicks* ticks) const;
  // Whether X, Y and Z are known behind it, if they were before.
  bool IsKept(const FrameChange& change) const;
  // Of an axis whose position is unknown: since which line (0: never programmed), and whether that block was reported.
  int64_t unknown_since(int axis) const { return unknown_since_[axis]; }
  bool is_unknown_reported(int axis) const { return unknown_reported_ >> axis & 1; }
  // The same: since a tool change, which may leave rotary axes where they stand; and never known before either.
  bool is_lost_in_tool_change(int axis) const { return lost_in_tool_change_ >> axis & 1; }
  bool is_never_known(int axis) const { return unknown_since_[axis] == 0 || (never_known_ >> axis & 1); }
  // Index of the machine's axis that a capital letter commands, or -1. Keywords (letter 0) command none.
  int AxisOf(char letter) const { return letter == 0 ? -1 : axis_of_letter_[static_cast<size_t>(letter - 'A')]; }
  Role RoleOf(char letter) const { return letter == 0 ? Role::kParameter : roles_[static_cast<size_t>(letter - 'A')]; }
  // Axis of the plane's first, second and normal direction (0 to 2) in the present plane, or -1.
  int PlaneAxis(int index) const;
  bool IsIncremental(const Word& word) const {
    return word.distance == Distance::kModal ? modal_.is_incremental : word.distance == Distance::kIncremental;
  }
  // How an absolute word without a distance of its own is taken; kNone: by the difference of the numbers;
  // kUnstated: not known. In the present modal state, or in another one.
  machine::RollOver WayOf(int axis) const { return WayOf(axis, modal_); }
  machine::RollOver WayOf(int axis, const Modal& modal) const;
  bool IsMotionCode(const Word& word) const;  // of the group of G00 to G03
  bool IsArcCode(const Word& word) const;
  // TURN=0 of Sinumerik.
  bool IsTurns(const Word& word) const {
    return word.letter == 0 && dialect_->keywords[static_cast<size_t>(word.keyword)].meaning == Meaning::kTurns;
  }
  // A word's value by the rule for words without a point. An angle's increment is that of mm programs in inch, too.
  Decimal Meant(const Decimal& written, Ticks ticks_per_unit) const {
    Decimal number = written;
    if (!number.has_point && options_->integer_words == IntegerWords::kLeastIncrement)
      number.decimals =
          static_cast<int8_t>(ticks_per_unit == kTicksPerInch ? options_->decimals_inch : options_->decimals_mm);
    return number;
  }
  // A length in ticks of a linear axis; nothing when it is out of range.
  std::optional<Ticks> LengthTicks(const Word& word) const;

 private:
  using Code = CodeMeaning;
  struct Request;

  Interpreter(const machine::Machine& machine, const RewriteOptions& options, const Dialect& dialect,
              Coordinates coordinates);
  absl::Status TakeOptions();
  // Whether the block is nothing but axis words, and words that change nothing, where such a block is a linear move;
  // fills step->word_of_axis then. Any other block takes the way through ReadBlock, which most do not need.
  bool IsPlainMove(const Block& block, Step* step);
  void ReadBlock(const char* text, const Block& block, Step* step);
  // What the block sets, or may set.
  void TakeVariables(const char* text, const Block& block);
  // Whether a keyword of Klartext sets no variable below Q200.
  bool LeavesVariables(const Word& word) const;
  // "FN 1: Q5 = +Q2 + +3", of FN 0 to 4: what it sets. False: it is none of these, or not read.
  bool TakeFunction(const char* text, const Block& block, bool may_be_skipped);
  // Of a block that was not read to its end: ": the value of Q5 is not known here", or "".
  std::string UnknownVariable(const char* text, const Block& block) const;
  bool BeginsStructure(const char* text, size_t size, const Block& block) const;
  void Apply(const char* text, const Block& block, Step* step);
  void ScanWords(const Block& block, Request* request, Step* step);
  void ScanCode(const Word& word, const Code& code, Request* request, Step* step);
  void ScanKeyword(const Block& block, const Word& word, Request* request, Step* step);
  void CallTool(const Block& block, const Word& word, Request* request, Step* step);
  // Whether CYCLE832 switches no transformation, as its argument says.
  bool KeepsTransformation(const Word& word) const;
  // G00 to G03, G80 and the like.
  void SelectMotion(const Code& code);
  void SelectSense(Request* request);
  void SelectSpeedMode(Request* request);
  void SelectOffset(const char* text, const Block& block, Request* request);
  // Whether no other code of the block takes its P word than one that selects a work offset.
  bool LeavesNumber(const Block& block) const;
  void NeedAbsoluteZ();
  // TRANS X10, TRANS; CYCL DEF 10.1 ROT+30, ROT+0.
  void SelectByRest(const char* text, Request* request, Step* step);
  // "TRANS X10 Y5": the shift of coordinates that it states. False where its words are not plain numbers of axes, or
  // something is in force with which it is not followed.
  bool Translate(const std::string& words, bool adds);
  // "X+10 Y+5" of CYCL DEF 7: axes that are shifted by what is not known, in bits of shifted_axes.
  uint16_t ShiftDatum(const std::string& words, uint16_t shifted);
  // A change of offsets: on some controls G91 behind it moves by it too.
  void ShiftFrame(int axis, Ticks value);
  // Whether the rest of a move in machine coordinates is axis words of variables, and nothing else: Z=_Z_HOME.
  // A D word among them leaves the tool length unknown.
  bool NamesAxesOnly(const char* text, const Block& block);
  void BeginToolPoint(const char* text, const Block& block, Request* request);
  // Why the control's words cannot be followed under tool centre point control, or "".
  std::string WhyNoToolPoint(const char* text, const Block& block, const Request& request) const;
  // Why rotary axes are offset, of which the words' frame is not known, or "".
  std::string RotaryOffsetProblem() const;
  // Whether I, J and K of linear moves state the tool's direction (G43.5).
  bool StatesVectors() const { return modal_.states_vectors && (modal_.tool_point & ~kPlacedFrames) != 0; }
  // Why the tool's direction cannot be followed that a block states, or "" (also where it states none).
  std::string WhyNoVector(const Request& request, const Step& step) const;
  // Whether the tool of a move turns along the shortest way from its first direction to its last one (ORIVECT) as it
  // does where the rotary axes turn in proportion (ORIAXES): notes the first such move.
  bool TurnsAlike(Step* step);
  // Turns the rotary axes of step->end to it. Why it is not known where they go, or "".
  std::string TurnToVector(const Block& block, const Request& request, Step* step);
  // Takes the positions along when the frame of the words, or the tool length under tool centre point control, changed.
  void ChangeFrame(Request* request, Step* step);
  // Whether tool centre point control goes on is not known, nor any other frame of words.
  void LoseToolPoint() {
    if (modal_.tool_point != 0) lost_tool_point_ = modal_.tool_point, lost_tool_point_line_ = line_;
    modal_.blockers |= modal_.tool_point;
    modal_.tool_point = 0;
    coordinates_.SetToolPoint(false);
    frames_ = Frames();
    word_frame_.reset();
  }
  // Cutter compensation goes on, and nobody knows how: where it was followed, nothing is corrected until it ends.
  void LoseCutter() {
    if (modal_.cutter_side == 0) return;
    modal_.cutter_side = 0, modal_.cutter_radius = 0;
    modal_.blockers |= kCutterCompensation;
  }
  // G41, G42, RL, RR.
  void BeginCutter(Request* request);
  // Why the control's offset of the contour cannot be followed, or ""; fills the radius.
  std::string WhyNoCutter(const Request& request, Ticks* radius) const;
  // While it is in force: what the block does to the contour beside moving along it.
  void KeepCutter(const AxisTicks& offsets_before, const Modal& before, Request* request);
  // Why APPR or DEP LCT is not followed, or "".
  std::string WhyNoApproach(const Request& request) const;
  // DEP LT, LN and CT.
  void Depart(const Request& request, Step* step);
  // Why a move is not one of the contour, or "".
  std::string WhyNoContour(const Request& request, const Step& step) const;
  // The same of tool centre point control alone.
  void LoseControl() {
    if ((modal_.tool_point & ~kPlacedFrames) != 0) LoseToolPoint();
  }
  // What turns, mirrors, scales and tilts words. base = plane (inner words + inner_at_mm) + plane_at_mm, each counted
  // from the work offset.
  struct Frames {
    bool is_tilted = false;     // `plane` is one to which the tool stands upright
    bool moves_origin = false;  // G254
    Eigen::Matrix3d plane = Eigen::Matrix3d::Identity(), inner = Eigen::Matrix3d::Identity();
    Eigen::Vector3d plane_at_mm = Eigen::Vector3d::Zero(), inner_at_mm = Eigen::Vector3d::Zero();
  };
  // Why a frame cannot be followed that begins in this block, or "". `in_table`: it stands on the workpiece.
  std::string WhyNoFrame(uint32_t mode, bool in_table) const;
  // G68, G68.2, G51, G51.1, G254 with their words.
  void BeginFrame(const Block& block, Request* request, Step* step);
  std::string ReadFrame(const Block& block, const Request& request);
  // ROT Z30, AMIRROR X0, CYCLE800(...); CYCL DEF 8.1 X, PLANE SPATIAL ... : false where it is not followed, and why.
  bool FrameByRest(const std::string& name, const std::string& rest, uint32_t mode, Step* step, std::string* problem);
  std::string TurnFrame(const std::string& name, const std::string& words);
  std::string Swivel(const std::string& arguments, Step* step);
  std::string TiltKlartext(const std::string& name, const std::string& words, Step* step);
  // A tilted plane begins.
  void Tilt(const Eigen::Matrix3d& plane, const Eigen::Vector3d& at_mm);
  // Where the control turns the rotary axes for the tilted plane: fills `at` (ticks) and `free`, an axis whose place is
  // open. `sign`: of the axis nearest to the tool, 0: any. `goes_shorter`: of several places it takes the one that is
  // nearer in every axis. Why that is not known, or "".
  std::string AxesOfPlane(int sign, bool goes_shorter, AxisTicks* at, int* free_axis) const;
  // Of the places of the rotary axes in `found` the only one; with `goes_shorter` else the one that is nearer than all
  // others in every axis. Why there is none, with the places, or "".
  std::string ChoosePlace(const std::vector<AxisTicks>& found, bool goes_shorter, AxisTicks* at) const;
  // The control turns them.
  std::string TurnToPlane(int sign, bool goes_shorter, Step* step);
  // Behind what may have changed them: where words stand now.
  void PlaceWords(Request* request, Step* step);
  // Where X, Y and Z stand, from the frame `before` to word_frame_. False where that is not known.
  bool Trace(const Request& request, const WordFrame* before, AxisTicks* ticks) const;
  // Whether a move in a tilted plane is followed; Unsupported when not.
  bool KeepsPlane(Step* step);
  // The frame and the tool of a move.
  void TakeFrame(Step* step) const {
    step->is_tool_point = modal_.tool_point != 0;
    if (step->placed != word_frame_) step->placed = word_frame_;
    step->tool_length = coordinates_.active_length();
    step->cutter_side = modal_.cutter_side;
    step->cutter_radius = modal_.cutter_radius;
  }
  bool HasRotaryAxis() const {
    return !std::all_of(is_linear_.begin(), is_linear_.begin() + axis_count_, [](bool is_linear) { return is_linear; });
  }
  bool is_in_table() const { return word_frame_ != nullptr && word_frame_->base != WordFrame::Base::kAxes; }
  void EndMode(uint32_t blockers) {
    if ((blockers & kCutterCompensation) != 0) {
      modal_.is_cutter_ending |= modal_.cutter_side != 0;
      modal_.cutter_side = 0, modal_.cutter_radius = 0;
    }
    modal_.blockers &= ~blockers;
    modal_.tool_point &= ~blockers;
  }
  void MayHaveChanged(uint8_t groups) {
    modal_.uncertain |= groups;
    modal_.is_return_unsure |= (groups & kMotionGroup) != 0;
    is_unit_asked_ |= (groups & kUnitGroup) != 0;  // its block is reported
  }
  // What the call that is followed next states of variables ("#1"); nullopt: not known.
  using Arguments = std::vector<std::pair<std::string, std::optional<double>>>;
  Arguments ArgumentsOfOWord() const;
  Arguments ArgumentsOfMacro();
  // An N word, to know later where jumps lead.
  void NoteNumber(const Word& word) {
    const int64_t number = word.number.mantissa;
    if (number >= 0 && number < static_cast<int64_t>(numbers_seen_.size()))
      numbers_seen_[static_cast<size_t>(number)] = true;
  }
  bool MayBeSeen(int64_t number) const {
    return number < 0 || number >= static_cast<int64_t>(numbers_seen_.size()) ||
           numbers_seen_[static_cast<size_t>(number)];
  }
  // Whether a block that jumps, or calls a part of this text, may lead to what stands in front of it.
  bool MayJumpBack(const char* text, const Block& block, const Request& request) const;
  // A program is called: the modes in force are its too, and it may change modal groups.
  void NoteCall();
  // "G10 L2 P1 X5. Y0.": the values of a work offset. Why it is not followed, or "".
  std::string InputData(const Block& block, const Request& request, const Step& step);
  // The offsets that it states: two names may mean one. INVALID_ARGUMENT says why none is followed.
  absl::StatusOr<std::vector<std::string>> OffsetsOfInput(const Block& block) const;
  // "Q339=+2" of CYCL DEF 247, whose last line it may be: selects PRESET 2.
  void ReadDatum(const char* text, size_t size, Step* step);
  // Work offsets and tool lengths are no longer those that were stated.
  void ForgetStated();
  // G51.1 and G50.1 act on the axes that their block names; a mirror is off when none is left. `is_whole`: the block
  // was read to its end.
  void SelectMirror(const Request& request, bool is_whole, const Step& step);
  // Behind a block that may be skipped: what it changed is not known.
  void KeepBoth(const Modal& before, const AxisTicks& offsets_before);
  // Why a work offset or a tool length is not known: `what`, or the line that may have changed it.
  std::string WhyNotStated(const std::string& what) const;
  void SelectLength(Request* request);
  // Of a D number of Sinumerik: that of the tool which the last T word and M6 brought into the spindle; 0: which tool
  // that is, is not known.
  int NumberOfSpindle(int edge) const {
    const bool is_known = has_changer_ && is_loaded_tool_known_ && loaded_tool_ < kEdgesOfTool;
    return is_known ? NumberOfEdge(static_cast<int>(loaded_tool_), edge) : 0;
  }
  // Whether a D number belongs to the same tool as at its first use.
  bool IsOfOneTool(int number);
  void Act(const Block& block, const Request& request, Step* step);
  void DoDwell(const Request& request, Step* step);
  void DoMachineMove(const Request& request, Step* step);
  void DoPreset(const Block& block, const Request& request, Step* step);
  void SetPole(const Block& block, const Request& request, Step* step);
  void DoShift(const Block& block, const Request& request, Step* step);
  // Why axis words of this block cannot be followed, or "".
  std::string WhyNoMove(const Request& request, bool* is_consequence);
  // Why lengths cannot be read: the unit is not known. "" when it is.
  std::string UnitProblem() const;
  void Move(const Block& block, const Request& request, Step* step);
  // A block with axis words while a drilling cycle is in force.
  void Drill(const Block& block, const Request& request, Step* step);
  // Why no hole is followed in the present state, or ""; `needed`: modal groups that must be known beside those of all.
  std::string WhyNoDrilling(uint8_t needed) const;
  // Why such a block is not followed, or ""; fills R and the number of repeats, which is 1 where the block says none.
  std::string ReadCycleWords(const Block& block, const Request& request, const Word** entry, int64_t* repeats) const;
  // The same of CYCLE81(10,0,2,-20) behind MCALL or alone: false where they are no plain numbers.
  bool ReadArguments(const std::string& arguments, const Code* code, DrillCycle* cycle) const;
  // "Q200=+2" of a line of CYCL DEF.
  void ReadDefinition(const char* text, size_t size, Step* step);
  // Why what is called cannot be followed here, or "".
  std::string WhyNoCall() const;
  // The cycle that is called, at the end of the block's move or where the tool stands.
  void CallCycle(const Request& request, Step* step);
  // CYCL CALL POS X Y Z.
  void CallCycleAt(const Block& block, const Request& request, Step* step);
  void LoseCycle(const std::string& reason, Step* step);
  void GoTo(Step* step);
  // In a tilted plane: where a rapid move leads is not known along the tool until a tool length is in force.
  void WaitForLength(Step* step);
  // Whether a word may be a difference (G91) of the axis' position; Unsupported when not.
  bool MayMoveBy(int axis, Step* step);
  // The axis words' positions into step->end; false and Unsupported when one cannot be read.
  bool ReadTargets(const Block& block, Step* step);
  // The way to the position of a rotary axis that counts from 0 to 360 deg: moves step->start by whole turns, so that
  // the difference is what the axis travels.
  bool Wrap(const Word& word, int axis, Step* step);
  // The way of such a word, as Wrap.
  bool TakeWay(const Word& word, int axis, Step* step);
  // The value of one axis word; false and Unsupported as above.
  bool ReadTarget(const Word& word, Ticks unit, Ticks* value, Step* step);
  bool ReadArc(const Block& block, const Request& request, Step* step);
  // The arc of a circular move that states its sense: about the pole, or CR's. INVALID_ARGUMENT says why there is none.
  absl::StatusOr<Arc> ArcByPole(const Request& request, const Step& step) const;
  std::string WordProblem(const Word& word) const;
  void Unsupported(std::string reason, bool is_consequence, Step* step);
  void ForgetPositions(bool is_reported);
  void ForgetPosition(int axis, bool is_reported);
  // Behind a tool or pallet change: all but what the tool changer leaves where it stands.
  void ForgetAway(const Request& request, Step* step);
  void StartProgram();
  // The modal state at the begin of a program.
  void BeginModal();
  const Code& Find(const Word& word) const;
  bool TakesRest(const Word& word) const {
    return word.letter == 0 && dialect_->keywords[static_cast<size_t>(word.keyword)].takes_rest;
  }

  const machine::Machine* machine_;
  int axis_count_;
  const RewriteOptions* options_;
  const Dialect* dialect_;
  Coordinates coordinates_;
  ToolPointFrame frame_of_words_;
  std::array<Role, 26> roles_{};
  std::array<int8_t, 26> axis_of_letter_{};
  std::array<bool, machine::kMaxAxes> is_linear_{};
  uint16_t ways_ = 0;                     // rotary axes that may go another way than the difference of the numbers
  std::vector<bool> is_stated_harmless_;  // by number of the M code; as long as it must be
  ProgramFrame frame_;
  Modal modal_;
  Frames frames_;
  std::shared_ptr<const WordFrame> word_frame_;  // of `frames_`, nullptr: none is in force
  std::array<Ticks, 3> placed_offsets_{},
      placed_origins_{};               // of X, Y and Z from which it counts; with tool length, TRANS
  std::string axes_of_plane_problem_;  // why Q120 to Q122 are not known, "": they are
  bool has_noted_tilt_ = false, has_noted_vector_ = false, has_noted_turning_ = false;
  Positions positions_;
  // Axes whose position is unknown to the program's words, though their ticks say where they stand in the frame that
  // began: the path of the move that names them all is known.
  uint16_t traced_ = 0;
  std::array<int64_t, machine::kMaxAxes> unknown_since_{};
  uint16_t unknown_reported_ = 0, lost_in_tool_change_ = 0, never_known_ = 0;
  uint16_t kept_in_tool_change_ = 0;  // rotary axes (RewriteOptions::tool_change_keeps)
  uint16_t needs_absolute_ = 0;       // axes whose tool length or work offset changed: controllers differ on G91 then
  int last_length_number_ = -1;       // of H
  int last_radius_number_ = -1;       // of D
  std::optional<Ticks> radius_difference_ = 0;  // DR of TOOL CALL; nothing: not known
  int64_t called_tool_ = 0, loaded_tool_ = 0;   // of the last T word, and of that before the last M6
  bool is_called_tool_sure_ = true;
  bool is_loaded_tool_known_ = false;                    // the number of the last M6, and nothing behind it changed it
  bool has_changer_ = false;                             // T words choose a tool for M6
  std::vector<std::pair<int, int64_t>> tool_of_length_;  // D numbers of Sinumerik that were used, with their tools
  bool has_noted_integers_ = false, has_noted_cut_ = false;
  bool says_mm_ = false, says_inch_ = false;  // some program of this text does
  bool is_tool_length_asked_ = false;         // the same of the tool length under tool centre point control
  bool is_unit_asked_ = false;                // the block was reported since which it is not known
  int64_t line_ = 0;
  int64_t jump_line_ = 0;  // behind it the order of blocks is not known
  Pole pole_;
  StateBefore before_;
  const char *text_ = nullptr, *end_of_text_ = nullptr;  // of the line that is read
  std::vector<bool> numbers_seen_;                       // N words, where blocks may be passed
  bool is_before_now_ = false;                           // a plain move changes nothing of it
  int64_t programs_begun_ = 0;
  bool rounds_corners_ = false;    // until it ends (RNDM=)
  bool is_behind_corner_ = false;  // the corner at the end of the last move is rounded or chamfered
  bool leaves_corners_ = false;
  bool has_moved_ = false;
  bool takes_plain_moves_ = false;  // the last block was a linear move that left nothing behind but its positions
  bool may_carry_shift_ = false;    // G92 or G52 of a program that ended
  bool has_called_ = false;         // a program further on may be a subprogram, called in any modal state
  uint32_t blockers_at_calls_ = 0;  // that were in force at any call: its program has them too
  uint32_t blockers_seen_ = 0;      // that were ever in force
  const Code* defined_ = nullptr;   // of CYCL DEF, whose lines are read
  std::array<std::optional<Ticks>, 5> definition_;  // Q200 to Q204
  uint32_t lost_tool_point_ = 0;                    // whose end or going on is not known, since this line
  int64_t lost_tool_point_line_ = 0;
  int64_t forgot_stated_line_ = 0;  // which may have changed offsets and lengths that were stated
  bool block_may_be_skipped_ = false;
  bool stops_at_calls_ = false;
  bool is_followed_return_ = false;  // of the line that is read
  bool is_followed_call_ = false;
  std::string call_problem_;
  Variables variables_;
  std::string call_block_;                // that calls next
  std::vector<Variables> callers_;        // what was known when each level was entered
  std::vector<std::string> call_blocks_;  // of the subprograms that run
  bool is_continued_ = false;             // Klartext: the next line belongs to this block ("~")
  bool at_program_end_ = false;           // M30: what follows is another program
};

}  // namespace axiscal::nc

#endif  // AXISCAL_CORE_NC_INTERPRETER_H_
