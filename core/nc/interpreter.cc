#include "core/nc/interpreter.h"

#include <algorithm>
#include <cstring>

#include "core/nc/calls.h"
#include "core/nc/char_class.h"
#include "core/nc/lexer.h"
#include "core/nc/line_splitter.h"
#include "core/nc/request.h"

namespace axiscal::nc {
namespace {

bool SameButRapid(Modal a, Modal b) {
  for (Modal* modal : {&a, &b}) {
    if (modal->motion == Meaning::kRapid) modal->motion = Meaning::kLinear;
    if (modal->motion != Meaning::kOtherMotion && modal->motion != Meaning::kDrillCycle) modal->motion_text = "";
    modal->lacks_feed = modal->is_rapid_unsure = false;
  }
  return a == b;
}

// "CYCL DEF 200 DRILLING ~": the next line belongs to the block. Blocks of words cannot be continued: there '~' is a
// stray character.
bool IsContinued(const char* text, size_t size) {
  while (size > 0 && (text[size - 1] == ' ' || text[size - 1] == '\t' || text[size - 1] == '\r')) --size;
  return size > 0 && text[size - 1] == '~';
}

// Numbered lines begin blocks.
bool BeginsWithNumber(const char* text, size_t size) {
  while (size > 0 && (*text == ' ' || *text == '\t')) ++text, --size;
  return size > 0 && *text >= '0' && *text <= '9';
}

// Whether the M at `at` may be a code that changes the modal state: any but one that is known to change nothing. M
// within a word (FMAX, MOD) is none.
bool MayChangeState(const Dialect& dialect, const std::vector<bool>& is_stated_harmless, const char* at,
                    const char* end) {
  size_t number = 0;
  const char* digit = ++at;
  for (; digit != end && *digit >= '0' && *digit <= '9' && number < kCodes; ++digit)
    number = 10 * number + static_cast<size_t>(*digit - '0');
  if (digit == at) return digit == end || Capital(*digit) < 'A' || Capital(*digit) > 'Z';
  if (number < is_stated_harmless.size() && is_stated_harmless[number]) return false;
  return 10 * number >= kCodes || dialect.m_codes[10 * number].meaning != Meaning::kHarmless;
}

// Programs of machines' and probes' makers, which set work offsets and tool lengths.
bool IsMakersMacro(const Word* number) {
  return number != nullptr && number->number.mantissa >= 9000 && number->number.mantissa <= 9999;
}

// Whether a word that moves stands there, whose number is none: "X#1", "I[#2/2]".
bool BeginsWithMove(const char* at, const char* end) {
  return at != end && std::strchr("XYZABCUVWIJKR", Capital(*at)) != nullptr &&
         (at + 1 == end || Capital(at[1]) < 'A' || Capital(at[1]) > 'Z');
}

// Whether capitals stand there, in any case.
bool Holds(const char* begin, const char* end, const std::string& capitals) {
  const auto same = [](char a, char b) { return Capital(a) == b; };
  return std::search(begin, end, capitals.begin(), capitals.end(), same) != end;
}

// L, C, CR and CC: words, M codes, RL and RR.
bool IsPlainMove(Meaning meaning) {
  return meaning == Meaning::kLinear || meaning == Meaning::kArc || meaning == Meaning::kPole;
}

// Whether what stands behind a problem may hold modal codes. An L block of Klartext can hold M codes and RL or RR;
// other blocks of Klartext are not known, nor those of Sinumerik, whose codes may be words.
bool MayHoldCodes(const Dialect& dialect, const std::vector<bool>& is_stated_harmless, const Block& block,
                  const char* begin, const char* end) {
  const bool is_klartext = dialect.has_bare_keywords;
  const bool is_l_block = is_klartext && block.word_count > 0 && block.words[0].letter == 0 &&
                          IsPlainMove(dialect.keywords[static_cast<size_t>(block.words[0].keyword)].meaning);
  if (!dialect.has_parenthesis_comments && !is_l_block) return true;
  for (const char* at = begin; at != end; ++at) {
    const char c = Capital(*at);
    if (c == 'G' && !is_klartext) return true;
    if (c == 'M' && MayChangeState(dialect, is_stated_harmless, at, end)) return true;
    if (c == 'R' && is_klartext && at + 1 != end && (Capital(at[1]) == 'L' || Capital(at[1]) == 'R')) return true;
  }
  return false;
}

// Whether G10 stands there, which sets work offsets and tool lengths: "G10", "G 010".
bool HoldsDataInput(const char* begin, const char* end) {
  for (const char* at = begin; at != end; ++at) {
    if (Capital(*at) != 'G') continue;
    int64_t number = 0;
    const char* digit = at + 1;
    while (digit != end && *digit == ' ') ++digit;
    for (; digit != end && *digit >= '0' && *digit <= '9' && number < kCodes; ++digit)
      number = 10 * number + (*digit - '0');
    if (number == 10) return true;
  }
  return false;
}

// Whether a block that is no plain assignment may write variables of the control that hold work offsets or tool
// lengths: "#5221=10.", "#[#1]=0", "$P_UIFR[1,X,TR]=10". Numbers of the program's own variables are below 1000; from
// 3000 to 4999 stand alarms, clocks and the modal state.
bool MayWriteOffsets(const Dialect& dialect, const char* begin, const char* end) {
  if (dialect.has_parenthesis_comments && HoldsDataInput(begin, end)) return true;
  if (dialect.variable == 'Q' || std::find(begin, end, '=') == end) return false;  // Klartext writes them by FN 17
  if (dialect.variable == 'R') return std::find(begin, end, '$') != end;
  for (const char* at = std::find(begin, end, '#'); at != end; at = std::find(at + 1, end, '#')) {
    int64_t number = 0;
    const char* digit = at + 1;
    if (digit != end && *digit == '[' && std::find(digit, end, '=') != end) return true;
    for (; digit != end && *digit >= '0' && *digit <= '9' && number < 100000; ++digit)
      number = 10 * number + (*digit - '0');
    while (digit != end && (*digit == ' ' || *digit == '\t')) ++digit;
    if (digit != end && *digit == '=' && number >= 2000 && (number < 3000 || number >= 5000)) return true;
  }
  return false;
}

}  // namespace

Interpreter::Interpreter(const machine::Machine& machine, const RewriteOptions& options, const Dialect& dialect,
                         Coordinates coordinates)
    : machine_(&machine),
      axis_count_(machine.axis_count()),
      options_(&options),
      dialect_(&dialect),
      coordinates_(std::move(coordinates)),
      frame_of_words_(machine, options.tool_tip_mm) {
  for (const int number : options.harmless_m) {
    if (number < 0 || number > kMaxHarmlessM) continue;  // Validate says so
    const auto index = static_cast<size_t>(number);
    if (index >= is_stated_harmless_.size()) is_stated_harmless_.resize(index + 1);
    is_stated_harmless_[index] = true;
  }
  axis_of_letter_.fill(-1);
  roles_ = dialect.roles;
  for (int i = 0; i < machine.axis_count(); ++i) {
    is_linear_[i] = machine.axes[i].kind == machine::AxisKind::kLinear;
    // M126 may come in any Klartext program.
    const bool may_change = dialect.has_poles && machine.axes[i].roll_over == machine::RollOver::kUnstated;
    if (!is_linear_[i] && (may_change || WayOf(i) != machine::RollOver::kNone)) ways_ |= static_cast<uint16_t>(1u << i);
    const size_t letter = static_cast<size_t>(machine.axes[i].name[0] - 'A');
    if (machine.axes[i].name.size() == 1 && roles_[letter] == Role::kAxis)
      axis_of_letter_[letter] = static_cast<int8_t>(i);
  }
}

absl::StatusOr<Interpreter> Interpreter::Create(const machine::Machine& machine, const RewriteOptions& options) {
  const Dialect* dialect = FindDialect(options.dialect);
  if (dialect == nullptr) {
    return absl::InvalidArgumentError(absl::StrCat("dialect = '", options.dialect, "', there is none of that name"));
  }
  ASSIGN_OR_RETURN(Coordinates coordinates, Coordinates::Create(machine, options, *dialect));
  Interpreter interpreter(machine, options, *dialect, std::move(coordinates));
  RETURN_IF_ERROR(interpreter.TakeOptions());
  interpreter.BeginModal();
  return interpreter;
}

absl::Status Interpreter::TakeOptions() {
  std::vector<int> axes;
  constexpr size_t kNumbers = 100'000;  // N words have five digits on most controls
  if (options_->on_unsupported == OnUnsupported::kPass) numbers_seen_.resize(kNumbers);
  ASSIGN_OR_RETURN(positions_.ticks, ToAxisTicks(*machine_, options_->initial_position, "initial_position", &axes));
  for (const int axis : axes) positions_.known |= static_cast<uint16_t>(1u << axis);
  for (const std::string& name : options_->tool_change_keeps) {
    const int axis = machine::FindAxis(*machine_, name);
    if (axis < 0 || is_linear_[axis]) {
      return absl::InvalidArgumentError(
          absl::StrCat("tool_change_keeps: '", name, "', must be a rotary axis of machine '", machine_->id, "'"));
    }
    kept_in_tool_change_ |= static_cast<uint16_t>(1u << axis);
  }
  return absl::OkStatus();
}

int Interpreter::PlaneAxis(int index) const {
  static constexpr char kLetters[3][4] = {"YZX", "ZXY", "XYZ"};  // by normal: first, second, normal
  return AxisOf(kLetters[modal_.plane_normal][index]);
}

void Interpreter::ForgetPosition(int axis, bool is_reported) {
  const auto bit = static_cast<uint16_t>(1u << axis);
  if (positions_.is_known(axis)) {
    never_known_ &= static_cast<uint16_t>(~bit);
  } else if (unknown_since_[axis] == 0) {
    never_known_ |= bit;
  }
  lost_in_tool_change_ &= static_cast<uint16_t>(~bit);
  positions_.known &= static_cast<uint16_t>(~bit);
  traced_ &= static_cast<uint16_t>(~bit);
  positions_.sense[axis] = 0;
  unknown_reported_ = static_cast<uint16_t>(is_reported ? unknown_reported_ | bit : unknown_reported_ & ~bit);
  unknown_since_[axis] = line_;
}

void Interpreter::ForgetPositions(bool is_reported) {
  for (int i = 0; i < axis_count_; ++i) ForgetPosition(i, is_reported);
}

void Interpreter::ForgetAway(const Request& request, Step* step) {
  const bool is_sure = step->is_tool_change && !request.changes_pallet && !block_may_be_skipped_;
  for (int i = 0; i < axis_count_; ++i) {
    const auto bit = static_cast<uint16_t>(1u << i);
    if (is_sure && (kept_in_tool_change_ & bit) != 0) {
      step->kept_away |= bit;
      continue;
    }
    ForgetPosition(i, false);
    if (step->is_tool_change && !is_linear_[i]) lost_in_tool_change_ |= bit;
  }
}

void Interpreter::Unsupported(std::string reason, bool is_consequence, Step* step) {
  step->kind = StepKind::kUnsupported;
  step->reason = std::move(reason);
  step->is_consequence = is_consequence;
  step->preset = PresetChange::kNone;
  pole_.is_known = takes_plain_moves_ = false;
  // The block may have begun another drilling cycle, or stated other heights of the one in force.
  if (modal_.motion == Meaning::kDrillCycle) modal_.motion = Meaning::kOtherMotion, modal_.cycle = DrillCycle();
  ForgetPositions(true);
}

void Interpreter::StartProgram() {
  variables_.ForgetAll();
  const bool is_first = !has_moved_ && !at_program_end_;
  at_program_end_ = takes_plain_moves_ = false;
  if (is_first) return;
  ++programs_begun_;
  // Controls differ on whether the end of a program ends them.
  may_carry_shift_ |= coordinates_.has_shift() || coordinates_.has_preset() || coordinates_.has_frame();
  // A called tool stays in the spindle when its program ends.
  const bool has_called_tool = dialect_->tool_call_sets_length &&
                               (coordinates_.active_length() >= 0 || (modal_.blockers & kUnstatedLength) != 0);
  BeginModal();
  if (has_called_tool) modal_.blockers |= kUnstatedLength;
  if (modal_.blockers & kMirror) modal_.mirrored_axes = kAllAxes;
  if (modal_.blockers & kDatumShift) modal_.shifted_axes = kAllAxes;
  if (may_carry_shift_) modal_.blockers |= kShift;
  coordinates_.Reset();
  needs_absolute_ = 0;
  last_length_number_ = last_radius_number_ = -1;
  rounds_corners_ = is_behind_corner_ = false;
  pole_.is_known = false;
  ForgetPositions(false);
}

void Interpreter::BeginModal() {
  modal_ = Modal();
  frames_ = Frames();
  word_frame_.reset();
  const bool is_inch = options_->unit == ProgramUnit::kInch;
  modal_.is_inch = is_inch;
  modal_.turns_by_vector = dialect_->transformation_may_drop_offset;
  // A code of an earlier program of this text may still be in force.
  const bool is_contradicted = is_inch ? says_mm_ : says_inch_;
  const bool is_unit_known = options_->unit != ProgramUnit::kUnstated && !is_contradicted;
  if (has_called_) modal_.uncertain = kCalledGroups & ~kUnitGroup, modal_.blockers = blockers_at_calls_;
  if (!is_unit_known) modal_.uncertain |= kUnitGroup;
  is_unit_asked_ = false;
}

void Interpreter::ReadOverlong(Step* step) {
  ++line_;
  *step = Step();
  step->has_words = step->has_other_words = true;
  if (frame_.has_ended()) return;
  is_before_now_ = false;
  before_ = {modal_, coordinates_.offsets(), pole_, rounds_corners_ || is_behind_corner_};
  MayHaveChanged(kAllGroups);
  LoseToolPoint();
  step->leaves_text = true;
  Unsupported("the block is too long to be one", false, step);
}

void Interpreter::Read(const char* text, size_t size, Block* block, Step* step) {
  ++line_;
  step->kind = StepKind::kNone;
  step->has_words = step->has_other_words = step->is_rapid = step->is_arc = step->may_be_skipped = false;
  step->is_consequence = step->is_tool_change = step->moves_away = step->departs = step->ends_block =
      step->is_at_corner = false;
  step->sets_pole = step->is_corner = step->leaves_text = step->ends_program = step->ends_subprogram = false;
  step->jumps_back = step->is_curve = step->is_tangential = false;
  step->frame.is_changed = step->begins_definition = step->defines_cycle = step->begins_structure = false;
  text_ = text, end_of_text_ = text + size;
  step->has_vector = step->takes_no_rotary_words = false;
  step->wrapped = step->downwards = step->frame.turned = step->kept_away = 0;
  step->preset = PresetChange::kNone;
  if (!step->reason.empty()) step->reason.clear();
  if (!step->note.text.empty()) step->note = {};
  const char* const begin = text;
  block->word_count = 0;
  block->is_marked = false;
  switch (frame_.Read(line_, &text, &size)) {
    case ProgramFrame::Kind::kBlock:
      break;
    case ProgramFrame::Kind::kNotABlock:
      return;
    case ProgramFrame::Kind::kTail:
      step->note = RemarkAt(line_, "text-after-end", "text behind the end of the program is left as it is");
      return;
    case ProgramFrame::Kind::kHead:
      return StartProgram();
    case ProgramFrame::Kind::kSecondProgram:
      return Unsupported("a second program behind the closing '%'", false, step);
    case ProgramFrame::Kind::kBehindCut:
      Unsupported("text behind 0x1A: controllers differ on whether the program ends there", has_noted_cut_, step);
      has_noted_cut_ = true;
      return;
  }
  if (is_continued_ && !BeginsWithNumber(text, size)) {
    is_continued_ = IsContinued(text, size);
    if (defined_ != nullptr) ReadDefinition(text, size, step);
    return;
  }
  // The lines of CYCL DEF 247 ended without its number.
  if (defined_ != nullptr && defined_->meaning == Meaning::kSelectDatum) modal_.blockers |= kUnstatedOffset;
  defined_ = nullptr;
  const size_t skipped = static_cast<size_t>(text - begin);
  Lex(begin + skipped, size, *dialect_, block, &variables_);
  if (skipped > 0) {
    const auto shift = static_cast<uint32_t>(skipped);
    for (int i = 0; i < block->word_count; ++i) {
      Word& word = block->words[static_cast<size_t>(i)];
      word.letter_at += shift;
      word.number_at += shift;
      word.end += shift;
    }
    block->problem_at += shift;
  }
  is_continued_ = dialect_->has_bare_keywords && block->word_count > 0 && IsContinued(text, size) &&
                  TakesRest(block->words[static_cast<size_t>(block->word_count) - 1]);
  if (takes_plain_moves_ && IsPlainMove(*block, step)) {
    step->has_words = step->has_other_words = is_before_now_ = true;
    step->is_rapid = modal_.motion == Meaning::kRapid;
    if (ReadTargets(*block, step)) GoTo(step);
    takes_plain_moves_ = step->kind == StepKind::kMove;
    return;
  }
  if (stops_at_calls_ && BeginsStructure(begin, static_cast<size_t>(text + size - begin), *block)) {
    --line_;
    step->begins_structure = true;
    return;
  }
  takes_plain_moves_ = is_before_now_ = false;
  before_ = {modal_, coordinates_.offsets(), pole_, rounds_corners_ || is_behind_corner_};
  step->has_words = block->word_count > 0 || block->has_assignment || block->problem != LexProblem::kNone;
  if (step->has_words) ReadBlock(begin, *block, step);
  if (defined_ != nullptr) ReadDefinition(text, size, step);
  if (block->problem == LexProblem::kNone || step->kind == StepKind::kUntouched) return;
  if (MayHoldCodes(*dialect_, is_stated_harmless_, *block, begin + block->problem_at, text + size)) {
    NoteCall();
    step->leaves_text |= !BeginsWithMove(begin + block->problem_at, text + size);
  }
  const char *const rest = begin + block->problem_at, *const end = text + size;
  if (MayWriteOffsets(*dialect_, rest, end)) ForgetStated();
  rounds_corners_ |= !leaves_corners_ && dialect_->has_equals && Holds(rest, end, "RNDM");
  if (roles_['D' - 'A'] == Role::kToolRadius && Holds(rest, end, "D")) last_radius_number_ = -1;
  // "X#1 H2": the length in force, or that of the next G43, may be another.
  if (roles_['H' - 'A'] == Role::kToolLength && Holds(rest, end, "H")) {
    last_length_number_ = -1;
    if (coordinates_.active_length() >= 0) modal_.blockers |= kUnstatedLength;
  }
}

bool Interpreter::IsPlainMove(const Block& block, Step* step) {
  if (block.problem != LexProblem::kNone || block.is_deletable || block.has_assignment) return false;
  step->word_of_axis.fill(-1);
  bool has_axis = false, has_code = false, has_feed = false;
  for (int i = 0; i < block.word_count; ++i) {
    const Word& word = block.words[static_cast<size_t>(i)];
    if (word.distance != Distance::kModal) return false;
    switch (RoleOf(word.letter)) {
      case Role::kAxis: {
        const int axis = AxisOf(word.letter);
        if (axis < 0 || step->word_of_axis[axis] >= 0) return false;
        step->word_of_axis[axis] = static_cast<int8_t>(i);
        has_axis = true;
        break;
      }
      case Role::kCode: {
        // The motion code in force, written again, is accepted once.
        const Code& code = Find(word);
        if (has_code || code.meaning != modal_.motion || code.text != modal_.motion_text) return false;
        if ((code.detail != 0) != modal_.is_clockwise) return false;
        has_code = true;
        break;
      }
      case Role::kLineNumber:
        if (!numbers_seen_.empty()) NoteNumber(word);
        break;
      case Role::kFeed:
        has_feed = true;
        break;
      case Role::kPassive:
        break;
      default:
        return false;
    }
  }
  if (!has_axis) return false;
  modal_.lacks_feed &= !has_feed;
  modal_.is_rapid_unsure &= !has_code;
  return true;
}

// LinuxCNC 2.9, "O codes": [1] [2] behind CALL are #1 and #2 of the subprogram; the others are those of the caller
// (not read here), to whom all of them come back as they were.
Interpreter::Arguments Interpreter::ArgumentsOfOWord() const {
  std::vector<std::pair<std::string, std::optional<double>>> arguments;
  const char* at = call_block_.data();
  const char* const end = at + TextSize(at, call_block_.size());
  for (at = std::find(at, end, '['); at != end;) {
    const char* behind = at;
    const std::optional<double> value = Evaluate(&behind, end, *dialect_, variables_);
    arguments.emplace_back(absl::StrCat("#", arguments.size() + 1), value);
    int depth = 0;
    do {
      depth += *at == '[' ? 1 : *at == ']' ? -1 : 0;
      ++at;
    } while (at != end && depth > 0);
    if (value && behind != at) arguments.back().second.reset();
    while (at != end && *at == ' ') ++at;
    if (at != end && *at != '[') break;
  }
  return arguments;
}

// B-64484EN, "Macro call (G65)", argument specification I. Without a point a number counts by the address.
Interpreter::Arguments Interpreter::ArgumentsOfMacro() {
  static constexpr int kVariables[] = {1, 2, 3, 7,  8,  9,  0,  11, 4,  5,  6,  0,  13,
                                       0, 0, 0, 17, 18, 19, 20, 21, 22, 23, 24, 25, 26};
  Arguments arguments;
  Block call;
  bool is_macro = false;
  Lex(call_block_.data(), TextSize(call_block_.data(), call_block_.size()), *dialect_, &call, &variables_);
  for (const Word& word : call) {
    is_macro |= word.letter == 'G' && word.number.mantissa == 65 && word.number.decimals == 0;
    const int variable = word.letter >= 'A' && word.letter <= 'Z' ? kVariables[word.letter - 'A'] : 0;
    if (variable == 0) continue;
    const std::string name = absl::StrCat("#", variable);
    // I, J and K again are other variables.
    if (std::any_of(arguments.begin(), arguments.end(), [&](const auto& other) { return other.first == name; }))
      return {};
    const bool is_known = word.number.has_point || word.number.mantissa == 0;
    arguments.emplace_back(name, is_known ? std::optional<double>(ValueOf(word.number)) : std::nullopt);
  }
  return is_macro && call.problem == LexProblem::kNone ? arguments : Arguments();
}

void Interpreter::EnterLevel() {
  const bool keeps_caller = dialect_->takes_loaded_tool;  // LinuxCNC
  const Arguments arguments = keeps_caller ? ArgumentsOfOWord() : ArgumentsOfMacro();
  callers_.push_back(keeps_caller ? variables_ : Variables());
  variables_.ForgetLocals();
  for (const auto& [name, value] : arguments) variables_.Set(name, value);
  call_blocks_.push_back(call_block_);
}

void Interpreter::LeaveLevel() {
  variables_.ForgetLocals();
  if (call_blocks_.empty()) return;
  if (dialect_->takes_loaded_tool) variables_.TakeLocals(callers_.back());
  callers_.pop_back();
  call_block_ = call_blocks_.back();
  call_blocks_.pop_back();
}

// TNC 640, User's Manual for Klartext Programming, "Describing contours with mathematical functions".
bool Interpreter::TakeFunction(const char* text, const Block& block, bool may_be_skipped) {
  if (!dialect_->has_poles || block.word_count != 1 || block.words[0].letter != 0) return false;
  const Word& word = block.words[0];
  const std::string keyword = dialect_->keywords[static_cast<size_t>(word.keyword)].name;
  if (keyword.size() != 4 || keyword.rfind("FN ", 0) != 0 || keyword[3] < '0' || keyword[3] > '4') return false;
  std::string rest = RestOf(text + word.letter_at + keyword.size(), end_of_text_);
  if (const size_t at = rest.find(" DIV "); at != std::string::npos) rest.replace(at, 5, " / ");
  size_t begin = 0;
  while (begin < rest.size() && (rest[begin] == ':' || rest[begin] == ' ')) ++begin;
  const char *at = rest.data() + begin, *const end = rest.data() + rest.size();
  std::string name;
  at = EndOfVariable(at, end, *dialect_, &name);
  if (at == nullptr) return false;
  while (at != end && *at == ' ') ++at;
  if (at == end || *at++ != '=') return false;
  const std::optional<double> value = EvaluateSum(&at, end, *dialect_, variables_);
  variables_.Set(name, at == end && !may_be_skipped ? value : std::nullopt);
  return true;
}

// B-64484EN, "G code list": G80 is of the group of the cycles, G00 and G01 are of their own.
void Interpreter::SelectMotion(const Code& code) {
  const bool was_cycle = modal_.motion == Meaning::kDrillCycle;
  if (code.meaning == Meaning::kDrillCycle && !was_cycle) {
    const bool is_known = modal_.motion == Meaning::kRapid || modal_.motion == Meaning::kLinear;
    const bool is_kept = dialect_->cycles_keep_motion && is_known && !modal_.is_rapid_unsure &&
                         !block_may_be_skipped_ && (modal_.uncertain & kMotionGroup) == 0;
    modal_.motion_before_cycle = is_kept ? modal_.motion : Meaning::kCancelMotion;
  }
  const bool brings_back = code.meaning == Meaning::kCancelMotion && was_cycle;
  modal_.motion = brings_back ? modal_.motion_before_cycle : code.meaning;
}

// Tools, blanks, and cycles that wait for their call, whose definition writes their own parameters from Q200 on.
bool Interpreter::LeavesVariables(const Word& word) const {
  const Keyword& keyword = dialect_->keywords[static_cast<size_t>(word.keyword)];
  static constexpr const char* kNames[] = {"TOOL CALL",     "TOOL DEF", "BLK FORM", "CYCL CALL",
                                           "CYCL CALL POS", "RND",      "CHF"};
  return keyword.meaning == Meaning::kDefineCycle ||
         std::any_of(std::begin(kNames), std::end(kNames),
                     [&](const char* name) { return std::strcmp(keyword.name, name) == 0; });
}

void Interpreter::TakeVariables(const char* text, const Block& block) {
  const bool may_be_skipped = block.is_deletable && options_->block_delete == BlockDelete::kEither;
  for (const auto& [name, value] : block.has_assignment ? block.assigned : decltype(block.assigned)())
    variables_.Set(name, may_be_skipped ? std::nullopt : value);
  if (TakeFunction(text, block, may_be_skipped)) return;
  // What is not read may set them, and so may cycles and functions of Klartext, which have parameters of their own.
  const auto is_any = [&](auto&& is_one) {
    return dialect_->has_poles && std::any_of(block.begin(), block.end(), is_one);
  };
  if (is_any([this](const Word& word) { return TakesRest(word); })) variables_.ForgetOfCycles();
  if (block.problem != LexProblem::kNone ||
      is_any([this](const Word& word) { return TakesRest(word) && !LeavesVariables(word); }))
    variables_.ForgetAll();
}

bool Interpreter::BeginsStructure(const char* text, size_t size, const Block& block) const {
  if (std::memchr(text, 0x1A, size) != nullptr) return false;  // the program ends there
  const Word* first = block.begin();
  while (first != block.end() && first->letter == 'N' && !dialect_->has_poles) ++first;
  const bool is_empty = first == block.end();
  bool may_call = is_empty && block.problem != LexProblem::kNone && !dialect_->has_poles;
  if (!is_empty && first->letter == 0) {
    const Meaning meaning = dialect_->keyword_codes[static_cast<size_t>(first->keyword)].meaning;
    may_call = meaning == Meaning::kCall || meaning == Meaning::kJump;
  }
  for (const Word* word = first; word != block.end() && !may_call && !dialect_->has_poles; ++word) {
    const int64_t value = word->number.mantissa;
    may_call = (word->letter == 'M' && (value == 98 || value == 97)) || (word->letter == 'G' && value == 65) ||
               (word->letter == 'O' && dialect_->takes_loaded_tool) || (word->letter == 'L' && dialect_->has_equals);
  }
  if (!may_call) return false;
  const FlowLine flow = ReadFlow(std::string(text, size), *dialect_);
  return flow.kind == FlowLine::Kind::kCall || (flow.kind == FlowLine::Kind::kHead && flow.is_alone);
}

void Interpreter::ReadBlock(const char* text, const Block& block, Step* step) {
  if (!block.is_deletable || options_->block_delete == BlockDelete::kExecuted) return Apply(text, block, step);
  if (options_->block_delete == BlockDelete::kSkipped) return;
  Modal modal = modal_;
  const Positions positions = positions_;
  const AxisTicks offsets = coordinates_.offsets();
  const bool rounded_corners = rounds_corners_, was_behind_corner = is_behind_corner_;
  Apply(text, block, step);
  defined_ = nullptr;
  rounds_corners_ |= rounded_corners;
  is_behind_corner_ |= was_behind_corner;
  if (at_program_end_ && has_called_) MayHaveChanged(kCalledGroups);
  // Where it is skipped the program goes on, and where it is not nothing behind it follows.
  at_program_end_ = step->ends_program = false;
  if (dialect_->has_poles)
    modal.motion = modal_.motion, modal.is_clockwise = modal_.is_clockwise;  // every block states it
  if (!SameButRapid(modal, modal_) || offsets != coordinates_.offsets()) {
    if (step->kind != StepKind::kUnsupported) Unsupported("a modal code in a block that may be skipped", false, step);
    return KeepBoth(modal, offsets);
  }
  modal_.lacks_feed |= modal.lacks_feed;
  modal_.is_rapid_unsure |= modal.is_rapid_unsure;
  modal_.is_rapid_unsure |= (modal.motion == Meaning::kRapid) != (modal_.motion == Meaning::kRapid);
  if (step->kind == StepKind::kUnsupported || step->moves_away) return;
  if (step->kind == StepKind::kMove && modal_.cutter_side != 0) {
    LoseCutter();
    return Unsupported(
        "a move along a contour, while cutter compensation is active, that may be skipped: which contour "
        "the control offsets is not known, state --block-delete",
        false, step);
  }
  step->may_be_skipped = true;
  for (int i = 0; i < axis_count_; ++i) {
    const bool was_known = positions.is_known(i), is_known = positions_.is_known(i);
    if (was_known == is_known && (!is_known || positions.ticks[i] == positions_.ticks[i])) continue;
    ForgetPosition(i, false);
  }
  if (step->sets_pole) pole_.is_known = false;
}

void Interpreter::KeepBoth(const Modal& before, const AxisTicks& offsets_before) {
  const auto changed = [this](bool differs, uint8_t groups) {
    if (differs) MayHaveChanged(groups);
  };
  changed(before.motion != modal_.motion || before.is_clockwise != modal_.is_clockwise, kMotionGroup);
  changed(before.is_incremental != modal_.is_incremental, kDistanceGroup);
  changed(before.is_inch != modal_.is_inch, kUnitGroup);
  changed(before.plane_normal != modal_.plane_normal, kPlaneGroup);
  changed(before.feed_mode != modal_.feed_mode, kFeedGroup);
  if (before.way != modal_.way) modal_.way = Way::kUnknown;
  defined_ = nullptr;
  if (before.called != modal_.called) modal_.called = DrillCycle();
  if (before.cutter_side != modal_.cutter_side || before.cutter_radius != modal_.cutter_radius) {
    modal_.blockers |= kCutterCompensation;
    modal_.cutter_side = 0, modal_.cutter_radius = 0;
  }
  if (before.calls_at_moves != modal_.calls_at_moves) modal_.blockers |= kModalMacro, modal_.calls_at_moves = false;
  modal_.is_return_unsure |= before.is_return_unsure || before.returns_to_entry != modal_.returns_to_entry;
  if (before.cycle != modal_.cycle && modal_.motion == Meaning::kDrillCycle) modal_.motion = Meaning::kOtherMotion;
  changed(before.are_centres_absolute != modal_.are_centres_absolute, kCentreGroup);
  modal_.blockers |= before.blockers;
  modal_.turns_by_vector |= before.turns_by_vector;
  if (before.tool_point != modal_.tool_point || before.states_vectors != modal_.states_vectors) {
    modal_.blockers |= before.tool_point;
    LoseToolPoint();
  }
  modal_.mirrored_axes |= before.mirrored_axes;
  modal_.shifted_axes |= before.shifted_axes;
  modal_.macro_depth = std::max(modal_.macro_depth, before.macro_depth);
  if (offsets_before == coordinates_.offsets()) return;
  MayHaveChanged(kOffsetGroup | kLengthGroup);
  modal_.blockers |= kShift;
}

std::string Interpreter::UnknownVariable(const char* text, const Block& block) const {
  if (block.problem != LexProblem::kExpression && block.problem != LexProblem::kNoNumber) return "";
  if (Capital(text[block.problem_at]) == 'O') return "";  // a call, whose arguments matter less than whom it calls
  for (const char* at = text + block.problem_at + 1; at < end_of_text_; ++at) {
    const bool is_inside = at > text && ((Capital(at[-1]) >= 'A' && Capital(at[-1]) <= 'Z') || at[-1] == '_');
    const bool is_of_word = at == text + block.problem_at + 1;
    std::string name;
    if ((is_inside && !is_of_word) || EndOfVariable(at, end_of_text_, *dialect_, &name) == nullptr) continue;
    if (!variables_.Value(name)) return absl::StrCat(": the value of ", name, " is not known here");
  }
  return "";
}

void Interpreter::Apply(const char* text, const Block& block, Step* step) {
  if (at_program_end_) StartProgram();
  if (jump_line_ > 0) {
    step->has_other_words = true;
    return Unsupported(absl::StrCat("the order of blocks is not known: macro or jump in line ", jump_line_), true,
                       step);
  }
  TakeVariables(text, block);
  step->has_other_words |= block.has_assignment;
  if (block.has_assignment && dialect_->has_poles) modal_.called = DrillCycle();
  Request request;
  request.is_whole = block.problem == LexProblem::kNone;
  request.blockers_before = modal_.blockers;
  request.uncertain_before = modal_.uncertain;
  request.tool_point_before = modal_.tool_point;
  request.word_frame_before = word_frame_;
  request.length_before = coordinates_.active_length();
  request.cutter_side_before = modal_.cutter_side;
  const AxisTicks offsets_before = modal_.cutter_side != 0 ? coordinates_.offsets() : AxisTicks();
  const Modal modal_before = modal_;
  block_may_be_skipped_ = block.is_deletable && options_->block_delete == BlockDelete::kEither;
  ScanWords(block, &request, step);
  if (request.by_rest != nullptr) SelectByRest(text, &request, step);
  if (step->is_tool_change) {
    loaded_tool_ = called_tool_, has_changer_ = true;
    const bool is_done = !block.is_deletable || options_->block_delete != BlockDelete::kEither;
    is_loaded_tool_known_ = is_done && is_called_tool_sure_ && called_tool_ > 0;
    EndMode(kTurretOffset);
  }
  if (request.may_switch_offset && !has_changer_ && dialect_->tools_may_switch_offsets)
    modal_.blockers |= kTurretOffset;
  if (request.has_feed) modal_.lacks_feed = false;
  if (request.motion != nullptr) {
    SelectMotion(*request.motion);
    modal_.is_rapid_unsure = false;
    modal_.is_clockwise = request.motion->detail != 0;
    modal_.motion_text = request.motion->text;
    if (modal_.motion != Meaning::kDrillCycle) modal_.cycle = DrillCycle();
    if (dialect_->has_poles) SelectSense(&request);
  } else if (request.sense != nullptr) {
    request.Refuse("the sense of an arc without one");
  }
  modal_.uncertain &= static_cast<uint8_t>(~request.stated);
  if (request.scaling_off != nullptr) {
    if (request.has_axis || request.foreign_axis != 0 || !request.is_whole) {
      request.preset = request.scaling_off;
    } else {
      EndMode(kScaling);
    }
  }
  SelectMirror(request, block.problem == LexProblem::kNone, *step);
  blockers_seen_ |= modal_.blockers;
  if (request.speed_mode != nullptr) SelectSpeedMode(&request);
  if (request.offset != nullptr) SelectOffset(text, block, &request);
  if (request.length != nullptr || request.length_number != nullptr) SelectLength(&request);
  if (request.radius_number != nullptr) {
    const Decimal& number = request.radius_number->number;
    const bool is_number = number.decimals == 0 && number.mantissa >= 0 && number.mantissa <= 9999;
    last_radius_number_ = is_number && !block_may_be_skipped_ ? static_cast<int>(number.mantissa) : -1;
  }
  if (request.tool_point != nullptr) BeginToolPoint(text, block, &request);
  if (StatesVectors() && modal_.motion != Meaning::kArc && request.has_centre) {
    request.vector = request.centre;
    request.has_centre = false;
  }
  if (request.frame != nullptr) BeginFrame(block, &request, step);
  if (((modal_.tool_point | request.tool_point_before) & kPlacedFrames) != 0) PlaceWords(&request, step);
  if (request.turn_to_plane != nullptr) {
    std::string problem;
    if ((modal_.tool_point & kTiltedPlane) == 0) {
      problem = "no tilted plane is in force that is followed";
    } else if (request.has_axis || request.foreign_axis != 0 || request.parameter != 0 || request.motion != nullptr ||
               !request.is_whole) {
      problem = "with other words in its block";
    } else {
      problem = TurnToPlane(0, true, step);
    }
    if (!problem.empty()) request.Refuse(absl::StrCat(step->reason, ": ", problem));
    step->reason.clear();
  }
  if ((modal_.tool_point & ~kPlacedFrames) != 0 && request.offset != nullptr) {
    if (const std::string reason = RotaryOffsetProblem(); !reason.empty()) {
      LoseToolPoint();
      request.Refuse(reason);
    }
  }
  if (((modal_.tool_point | request.tool_point_before) & ~kPlacedFrames) != 0) ChangeFrame(&request, step);
  if (request.cutter_side_before != 0) KeepCutter(offsets_before, modal_before, &request);
  if (request.cutter_side != nullptr || (request.radius_number != nullptr && modal_.cutter_side != 0))
    BeginCutter(&request);
  // A pole of parameters moves nothing: it is not known.
  const bool is_read = block.problem == LexProblem::kNone || request.is_pole ||
                       (request.machine_move != nullptr && NamesAxesOnly(text, block));
  if (!is_read) {
    step->has_other_words = true;
    // o<name> of LinuxCNC calls or defines what stands elsewhere.
    request.is_jump |= text[block.problem_at] == 'o' || text[block.problem_at] == 'O';
    // Q120 to Q122: where a tilted plane needs the rotary axes.
    const bool is_of_plane = (modal_.tool_point & kTiltedPlanes) != 0 && dialect_->has_poles &&
                             Holds(text + block.problem_at, end_of_text_, "Q12");
    request.Refuse(absl::StrCat(ToString(block.problem, block.problem_at), UnknownVariable(text, block),
                                is_of_plane && !axes_of_plane_problem_.empty() ? ": " + axes_of_plane_problem_ : ""));
  }
  if (request.is_end && request.parameter != 0) {
    request.is_jump = true;
    request.Refuse("return to another block (M99 P)");
  }
  if (request.data_input != nullptr) {
    if (const std::string problem = InputData(block, request, *step); !problem.empty()) {
      ForgetStated();
      request.Refuse(absl::StrCat("G10 (", request.data_input->text, "): ", problem));
    }
  }
  step->moves_away = request.away != nullptr;
  // What runs in between may take the words as its arguments, and move from where it likes.
  const bool has_axis = request.has_axis || request.foreign_axis != 0;
  if (request.away != nullptr && !request.goes_away_behind && request.machine_move == nullptr && has_axis)
    request.Refuse(absl::StrCat(request.away, " and words of axes in one block: which comes first is not known"));
  if (!request.problem.empty()) {
    // "G52 X#1": it shifts, by what is not known.
    if (request.preset != nullptr || request.shift != nullptr) modal_.blockers |= kShift;
    Unsupported(request.problem, false, step);
  } else {
    Act(block, request, step);
  }
  if (request.is_jump) jump_line_ = line_;
  if (step->moves_away) modal_.is_cutter_ending = false;
  if (step->moves_away && !step->departs && step->kind != StepKind::kUnsupported) ForgetAway(request, step);
  if (step->kind == StepKind::kUnsupported && !call_problem_.empty() && !step->is_consequence)
    absl::StrAppend(&step->reason, ": ", call_problem_);
  at_program_end_ = step->ends_program = request.is_end;
  step->ends_subprogram = request.is_subprogram_end;
  step->leaves_text |= request.is_call || request.is_jump;
  if (request.is_call || request.is_jump) step->jumps_back = MayJumpBack(text, block, request);
  if (request.is_call && IsMakersMacro(request.number_of_parameter)) ForgetStated();
  const bool is_corner_pending = rounds_corners_ || is_behind_corner_;
  takes_plain_moves_ = step->kind == StepKind::kMove && !step->is_arc && step->wrapped == 0 && !is_corner_pending &&
                       !step->moves_away && !request.is_jump && !request.is_end && !request.is_rapid_block &&
                       !dialect_->has_bare_keywords && !dialect_->has_poles &&
                       !(modal_.tool_point != 0 && modal_.turns_by_vector) && !StatesVectors() && !is_in_table() &&
                       modal_.cutter_side == 0 && !modal_.is_cutter_ending;
}

}  // namespace axiscal::nc
