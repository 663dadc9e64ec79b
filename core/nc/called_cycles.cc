// Drilling cycles that are called: CYCLE81 to CYCLE89 of Sinumerik, alone or by MCALL; CYCL DEF 200 and its kin of
// Klartext by CYCL CALL or M99. Their heights are arguments, the same for every hole; Z of CYCL CALL POS shifts them.
#include <algorithm>
#include <cstring>
#include <string_view>

#include "core/nc/char_class.h"
#include "core/nc/plain_number.h"
#include "core/nc/request.h"

namespace axiscal::nc {

bool Interpreter::ReadArguments(const std::string& arguments, const Code* code, DrillCycle* cycle) const {
  *cycle = DrillCycle();
  const int z = AxisOf('Z');
  // Under G70 arguments may be in the machine's unit.
  if (modal_.is_inch) return false;
  if (z < 0 || arguments.size() < 2 || arguments.front() != '(' || arguments.back() != ')') return false;
  std::vector<std::string_view> parts;
  for (std::string_view rest = std::string_view(arguments).substr(1, arguments.size() - 2); parts.size() < 5;) {
    const size_t end = std::min(rest.find(','), rest.size());
    parts.push_back(rest.substr(0, end));
    if (end == rest.size()) break;
    rest.remove_prefix(end + 1);
  }
  if (parts.size() < 4 || std::count(arguments.begin(), arguments.end(), '(') != 1) return false;
  const auto is_empty = [](std::string_view part) { return part.find_first_not_of(' ') == std::string_view::npos; };
  const Ticks unit = ticks_per_unit(z);
  const auto retraction = PlainTicks(parts[0], unit), surface = PlainTicks(parts[1], unit);
  const auto distance = is_empty(parts[2]) ? std::optional<Ticks>(0) : PlainTicks(parts[2], unit);
  if (!retraction || !surface || !distance) return false;
  const bool has_relative = parts.size() > 4 && !is_empty(parts[4]);
  const auto depth = PlainTicks(is_empty(parts[3]) && has_relative ? parts[4] : parts[3], unit);
  if (!depth || (!is_empty(parts[3]) && has_relative && PlainTicks(parts[4], unit) != std::optional<Ticks>(0)))
    return false;
  const Ticks bottom = is_empty(parts[3]) ? *surface - std::abs(*depth) : *depth;
  const Ticks entry = *surface + std::abs(*distance);
  if (bottom >= entry || *retraction < entry) return false;
  *cycle = {code, entry + offset(z), bottom + offset(z), *retraction + offset(z), true, offset(z), modal_.is_inch};
  return true;
}

void Interpreter::ReadDefinition(const char* text, size_t size, Step* step) {
  if (defined_->meaning == Meaning::kSelectDatum) return ReadDatum(text, size, step);
  const int z = AxisOf('Z');
  const char* const end = std::find(text, text + size, ';');
  for (const char* at = std::find(text, end, 'Q'); at != end; at = std::find(at + 1, end, 'Q')) {
    const char* digit = at + 1;
    size_t number = 0;
    for (; digit != end && Class(*digit) == kDigit && number < 1000; ++digit)
      number = 10 * number + static_cast<size_t>(*digit - '0');
    while (digit != end && *digit == ' ') ++digit;
    if (digit == end || *digit != '=' || number < 200 || number >= 200 + definition_.size()) continue;
    const char* last = ++digit;
    while (last != end && *last == ' ') ++last;
    while (last != end && *last != ' ' && *last != '~') ++last;
    definition_[number - 200] =
        PlainTicks({digit, static_cast<size_t>(last - digit)}, z < 0 ? kTicksPerMm : ticks_per_unit(z));
    // "Q203=Q5": it is not known.
    if (!definition_[number - 200]) {
      defined_ = nullptr;
      modal_.called = DrillCycle();
      return;
    }
  }
  const auto &clearance = definition_[0], &depth = definition_[1], &surface = definition_[3], &second = definition_[4];
  if (z < 0 || !clearance || !depth || !surface || *clearance < 0 || *depth >= 0) return;
  const Ticks entry = *surface + *clearance, level = *surface + std::max(*clearance, second.value_or(0));
  modal_.called = {defined_,  entry + offset(z), *surface + *depth + offset(z), level + offset(z), true,
                   offset(z), modal_.is_inch};
}

std::string Interpreter::WhyNoCall() const {
  const DrillCycle& cycle = modal_.called;
  if (cycle.code == nullptr) return "its definition is not followed, or holds more than plain numbers";
  if (std::string problem = WhyNoDrilling(kUnitGroup); !problem.empty()) return problem;
  if (cycle.z_offset != offset(AxisOf('Z')) || cycle.is_inch != modal_.is_inch)
    return "the unit, work offset or tool length changed since its definition";
  return "";
}

void Interpreter::CallCycle(const Request& request, Step* step) {
  const Code* const call = request.cycle_call;
  const std::string name = call != nullptr ? call->text : "modal call of a cycle";
  std::string problem;
  if (call != nullptr && call->detail != kAtPosition && request.cycle_call_word->letter == 0) {
    const Word& word = *request.cycle_call_word;
    const size_t size = std::strlen(dialect_->keywords[static_cast<size_t>(word.keyword)].name);
    const std::string rest = RestOf(text_ + word.letter_at + size, end_of_text_);
    if (call->detail == kByArguments) {
      DrillCycle once;
      if (modal_.calls_at_moves || !ReadArguments(rest, call, &once)) problem = "its arguments are not followed";
      if (problem.empty()) modal_.called = once;
    } else if (!rest.empty() && rest != "M3" && rest != "M4" && rest != "M8" && rest != "M13" && rest != "M14") {
      problem = absl::StrCat("with '", rest, "'");
    }
  }
  if (problem.empty()) problem = WhyNoCall();
  const bool is_move = step->kind == StepKind::kMove;
  if (is_move && (!step->is_rapid || step->is_arc || step->wrapped != 0 || step->is_at_corner || step->moves_away))
    problem = "behind another move than a rapid one";
  if (!problem.empty()) return Unsupported(absl::StrCat(name, ": ", problem), false, step);
  const DrillCycle& cycle = modal_.called;
  const int z = AxisOf('Z');
  for (int i = 0; i < axis_count_ && !is_move; ++i) step->word_of_axis[i] = -1;
  step->kind = StepKind::kHole;
  step->is_rapid = true;
  step->hole = {};
  step->hole.entry = cycle.entry;
  step->hole.bottom = cycle.bottom;
  step->hole.is_fixed = true;
  step->end.ticks[z] = cycle.level;
  step->end.known |= static_cast<uint16_t>(1u << z);
  step->end.sense[z] = 1;
  TakeFrame(step);
  positions_.CopyFrom(step->end, axis_count_);
  if (call != nullptr && call->detail == kByArguments) modal_.called = DrillCycle();
}

void Interpreter::CallCycleAt(const Block& block, const Request& request, Step* step) {
  bool is_consequence = false;
  std::string problem = WhyNoMove(request, &is_consequence);
  if (problem.empty() && (request.motion != nullptr || request.HasVector())) problem = "CYCL CALL POS and another move";
  for (int i = 0; i < axis_count_ && problem.empty(); ++i) {
    const bool is_of_position = machine_->axes[i].name.find_first_not_of("XYZ") == std::string::npos;
    const int word = step->word_of_axis[i];
    const bool is_plain = word >= 0 && block.words[static_cast<size_t>(word)].distance == Distance::kModal;
    if (is_of_position ? !is_plain : word >= 0)
      problem = "CYCL CALL POS without X, Y and Z, or with words of other axes";
  }
  if (!problem.empty()) return Unsupported(std::move(problem), is_consequence, step);
  step->is_rapid = true;
  step->is_at_corner = rounds_corners_ || is_behind_corner_ || request.has_corner;
  is_behind_corner_ = request.has_corner;
  if (!ReadTargets(block, step) || (is_in_table() && !KeepsPlane(step))) return;
  const int z = AxisOf('Z');
  const Ticks to = z < 0 ? 0 : step->end.ticks[z], shift = z < 0 ? 0 : to - offset(z);
  GoTo(step);
  CallCycle(request, step);
  if (step->kind != StepKind::kHole) return;
  step->hole.entry += shift;
  step->hole.bottom += shift;
  step->hole.shifted_to = to;
  step->end.ticks[z] += shift;
  positions_.ticks[z] = step->end.ticks[z];
}

}  // namespace axiscal::nc
