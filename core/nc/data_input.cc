// Work offsets whose values or number the program itself states: G10 L2 and L20, CYCL DEF 247. Fanuc B-64484EN,
// "Changing workpiece coordinate system"; Haas Mill Operator's Manual 96-8200, "G10"; LinuxCNC 2.9, "G10 L2"; TNC 640,
// User's Manual for Cycle Programming, "Datum setting (cycle 247)".
#include <algorithm>

#include "core/nc/char_class.h"
#include "core/nc/request.h"

namespace axiscal::nc {
namespace {

constexpr int kLeastHaasNumbered = 110, kHaasNumbered = 20;  // G110 to G129 are G154 P1 to P20

bool IsInteger(const Decimal& number) { return number.decimals == 0 && number.mantissa >= 0; }

}  // namespace

absl::StatusOr<std::vector<std::string>> Interpreter::OffsetsOfInput(const Block& block) const {
  const auto refuse = [](const std::string& reason) { return absl::InvalidArgumentError(reason); };
  int64_t kind = -1, number = -1;
  for (const Word& word : block) {
    const Role role = RoleOf(word.letter);
    if (role == Role::kLineNumber || role == Role::kAxis) continue;
    const bool is_code =
        word.letter == 'G' && (Find(word).meaning == Meaning::kDataInput || Find(word).meaning == Meaning::kAbsolute);
    int64_t* const chosen = word.letter == 'L' ? &kind : word.letter == 'P' ? &number : nullptr;
    const bool is_choice = chosen != nullptr && *chosen < 0 && IsInteger(word.number);
    if (!is_code && !is_choice)
      return refuse(absl::StrCat("with the word ", WordText(word), ", which is not followed"));
    if (is_choice) *chosen = word.number.mantissa;
  }
  if (kind == 2 && number >= 1 && number <= dialect_->plain_offsets)
    return std::vector<std::string>{number <= 6 ? absl::StrCat("G", 53 + number) : absl::StrCat("G59.", number - 6)};
  if (kind == 20 && number >= 1 && number <= dialect_->additional_offsets) {
    std::vector<std::string> codes = {absl::StrCat(dialect_->numbered_offset, " P", number)};
    if (dialect_->g_codes[10 * kLeastHaasNumbered].meaning == Meaning::kWorkOffset && number <= kHaasNumbered)
      codes.push_back(absl::StrCat("G", kLeastHaasNumbered - 1 + number));
    return codes;
  }
  if (kind == 20 && dialect_->additional_offsets == 0)
    return refuse("L20 counts from where the control stands, which is a corrected position: state the values by L2");
  return refuse(absl::StrCat(
      "followed is L2 with P1 to P", dialect_->plain_offsets,
      dialect_->additional_offsets == 0 ? "" : absl::StrCat(" and L20 with P1 to P", dialect_->additional_offsets)));
}

std::string Interpreter::InputData(const Block& block, const Request& request, const Step& step) {
  if (!request.is_whole || !request.problem.empty()) return "its block is not read whole";
  if (block_may_be_skipped_) return "in a block that may be skipped: state --block-delete";
  if (modal_.is_incremental || (modal_.uncertain & (kDistanceGroup | kOffsetGroup)) != 0)
    return "in G91, or where that is not known, controls differ on what it does: program it in G90";
  if (modal_.tool_point != 0) return "under tool centre point control it is not followed";
  if (modal_.blockers != 0) return BlockerText(modal_.blockers);
  if (modal_.motion == Meaning::kDrillCycle) return "in a drilling cycle: end it in front by G80";
  if (coordinates_.has_preset() || coordinates_.has_shift())
    return "with preset or shifted coordinates (G92, G52) in force it is not followed";
  const absl::StatusOr<std::vector<std::string>> codes = OffsetsOfInput(block);
  if (!codes.ok()) return std::string(codes.status().message());
  if (!request.has_axis || request.foreign_axis != 0) return "it names no axis of the machine, or one that it has not";
  if (std::string problem = UnitProblem(); !problem.empty()) return problem;
  uint16_t axes = 0;
  AxisTicks ticks{};
  for (int i = 0; i < axis_count_; ++i) {
    if (step.word_of_axis[i] < 0) continue;
    const Word& word = block.words[static_cast<size_t>(step.word_of_axis[i])];
    if (word.distance != Distance::kModal) return "with a word that states its distance";
    if (std::string problem = WordProblem(word); !problem.empty()) return problem;
    ticks[i] = *ToTicks(Meant(word.number, ticks_per_unit(i)), ticks_per_unit(i));
    axes |= static_cast<uint16_t>(1u << i);
  }
  // Of two names of one offset the one that is not stated needs no values, unless this block states all.
  const bool is_known = std::any_of(codes->begin(), codes->end(),
                                    [this](const std::string& code) { return coordinates_.IsStated(code); });
  const AxisTicks before = coordinates_.offsets();
  bool is_taken = false;
  for (const std::string& code : *codes) is_taken |= coordinates_.Restate(code, axes, ticks);
  if (!is_taken && !is_known) {
    return absl::StrCat("it sets some axes of ", codes->front(), ", and the others are not stated: state it with ",
                        "--offset \"", codes->front(), " X=... \"");
  }
  for (int i = 0; i < axis_count_; ++i) {
    if (coordinates_.Offset(i) != before[i]) needs_absolute_ |= static_cast<uint16_t>(1u << i);
  }
  return "";
}

void Interpreter::ReadDatum(const char* text, size_t size, Step* step) {
  const char* const end = std::find(text, text + size, ';');
  static constexpr char kNumber[] = {'Q', '3', '3', '9'};
  const auto same = [](char a, char b) { return Capital(a) == b; };
  const char* at = std::search(text, end, kNumber, kNumber + sizeof(kNumber), same);
  if (at == end && is_continued_) return;
  const std::string name = absl::StrCat("CYCL DEF 247 (", defined_->text, ")");
  defined_ = nullptr;
  pole_.is_known = false;
  const auto refuse = [&](const std::string& reason) {
    modal_.blockers |= kUnstatedOffset;
    Unsupported(absl::StrCat(name, ": ", reason), false, step);
  };
  if (step->kind != StepKind::kNone) return;
  const auto skip_blanks = [&] {
    while (at != end && Class(*at) == kBlank) ++at;
  };
  at += at == end ? 0 : sizeof(kNumber);
  skip_blanks();
  if (at == end || *at != '=') return refuse("its lines state no number by Q339");
  ++at;
  skip_blanks();
  if (at != end && *at == '+') ++at;
  int64_t number = 0;
  const char* const digits = at;
  for (; at != end && Class(*at) == kDigit && number < 100'000; ++at) number = 10 * number + (*at - '0');
  const bool is_number = at != digits && (at == end || Class(*at) == kBlank || *at == '~' || *at == '\r');
  if (!is_number) return refuse("Q339 is no plain number");
  if (modal_.tool_point != 0) return refuse("under tool centre point control it is not followed");
  if (coordinates_.has_frame()) return refuse("with a datum shift (cycle 7) in force: end it in front");
  const std::string code = absl::StrCat("PRESET ", number);
  modal_.uncertain &= static_cast<uint8_t>(~kOffsetGroup);
  if (!coordinates_.Select(code))
    return refuse(absl::StrCat(code, " is not stated: state it with --offset \"", code, " X=...\""));
  EndMode(kUnstatedOffset);
}

}  // namespace axiscal::nc
