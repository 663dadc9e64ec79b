#include "core/nc/stated_options.h"

#include <algorithm>
#include <cstdio>
#include <map>
#include <sstream>

#include "core/session/text.h"

namespace axiscal::nc {
namespace {

using session::ParseNumbers;

constexpr char kIncrements[] = "increments";

const std::map<std::string, BlockDelete> kBlockDelete = {
    {"either", BlockDelete::kEither}, {"executed", BlockDelete::kExecuted}, {"skipped", BlockDelete::kSkipped}};
const std::map<std::string, IntegerWords> kIntegerWords = {{"units", IntegerWords::kWholeUnits},
                                                           {kIncrements, IntegerWords::kLeastIncrement}};
const std::map<std::string, ProgramUnit> kUnits = {{"mm", ProgramUnit::kMillimetre}, {"inch", ProgramUnit::kInch}};

template <typename Value>
std::vector<std::string> NamesOf(const std::map<std::string, Value>& choices) {
  std::vector<std::string> names;
  for (const auto& [name, value] : choices) names.push_back(name);
  return names;
}

// An option and the member of a profile that says the same.
struct Names {
  const char *option, *member;
};
std::string Shown(StatedBy by, const Names& names) {
  return by == StatedBy::kOptions ? names.option : absl::StrCat("programs.", names.member);
}
constexpr Names kToolTip = {"--tool-tip", "tool_tip"}, kDialect = {"--dialect", "dialect"}, kUnit = {"--unit", "unit"},
                kInteger = {"--integer-words", "integer_words"}, kDecimals = {"--decimals", "decimals"},
                kDelete = {"--block-delete", "block_delete"}, kHarmless = {"--harmless-m", "harmless_m"},
                kStart = {"--start", "start"}, kKeeps = {"--tool-change-keeps", "tool_change_keeps"},
                kOffset = {"--offset", "offsets"}, kLength = {"--tool-length", "tool_lengths"},
                kRadius = {"--tool-radius", "tool_radii"};

absl::Status Twice(const std::string& name, const std::string& what) {
  return absl::InvalidArgumentError(absl::StrCat(name, ": ", what, " stands twice, expected it once"));
}

// "X=12.5": mm of a linear axis, deg of a rotary one.
absl::StatusOr<AxisValue> ParseAxisValue(const std::string& name, const std::string& word,
                                         const machine::Machine& machine) {
  const size_t equals = word.find('=');
  std::vector<double> numbers;
  const int axis = equals == std::string::npos ? -1 : machine::FindAxis(machine, word.substr(0, equals));
  if (axis < 0 || !ParseNumbers(word.substr(equals + 1), &numbers) || numbers.size() != 1) {
    return absl::InvalidArgumentError(
        absl::StrCat(name, ": '", word, "', expected an axis of machine ", machine.id, " and its value: X=12.5"));
  }
  const bool rotary = machine.axes[axis].kind == machine::AxisKind::kRotary;
  return AxisValue{machine.axes[axis].name, rotary ? numbers[0] * base::kRadPerDeg : numbers[0]};
}

absl::StatusOr<std::vector<AxisValue>> ParseAxisValues(const std::string& name, std::istream& words,
                                                       const machine::Machine& machine) {
  std::vector<AxisValue> values;
  for (std::string word; words >> word;) {
    ASSIGN_OR_RETURN(AxisValue value, ParseAxisValue(name, word, machine));
    for (const AxisValue& known : values) {
      if (known.axis == value.axis) return Twice(name, value.axis);
    }
    values.push_back(std::move(value));
  }
  return values;
}

// The spelling of a work offset's code by which it is known: "g54  " is "G54", "G54.1P05" and "G54 P5" are "G54.1 P5".
std::string OffsetCode(const std::string& text) {
  std::string code;
  for (const char c : text) {
    const char capital = c >= 'a' && c <= 'z' ? static_cast<char>(c - 'a' + 'A') : c;
    const bool is_blank = capital == ' ' || capital == '\t';
    const bool ends_word =
        !code.empty() && code.back() >= '0' && code.back() <= '9' && capital >= 'A' && capital <= 'Z';
    if ((is_blank || ends_word) && !code.empty() && code.back() != ' ') code += ' ';
    if (!is_blank) code += capital;
  }
  while (!code.empty() && code.back() == ' ') code.pop_back();
  const size_t number = code.find(" P");
  if (number == std::string::npos) return code;
  while (code.size() > number + 3 && code[number + 2] == '0') code.erase(number + 2, 1);
  return code.substr(0, number) == "G54" ? "G54.1" + code.substr(number) : code;
}

// Of "G54 X=1 Y=2", "G54.1 P5 X=1" or "G54=1 2 3": the code, and where its values begin.
std::pair<std::string, size_t> SplitOffset(const std::string& text) {
  const size_t equals = std::min(text.find('='), text.size());
  const size_t blank = text.substr(0, equals).rfind(' ');
  const bool names_axis = blank != std::string::npos && blank + 1 < equals &&
                          std::string("XYZABCUVWxyzabcuvw").find(text[blank + 1]) != std::string::npos &&
                          blank + 2 == equals;
  return {OffsetCode(text.substr(0, names_axis ? blank : equals)), names_axis ? blank : equals};
}

// "G54 X=-490 C=90", "G54.1 P5 X=1", or with all axes "G54=-490 0 0 0 90".
absl::StatusOr<WorkOffset> ParseOffset(const std::string& name, const std::string& text,
                                       const machine::Machine& machine) {
  const auto [code, begin] = SplitOffset(text);
  WorkOffset offset;
  offset.code = code;
  if (begin == text.size() || text[begin] == ' ') {
    std::istringstream words(text.substr(begin));
    ASSIGN_OR_RETURN(offset.offsets, ParseAxisValues(name, words, machine));
    return offset;
  }
  std::string names;
  std::vector<double> numbers;
  const bool are_numbers = ParseNumbers(text.substr(begin + 1), &numbers);
  for (const char letter : std::string("XYZABCUVW")) {
    const int axis = machine::FindAxis(machine, std::string(1, letter));
    if (axis < 0) continue;
    names += letter;
    const bool rotary = machine.axes[axis].kind == machine::AxisKind::kRotary;
    if (names.size() <= numbers.size())
      offset.offsets.push_back({std::string(1, letter), numbers[names.size() - 1] * (rotary ? base::kRadPerDeg : 1.0)});
  }
  if (!are_numbers || numbers.size() != names.size()) {
    return absl::InvalidArgumentError(absl::StrCat(name, ": '", text, "', expected ", names.size(), " numbers (", names,
                                                   ") or axes with values: G54 X=12.5"));
  }
  return offset;
}

// "T5D1": D1 of tool 5.
bool ReadEdge(const std::string& text, int* number) {
  const size_t edge = text.find_first_of("Dd");
  std::vector<double> values;
  if (edge == std::string::npos || edge < 2 || (text[0] != 'T' && text[0] != 't') ||
      !ParseNumbers(text.substr(1, edge - 1) + " " + text.substr(edge + 1), &values) || values.size() != 2)
    return false;
  for (const double value : values) {
    if (!(value >= 1 && value < kEdgesOfTool && value == static_cast<int>(value))) return false;
  }
  *number = NumberOfEdge(static_cast<int>(values[0]), static_cast<int>(values[1]));
  return true;
}

// "H1=120.5", "T5D1=120.5": one of the option's letters, or none, in front of the number. False where it is no number
// and no value.
bool ReadNumbered(const std::string& text, const char* letters, int* number_of, double* value_of) {
  const size_t equals = text.find('=');
  const size_t begin = text.find_first_not_of(letters);
  std::vector<double> number, value;
  if (equals != std::string::npos && ReadEdge(text.substr(0, equals), number_of)) {
    if (!ParseNumbers(text.substr(equals + 1), &value) || value.size() != 1) return false;
    *value_of = value[0];
    return true;
  }
  if (equals == std::string::npos || begin > 1 || !ParseNumbers(text.substr(begin, equals - begin), &number) ||
      !ParseNumbers(text.substr(equals + 1), &value) || number.size() != 1 || value.size() != 1 ||
      !(number[0] >= 1 && number[0] <= 9999)) {
    return false;
  }
  *number_of = static_cast<int>(number[0]);
  *value_of = value[0];
  return true;
}

absl::StatusOr<ToolLength> ParseToolLength(const std::string& name, const std::string& text) {
  ToolLength length;
  if (ReadNumbered(text, "HDThdt", &length.number, &length.length_mm)) return length;
  return absl::InvalidArgumentError(
      absl::StrCat(name, ": '", text, "', expected a number and a length in mm: H1=120.5, or T5D1=120.5"));
}

absl::StatusOr<ToolRadius> ParseToolRadius(const std::string& name, const std::string& text) {
  ToolRadius radius;
  if (ReadNumbered(text, "DTdt", &radius.number, &radius.radius_mm) && radius.radius_mm >= 0) return radius;
  return absl::InvalidArgumentError(
      absl::StrCat(name, ": '", text, "', expected a number and a radius in mm, at least 0: D1=5, or T5D1=5"));
}

// "B C": rotary axes.
absl::StatusOr<std::vector<std::string>> ParseRotaryAxes(const std::string& name, const std::string& text,
                                                         const machine::Machine& machine) {
  std::vector<std::string> axes;
  std::istringstream words(text);
  for (std::string word; words >> word;) {
    const int axis = machine::FindAxis(machine, word);
    if (axis < 0 || machine.axes[axis].kind != machine::AxisKind::kRotary) {
      return absl::InvalidArgumentError(
          absl::StrCat(name, ": '", word, "', expected rotary axes of machine ", machine.id, ": \"B C\""));
    }
    if (std::find(axes.begin(), axes.end(), word) != axes.end()) return Twice(name, word);
    axes.push_back(word);
  }
  return axes;
}

// "47,120-129": numbers and ranges.
absl::StatusOr<std::vector<int>> ParseCodes(const std::string& name, const std::string& text) {
  std::vector<int> codes;
  std::istringstream parts(text);
  for (std::string part; std::getline(parts, part, ',');) {
    int first = 0, last = 0, read = 0;
    const bool is_range = std::sscanf(part.c_str(), "%4d-%4d%n", &first, &last, &read) == 2;
    if (!is_range && std::sscanf(part.c_str(), "%4d%n", &first, &read) == 1) last = first;
    if (read != static_cast<int>(part.size()) || part.empty() || first < 0 || first > last) {
      return absl::InvalidArgumentError(absl::StrCat(name, ": '", text, "', expected numbers of M codes from 0 to ",
                                                     kMaxHarmlessM, " and ranges: 47,120-129"));
    }
    for (int code = first; code <= last; ++code) codes.push_back(code);
  }
  return codes;
}

// The value of a name; an empty text states none.
template <typename Value>
absl::StatusOr<std::optional<Value>> ReadChoice(const std::string& name, const std::map<std::string, Value>& choices,
                                                const std::string& text) {
  if (text.empty()) return std::nullopt;
  if (const auto found = choices.find(text); found != choices.end()) return found->second;
  std::string list;
  for (const auto& [known, value] : choices) absl::StrAppend(&list, list.empty() ? "" : ", ", known);
  return absl::InvalidArgumentError(absl::StrCat(name, ": '", text, "', expected one of ", list));
}

absl::StatusOr<int> ReadDecimals(const std::string& name, const std::string& text) {
  constexpr double kMost = 6;  // of a corrected word (options.cc)
  std::vector<double> numbers;
  if (!ParseNumbers(text, &numbers) || numbers.size() != 1 || !(numbers[0] >= 0 && numbers[0] <= kMost) ||
      numbers[0] != static_cast<int>(numbers[0])) {
    return absl::InvalidArgumentError(absl::StrCat(name, ": '", text, "', expected a whole number from 0 to 6"));
  }
  return static_cast<int>(numbers[0]);
}

// An offset that is stated in part would lose what the machine's profile knows of its other axes.
absl::Status CheckAxesOfBoth(const WorkOffset& stated, const WorkOffset& kept) {
  std::string missing;
  for (const AxisValue& value : kept.offsets) {
    const bool is_named = std::any_of(stated.offsets.begin(), stated.offsets.end(),
                                      [&](const AxisValue& other) { return other.axis == value.axis; });
    if (!is_named) absl::StrAppend(&missing, missing.empty() ? "" : ", ", value.axis);
  }
  if (missing.empty()) return absl::OkStatus();
  return absl::InvalidArgumentError(absl::StrCat("--offset: '", stated.code,
                                                 "' does not state all that the machine's profile states of it (",
                                                 missing, "): state all of it"));
}

// Entries whose name nobody has stated; their names, for the note.
template <typename Entry, typename NameOf>
std::string AddOpen(const std::vector<Entry>& from, const NameOf& name_of, std::vector<Entry>* to) {
  const size_t stated = to->size();
  std::string names;
  for (const Entry& entry : from) {
    const std::string name = name_of(entry);
    const bool is_stated = std::any_of(to->begin(), to->begin() + static_cast<std::ptrdiff_t>(stated),
                                       [&](const Entry& known) { return name_of(known) == name; });
    if (is_stated) continue;
    to->push_back(entry);
    absl::StrAppend(&names, names.empty() ? " " : ", ", name);
  }
  return names;
}

// What an integer stands for is said by two options together.
absl::Status CheckIncrements(const StatedOptions& profile, const StatedOptions& stated) {
  const bool states_decimals = !stated.open.decimals, states_integers = !stated.open.integer_words;
  const IntegerWords integers = (states_integers ? stated : profile).options.integer_words;
  if (integers != IntegerWords::kLeastIncrement) return absl::OkStatus();
  if (states_decimals != states_integers && !(states_decimals ? profile.open.integer_words : profile.open.decimals)) {
    return absl::InvalidArgumentError(
        absl::StrCat(states_decimals ? "--decimals" : "--integer-words", " is stated and ",
                     states_decimals ? "--integer-words increments" : "--decimals",
                     " is of the machine's profile: with increments they say together what X100 means, state both"));
  }
  if (states_decimals || !profile.open.decimals) return absl::OkStatus();
  return absl::InvalidArgumentError(
      "--integer-words increments: needs --decimals, the least increment: with 3 X10 is 0.010 mm, with 4 0.0010 mm");
}

}  // namespace

std::vector<std::string> ProgramUnitNames() { return NamesOf(kUnits); }
std::vector<std::string> IntegerWordsNames() { return NamesOf(kIntegerWords); }
std::vector<std::string> BlockDeleteNames() { return NamesOf(kBlockDelete); }

absl::StatusOr<Eigen::Vector3d> ReadToolTip(const std::string& text, const std::string& name) {
  std::vector<double> numbers;
  if (!ParseNumbers(text, &numbers) || numbers.size() != 3) {
    return absl::InvalidArgumentError(absl::StrCat(name, ": '", text, "', expected three numbers in mm: \"0 0 -350\""));
  }
  return Eigen::Vector3d(numbers[0], numbers[1], numbers[2]);
}

absl::StatusOr<StatedOptions> ReadStated(const machine::ProgramProfile& words, StatedBy by,
                                         const machine::Machine& machine) {
  StatedOptions stated;
  RewriteOptions& options = stated.options;
  stated.open.tool_tip = words.tool_tip.empty();
  if (!words.tool_tip.empty()) {
    ASSIGN_OR_RETURN(stated.tool_tip_mm, ReadToolTip(words.tool_tip, Shown(by, kToolTip)));
  }
  stated.open.dialect = words.dialect.empty();
  if (!words.dialect.empty()) options.dialect = words.dialect;
  ASSIGN_OR_RETURN(const auto unit, ReadChoice(Shown(by, kUnit), kUnits, words.unit));
  options.unit = unit.value_or(options.unit);
  ASSIGN_OR_RETURN(const auto integers, ReadChoice(Shown(by, kInteger), kIntegerWords, words.integer_words));
  options.integer_words = integers.value_or(options.integer_words);
  stated.open.integer_words = !integers.has_value();
  ASSIGN_OR_RETURN(const auto skips, ReadChoice(Shown(by, kDelete), kBlockDelete, words.block_delete));
  options.block_delete = skips.value_or(options.block_delete);
  stated.open.block_delete = !skips.has_value();
  stated.open.decimals = words.decimals.empty();
  if (!words.decimals.empty()) {
    constexpr int kMost = 6;
    ASSIGN_OR_RETURN(options.decimals_mm, ReadDecimals(Shown(by, kDecimals), words.decimals));
    options.decimals_inch = std::min(options.decimals_mm + 1, kMost);
  }
  ASSIGN_OR_RETURN(options.harmless_m, ParseCodes(Shown(by, kHarmless), words.harmless_m));
  std::istringstream start(words.start);
  ASSIGN_OR_RETURN(options.initial_position, ParseAxisValues(Shown(by, kStart), start, machine));
  ASSIGN_OR_RETURN(options.tool_change_keeps, ParseRotaryAxes(Shown(by, kKeeps), words.tool_change_keeps, machine));
  for (const std::string& text : words.offsets) {
    ASSIGN_OR_RETURN(WorkOffset offset, ParseOffset(Shown(by, kOffset), text, machine));
    for (const WorkOffset& known : options.work_offsets) {
      if (known.code == offset.code) return Twice(Shown(by, kOffset), offset.code);
    }
    options.work_offsets.push_back(std::move(offset));
  }
  for (const std::string& text : words.tool_lengths) {
    ASSIGN_OR_RETURN(const ToolLength length, ParseToolLength(Shown(by, kLength), text));
    for (const ToolLength& known : options.tool_lengths) {
      if (known.number == length.number) return Twice(Shown(by, kLength), "H" + ToolNumberText(length.number));
    }
    options.tool_lengths.push_back(length);
  }
  for (const std::string& text : words.tool_radii) {
    ASSIGN_OR_RETURN(const ToolRadius radius, ParseToolRadius(Shown(by, kRadius), text));
    for (const ToolRadius& known : options.tool_radii) {
      if (known.number == radius.number) return Twice(Shown(by, kRadius), "D" + ToolNumberText(radius.number));
    }
    options.tool_radii.push_back(radius);
  }
  return stated;
}

absl::StatusOr<std::string> TakeProfile(const machine::ProgramProfile& words, const machine::Machine& machine,
                                        StatedOptions* stated) {
  ASSIGN_OR_RETURN(const StatedOptions profile, ReadStated(words, StatedBy::kProfile, machine));
  RETURN_IF_ERROR(CheckIncrements(profile, *stated));
  const RewriteOptions& from = profile.options;
  RewriteOptions& to = stated->options;
  for (const WorkOffset& offset : to.work_offsets) {
    for (const WorkOffset& kept : from.work_offsets) {
      if (offset.code == kept.code) RETURN_IF_ERROR(CheckAxesOfBoth(offset, kept));
    }
  }
  std::string taken;
  const auto note = [&taken](const std::string& option) { absl::StrAppend(&taken, taken.empty() ? "" : ", ", option); };
  const auto takes = [&](const Names& names, bool is_open_here, bool* is_open) {
    if (!*is_open || is_open_here) return false;
    *is_open = false;
    note(names.option);
    return true;
  };
  const auto take_list = [&](const Names& names, const auto& list, auto* into) {
    if (!into->empty() || list.empty()) return;
    *into = list;
    note(names.option);
  };
  OpenOptions& open = stated->open;
  if (takes(kToolTip, profile.open.tool_tip, &open.tool_tip)) stated->tool_tip_mm = profile.tool_tip_mm;
  if (takes(kDialect, profile.open.dialect, &open.dialect)) to.dialect = from.dialect;
  if (to.unit == ProgramUnit::kUnstated && from.unit != ProgramUnit::kUnstated) {
    to.unit = from.unit;
    note(kUnit.option);
  }
  if (takes(kInteger, profile.open.integer_words, &open.integer_words)) to.integer_words = from.integer_words;
  if (takes(kDecimals, profile.open.decimals, &open.decimals)) {
    to.decimals_mm = from.decimals_mm;
    to.decimals_inch = from.decimals_inch;
  }
  if (takes(kDelete, profile.open.block_delete, &open.block_delete)) to.block_delete = from.block_delete;
  take_list(kHarmless, from.harmless_m, &to.harmless_m);
  take_list(kStart, from.initial_position, &to.initial_position);
  take_list(kKeeps, from.tool_change_keeps, &to.tool_change_keeps);
  const auto add = [&](const Names& names, const std::string& added) {
    if (!added.empty()) note(names.option + added);
  };
  add(kOffset, AddOpen(
                   from.work_offsets, [](const WorkOffset& offset) { return offset.code; }, &to.work_offsets));
  if (!open.tools) return taken;
  const auto number = [](const auto& tool) { return ToolNumberText(tool.number); };
  add(kLength, AddOpen(from.tool_lengths, number, &to.tool_lengths));
  add(kRadius, AddOpen(from.tool_radii, number, &to.tool_radii));
  return taken;
}

}  // namespace axiscal::nc
