#include "core/nc/interpreter.h"

#include <algorithm>
#include <cmath>

#include "core/base/units.h"
#include "core/nc/lexer.h"

namespace axiscal::nc {
namespace {

using machine::AxisKind;
using machine::kMaxAxes;

constexpr double kMaxPositionUnits = 1e7;  // 10 km: ticks stay far from overflow
constexpr Ticks kMaxTicks = static_cast<Ticks>(kMaxPositionUnits) * kTicksPerMm;

std::string WordText(const Word& word) {
  std::string text(1, word.letter);
  AppendFixed(word.number.mantissa, word.number.decimals, false, word.number.has_point, &text);
  return text;
}

bool SameButRapid(const Modal& a, const Modal& b) {
  const auto kind = [](Meaning motion) { return motion == Meaning::kRapid ? Meaning::kLinear : motion; };
  return kind(a.motion) == kind(b.motion) && a.is_inch == b.is_inch && a.is_incremental == b.is_incremental &&
         a.feed_mode == b.feed_mode && a.blockers == b.blockers && a.work_offset == b.work_offset;
}

}  // namespace

// What the words of one block ask for, before anything is done.
struct Interpreter::Scan {
  const Code* motion = nullptr;
  const Code* one_shot = nullptr;
  const Code* distance = nullptr;  // G90, G91
  const Code* unit = nullptr;      // G20, G21
  const Code* feed = nullptr;      // G93 to G95
  std::string problem;             // first reason to refuse
  uint16_t blockers_before = 0;
  bool has_axis = false;
  bool has_code = false;
  bool is_dwell = false;
  bool is_end = false;
  char foreign_axis = 0;
  char parameter = 0;

  void Refuse(const std::string& reason) {
    if (problem.empty()) problem = reason;
  }
  // Controllers differ: the last of two counts for the block, or each for the words behind it (G90 X5. G91 Y1.).
  void Choose(const Code** chosen, const Code& code, const char* what) {
    if (*chosen != nullptr && (*chosen)->meaning != code.meaning)
      Refuse(absl::StrCat("two different ", what, " codes in one block"));
    *chosen = &code;
  }
};

Interpreter::Interpreter(const machine::Machine& machine, const RewriteOptions& options, const Dialect& dialect)
    : machine_(&machine), options_(&options), dialect_(&dialect) {
  roles_.fill(Role::kParameter);
  axis_of_letter_.fill(-1);
  for (const char letter : dialect.axis_letters) roles_[static_cast<size_t>(letter - 'A')] = Role::kForeignAxis;
  for (const char letter : {'F', 'S', 'T', 'D', 'H'}) roles_[static_cast<size_t>(letter - 'A')] = Role::kPassive;
  roles_['G' - 'A'] = roles_['M' - 'A'] = Role::kCode;
  roles_['N' - 'A'] = Role::kLineNumber;
  roles_['O' - 'A'] = Role::kProgramNumber;
  for (int i = 0; i < machine.axis_count(); ++i) {
    is_linear_[i] = machine.axes[i].kind == AxisKind::kLinear;
    const size_t letter = static_cast<size_t>(machine.axes[i].name[0] - 'A');
    if (machine.axes[i].name.size() != 1 || roles_[letter] != Role::kForeignAxis) continue;
    roles_[letter] = Role::kAxis;
    axis_of_letter_[letter] = static_cast<int8_t>(i);
  }
}

absl::StatusOr<Interpreter> Interpreter::Create(const machine::Machine& machine, const RewriteOptions& options) {
  const Dialect* dialect = FindDialect(options.dialect);
  if (dialect == nullptr) {
    return absl::InvalidArgumentError(absl::StrCat("dialect = '", options.dialect, "', there is none of that name"));
  }
  Interpreter interpreter(machine, options, *dialect);
  RETURN_IF_ERROR(interpreter.TakeOptions());
  return interpreter;
}

absl::StatusOr<AxisTicks> Interpreter::ToAxisTicks(const std::vector<AxisValue>& values, const std::string& field,
                                                   std::vector<int>* axes) const {
  AxisTicks ticks{};
  for (const AxisValue& value : values) {
    const int axis = machine::FindAxis(*machine_, value.axis);
    if (axis < 0) {
      return absl::InvalidArgumentError(
          absl::StrCat(field, ": machine '", machine_->id, "' has no axis '", value.axis, "'"));
    }
    const double units = is_linear_[axis] ? value.value : value.value * base::kDegPerRad;
    if (!(std::abs(units) <= kMaxPositionUnits)) {
      return absl::InvalidArgumentError(
          absl::StrCat(field, ": ", value.axis, " = ", units, ", must be finite, at most 1e7"));
    }
    ticks[axis] = std::llround(units * kTicksPerUnit);
    axes->push_back(axis);
  }
  return ticks;
}

absl::Status Interpreter::TakeOptions() {
  std::vector<int> axes;
  ASSIGN_OR_RETURN(const AxisTicks initial, ToAxisTicks(options_->initial_position, "initial_position", &axes));
  for (const int axis : axes) {
    positions_[axis].ticks = initial[axis];
    positions_[axis].is_known = true;
  }
  for (size_t i = 0; i < options_->work_offsets.size(); ++i) {
    const WorkOffset& offset = options_->work_offsets[i];
    ASSIGN_OR_RETURN(const AxisTicks ticks, ToAxisTicks(offset.offsets, "work_offsets " + offset.code, &axes));
    offsets_.push_back(ticks);
    if (offset.code == "G54") modal_.work_offset = static_cast<int16_t>(i);  // what controllers select at power-on
  }
  return absl::OkStatus();
}

Decimal Interpreter::Meant(const Decimal& written) const {
  Decimal number = written;
  if (!number.has_point && options_->integer_words == IntegerWords::kLeastIncrement) {
    number.decimals = static_cast<int8_t>(modal_.is_inch ? options_->decimals_inch : options_->decimals_mm);
  }
  return number;
}

const Interpreter::Code& Interpreter::Find(const Word& word) const {
  static const Code kUnknown = {Meaning::kUnknown, 0, "unknown code"};
  int64_t tenths = word.number.mantissa;
  int decimals = word.number.decimals;
  for (; decimals > 1 && tenths % 10 == 0; --decimals) tenths /= 10;
  if (decimals > 1) return kUnknown;
  if (decimals == 0 && tenths < kCodes) tenths *= 10;
  if (tenths < 0 || tenths >= kCodes) return kUnknown;
  return (word.letter == 'G' ? dialect_->g_codes : dialect_->m_codes)[static_cast<size_t>(tenths)];
}

void Interpreter::ForgetPositions(bool is_consequence) {
  for (AxisPosition& position : positions_) {
    position.is_known = false;
    position.sense = 0;
    position.is_consequence = is_consequence;
    position.unknown_since_line = line_;
  }
}

void Interpreter::Unsupported(std::string reason, bool is_consequence, Step* step) {
  step->kind = StepKind::kUnsupported;
  step->reason = std::move(reason);
  step->is_consequence = is_consequence;
  ForgetPositions(true);
}

void Interpreter::StartProgram() {
  at_program_end_ = false;
  if (!has_moved_) return;
  modal_ = Modal();
  for (size_t i = 0; i < options_->work_offsets.size(); ++i) {
    if (options_->work_offsets[i].code == "G54") modal_.work_offset = static_cast<int16_t>(i);
  }
  ForgetPositions(false);
}

void Interpreter::ReadOverlong(Step* step) {
  ++line_;
  *step = Step();
  step->has_words = step->has_other_words = true;
  if (!frame_.has_ended()) Unsupported("the block is too long to be one", false, step);
}

void Interpreter::Read(const char* text, size_t size, Block* block, Step* step) {
  ++line_;
  step->kind = StepKind::kNone;
  step->has_words = step->has_other_words = step->is_rapid = step->may_be_skipped = false;
  step->is_consequence = step->is_tool_change = step->ends_block = false;
  if (!step->reason.empty()) step->reason.clear();
  if (!step->note.empty()) step->note.clear();
  const char* const begin = text;
  block->word_count = 0;
  block->is_marked = false;
  switch (frame_.Read(line_, &text, &size)) {
    case ProgramFrame::Kind::kBlock:
      break;
    case ProgramFrame::Kind::kNotABlock:
      return;
    case ProgramFrame::Kind::kTail:
      step->note = absl::StrCat("line ", line_, ": text behind the end of the program is left as it is");
      return;
    case ProgramFrame::Kind::kSecondProgram:
      return Unsupported("a second program behind the closing '%'", false, step);
  }
  const size_t skipped = static_cast<size_t>(text - begin);
  Lex(begin + skipped, size, *dialect_, block);
  if (skipped > 0) {
    const auto shift = static_cast<uint32_t>(skipped);
    for (int i = 0; i < block->word_count; ++i) {
      Word& word = block->words[static_cast<size_t>(i)];
      word.letter_at += shift;
      word.number_at += shift;
      word.end += shift;
    }
  }
  step->has_words = block->word_count > 0 || block->problem != LexProblem::kNone;
  if (!step->has_words) return;
  if (!block->is_deletable || options_->block_delete == BlockDelete::kExecuted) return Apply(*block, step);
  if (options_->block_delete == BlockDelete::kSkipped) return;
  const Modal modal = modal_;
  const auto positions = positions_;
  Apply(*block, step);
  if (step->kind == StepKind::kUnsupported) return;
  if (!SameButRapid(modal, modal_)) return Unsupported("a modal code in a block that may be skipped", false, step);
  if (step->is_tool_change || at_program_end_) return;
  step->may_be_skipped = true;
  for (size_t i = 0; i < positions_.size(); ++i) {
    if (positions[i].is_known && positions_[i].is_known && positions[i].ticks == positions_[i].ticks) continue;
    if (!positions[i].is_known && !positions_[i].is_known) continue;
    positions_[i].is_known = false;
    positions_[i].sense = 0;
    positions_[i].is_consequence = false;
    positions_[i].unknown_since_line = line_;
  }
}

void Interpreter::SelectOffset(const Word& word, const Code& code, Scan* scan) {
  const std::string name = WordText(word);
  for (size_t i = 0; i < options_->work_offsets.size(); ++i) {
    if (options_->work_offsets[i].code != absl::StrCat("G", word.number.mantissa) || word.number.decimals != 0)
      continue;
    modal_.work_offset = static_cast<int16_t>(i);
    modal_.blockers &= static_cast<uint16_t>(~kUnstatedOffset);
    return;
  }
  modal_.blockers |= kUnstatedOffset;
  scan->Refuse(absl::StrCat(name, " (", code.text, "): its values are not stated"));
}

void Interpreter::ScanCode(const Word& word, Scan* scan, Step* step) {
  const Code& code = Find(word);
  scan->has_code = true;
  const auto named = [&] { return absl::StrCat(WordText(word), " (", code.text, ")"); };
  switch (code.meaning) {
    case Meaning::kUnknown:
      return scan->Refuse(named() + ": it might move axes");
    case Meaning::kHarmless:
      return;
    case Meaning::kRapid:
    case Meaning::kLinear:
    case Meaning::kOtherMotion:
    case Meaning::kCancelMotion:
      if (scan->motion != nullptr) scan->Refuse("two motion codes in one block");
      scan->motion = &code;
      if (code.meaning == Meaning::kOtherMotion) scan->Refuse(named());
      return;
    case Meaning::kOneShot:
    case Meaning::kSubprogram:
      scan->one_shot = &code;
      return scan->Refuse(named());
    case Meaning::kDwell:
      scan->is_dwell = true;
      return;
    case Meaning::kInch:
      scan->Choose(&scan->unit, code, "unit");
      modal_.is_inch = true;
      return;
    case Meaning::kMillimetre:
      scan->Choose(&scan->unit, code, "unit");
      modal_.is_inch = false;
      return;
    case Meaning::kAbsolute:
      scan->Choose(&scan->distance, code, "distance (G90, G91)");
      modal_.is_incremental = false;
      return;
    case Meaning::kIncremental:
      scan->Choose(&scan->distance, code, "distance (G90, G91)");
      modal_.is_incremental = true;
      return;
    case Meaning::kFeedPerMinute:
      scan->Choose(&scan->feed, code, "feed mode");
      modal_.feed_mode = FeedMode::kPerMinute;
      return;
    case Meaning::kFeedInverseTime:
      scan->Choose(&scan->feed, code, "feed mode");
      modal_.feed_mode = FeedMode::kInverseTime;
      return;
    case Meaning::kFeedPerTurn:
      scan->Choose(&scan->feed, code, "feed mode");
      modal_.feed_mode = FeedMode::kPerTurn;
      return;
    case Meaning::kWorkOffset:
      return SelectOffset(word, code, scan);
    case Meaning::kBlockerOn:
      modal_.blockers |= code.blocker;
      return scan->Refuse(named());
    case Meaning::kBlockerOff:
      modal_.blockers &= static_cast<uint16_t>(~code.blocker);
      return;
    case Meaning::kToolChange:
      step->is_tool_change = true;
      return;
    case Meaning::kEndOfProgram:
      scan->is_end = step->ends_block = true;
      return;
    case Meaning::kEndOfBlock:
      step->ends_block = true;
      return;
  }
}

void Interpreter::ScanWords(const Block& block, Scan* scan, Step* step) {
  step->word_of_axis.fill(-1);
  for (int i = 0; i < block.word_count; ++i) {
    const Word& word = block.words[static_cast<size_t>(i)];
    const size_t letter = static_cast<size_t>(word.letter - 'A');
    const Role role = roles_[letter];
    step->has_other_words |= role != Role::kLineNumber && role != Role::kProgramNumber;
    switch (role) {
      case Role::kCode:
        ScanCode(word, scan, step);
        break;
      case Role::kAxis: {
        int8_t& index = step->word_of_axis[static_cast<size_t>(axis_of_letter_[letter])];
        if (index >= 0) scan->Refuse(absl::StrCat("two words ", std::string(1, word.letter), " in one block"));
        index = static_cast<int8_t>(i);
        scan->has_axis = true;
        break;
      }
      case Role::kForeignAxis:
        if (scan->foreign_axis == 0) scan->foreign_axis = word.letter;
        break;
      case Role::kParameter:
        if (scan->parameter == 0) scan->parameter = word.letter;
        break;
      case Role::kProgramNumber:
        StartProgram();
        break;
      case Role::kLineNumber:
      case Role::kPassive:
        break;
    }
  }
}

void Interpreter::Apply(const Block& block, Step* step) {
  if (at_program_end_) StartProgram();
  Scan scan;
  scan.blockers_before = modal_.blockers;
  ScanWords(block, &scan, step);
  if (scan.motion != nullptr) {
    modal_.motion = scan.motion->meaning;
    modal_.motion_text = scan.motion->text;
  }
  if (block.problem != LexProblem::kNone) {
    step->has_other_words = true;
    scan.Refuse(ToString(block.problem, block.problem_at));
  }
  if (scan.is_end && scan.parameter != 0) scan.Refuse("return to another block (M99 P)");
  if (!scan.problem.empty()) {
    Unsupported(scan.problem, false, step);
  } else {
    CheckAndMove(block, scan, step);
  }
  if (step->is_tool_change && step->kind != StepKind::kUnsupported) ForgetPositions(false);
  at_program_end_ = scan.is_end;
}

void Interpreter::CheckAndMove(const Block& block, const Scan& scan, Step* step) {
  if (scan.is_dwell) {
    for (int i = 0; i < machine_->axis_count(); ++i) {
      if (step->word_of_axis[i] < 0 || machine_->axes[i].name == "X" || machine_->axes[i].name == "U") continue;
      return Unsupported("a dwell with the axis word " + machine_->axes[i].name, false, step);
    }
    if (scan.motion != nullptr) return Unsupported("a dwell and a motion code in one block", false, step);
    return;
  }
  const std::string parameter(1, scan.parameter);
  if (!scan.has_axis && scan.foreign_axis == 0) {
    if (scan.parameter != 0 && !scan.has_code)
      Unsupported("word " + parameter + " without a code that it belongs to", false, step);
    return;
  }
  if (modal_.blockers != 0) {
    return Unsupported(BlockerText(modal_.blockers), (modal_.blockers & scan.blockers_before) != 0, step);
  }
  if (modal_.motion == Meaning::kOtherMotion) return Unsupported(modal_.motion_text, false, step);
  if (modal_.motion == Meaning::kCancelMotion) {
    return Unsupported("axis words while no motion code is in force (G80)", false, step);
  }
  if (scan.foreign_axis != 0) {
    return Unsupported(
        absl::StrCat("word ", std::string(1, scan.foreign_axis), ": machine '", machine_->id, "' has no such axis"),
        false, step);
  }
  if (scan.parameter != 0) return Unsupported("word " + parameter + " in a linear move", false, step);
  Move(block, step);
}

void Interpreter::Move(const Block& block, Step* step) {
  step->is_rapid = modal_.motion == Meaning::kRapid;
  const int count = machine_->axis_count();
  for (int i = 0; i < count; ++i) {
    step->start[i] = step->end[i] = positions_[i];
    if (step->word_of_axis[i] < 0) continue;
    const Word& word = block.words[static_cast<size_t>(step->word_of_axis[i])];
    const Decimal& number = word.number;
    if (!number.has_point && number.digits >= 5 && options_->integer_words == IntegerWords::kWholeUnits) {
      return Unsupported(
          absl::StrCat(
              "word ", WordText(word),
              " has no point and five digits or more: state whether it counts whole units or least increments"),
          false, step);
    }
    const std::optional<Ticks> value = ToTicks(Meant(number), ticks_per_unit(i));
    AxisPosition& end = step->end[i];
    if (modal_.is_incremental && !end.is_known) {
      const bool is_consequence = end.is_consequence;
      return Unsupported(absl::StrCat("G91 from an unknown position of ", machine_->axes[i].name), is_consequence,
                         step);
    }
    const Ticks base = modal_.is_incremental ? end.ticks : offset(i);
    if (!value || std::abs(*value) > kMaxTicks || std::abs(base + *value) > kMaxTicks) {
      return Unsupported(absl::StrCat("word ", WordText(word), " has more than nine decimals or is out of range"),
                         false, step);
    }
    const Ticks target = base + *value;
    if (!end.is_known) {
      end.sense = 0;
    } else if (target != end.ticks) {
      end.sense = target > end.ticks ? 1 : -1;
    }
    end.ticks = target;
    end.is_known = true;
  }
  step->kind = StepKind::kMove;
  for (int i = 0; i < count; ++i) positions_[i] = step->end[i];
  has_moved_ = true;
}

}  // namespace axiscal::nc
