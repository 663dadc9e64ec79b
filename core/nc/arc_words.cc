// Words of arcs: centre and radius, and the motion code where an arc became chords.
#include <cmath>

#include "core/nc/block_writer.h"
#include "core/nc/char_class.h"

namespace axiscal::nc {
namespace {

bool IsBlank(char c) { return c == ' ' || c == '\t'; }

// Whether the axis words of a block with this code are the code's own, and no move: G68 X0 Y0 R5., G52 X#1, G65 X1.
bool OwnsWords(const Dialect& dialect, const Word& word) {
  if (word.letter != 'G') return false;
  int64_t tenths = word.number.mantissa;
  if (word.number.decimals == 0) tenths *= 10;
  if (word.number.decimals > 1 || tenths < 0 || tenths >= kCodes) return true;  // no code that is known
  const CodeMeaning& code = dialect.g_codes[static_cast<size_t>(tenths)];
  constexpr uint32_t kMovesOn = kCutterCompensation | kToolControl | kNormalDirection;  // G41 X5. moves
  switch (code.meaning) {
    case Meaning::kBlockerOn:
      return (code.detail & ~kMovesOn) != 0;
    case Meaning::kBlockerOff:
      return code.detail == kMirror;
    case Meaning::kPreset:
    case Meaning::kScalingOffOrPreset:
    case Meaning::kLocalShift:
    case Meaning::kLimits:
    case Meaning::kDwell:
    case Meaning::kDataInput:
    case Meaning::kMachineMove:
    case Meaning::kOneShot:
    case Meaning::kCall:
    case Meaning::kUnknown:
      return true;
    default:
      return false;
  }
}

bool IsLetter(char c) { return Capital(c) >= 'A' && Capital(c) <= 'Z'; }

// Index in the plane (0, 1) of I, J or K, or -1.
int PlaneIndex(char letter, int plane_normal) {
  static constexpr char kCentres[3][3] = {"JK", "KI", "IJ"};
  return letter == kCentres[plane_normal][0] ? 0 : letter == kCentres[plane_normal][1] ? 1 : -1;
}

char CentreLetter(int index, int plane_normal) {
  static constexpr char kCentres[3][3] = {"JK", "KI", "IJ"};
  return kCentres[plane_normal][index];
}

}  // namespace

void BlockWriter::SetCentreGrain(const Block& block, const Step& step, WordGrain* grain) const {
  const Dialect& dialect = interpreter_->dialect();
  const Modal& modal = interpreter_->modal();
  grain->radius_tolerance_mm = dialect.arc_radius_tolerance_mm;
  grain->takes_finer_centres = dialect.takes_finer_words;
  for (const int index : {0, 1}) {
    const int axis = index == 0 ? step.arc.first : step.arc.second;
    const Ticks unit = interpreter_->ticks_per_unit(axis);
    CentreWord& centre = grain->centre[static_cast<size_t>(index)];
    centre.form = rule_.Inserted(unit);
    centre.ticks_per_unit = unit;
    centre.origin = interpreter_->offset(axis) + (dialect.has_poles ? 0 : preset_shift_[axis]);
    centre.from_origin = dialect.has_poles || modal.are_centres_absolute;
    centre.from_start = !centre.from_origin;
    for (const Word& word : block) {
      if (dialect.has_poles || interpreter_->RoleOf(word.letter) != Role::kCentre) continue;
      if (PlaneIndex(word.letter, modal.plane_normal) != index) continue;
      centre.form = rule_.Of(word, unit);
      centre.from_origin |= word.distance == Distance::kAbsolute;
      centre.from_start |= word.distance == Distance::kIncremental;
    }
  }
}

bool BlockWriter::ArcWord(char letter, const Word* word, const Piece& piece, const AxisTicks& start,
                          CorrectedWord* corrected) const {
  const Modal& modal = interpreter_->modal();
  const Ticks unit = interpreter_->ticks_per_unit(piece.arc.first);
  const WordForm form = word == nullptr ? rule_.Inserted(unit) : rule_.Of(*word, unit);
  if (interpreter_->RoleOf(letter) == Role::kRadius) {
    const double sign = std::abs(piece.arc.sweep_rad) > std::numbers::pi ? -1.0 : 1.0;
    *corrected = WordFor(std::llround(sign * piece.arc.radius_mm() * kTicksPerUnit), 0, form);
    return true;
  }
  const int index = PlaneIndex(letter, modal.plane_normal);
  if (index < 0) return false;
  const int axis = index == 0 ? piece.arc.first : piece.arc.second;
  const Ticks centre = std::llround(piece.arc.centre_mm[index] * kTicksPerUnit);
  const bool is_absolute = word == nullptr || word->distance == Distance::kModal
                               ? modal.are_centres_absolute
                               : word->distance == Distance::kAbsolute;
  const Ticks base = is_absolute ? interpreter_->offset(axis) + preset_shift_[axis] : start[axis];
  *corrected = WordFor(centre, base, AtLeast(piece.centre_decimals, form, unit));
  return true;
}

void BlockWriter::WriteArcWord(const char* text, size_t size, const Word& word, const Piece& piece,
                               const AxisTicks& start, uint32_t* copied, OutBuffer* out) const {
  const Role role = interpreter_->RoleOf(word.letter);
  const auto copy_to = [&](uint32_t at) {
    out->append(text + *copied, at - *copied);
    *copied = at;
  };
  const auto drop = [&] {
    uint32_t begin = word.letter_at;
    while (begin > *copied && IsBlank(text[begin - 1])) --begin;
    copy_to(begin);
    *copied = EndOf(text, size, word);
  };
  if (!piece.is_arc && interpreter_->IsTurns(word)) return drop();
  if (word.letter == 0 && interpreter_->dialect().has_poles) {
    const Meaning meaning = interpreter_->dialect().keywords[static_cast<size_t>(word.keyword)].meaning;
    if (meaning == Meaning::kArcSense && !piece.is_arc) return drop();
    if (meaning != Meaning::kArc || piece.is_arc) return;
    copy_to(word.letter_at);
    out->append("L");
    *copied = word.end;
    return;
  }
  if (role == Role::kCode && word.letter == 'G' && !piece.is_arc && interpreter_->IsArcCode(word)) {
    copy_to(word.number_at);
    out->append(word.end - word.number_at > 1 ? "01" : "1");
    *copied = word.end;
    return;
  }
  if (role != Role::kCentre && role != Role::kRadius) return;
  if (!piece.is_arc) return drop();
  CorrectedWord corrected;
  if (!ArcWord(word.letter, &word, piece, start, &corrected) || IsSaid(corrected, word)) return;
  copy_to(word.number_at);
  AppendCorrected(corrected, &word, out);
  *copied = word.end;
}

void BlockWriter::InsertCentre(const char* text, const Block& block, const Piece& piece, const AxisTicks& start,
                               OutBuffer* out) {
  if (interpreter_->dialect().has_poles) return;
  bool found[2] = {false, false};
  for (const Word& word : block) {
    const Role role = interpreter_->RoleOf(word.letter);
    if (role == Role::kRadius) return;
    const int index = role == Role::kCentre ? PlaneIndex(word.letter, interpreter_->modal().plane_normal) : -1;
    if (index >= 0) found[index] = true;
  }
  for (const int index : {0, 1}) {
    if (found[index]) continue;
    const char letter = CentreLetter(index, interpreter_->modal().plane_normal);
    CorrectedWord corrected;
    if (!ArcWord(letter, nullptr, piece, start, &corrected) || corrected.number == 0) continue;
    if (!IsPacked(text, block)) out->push_back(' ');
    out->push_back(letter);
    AppendCorrected(corrected, nullptr, out);
  }
}

void BlockWriter::AppendArcWords(const Block& block, const Piece& piece, const AxisTicks& start, bool is_packed,
                                 OutBuffer* out) const {
  const auto append = [&](char letter, const Word* like) {
    CorrectedWord corrected;
    Word plain;  // a word without a distance of its own
    if (like != nullptr) plain = *like;
    plain.distance = Distance::kModal;
    const Word* const word = like == nullptr ? nullptr : &plain;
    if (!ArcWord(letter, word, piece, start, &corrected)) return;
    if (!is_packed) out->push_back(' ');
    if (interpreter_->RoleOf(letter) == Role::kRadius) {
      out->append(interpreter_->dialect().radius_address);
    } else {
      out->push_back(letter);
    }
    AppendNumber(corrected, interpreter_->dialect().writes_plus, out);
  };
  if (interpreter_->dialect().has_poles) {
    if (const Word* const radius = RadiusOf(block); radius != nullptr) append(radius->letter, radius);
    return;
  }
  const Word* of_letter[26] = {};
  for (const Word& word : block) {
    if (word.letter != 0) of_letter[word.letter - 'A'] = &word;
    if (interpreter_->RoleOf(word.letter) == Role::kRadius) return append(word.letter, &word);
  }
  for (const int index : {0, 1}) {
    const char letter = CentreLetter(index, interpreter_->modal().plane_normal);
    append(letter, of_letter[letter - 'A']);
  }
}

const Word* BlockWriter::RadiusOf(const Block& block) const {
  for (const Word& word : block) {
    if (interpreter_->RoleOf(word.letter) == Role::kRadius) return &word;
  }
  return nullptr;
}

void BlockWriter::AppendPole(const Block& block, const Piece& piece, const std::string& line_end, OutBuffer* out) {
  if (!interpreter_->dialect().has_poles || RadiusOf(block) != nullptr) return;
  Pole wanted = {{}, true, true};
  std::string words = "CC";
  for (const int index : {0, 1}) {
    const int axis = index == 0 ? piece.arc.first : piece.arc.second;
    const Ticks base = interpreter_->offset(axis);
    const Ticks unit = interpreter_->ticks_per_unit(axis);
    const CorrectedWord corrected = WordFor(std::llround(piece.arc.centre_mm[index] * kTicksPerUnit), base,
                                            AtLeast(piece.centre_decimals, rule_.Inserted(unit), unit));
    wanted.ticks[static_cast<size_t>(index)] = corrected.Position(base);
    absl::StrAppend(&words, " ", machine_->axes[axis].name);
    AppendNumber(corrected, true, &words);
  }
  if (wanted == pole_) return;
  pole_ = wanted;
  is_pole_moved_ = true;
  out->append(words);
  out->append(line_end);
}

bool BlockWriter::HasMotionWord(const Block& block) const {
  for (const Word& word : block) {
    if (interpreter_->IsMotionCode(word)) return true;
  }
  return false;
}

std::string BlockWriter::MotionFor(const Block& block, bool wants_arc) const {
  if (interpreter_->dialect().has_poles) return "";  // every block states its motion
  if (wants_arc != is_in_chords_ || HasMotionWord(block)) return "";
  if (!wants_arc) return "G01 ";
  return interpreter_->modal().is_clockwise ? "G02 " : "G03 ";
}

bool BlockWriter::MovesByCode(const char* text, size_t size, const Block& block) const {
  for (const Word& word : block) {
    if (OwnsWords(interpreter_->dialect(), word)) return false;
  }
  for (const Word& word : block) {
    if (interpreter_->AxisOf(word.letter) >= 0) return true;
    const Role role = interpreter_->RoleOf(word.letter);
    if (role == Role::kAxis || role == Role::kCentre) return true;
  }
  // "X#1": a word that moves, whose number is none.
  if (block.problem == LexProblem::kNone || block.problem_at >= size) return false;
  const char letter = text[block.problem_at];
  const Role role = interpreter_->RoleOf(IsLetter(letter) ? Capital(letter) : char{0});
  const bool is_word = block.problem_at + 1 >= size || !IsLetter(text[block.problem_at + 1]);
  return is_word && (role == Role::kAxis || role == Role::kCentre || role == Role::kRadius);
}

void BlockWriter::CopyBlock(const char* text, size_t size, const Block& block, const Step& step, OutBuffer* out) {
  const bool has_motion = HasMotionWord(block);
  const bool passes = step.kind == StepKind::kMove || step.kind == StepKind::kUnsupported;
  if (!is_in_chords_ || !passes || has_motion || !MovesByCode(text, size, block)) {
    if (has_motion && (!passes || !step.may_be_skipped)) is_in_chords_ = false;
    out->append(text, size);
    return;
  }
  // Behind the line number, in front of whatever moves.
  uint32_t at = block.word_count > 0 ? block.words[0].letter_at : block.problem_at;
  if (block.word_count > 0 && block.words[0].letter == 'N')
    at = block.word_count > 1 ? block.words[1].letter_at : block.words[0].end;
  out->append(text, at);
  out->append(interpreter_->modal().is_clockwise ? " G02 " : " G03 ");
  out->append(text + at, size - at);
  if (!step.may_be_skipped) is_in_chords_ = false;
}

}  // namespace axiscal::nc
