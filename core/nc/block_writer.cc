#include "core/nc/block_writer.h"

#include <algorithm>
#include <cmath>
#include <cstdlib>

namespace axiscal::nc {
namespace {

constexpr int kFeedDecimals = 4;      // of a scaled G93 feed; its own decimals when there are more
constexpr int kVectorDecimals = 7;    // of the tool's direction between pieces: 0.1 urad
constexpr double kLeastShare = 1e-3;  // of the time of a move: for pieces that only take up a reversal

std::string LineEndOf(const char* text, size_t size) {
  size_t at = size;
  while (at > 0 && (text[at - 1] == '\n' || text[at - 1] == '\r')) --at;
  return at == size ? "\n" : std::string(text + at, size - at);
}

bool IsBlank(char c) { return c == ' ' || c == '\t'; }

}  // namespace

BlockWriter::BlockWriter(const machine::Machine& machine, const RewriteOptions& options, const Interpreter& interpreter)
    : machine_(&machine), interpreter_(&interpreter), rule_(WordRule::Of(options)) {
  for (const char letter : interpreter.dialect().axis_letters) {
    const int axis = machine::FindAxis(machine, std::string(1, letter));
    if (axis >= 0) order_.push_back(axis);
  }
  for (const int axis : order_) {
    is_linear_[axis] = machine.axes[axis].kind == machine::AxisKind::kLinear;
    is_followed_[axis] = options.orientation && !is_linear_[axis];
  }
  commanded_.ticks = programmed_ = interpreter.positions().ticks;
  commanded_.known = interpreter.positions().known;
}

void BlockWriter::Pass(const Block& block, const Step& step) {
  switch (step.preset) {
    case PresetChange::kNone:
      break;
    case PresetChange::kSet:
      // The controller takes the coordinates from where it stands, not from where the program thinks it does.
      for (const int axis : order_) {
        if (step.preset_axes >> axis & 1) preset_shift_[axis] = commanded_.ticks[axis] - step.end.ticks[axis];
      }
      suspended_shift_ = preset_shift_;
      return;
    case PresetChange::kCleared:
      for (const int axis : order_) {
        if (step.preset_axes >> axis & 1) preset_shift_[axis] = suspended_shift_[axis] = 0;
      }
      return;
    case PresetChange::kSuspended:
      preset_shift_ = {};
      return;
    case PresetChange::kRestored:
      preset_shift_ = suspended_shift_;
      return;
  }
  if (step.kind == StepKind::kUnsupported) ForgetAll();
  if (step.kind == StepKind::kUntouched) commanded_.known &= interpreter_->positions().known;
  const bool is_straight =
      interpreter_->modal().motion == Meaning::kRapid || interpreter_->modal().motion == Meaning::kLinear;
  // Axes that are told where to go are there again.
  for (const int axis : order_) {
    if (step.word_of_axis[axis] < 0 || block.problem != LexProblem::kNone || !is_straight) continue;
    if (step.kind == StepKind::kUntouched ||
        !interpreter_->IsIncremental(block.words[static_cast<size_t>(step.word_of_axis[axis])]))
      adrift_ &= static_cast<uint16_t>(~(1u << axis));
  }
  if (step.kind == StepKind::kHole) return PassHole(step);
  if (step.kind != StepKind::kMove) return;
  for (const int axis : order_) {
    if (step.has_vector && !is_linear_[axis]) TurnByVector(axis, step.end.ticks[axis]);
    if (step.word_of_axis[axis] < 0) continue;
    programmed_[axis] = step.end.ticks[axis];
    if (interpreter_->IsIncremental(block.words[static_cast<size_t>(step.word_of_axis[axis])])) {
      commanded_.ticks[axis] += step.end.ticks[axis] - step.start.ticks[axis];
    } else {
      commanded_.ticks[axis] = step.end.ticks[axis] + preset_shift_[axis];
      commanded_.known |= static_cast<uint16_t>(1u << axis);
    }
  }
}

void BlockWriter::Wrap(const Step& step) {
  for (const int axis : order_) {
    if ((step.wrapped >> axis & 1) == 0 || !step.start.is_known(axis)) continue;
    const Ticks turns = RoundToGrains(commanded_.ticks[axis] - step.start.ticks[axis], kTurn) * kTurn;
    commanded_.ticks[axis] -= turns;
    programmed_[axis] -= turns;
  }
}

void BlockWriter::ChangeFrame(const FrameChange& change) {
  adrift_ |= Departed();
  AxisTicks commanded = commanded_.ticks, programmed = programmed_;
  uint16_t kept = change.kept, rotary = 0;
  for (const int axis : order_) {
    if (!is_linear_[axis]) rotary |= static_cast<uint16_t>(1u << axis);
  }
  const auto needed = static_cast<uint16_t>(rotary | kept);
  // Rotary axes that the control itself turned to a tilted plane.
  for (const int axis : order_) {
    const auto bit = static_cast<uint16_t>(1u << axis);
    if ((change.turned & bit) == 0) continue;
    commanded_.ticks[axis] = programmed_[axis] = interpreter_->positions().ticks[axis];
    const bool is_known = interpreter_->positions().is_known(axis);
    commanded_.known = static_cast<uint16_t>(is_known ? commanded_.known | bit : commanded_.known & ~bit);
    adrift_ &= static_cast<uint16_t>(~bit);
  }
  if (change.to == FrameChange::To::kSame) {
    // Words of these axes say the same as before.
  } else if ((commanded_.known & needed) != needed || kept == 0 || !interpreter_->ToFrame(change, &commanded) ||
             !interpreter_->ToFrame(change, &programmed)) {
    kept = 0;
  }
  for (const int axis : interpreter_->frame().xyz()) {
    const auto bit = static_cast<uint16_t>(1u << axis);
    if ((kept & bit) == 0) {
      commanded_.known &= static_cast<uint16_t>(~bit);
      continue;
    }
    commanded_.ticks[axis] = commanded[axis];
    programmed_[axis] = programmed[axis];
    adrift_ &= static_cast<uint16_t>(~bit);
  }
}

void BlockWriter::ForgetChanges(const Commanded& before) {
  is_cycle_known_ = false;
  for (const int axis : order_) {
    if (before.is_known(axis) && before.ticks[axis] == commanded_.ticks[axis]) continue;
    commanded_.known &= static_cast<uint16_t>(~(1u << axis));
    adrift_ |= static_cast<uint16_t>(1u << axis);
  }
}

int BlockWriter::FirstUnknown(const Block& block, const Step& step) const {
  if (!interpreter_->modal().is_incremental && !step.is_arc) {
    for (int i = 0; i < block.word_count; ++i) {
      const Word& word = block.words[static_cast<size_t>(i)];
      const int axis = word.distance == Distance::kIncremental ? interpreter_->AxisOf(word.letter) : -1;
      if (axis >= 0 && !commanded_.is_known(axis)) return axis;
    }
    return -1;
  }
  for (const int axis : order_) {
    const bool is_flat = interpreter_->dialect().has_poles;  // arcs hold no word of another axis
    const bool matters =
        interpreter_->modal().is_incremental || is_flat || axis == step.arc.first || axis == step.arc.second;
    if (matters && !commanded_.is_known(axis)) return axis;
  }
  return -1;
}

WordForm BlockWriter::FormOf(const Block& block, const Step& step, int axis) const {
  const Ticks unit = interpreter_->ticks_per_unit(axis);
  if (step.word_of_axis[axis] < 0) return rule_.Inserted(unit);
  return rule_.Of(block.words[static_cast<size_t>(step.word_of_axis[axis])], unit);
}

WordGrain BlockWriter::GrainOf(const Block& block, const Step& step) const {
  WordGrain grain;
  for (int i = 0; i < machine_->axis_count(); ++i) {
    grain.of_axis[i] = FormOf(block, step, i).grain;
    grain.base[i] = BaseOf(block, step, i);
  }
  if (!step.is_arc) return grain;
  grain.is_flat = interpreter_->dialect().has_poles;
  for (const Word& word : block) {
    if (interpreter_->RoleOf(word.letter) != Role::kRadius) continue;
    grain.radius = rule_.Of(word, interpreter_->ticks_per_unit(step.arc.first)).grain;
  }
  if (grain.radius == 0) SetCentreGrain(block, step, &grain);
  return grain;
}

Ticks BlockWriter::BaseOf(const Block& block, const Step& step, int axis) const {
  const int index = step.word_of_axis[axis];
  const bool is_incremental = index < 0 ? interpreter_->modal().is_incremental
                                        : interpreter_->IsIncremental(block.words[static_cast<size_t>(index)]);
  return is_incremental ? commanded_.ticks[axis] : interpreter_->offset(axis) + preset_shift_[axis];
}

CorrectedWord BlockWriter::CorrectedOf(const Step& step, int axis, Ticks target, Ticks base,
                                       const WordForm& form) const {
  CorrectedWord corrected = WordFor(target, base, form);
  if (step.wrapped >> axis & 1) {
    const int64_t turn = kTurn / form.grain;
    corrected.number %= turn;
    if (corrected.number < 0) corrected.number += turn;
    corrected.number += turn * step.word_turns[axis];
    corrected.is_negated = (step.downwards >> axis & 1) != 0;
    // Zero has no sign that all controls read: the last place beside it.
    if (corrected.is_negated && corrected.number == 0) corrected.number = 1;
  }
  return corrected;
}

uint32_t BlockWriter::EndOf(const char* text, size_t size, const Word& word) {
  if (word.distance == Distance::kModal) return word.end;
  size_t at = word.end;
  while (at < size && IsBlank(text[at])) ++at;
  return at < size && text[at] == ')' ? static_cast<uint32_t>(at + 1) : word.end;
}

void BlockWriter::SetCommanded(const Step& step, int axis, const CorrectedWord& corrected, Ticks base, Ticks target) {
  Ticks at = corrected.Position(base);
  // The same position, on the turn of the move: words of later blocks may be differences.
  if (step.wrapped >> axis & 1) at -= RoundToGrains(at - target, kTurn) * kTurn;
  commanded_.ticks[axis] = at;
  commanded_.known |= static_cast<uint16_t>(1u << axis);
}

bool BlockWriter::NeedsWord(int axis, Ticks target, Ticks grain) const {
  // Rotary targets of orientation are what words say, and the linear axes follow them exactly.
  if (is_followed_[axis]) return !commanded_.is_known(axis) || target != commanded_.ticks[axis];
  return !commanded_.is_known(axis) || !IsHeld(target, commanded_.ticks[axis], grain);
}

bool BlockWriter::IsPacked(const char* text, const Block& block) {
  if (block.has_expression) return false;  // "R168Y5" would be one name
  for (int i = 1; i < block.word_count; ++i) {
    if (!IsBlank(text[block.words[static_cast<size_t>(i)].letter_at - 1])) return true;
  }
  return false;
}

void BlockWriter::AppendCorrected(const CorrectedWord& corrected, const Word* word, OutBuffer* out) const {
  const bool plus =
      word == nullptr || word->number.mantissa < 0 ? interpreter_->dialect().writes_plus : word->number.has_plus;
  AppendNumber(corrected, plus, out);
}

void BlockWriter::AppendDistance(Distance distance, OutBuffer* out) const {
  for (const DistanceName& known : interpreter_->dialect().distance_names) {
    if (known.distance == distance) out->append(absl::StrCat("=", known.name, "("));
  }
}

void BlockWriter::AppendFeed(const Word& word, double fraction, OutBuffer* out) const {
  const int decimals = std::clamp<int>(word.number.decimals, kFeedDecimals, kMaxDecimals);
  const double feed = ValueOf(word.number) / std::max(fraction, kLeastShare);
  AppendFixed(std::llround(feed * static_cast<double>(kPowersOfTen[decimals])), decimals, false, true, out);
}

void BlockWriter::InsertWords(const char* text, const Block& block, const Step& step, const AxisTicks& targets,
                              bool is_lower, OutBuffer* out) {
  for (const int axis : order_) {
    if (step.word_of_axis[axis] >= 0) continue;
    if (step.takes_no_rotary_words && !is_linear_[axis]) {
      TurnByVector(axis, targets[axis]);
      continue;
    }
    const Ticks base = BaseOf(block, step, axis);
    const CorrectedWord corrected = CorrectedOf(step, axis, targets[axis], base, FormOf(block, step, axis));
    if (!NeedsWord(axis, targets[axis], corrected.form.grain)) continue;
    if (!IsPacked(text, block)) out->push_back(' ');
    const char letter = machine_->axes[axis].name[0];
    out->push_back(is_lower ? static_cast<char>(letter - 'A' + 'a') : letter);
    AppendCorrected(corrected, nullptr, out);
    SetCommanded(step, axis, corrected, base, targets[axis]);
  }
}

bool BlockWriter::WriteSimple(const char* text, size_t size, const Block& block, const Step& step, const Piece& piece,
                              OutBuffer* out) {
  constexpr size_t kMaxBytes = 256;
  if (step.is_arc || step.is_resolved || step.wrapped != 0 || is_in_chords_ || size > kMaxBytes ||
      interpreter_->modal().is_incremental)
    return false;
  for (const int axis : order_) {
    if (step.word_of_axis[axis] >= 0) continue;
    if (step.takes_no_rotary_words && !is_linear_[axis]) {
      TurnByVector(axis, piece.targets[axis]);
      continue;
    }
    if (NeedsWord(axis, piece.targets[axis], FormOf(block, step, axis).grain)) return false;
  }
  // Local copies: the compiler must assume that a write through `to` can change any member of this object.
  const WordRule rule = rule_;
  char* to = out->Room(kMaxBytes + machine::kMaxAxes * kMaxFixedBytes);
  uint32_t copied = 0;
  const int word_count = block.word_count;
  for (int i = 0; i < word_count; ++i) {
    const Word& word = block.words[static_cast<size_t>(i)];
    const int axis = interpreter_->AxisOf(word.letter);
    if (axis < 0) continue;
    if (word.distance != Distance::kModal) return false;
    commanded_.known |= static_cast<uint16_t>(1u << axis);
    const Ticks target = piece.targets[axis], shift = preset_shift_[axis];
    // The word says this position already.
    if (target == step.end.ticks[axis] && shift == 0) {
      commanded_.ticks[axis] = target;
      continue;
    }
    const Ticks unit = interpreter_->ticks_per_unit(axis), base = interpreter_->offset(axis) + shift;
    const CorrectedWord corrected = WordFor(target, base, rule.Of(word, unit));
    commanded_.ticks[axis] = corrected.Position(base);
    if (IsSaid(corrected, word)) continue;
    const uint32_t number_at = word.number_at, end = word.end;
    const bool has_plus = word.number.has_plus;
    if (number_at - copied <= 16 && copied + 16 <= size) {
      __builtin_memcpy(to, text + copied, 16);  // more than is wanted, and written over
      to += number_at - copied;
    } else {
      to = CopyShort(text + copied, number_at - copied, to);
    }
    to = WriteNumber(corrected, has_plus, to);
    copied = end;
  }
  out->Take(CopyShort(text + copied, size - copied, to));
  return true;
}

void BlockWriter::WriteBlock(const char* text, size_t size, const Block& block, const Step& step, const Piece& piece,
                             double feed_fraction, OutBuffer* out) {
  if (feed_fraction == 1.0 && WriteSimple(text, size, block, step, piece, out)) return;
  const bool scales_feed = feed_fraction < 1.0 && interpreter_->modal().feed_mode == FeedMode::kInverseTime;
  const AxisTicks start = step.is_arc ? commanded_.ticks : AxisTicks();
  if (piece.is_arc) AppendPole(block, piece, LineEndOf(text, size), out);
  uint32_t copied = 0;
  const auto copy_to = [&](uint32_t at) {
    out->append(text + copied, at - copied);
    copied = at;
  };
  // Inserted words stand behind the last axis word, also when other words follow it.
  const Word* last = nullptr;
  const Word* first = nullptr;
  for (const Word& word : block) {
    const bool is_centre = step.is_arc && interpreter_->RoleOf(word.letter) == Role::kCentre;
    if (interpreter_->AxisOf(word.letter) < 0 && !is_centre) continue;
    last = &word;
    if (first == nullptr) first = &word;
  }
  // A block of the tool's direction alone; in LN X, Y and Z stand in front of it.
  if (last == nullptr && step.has_vector && interpreter_->dialect().has_poles) last = block.begin();
  if (last == nullptr && step.has_vector)
    last = &block.words[static_cast<size_t>(*std::max_element(step.word_of_vector.begin(), step.word_of_vector.end()))];
  const std::string motion = step.is_arc || is_in_chords_ ? MotionFor(block, piece.is_arc) : std::string();
  for (const Word& word : block) {
    if (first != nullptr && &word == first && !motion.empty()) {
      copy_to(word.letter_at);
      out->append(motion);
    }
    const int axis = interpreter_->AxisOf(word.letter);
    if (axis >= 0) {
      const Ticks base = BaseOf(block, step, axis);
      const CorrectedWord corrected = CorrectedOf(step, axis, piece.targets[axis], base, FormOf(block, step, axis));
      SetCommanded(step, axis, corrected, base, piece.targets[axis]);
      if (!IsSaid(corrected, word)) {
        copy_to(word.number_at);
        AppendCorrected(corrected, &word, out);
        copied = word.end;
      }
    } else if (word.letter == 'F' && scales_feed) {
      copy_to(word.number_at);
      AppendFeed(word, feed_fraction, out);
      copied = word.end;
    } else if (const int component = piece.end_fraction < 1.0 ? VectorOf(block, step, word) : -1; component >= 0) {
      copy_to(word.number_at);
      AppendComponent(word, piece, component, out);
      copied = word.end;
    } else if (step.is_arc) {
      WriteArcWord(text, size, word, piece, start, &copied, out);
    }
    if (&word == last) {
      copy_to(EndOf(text, size, word));
      InsertWords(text, block, step, piece.targets, last->is_lower, out);
      if (piece.is_arc) InsertCentre(text, block, piece, start, out);
    }
  }
  out->append(text + copied, size - copied);
  if (step.is_arc) {
    is_in_chords_ = !piece.is_arc && !interpreter_->dialect().has_poles;
  } else if (HasMotionWord(block)) {
    is_in_chords_ = false;
  }
}

int BlockWriter::VectorOf(const Block& block, const Step& step, const Word& word) {
  for (int k = 0; step.has_vector && k < 3; ++k) {
    if (&block.words[static_cast<size_t>(step.word_of_vector[static_cast<size_t>(k)])] == &word) return k;
  }
  return -1;
}

void BlockWriter::AppendComponent(const Word& word, const Piece& piece, int component, OutBuffer* out) const {
  const int decimals = std::clamp<int>(word.number.decimals, kVectorDecimals, kMaxDecimals);
  const double value = interpreter_->frame().Up(piece.nominal)[component];
  AppendFixed(std::llround(value * static_cast<double>(kPowersOfTen[decimals])), decimals,
              interpreter_->dialect().writes_plus, true, out);
}

void BlockWriter::AppendVector(const char* text, const Block& block, const Step& step, const Piece& piece,
                               bool is_packed, bool is_first, OutBuffer* out) const {
  const auto blank = [&] {
    if (!is_first && !is_packed) out->push_back(' ');
    is_first = false;
  };
  for (const Word& word : block) {  // they count for every piece
    if (word.letter != 0 ||
        interpreter_->dialect().keywords[static_cast<size_t>(word.keyword)].meaning != Meaning::kSurfaceNormal)
      continue;
    blank();
    out->append(text + word.letter_at, word.end - word.letter_at);
  }
  for (size_t k = 0; k < 3; ++k) {
    const Word& word = block.words[static_cast<size_t>(step.word_of_vector[k])];
    blank();
    out->append(interpreter_->dialect().vector_addresses[k]);
    if (piece.end_fraction < 1.0) {
      AppendComponent(word, piece, static_cast<int>(k), out);
    } else {
      out->append(text + word.number_at, word.end - word.number_at);
    }
  }
}

void BlockWriter::WritePiece(const char* text, const Block& block, const Step& step, const Piece& piece,
                             double feed_fraction, bool is_packed, const std::string& line_end, OutBuffer* out) {
  const AxisTicks start = commanded_.ticks;
  bool is_first = true;
  const bool has_poles = interpreter_->dialect().has_poles;
  if (piece.is_arc && has_poles) {
    AppendPole(block, piece, line_end, out);
    out->append(RadiusOf(block) != nullptr ? "CR " : "C ");
  } else {
    out->append(step.has_vector && has_poles ? "LN " : interpreter_->dialect().piece_prefix);
  }
  if (step.is_arc && !has_poles && piece.is_arc == is_in_chords_) {
    out->append(piece.is_arc ? interpreter_->modal().is_clockwise ? "G02" : "G03" : "G01");
    if (!is_packed) out->push_back(' ');
    is_in_chords_ = !piece.is_arc;
  }
  for (const int axis : order_) {
    if (step.takes_no_rotary_words && !is_linear_[axis]) {
      TurnByVector(axis, piece.targets[axis]);
      continue;
    }
    const int index = step.word_of_axis[axis];
    const bool is_of_arc = piece.is_arc && (axis == piece.arc.first || axis == piece.arc.second);
    const bool is_wrapped = step.wrapped >> axis & 1;  // such words are absolute, and say so in G91
    const Ticks base = interpreter_->modal().is_incremental && !is_wrapped
                           ? commanded_.ticks[axis]
                           : interpreter_->offset(axis) + preset_shift_[axis];
    WordForm form = FormOf(block, step, axis);
    // A rotary word that is not corrected says the program's own position, where it is absolute too.
    if (!is_linear_[axis] && !is_followed_[axis])
      form = ExactForm(form, piece.targets[axis] - base, interpreter_->ticks_per_unit(axis));
    const CorrectedWord corrected = CorrectedOf(step, axis, piece.targets[axis], base, form);
    if (index < 0 && !is_of_arc && !NeedsWord(axis, piece.targets[axis], corrected.form.grain)) continue;
    if (!is_first && !is_packed) out->push_back(' ');
    is_first = false;
    out->push_back(machine_->axes[axis].name[0]);
    const Word* const word = index < 0 ? nullptr : &block.words[static_cast<size_t>(index)];
    const bool says_distance = is_wrapped && word != nullptr && word->distance != Distance::kModal;
    if (says_distance) AppendDistance(word->distance, out);
    AppendNumber(corrected, interpreter_->dialect().writes_plus, out);
    if (says_distance) out->push_back(')');
    SetCommanded(step, axis, corrected, base, piece.targets[axis]);
  }
  if (step.has_vector) AppendVector(text, block, step, piece, is_packed, is_first, out);
  if (piece.is_arc) AppendArcWords(block, piece, start, is_packed, out);
  if (piece.is_arc && has_poles) out->append(interpreter_->modal().is_clockwise ? " DR-" : " DR+");
  if (interpreter_->modal().feed_mode == FeedMode::kInverseTime) {
    for (const Word& word : block) {
      if (word.letter != 'F') continue;
      out->append(is_packed ? "F" : " F");
      AppendFeed(word, feed_fraction, out);
    }
  }
  out->append(line_end);
}

}  // namespace axiscal::nc
