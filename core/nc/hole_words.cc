// Blocks of drilling cycles.
#include "core/nc/block_writer.h"

namespace axiscal::nc {

void BlockWriter::LeaveHole(const Step& step) {
  const int z = interpreter_->AxisOf('Z');
  const auto bit = static_cast<uint16_t>(1u << z);
  if (step.hole.is_fixed) {
    commanded_.ticks[z] = step.end.ticks[z] + preset_shift_[z];
    commanded_.known |= bit;
    return;
  }
  const bool is_known = !step.hole.is_return_unsure &&
                        (step.hole.returns_to_entry || (is_cycle_level_known_ && !step.hole.is_level_unsure));
  commanded_.ticks[z] = step.hole.returns_to_entry ? hole_entry_ : cycle_level_;
  commanded_.known = static_cast<uint16_t>(is_known ? commanded_.known | bit : commanded_.known & ~bit);
}

void BlockWriter::PassHole(const Step& step) {
  const int z = interpreter_->AxisOf('Z');
  if (step.hole.is_first) cycle_level_ = commanded_.ticks[z], is_cycle_level_known_ = commanded_.is_known(z);
  for (const int axis : order_) {
    programmed_[axis] = step.end.ticks[axis];
    if (axis == z || step.word_of_axis[axis] < 0) continue;
    commanded_.ticks[axis] = step.end.ticks[axis] + preset_shift_[axis];
    commanded_.known |= static_cast<uint16_t>(1u << axis);
  }
  hole_entry_ = step.hole.entry + preset_shift_[z];
  hole_bottom_ = step.hole.bottom + preset_shift_[z];
  is_cycle_known_ = true;
  LeaveHole(step);
}

void BlockWriter::WriteFixedHole(const char* text, size_t size, const Block& block, const Step& step,
                                 const Piece& entry, const Piece& bottom, OutBuffer* out) {
  const int z = interpreter_->AxisOf('Z');
  Ticks raised = 0;  // by the word of Z
  const Word* last = nullptr;
  for (const Word& word : block) {
    if (interpreter_->AxisOf(word.letter) >= 0 && step.word_of_axis[interpreter_->AxisOf(word.letter)] >= 0)
      last = &word;
  }
  uint32_t copied = 0;
  const auto target_of = [&](int axis) {
    return axis == z ? *step.hole.shifted_to + bottom.targets[z] - step.hole.bottom : entry.targets[axis];
  };
  const auto corrected_of = [&](int axis) {
    const Ticks origin = BaseOf(block, step, axis);
    return CorrectedOf(step, axis, target_of(axis), origin, FormOf(block, step, axis));
  };
  const auto go = [&](int axis, const CorrectedWord& corrected) {
    SetCommanded(step, axis, corrected, BaseOf(block, step, axis), entry.targets[axis]);
  };
  for (const Word& word : block) {
    const int axis = interpreter_->AxisOf(word.letter);
    if (last == nullptr || axis < 0) continue;
    if (axis != z || step.hole.shifted_to) {
      const CorrectedWord corrected = corrected_of(axis);
      if (axis == z) {
        raised = corrected.Position(BaseOf(block, step, z)) - preset_shift_[z] - *step.hole.shifted_to;
      } else {
        go(axis, corrected);
      }
      if (!IsSaid(corrected, word)) {
        out->append(text + copied, word.number_at - copied);
        AppendCorrected(corrected, &word, out);
        copied = word.end;
      }
    }
    if (&word != last) continue;
    const uint32_t end = EndOf(text, size, word);
    out->append(text + copied, end - copied);
    copied = end;
    for (const int other : order_) {
      if (other == z || step.word_of_axis[other] >= 0) continue;
      const CorrectedWord corrected = corrected_of(other);
      if (!NeedsWord(other, entry.targets[other], corrected.form.grain)) continue;
      if (!IsPacked(text, block)) out->push_back(' ');
      const char letter = machine_->axes[other].name[0];
      out->push_back(word.is_lower ? static_cast<char>(letter - 'A' + 'a') : letter);
      AppendCorrected(corrected, nullptr, out);
      go(other, corrected);
    }
  }
  out->append(text + copied, size - copied);
  hole_entry_ = step.hole.entry + preset_shift_[z] + raised;
  hole_bottom_ = step.hole.bottom + preset_shift_[z] + raised;
  LeaveHole(step);
  commanded_.ticks[z] += raised;
}

void BlockWriter::WriteHole(const char* text, size_t size, const Block& block, const Step& step, const Piece& entry,
                            const Piece& bottom, OutBuffer* out) {
  if (step.hole.is_fixed) return WriteFixedHole(text, size, block, step, entry, bottom, out);
  const int z = interpreter_->AxisOf('Z');
  if (step.hole.is_first) cycle_level_ = commanded_.ticks[z], is_cycle_level_known_ = commanded_.is_known(z);
  const Ticks unit = interpreter_->ticks_per_unit(z), base = interpreter_->offset(z) + preset_shift_[z];
  uint32_t copied = 0;
  const auto copy_to = [&](uint32_t at) {
    out->append(text + copied, at - copied);
    copied = at;
  };
  const auto replace = [&](const Word& word, const CorrectedWord& corrected) {
    if (IsSaid(corrected, word)) return;
    copy_to(word.number_at);
    AppendCorrected(corrected, &word, out);
    copied = word.end;
  };
  const Word *last = nullptr, *radius = nullptr;
  for (const Word& word : block) {
    if (interpreter_->AxisOf(word.letter) >= 0) last = &word;
    if (interpreter_->RoleOf(word.letter) == Role::kRadius) radius = &word;
  }
  const bool has_bottom = step.word_of_axis[z] >= 0;
  const WordForm inserted = rule_.Inserted(unit);
  const WordForm of_bottom =
      has_bottom ? rule_.Of(block.words[static_cast<size_t>(step.word_of_axis[z])], unit) : inserted;
  const CorrectedWord bottom_word = WordFor(bottom.targets[z], base, of_bottom);
  const CorrectedWord entry_word =
      WordFor(entry.targets[z], base, radius != nullptr ? rule_.Of(*radius, unit) : inserted);
  const bool writes_bottom = has_bottom || !is_cycle_known_ || !IsHeld(bottom.targets[z], hole_bottom_, inserted.grain);
  const bool writes_entry =
      radius != nullptr || !is_cycle_known_ || !IsHeld(entry.targets[z], hole_entry_, inserted.grain);
  const auto insert = [&](char letter, const CorrectedWord& corrected) {
    if (!IsPacked(text, block)) out->push_back(' ');
    out->push_back(last->is_lower ? static_cast<char>(letter - 'A' + 'a') : letter);
    AppendCorrected(corrected, nullptr, out);
  };
  for (const Word& word : block) {
    const int axis = interpreter_->AxisOf(word.letter);
    if (axis == z) {
      replace(word, bottom_word);
    } else if (&word == radius) {
      replace(word, entry_word);
    } else if (axis >= 0) {
      const Ticks origin = BaseOf(block, step, axis);
      const CorrectedWord corrected = CorrectedOf(step, axis, entry.targets[axis], origin, FormOf(block, step, axis));
      SetCommanded(step, axis, corrected, origin, entry.targets[axis]);
      replace(word, corrected);
    }
    if (&word != last) continue;
    copy_to(word.end);
    for (const int other : order_) {
      if (other == z || step.word_of_axis[other] >= 0) continue;
      const Ticks origin = BaseOf(block, step, other);
      const CorrectedWord corrected =
          CorrectedOf(step, other, entry.targets[other], origin, FormOf(block, step, other));
      if (!NeedsWord(other, entry.targets[other], corrected.form.grain)) continue;
      insert(machine_->axes[other].name[0], corrected);
      SetCommanded(step, other, corrected, origin, entry.targets[other]);
    }
    if (writes_bottom && !has_bottom) insert('Z', bottom_word);
    if (writes_entry && radius == nullptr) insert('R', entry_word);
  }
  out->append(text + copied, size - copied);
  if (writes_bottom) hole_bottom_ = bottom_word.Position(base);
  if (writes_entry) hole_entry_ = entry_word.Position(base);
  is_cycle_known_ = true;
  is_in_chords_ = false;
  LeaveHole(step);
}

}  // namespace axiscal::nc
