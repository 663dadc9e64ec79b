// Drilling cycles of the ISO family: where the holes are. Fanuc B-64484EN, "Canned cycle for drilling"; Haas Mill
// Operator's Manual 96-8200; LinuxCNC 2.9, "Canned cycles".
#include <cstring>

#include "core/nc/request.h"

namespace axiscal::nc {

void Interpreter::LoseCycle(const std::string& reason, Step* step) {
  Unsupported(absl::StrCat(modal_.motion_text, ": ", reason), false, step);
}

std::string Interpreter::WhyNoDrilling(uint8_t needed) const {
  for (const char letter : {'X', 'Y', 'Z'}) {
    if (AxisOf(letter) < 0 || !is_linear_[AxisOf(letter)]) return "the machine has not the linear axes X, Y and Z";
  }
  const auto groups = static_cast<uint8_t>(kDistanceGroup | kPlaneGroup | kLengthGroup | needed);
  if ((modal_.uncertain & groups) == kLengthGroup)
    return "the tool length is not known: behind a tool change, or a block that was not followed, state it again (D1)";
  if ((modal_.uncertain & groups) != 0) return "the modal state is not known behind a block that was not followed";
  if (modal_.plane_normal != 2) return "in another plane than XY controls differ on the axis that drills";
  if (modal_.is_incremental) return "in G91 controls differ on what its heights count from: program it in G90";
  if ((modal_.tool_point & ~kPlacedFrames) != 0) return "under tool centre point control it is not followed";
  if (options_->orientation) return "with --orientation it is not followed";
  return "";
}

std::string Interpreter::ReadCycleWords(const Block& block, const Request& request, const Word** entry,
                                        int64_t* repeats) const {
  const uint32_t words = modal_.cycle.code->detail;
  if (const std::string problem = WhyNoDrilling(kFeedGroup); !problem.empty()) return problem;
  if (modal_.feed_mode == FeedMode::kInverseTime) return "in G93";
  const bool selects_length = request.length != nullptr || request.length_number != nullptr;
  if (selects_length || request.is_end || request.is_call || request.away != nullptr || request.has_corner ||
      request.is_rapid_block)
    return "with a code that acts otherwise in its block";
  for (const Word& word : block) {
    if (word.letter == 0) return "with a keyword in its block";
    const Role role = RoleOf(word.letter);
    const int axis = AxisOf(word.letter);
    if (axis >= 0 && std::strchr("XYZ", word.letter) == nullptr)
      return absl::StrCat("with a word of ", std::string(1, word.letter), ": move that axis in front of it");
    if (word.distance != Distance::kModal) return "with a word that states its distance";
    if (role == Role::kRadius) {
      if (*entry != nullptr) return "with two R words";
      *entry = &word;
      if (const std::string problem = WordProblem(word); !problem.empty()) return problem;
    }
    const bool is_count =
        (word.letter == 'L' && (words & kCycleRepeatsL) != 0) || (word.letter == 'K' && (words & kCycleRepeatsK) != 0);
    if (is_count) {
      if (word.number.decimals > 0 || word.number.mantissa < 0) return "with a number of repeats that is none";
      *repeats = word.number.mantissa;
    } else if (role == Role::kCentre ? (words & kCycleCentres) == 0
                                     : role == Role::kParameter && word.letter != 'P' && word.letter != 'Q') {
      return absl::StrCat("with a word ", std::string(1, word.letter));
    }
  }
  return "";
}

void Interpreter::Drill(const Block& block, const Request& request, Step* step) {
  const bool is_in_cycle = before_.modal.motion == Meaning::kDrillCycle;
  const int z = AxisOf('Z');
  DrillCycle& cycle = modal_.cycle;
  if (!is_in_cycle) {
    cycle = DrillCycle();
    cycle.is_level_known = z >= 0 && positions_.is_known(z);
    if (cycle.is_level_known) cycle.level = positions_.ticks[z];
  }
  const bool is_new = !is_in_cycle || (request.motion != nullptr && request.motion != cycle.code);
  if (request.motion != nullptr) cycle.code = request.motion;
  if (cycle.code == nullptr) return LoseCycle("no block in front of it that was followed states R and Z", step);
  const Word* entry = nullptr;
  int64_t repeats = 1;
  if (std::string problem = ReadCycleWords(block, request, &entry, &repeats); !problem.empty())
    return LoseCycle(problem, step);
  const bool has_bottom = step->word_of_axis[z] >= 0;
  if (is_new && (entry == nullptr || !has_bottom)) return LoseCycle("its first block must state R and Z", step);
  const bool is_moved = !is_new && (cycle.z_offset != offset(z) || cycle.is_inch != modal_.is_inch);
  if (is_moved && (entry == nullptr || !has_bottom))
    return LoseCycle("the unit, work offset or tool length changed in it: state R and Z again", step);
  if (repeats == 0 && (step->word_of_axis[AxisOf('X')] >= 0 || step->word_of_axis[AxisOf('Y')] >= 0))
    return LoseCycle("with words of X or Y and no repeat controls differ on whether it moves", step);
  const Positions start = positions_;
  if (!ReadTargets(block, step)) {
    modal_.motion = Meaning::kOtherMotion;
    return;
  }
  cycle.z_offset = offset(z), cycle.is_inch = modal_.is_inch;
  if (has_bottom) cycle.bottom = step->end.ticks[z];
  if (entry != nullptr) cycle.entry = *LengthTicks(*entry) + offset(z);
  Positions& end = step->end;
  end.ticks[z] = start.ticks[z];
  end.known = static_cast<uint16_t>((end.known & ~(1u << z)) | (start.known & (1u << z)));
  if (cycle.bottom >= cycle.entry) return LoseCycle("its bottom is not below R", step);
  const bool is_below = cycle.is_level_known && cycle.level < cycle.entry;
  if (is_below) return LoseCycle("R is above where Z stood when the cycle began: controls differ", step);
  if (repeats == 0) {
    step->defines_cycle = true;
    step->end.sense[z] = start.sense[z];
    return;
  }
  step->is_rapid = true;
  if (is_in_table() && !KeepsPlane(step)) {
    modal_.motion = Meaning::kOtherMotion;
    return;
  }
  step->hole = {cycle.entry, cycle.bottom, is_new,      modal_.returns_to_entry, modal_.is_return_unsure,
                false,       false,        std::nullopt};
  constexpr Ticks kNear = kTicksPerMm;  // corrections are smaller
  step->hole.is_level_unsure = cycle.is_level_known && cycle.level - cycle.entry < kNear;
  end.ticks[z] = modal_.returns_to_entry ? cycle.entry : cycle.level;
  const bool is_known = !modal_.is_return_unsure && (modal_.returns_to_entry || cycle.is_level_known);
  end.known = static_cast<uint16_t>(is_known ? end.known | (1u << z) : end.known & ~(1u << z));
  end.sense[z] = 1;
  GoTo(step);
  if (!is_known) ForgetPosition(z, false);
  step->kind = StepKind::kHole;
}

}  // namespace axiscal::nc
