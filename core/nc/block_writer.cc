#include "core/nc/block_writer.h"

#include <algorithm>
#include <cmath>
#include <cstdlib>

namespace axiscal::nc {
namespace {

constexpr int kFeedDecimals = 4;  // of a scaled G93 feed; its own decimals when there are more

bool IsBlank(char c) { return c == ' ' || c == '\t'; }

}  // namespace

BlockWriter::BlockWriter(const machine::Machine& machine, const RewriteOptions& options, const Interpreter& interpreter)
    : machine_(&machine), options_(&options), interpreter_(&interpreter) {
  for (const char letter : interpreter.dialect().axis_letters) {
    const int axis = machine::FindAxis(machine, std::string(1, letter));
    if (axis >= 0) order_.push_back(axis);
  }
  for (int i = 0; i < machine.axis_count(); ++i) {
    commanded_.ticks[i] = interpreter.positions()[i].ticks;
    commanded_.is_known[i] = interpreter.positions()[i].is_known;
  }
}

void BlockWriter::Pass(const Step& step) {
  if (step.kind == StepKind::kUnsupported) return ForgetAll();
  if (step.kind != StepKind::kMove) return;
  for (const int axis : order_) {
    if (step.word_of_axis[axis] < 0) continue;
    if (interpreter_->modal().is_incremental) {
      commanded_.ticks[axis] += step.end[axis].ticks - step.start[axis].ticks;
    } else {
      commanded_.ticks[axis] = step.end[axis].ticks;
      commanded_.is_known[axis] = true;
    }
  }
}

void BlockWriter::ForgetChanges(const Commanded& before) {
  for (const int axis : order_) {
    commanded_.is_known[axis] &= before.is_known[axis] && before.ticks[axis] == commanded_.ticks[axis];
  }
}

int BlockWriter::FirstUnknown(const Step& step) const {
  if (!interpreter_->modal().is_incremental) return -1;
  for (const int axis : order_) {
    if (!commanded_.is_known[axis]) return axis;
  }
  return -1;
}

int BlockWriter::DecimalsOf(const Block& block, const Step& step, int axis) const {
  const bool is_inch = interpreter_->ticks_per_unit(axis) == kTicksPerInch;
  const int least = is_inch ? options_->decimals_inch : options_->decimals_mm;
  if (step.word_of_axis[axis] < 0) return least;
  const Decimal& number = block.words[static_cast<size_t>(step.word_of_axis[axis])].number;
  if (!number.has_point && options_->integer_words == IntegerWords::kLeastIncrement)
    return interpreter_->Meant(number).decimals;
  return std::max(least, static_cast<int>(number.decimals));
}

BlockWriter::Rounded BlockWriter::Round(int axis, Ticks target, int decimals) const {
  const Ticks grain = GrainTicks(interpreter_->ticks_per_unit(axis), decimals);
  const Ticks base = interpreter_->modal().is_incremental ? commanded_.ticks[axis] : interpreter_->offset(axis);
  return {RoundToGrains(target - base, grain), decimals, grain};
}

void BlockWriter::SetCommanded(int axis, const Rounded& rounded) {
  const Ticks base = interpreter_->modal().is_incremental ? commanded_.ticks[axis] : interpreter_->offset(axis);
  commanded_.ticks[axis] = base + rounded.mantissa * rounded.grain;
  commanded_.is_known[axis] = true;
}

bool BlockWriter::NeedsWord(int axis, Ticks target, Ticks grain) const {
  return !commanded_.is_known[axis] || std::llabs(target - commanded_.ticks[axis]) > grain / 2;
}

bool BlockWriter::IsPacked(const char* text, const Block& block) {
  for (int i = 1; i < block.word_count; ++i) {
    if (!IsBlank(text[block.words[static_cast<size_t>(i)].letter_at - 1])) return true;
  }
  return false;
}

void BlockWriter::AppendFeed(const Word& word, double fraction, std::string* out) const {
  const int decimals = std::clamp<int>(word.number.decimals, kFeedDecimals, kMaxDecimals);
  const double feed = ValueOf(word.number);
  AppendFixed(std::llround(feed / fraction * static_cast<double>(kPowersOfTen[decimals])), decimals, false, true, out);
}

void BlockWriter::InsertWords(const char* text, const Block& block, const Step& step, const AxisTicks& targets,
                              bool is_lower, std::string* out) {
  for (const int axis : order_) {
    if (step.word_of_axis[axis] >= 0) continue;
    const Rounded rounded = Round(axis, targets[axis], DecimalsOf(block, step, axis));
    if (!NeedsWord(axis, targets[axis], rounded.grain)) continue;
    if (!IsPacked(text, block)) out->push_back(' ');
    const char letter = machine_->axes[axis].name[0];
    out->push_back(is_lower ? static_cast<char>(letter - 'A' + 'a') : letter);
    AppendFixed(rounded.mantissa, rounded.decimals, false, true, out);
    SetCommanded(axis, rounded);
  }
}

void BlockWriter::WriteBlock(const char* text, size_t size, const Block& block, const Step& step,
                             const AxisTicks& targets, double feed_fraction, std::string* out) {
  const bool scales_feed = feed_fraction < 1.0 && interpreter_->modal().feed_mode == FeedMode::kInverseTime;
  uint32_t copied = 0;
  const Word* last = nullptr;
  // Inserted words stand behind the last axis word, also when other words follow it.
  for (const Word& word : block) {
    if (interpreter_->AxisOf(word.letter) >= 0) last = &word;
  }
  const auto insert = [&] {
    out->append(text + copied, last->end - copied);
    copied = last->end;
    InsertWords(text, block, step, targets, last->is_lower, out);
  };
  for (const Word& word : block) {
    const int axis = interpreter_->AxisOf(word.letter);
    if (axis >= 0) {
      const Rounded rounded = Round(axis, targets[axis], DecimalsOf(block, step, axis));
      const Decimal number = interpreter_->Meant(word.number);
      SetCommanded(axis, rounded);
      if (rounded.mantissa != number.mantissa * kPowersOfTen[rounded.decimals - number.decimals]) {
        out->append(text + copied, word.number_at - copied);
        const bool is_increments = !word.number.has_point && options_->integer_words == IntegerWords::kLeastIncrement;
        AppendFixed(rounded.mantissa, is_increments ? 0 : rounded.decimals, word.number.has_plus, !is_increments, out);
        copied = word.end;
      }
      if (&word == last) insert();
    } else if (word.letter == 'F' && scales_feed) {
      out->append(text + copied, word.number_at - copied);
      AppendFeed(word, feed_fraction, out);
      copied = word.end;
    }
  }
  out->append(text + copied, size - copied);
}

void BlockWriter::WritePiece(const Block& block, const Step& step, const AxisTicks& targets, double feed_fraction,
                             bool is_packed, const std::string& line_end, std::string* out) {
  bool is_first = true;
  for (const int axis : order_) {
    const Rounded rounded = Round(axis, targets[axis], DecimalsOf(block, step, axis));
    if (step.word_of_axis[axis] < 0 && !NeedsWord(axis, targets[axis], rounded.grain)) continue;
    if (!is_first && !is_packed) out->push_back(' ');
    is_first = false;
    out->push_back(machine_->axes[axis].name[0]);
    const bool is_increments = options_->integer_words == IntegerWords::kLeastIncrement &&
                               step.word_of_axis[axis] >= 0 &&
                               !block.words[static_cast<size_t>(step.word_of_axis[axis])].number.has_point;
    AppendFixed(rounded.mantissa, is_increments ? 0 : rounded.decimals, false, !is_increments, out);
    SetCommanded(axis, rounded);
  }
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
