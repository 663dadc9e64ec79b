#include "client/cli/rewrite_arguments.h"

#include <CLI/CLI.hpp>
#include <algorithm>
#include <cstdio>
#include <filesystem>
#include <map>
#include <sstream>

#include "client/cli/tool_table.h"
#include "core/base/files.h"
#include "core/base/units.h"
#include "core/session/text.h"

namespace axiscal::cli {
namespace {

const std::map<std::string, nc::OnUnsupported> kOnUnsupported = {
    {"refuse", nc::OnUnsupported::kRefuse}, {"pass", nc::OnUnsupported::kPass}, {"stop", nc::OnUnsupported::kStop}};
const std::map<std::string, nc::BlockDelete> kBlockDelete = {{"either", nc::BlockDelete::kEither},
                                                             {"executed", nc::BlockDelete::kExecuted},
                                                             {"skipped", nc::BlockDelete::kSkipped}};
const std::map<std::string, nc::IntegerWords> kIntegerWords = {{"units", nc::IntegerWords::kWholeUnits},
                                                               {"increments", nc::IntegerWords::kLeastIncrement}};

const std::map<std::string, nc::ProgramUnit> kUnits = {{"mm", nc::ProgramUnit::kMillimetre},
                                                       {"inch", nc::ProgramUnit::kInch}};

template <typename Value>
std::vector<std::string> NamesOf(const std::map<std::string, Value>& choices) {
  std::vector<std::string> names;
  for (const auto& [name, value] : choices) names.push_back(name);
  return names;
}

absl::Status Twice(const std::string& option, const std::string& what) {
  return absl::InvalidArgumentError(absl::StrCat(option, ": ", what, " stands twice, expected it once"));
}

// "X=12.5": mm of a linear axis, deg of a rotary one.
absl::StatusOr<nc::AxisValue> ParseAxisValue(const std::string& option, const std::string& word,
                                             const machine::Machine& machine) {
  const size_t equals = word.find('=');
  std::vector<double> numbers;
  const int axis = equals == std::string::npos ? -1 : machine::FindAxis(machine, word.substr(0, equals));
  if (axis < 0 || !session::ParseNumbers(word.substr(equals + 1), &numbers) || numbers.size() != 1) {
    return absl::InvalidArgumentError(
        absl::StrCat(option, ": '", word, "', expected an axis of machine ", machine.id, " and its value: X=12.5"));
  }
  const bool rotary = machine.axes[axis].kind == machine::AxisKind::kRotary;
  return nc::AxisValue{machine.axes[axis].name, rotary ? numbers[0] * base::kRadPerDeg : numbers[0]};
}

absl::StatusOr<std::vector<nc::AxisValue>> ParseAxisValues(const std::string& option, std::istream& words,
                                                           const machine::Machine& machine) {
  std::vector<nc::AxisValue> values;
  for (std::string word; words >> word;) {
    ASSIGN_OR_RETURN(nc::AxisValue value, ParseAxisValue(option, word, machine));
    for (const nc::AxisValue& known : values) {
      if (known.axis == value.axis) return Twice(option, value.axis);
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
absl::StatusOr<nc::WorkOffset> ParseOffset(const std::string& text, const machine::Machine& machine) {
  const auto [code, begin] = SplitOffset(text);
  nc::WorkOffset offset;
  offset.code = code;
  if (begin == text.size() || text[begin] == ' ') {
    std::istringstream words(text.substr(begin));
    ASSIGN_OR_RETURN(offset.offsets, ParseAxisValues("--offset", words, machine));
    return offset;
  }
  std::string names;
  std::vector<double> numbers;
  const bool are_numbers = session::ParseNumbers(text.substr(begin + 1), &numbers);
  for (const char letter : std::string("XYZABCUVW")) {
    const int axis = machine::FindAxis(machine, std::string(1, letter));
    if (axis < 0) continue;
    names += letter;
    const bool rotary = machine.axes[axis].kind == machine::AxisKind::kRotary;
    if (names.size() <= numbers.size())
      offset.offsets.push_back({std::string(1, letter), numbers[names.size() - 1] * (rotary ? base::kRadPerDeg : 1.0)});
  }
  if (!are_numbers || numbers.size() != names.size()) {
    return absl::InvalidArgumentError(absl::StrCat("--offset: '", text, "', expected ", names.size(), " numbers (",
                                                   names, ") or axes with values: G54 X=12.5"));
  }
  return offset;
}

// "T5D1": D1 of tool 5.
bool ReadEdge(const std::string& text, int* number) {
  const size_t edge = text.find_first_of("Dd");
  std::vector<double> values;
  if (edge == std::string::npos || edge < 2 || (text[0] != 'T' && text[0] != 't') ||
      !session::ParseNumbers(text.substr(1, edge - 1) + " " + text.substr(edge + 1), &values) || values.size() != 2)
    return false;
  for (const double value : values) {
    if (!(value >= 1 && value < nc::kEdgesOfTool && value == static_cast<int>(value))) return false;
  }
  *number = nc::NumberOfEdge(static_cast<int>(values[0]), static_cast<int>(values[1]));
  return true;
}

// "H1=120.5", "T5D1=120.5": one of the option's letters, or none, in front of the number. False where it is no number
// and no value.
bool ReadNumbered(const std::string& text, const char* letters, int* number_of, double* value_of) {
  const size_t equals = text.find('=');
  const size_t begin = text.find_first_not_of(letters);
  std::vector<double> number, value;
  if (equals != std::string::npos && ReadEdge(text.substr(0, equals), number_of)) {
    if (!session::ParseNumbers(text.substr(equals + 1), &value) || value.size() != 1) return false;
    *value_of = value[0];
    return true;
  }
  if (equals == std::string::npos || begin > 1 || !session::ParseNumbers(text.substr(begin, equals - begin), &number) ||
      !session::ParseNumbers(text.substr(equals + 1), &value) || number.size() != 1 || value.size() != 1 ||
      !(number[0] >= 1 && number[0] <= 9999)) {
    return false;
  }
  *number_of = static_cast<int>(number[0]);
  *value_of = value[0];
  return true;
}

// An offset that is stated in part would lose what the machine's profile knows of its other axes.
absl::Status CheckAxesOfBoth(const std::string& stated, const std::string& kept) {
  const auto [code, begin] = SplitOffset(stated);
  const auto [kept_code, kept_begin] = SplitOffset(kept);
  if (code != kept_code || (begin < stated.size() && stated[begin] == '=')) return absl::OkStatus();
  const auto axes_of = [](const std::string& text, size_t from) {
    std::string axes;
    for (size_t at = text.find('=', from); at != std::string::npos && at > 0; at = text.find('=', at + 1))
      if (const char letter = text[at - 1] & ~0x20; letter >= 'A' && letter <= 'Z') axes += letter;
    return axes;
  };
  const std::string named = axes_of(stated, begin);
  // "G54=1 2 3" states all axes.
  std::string missing = kept[kept_begin] == '=' ? "others" : "";
  for (const char axis : axes_of(kept, kept_begin)) {
    if (named.find(axis) == std::string::npos)
      absl::StrAppend(&missing, missing.empty() ? "" : ", ", std::string(1, axis));
  }
  if (missing.empty()) return absl::OkStatus();
  return absl::InvalidArgumentError(absl::StrCat("--offset: '", stated,
                                                 "' does not state all that the machine's profile "
                                                 "states of ",
                                                 code, " (", missing, "): state all of it"));
}

absl::StatusOr<nc::ToolLength> ParseToolLength(const std::string& text) {
  nc::ToolLength length;
  if (ReadNumbered(text, "HDThdt", &length.number, &length.length_mm)) return length;
  return absl::InvalidArgumentError(
      absl::StrCat("--tool-length: '", text, "', expected a number and a length in mm: H1=120.5, or T5D1=120.5"));
}

absl::StatusOr<nc::ToolRadius> ParseToolRadius(const std::string& text) {
  nc::ToolRadius radius;
  if (ReadNumbered(text, "DTdt", &radius.number, &radius.radius_mm) && radius.radius_mm >= 0) return radius;
  return absl::InvalidArgumentError(
      absl::StrCat("--tool-radius: '", text, "', expected a number and a radius in mm, at least 0: D1=5, or T5D1=5"));
}

// "B C": rotary axes.
absl::StatusOr<std::vector<std::string>> ParseRotaryAxes(const std::string& text, const machine::Machine& machine) {
  std::vector<std::string> axes;
  std::istringstream names(text);
  for (std::string name; names >> name;) {
    const int axis = machine::FindAxis(machine, name);
    if (axis < 0 || machine.axes[axis].kind != machine::AxisKind::kRotary) {
      return absl::InvalidArgumentError(
          absl::StrCat("--tool-change-keeps: '", name, "', expected rotary axes of machine ", machine.id, ": \"B C\""));
    }
    if (std::find(axes.begin(), axes.end(), name) != axes.end()) return Twice("--tool-change-keeps", name);
    axes.push_back(name);
  }
  return axes;
}

// "47,120-129": numbers and ranges.
absl::StatusOr<std::vector<int>> ParseCodes(const std::string& text) {
  std::vector<int> codes;
  std::istringstream parts(text);
  for (std::string part; std::getline(parts, part, ',');) {
    int first = 0, last = 0, read = 0;
    const bool is_range = std::sscanf(part.c_str(), "%4d-%4d%n", &first, &last, &read) == 2;
    if (!is_range && std::sscanf(part.c_str(), "%4d%n", &first, &read) == 1) last = first;
    if (read != static_cast<int>(part.size()) || part.empty() || first < 0 || first > last) {
      return absl::InvalidArgumentError(absl::StrCat("--harmless-m: '", text,
                                                     "', expected numbers of M codes from 0 to ", nc::kMaxHarmlessM,
                                                     " and ranges: 47,120-129"));
    }
    for (int code = first; code <= last; ++code) codes.push_back(code);
  }
  return codes;
}

}  // namespace

void AddModelOptions(CLI::App& command, std::string& machine, std::string& errors, int64_t& calibration) {
  command.add_option("--machine", machine, "a stored machine; with --errors its machine.json")->required();
  CLI::Option* chosen =
      command.add_option("--calibration", calibration, "this calibration instead of the approved one");
  chosen->check(CLI::PositiveNumber);
  command.add_option("--errors", errors, "errors.json in um and urad: needs no database")->excludes(chosen);
}

void AddUnitOption(CLI::App& command, RewriteArguments& arguments) {
  command
      .add_option("--unit", arguments.unit,
                  "of a program that does not state it by G20, G21, G70, G71, MM or INCH: mm or inch")
      ->check(CLI::IsMember(NamesOf(kUnits)));
}

void AddProfileOptions(CLI::App& command, RewriteArguments& arguments) {
  command.add_option("--tool-tip", arguments.tool_tip,
                     "nominal tool point with all axes at zero, machine coordinates: \"X Y Z\" in mm; required where "
                     "the machine's profile does not state it");
  command.add_option("--dialect", arguments.dialect,
                     "of the controller: fanuc, mazak, haas, linuxcnc, sinumerik, heidenhain; without it the program's "
                     "words say it, and you are asked where they do not");
  command
      .add_option(
          "--decimals", arguments.decimals,
          "least number of decimals of corrected words in mm and deg, one more in inch (4); the control's least "
          "increment")
      ->check(CLI::Range(0, 6));
  command
      .add_option("--block-delete", arguments.block_delete,
                  "blocks that begin with /: executed, skipped, or either (not known, the default)")
      ->check(CLI::IsMember(NamesOf(kBlockDelete)));
  command
      .add_option("--integer-words", arguments.integer_words,
                  "X10 means 10 mm (units, the default) or 10 least increments, of --decimals: with 3 it is 0.010 mm")
      ->check(CLI::IsMember(NamesOf(kIntegerWords)));
  AddUnitOption(command, arguments);
  command.add_option("--start", arguments.start, "where axes stand when the program starts, mm and deg: \"X=0 B=90\"");
  command.add_option("--tool-change-keeps", arguments.tool_change_keeps,
                     "rotary axes that the tool changer leaves where they stand: \"B C\"; without it each is unknown "
                     "behind a tool change until the program states it");
  // One value each time: the program's name may follow.
  command
      .add_option(
          "--offset", arguments.offsets,
          "a work offset that the program selects, mm and deg: \"G54 X=-490 C=90\" or, of all axes in the order "
          "XYZABC, \"G54=-490 0 0 0 90\"; may be given again")
      ->allow_extra_args(false);
  command
      .add_option("--tool-length", arguments.tool_lengths,
                  "a tool length that the program selects by number, mm, from the tool point of --tool-tip on: "
                  "H1=120.5, or of Sinumerik T5D1=120.5, D1 of tool 5; may be given again")
      ->allow_extra_args(false);
  command
      .add_option("--tool-radius", arguments.tool_radii,
                  "the radius of a cutter that the program selects by number for cutter compensation, mm, wear "
                  "included: D1=5, or of Sinumerik T5D1=5; may be given again")
      ->allow_extra_args(false);
  command.add_option("--tool-table", arguments.tool_table,
                     "the control's table of tools, for the lengths and radii that --tool-length and --tool-radius do "
                     "not state: of LinuxCNC (T5 P5 D10 Z120.5), Fanuc and Haas (G10 L10 P5 R120.5, L12), Sinumerik "
                     "($TC_DP3[5,1]=120.5, $TC_DP6) or Heidenhain (TOOL.T)");
  command.add_option("--harmless-m", arguments.harmless_m,
                     "M codes of the machine's builder that start no macro and move no axis, beside those of the "
                     "dialect's table (docs/nc.md): 47,120-129");
}

void AddRewriteOptions(CLI::App& command, RewriteArguments& arguments) {
  AddProfileOptions(command, arguments);
  command
      .add_option("--max-correction-um", arguments.max_correction_um, "a larger correction of one axis stops the job")
      ->capture_default_str();
  command
      .add_option("--tolerance-um", arguments.tolerance_um,
                  "a move is split where its correction departs from linear by more")
      ->capture_default_str();
  command
      .add_option("--cycle-tolerance-um", arguments.cycle_tolerance_um,
                  "what may be left at the bottom of a hole of a drilling cycle, which the cycle's words cannot take "
                  "away; more stops the job")
      ->capture_default_str();
  command
      .add_option("--cutter-tolerance-um", arguments.cutter_tolerance_um,
                  "what may be left along a contour under cutter compensation (G41, G42), where errors differ between "
                  "the contour and the cutter's centre; more stops the job")
      ->capture_default_str();
  command.add_flag("--orientation", arguments.orientation,
                   "correct rotary commands too, so that the tool's direction is the programmed one; what the axes "
                   "cannot turn is listed in the report");
  command
      .add_option("--max-rotary-correction-deg", arguments.max_rotary_correction_deg,
                  "with --orientation: no rotary command changes by more; near singular poses the change falls to zero "
                  "instead of swinging the axis round, and the report says what is left")
      ->check(CLI::Range(0.0, nc::kMaxRotaryCorrectionRad * base::kDegPerRad))
      ->capture_default_str();
  command
      .add_option("--tolerance-urad", arguments.tolerance_urad,
                  "with --orientation: a move is also split where the tool's direction departs by more")
      ->capture_default_str();
  command
      .add_option("--on-unsupported", arguments.on_unsupported,
                  "a block that cannot be corrected: refuse the program and list all, stop at the first, or pass the "
                  "block unchanged")
      ->check(CLI::IsMember(NamesOf(kOnUnsupported)))
      ->capture_default_str();
  command.add_option("--subprograms", arguments.subprograms,
                     "a folder with the subprograms that the program calls and does not hold itself");
  command.add_option("--time-s", arguments.time_s,
                     "when the program runs, s of the sessions' clock; needed for errors that drift");
  command.add_option("--temperature-c", arguments.temperature_celsius,
                     "at which temperature; needed for thermal errors");
}

absl::StatusOr<std::string> TakeProfile(const machine::ProgramProfile& profile, RewriteArguments* arguments) {
  std::string taken;
  const auto note = [&taken](const std::string& option) { absl::StrAppend(&taken, taken.empty() ? "" : ", ", option); };
  const auto take = [&](const char* option, const std::string& from, std::string* to) {
    if (!to->empty() || from.empty()) return;
    *to = from;
    note(option);
  };
  // Values that the command line states go before those of the profile with the same name.
  const auto add = [&](const char* option, const std::vector<std::string>& from, const auto& name_of,
                       std::vector<std::string>* to) {
    std::vector<std::string> stated;
    for (const std::string& text : *to) stated.push_back(name_of(text));
    std::string names;
    for (const std::string& text : from) {
      const std::string name = name_of(text);
      if (std::find(stated.begin(), stated.end(), name) != stated.end()) continue;
      to->push_back(text);
      absl::StrAppend(&names, names.empty() ? " " : ", ", name);
    }
    if (!names.empty()) note(option + names);
  };
  take("--tool-tip", profile.tool_tip, &arguments->tool_tip);
  take("--dialect", profile.dialect, &arguments->dialect);
  take("--unit", profile.unit, &arguments->unit);
  // What an integer stands for is the two together.
  const bool states_decimals = arguments->decimals.has_value(), states_integers = !arguments->integer_words.empty();
  const std::string& integers = states_integers ? arguments->integer_words : profile.integer_words;
  if (integers == "increments" && states_decimals != states_integers &&
      !(states_decimals ? profile.integer_words : profile.decimals).empty()) {
    return absl::InvalidArgumentError(absl::StrCat(states_decimals ? "--decimals" : "--integer-words",
                                                   " is stated and ",
                                                   states_decimals ? "--integer-words increments" : "--decimals",
                                                   " is of the machine's profile: with increments "
                                                   "they say together what X100 means, state both"));
  }
  take("--integer-words", profile.integer_words, &arguments->integer_words);
  take("--block-delete", profile.block_delete, &arguments->block_delete);
  take("--harmless-m", profile.harmless_m, &arguments->harmless_m);
  take("--start", profile.start, &arguments->start);
  take("--tool-change-keeps", profile.tool_change_keeps, &arguments->tool_change_keeps);
  if (!arguments->decimals && !profile.decimals.empty()) {
    std::vector<double> numbers;
    if (!session::ParseNumbers(profile.decimals, &numbers) || numbers.size() != 1 || numbers[0] < 0 || numbers[0] > 6 ||
        numbers[0] != static_cast<int>(numbers[0])) {
      return absl::InvalidArgumentError(
          absl::StrCat("programs.decimals: '", profile.decimals, "', expected a whole number from 0 to 6"));
    }
    arguments->decimals = static_cast<int>(numbers[0]);
    note("--decimals");
  }
  const auto known = [](const char* member, const auto& choices, const std::string& value) -> absl::Status {
    const std::vector<std::string> names = NamesOf(choices);
    if (value.empty() || std::find(names.begin(), names.end(), value) != names.end()) return absl::OkStatus();
    std::string list;
    for (const std::string& name : names) absl::StrAppend(&list, list.empty() ? "" : ", ", name);
    return absl::InvalidArgumentError(absl::StrCat("programs.", member, ": '", value, "', expected one of ", list));
  };
  RETURN_IF_ERROR(known("unit", kUnits, arguments->unit));
  RETURN_IF_ERROR(known("integer_words", kIntegerWords, arguments->integer_words));
  RETURN_IF_ERROR(known("block_delete", kBlockDelete, arguments->block_delete));
  for (const std::string& stated : arguments->offsets) {
    for (const std::string& kept : profile.offsets) RETURN_IF_ERROR(CheckAxesOfBoth(stated, kept));
  }
  const auto offset_name = [](const std::string& text) { return SplitOffset(text).first; };
  const auto number_name = [](const std::string& text) {
    const std::string head = text.substr(0, text.find('='));
    if (int edge = 0; ReadEdge(head, &edge)) return nc::ToolNumberText(edge);
    const size_t digits = head.find_first_of("123456789");
    return digits == std::string::npos ? head : head.substr(digits);
  };
  add("--offset", profile.offsets, offset_name, &arguments->offsets);
  if (!arguments->tool_table.empty()) return taken;  // it holds the tools as they are now
  add("--tool-length", profile.tool_lengths, number_name, &arguments->tool_lengths);
  add("--tool-radius", profile.tool_radii, number_name, &arguments->tool_radii);
  return taken;
}

absl::StatusOr<machine::ProgramProfile> ToProfile(const RewriteArguments& arguments, const machine::Machine& machine) {
  if (!arguments.tool_tip.empty()) RETURN_IF_ERROR(ToolTip(arguments).status());
  ASSIGN_OR_RETURN(const nc::RewriteOptions options, ToRewriteOptions(arguments, machine));
  RETURN_IF_ERROR(nc::Validate(options));
  machine::ProgramProfile profile;
  profile.tool_tip = arguments.tool_tip;
  profile.dialect = arguments.dialect;
  profile.unit = arguments.unit;
  profile.integer_words = arguments.integer_words;
  profile.block_delete = arguments.block_delete;
  profile.harmless_m = arguments.harmless_m;
  profile.start = arguments.start;
  profile.tool_change_keeps = arguments.tool_change_keeps;
  if (arguments.decimals) profile.decimals = absl::StrCat(*arguments.decimals);
  profile.offsets = arguments.offsets;
  for (const nc::ToolLength& length : options.tool_lengths)
    profile.tool_lengths.push_back(absl::StrFormat("%s%s=%.10g", length.number < nc::kEdgesOfTool ? "H" : "",
                                                   nc::ToolNumberText(length.number), length.length_mm));
  for (const nc::ToolRadius& radius : options.tool_radii)
    profile.tool_radii.push_back(absl::StrFormat("%s%s=%.10g", radius.number < nc::kEdgesOfTool ? "D" : "",
                                                 nc::ToolNumberText(radius.number), radius.radius_mm));
  return profile;
}

std::string ProfileText(const machine::ProgramProfile& profile) {
  std::string text;
  const auto add = [&text](const char* option, const std::string& value) {
    const bool is_quoted = value.find(' ') != std::string::npos;
    if (!value.empty()) absl::StrAppend(&text, option, " ", is_quoted ? "\"" : "", value, is_quoted ? "\"" : "", "\n");
  };
  add("--tool-tip", profile.tool_tip);
  add("--dialect", profile.dialect);
  add("--unit", profile.unit);
  add("--integer-words", profile.integer_words);
  add("--decimals", profile.decimals);
  add("--block-delete", profile.block_delete);
  add("--harmless-m", profile.harmless_m);
  add("--start", profile.start);
  add("--tool-change-keeps", profile.tool_change_keeps);
  for (const std::string& offset : profile.offsets) add("--offset", offset);
  for (const std::string& length : profile.tool_lengths) add("--tool-length", length);
  for (const std::string& radius : profile.tool_radii) add("--tool-radius", radius);
  return text;
}

absl::StatusOr<Eigen::Vector3d> ToolTip(const RewriteArguments& arguments) {
  std::vector<double> numbers;
  if (arguments.tool_tip.empty()) {
    return absl::InvalidArgumentError(
        "--tool-tip: '', expected the nominal tool point at home, in mm: \"0 0 -350\", here or in the machine's "
        "profile");
  }
  if (!session::ParseNumbers(arguments.tool_tip, &numbers) || numbers.size() != 3) {
    return absl::InvalidArgumentError(
        absl::StrCat("--tool-tip: '", arguments.tool_tip, "', expected three numbers in mm: \"0 0 -350\""));
  }
  return Eigen::Vector3d(numbers[0], numbers[1], numbers[2]);
}

absl::StatusOr<std::vector<nc::Subprogram>> ReadSubprograms(const std::string& option, const std::string& folder) {
  namespace fs = std::filesystem;
  constexpr uintmax_t kMostBytes = uintmax_t{1} << 28;
  std::vector<nc::Subprogram> files;
  if (folder.empty()) return files;
  std::error_code error;
  uintmax_t bytes = 0;
  for (fs::directory_iterator at(folder, error), end; !error && at != end; at.increment(error)) {
    if (!at->is_regular_file(error)) continue;
    bytes += at->file_size(error);
    if (error) break;
    if (bytes > kMostBytes) {
      return absl::InvalidArgumentError(
          absl::StrCat(option, ": the files of '", folder, "' have more than 256 MB: expected subprograms alone"));
    }
    ASSIGN_OR_RETURN(std::string text, base::ReadFile(at->path().string(), kMostBytes));
    files.push_back({at->path().filename().string(), std::move(text)});
  }
  if (error) return absl::NotFoundError(absl::StrCat(option, ": cannot read folder '", folder, "': ", error.message()));
  std::sort(files.begin(), files.end(),
            [](const nc::Subprogram& a, const nc::Subprogram& b) { return a.name < b.name; });
  return files;
}

absl::StatusOr<nc::RewriteOptions> ToRewriteOptions(const RewriteArguments& arguments,
                                                    const machine::Machine& machine) {
  nc::RewriteOptions options;
  if (!arguments.dialect.empty()) options.dialect = arguments.dialect;
  options.on_unsupported = kOnUnsupported.at(arguments.on_unsupported);
  if (!arguments.block_delete.empty()) options.block_delete = kBlockDelete.at(arguments.block_delete);
  if (!arguments.integer_words.empty()) options.integer_words = kIntegerWords.at(arguments.integer_words);
  if (options.integer_words == nc::IntegerWords::kLeastIncrement && !arguments.decimals) {
    return absl::InvalidArgumentError(
        "--integer-words increments: needs --decimals, the least increment: with 3 X10 is 0.010 mm, with 4 0.0010 mm");
  }
  if (!arguments.unit.empty()) options.unit = kUnits.at(arguments.unit);
  if (arguments.decimals) {
    options.decimals_mm = *arguments.decimals;
    options.decimals_inch = std::min(*arguments.decimals + 1, 6);
  }
  options.max_correction_mm = arguments.max_correction_um * base::kMmPerUm;
  options.tolerance_mm = arguments.tolerance_um * base::kMmPerUm;
  options.cycle_tolerance_mm = arguments.cycle_tolerance_um * base::kMmPerUm;
  options.cutter_tolerance_mm = arguments.cutter_tolerance_um * base::kMmPerUm;
  options.orientation = arguments.orientation;
  options.max_rotary_correction_rad = arguments.max_rotary_correction_deg * base::kRadPerDeg;
  options.tolerance_rad = arguments.tolerance_urad * base::kRadPerUrad;
  ASSIGN_OR_RETURN(options.harmless_m, ParseCodes(arguments.harmless_m));
  ASSIGN_OR_RETURN(options.subprograms, ReadSubprograms("--subprograms", arguments.subprograms));
  std::istringstream start(arguments.start);
  ASSIGN_OR_RETURN(options.initial_position, ParseAxisValues("--start", start, machine));
  ASSIGN_OR_RETURN(options.tool_change_keeps, ParseRotaryAxes(arguments.tool_change_keeps, machine));
  for (const std::string& text : arguments.offsets) {
    ASSIGN_OR_RETURN(nc::WorkOffset offset, ParseOffset(text, machine));
    for (const nc::WorkOffset& known : options.work_offsets) {
      if (known.code == offset.code) return Twice("--offset", offset.code);
    }
    options.work_offsets.push_back(std::move(offset));
  }
  for (const std::string& text : arguments.tool_lengths) {
    ASSIGN_OR_RETURN(const nc::ToolLength length, ParseToolLength(text));
    for (const nc::ToolLength& known : options.tool_lengths) {
      if (known.number == length.number) return Twice("--tool-length", "H" + nc::ToolNumberText(length.number));
    }
    options.tool_lengths.push_back(length);
  }
  for (const std::string& text : arguments.tool_radii) {
    ASSIGN_OR_RETURN(const nc::ToolRadius radius, ParseToolRadius(text));
    for (const nc::ToolRadius& known : options.tool_radii) {
      if (known.number == radius.number) return Twice("--tool-radius", "D" + nc::ToolNumberText(radius.number));
    }
    options.tool_radii.push_back(radius);
  }
  if (!arguments.tool_table.empty()) {
    constexpr size_t kMostBytes = size_t{1} << 24;
    ASSIGN_OR_RETURN(const std::string table, base::ReadFile(arguments.tool_table, kMostBytes));
    ASSIGN_OR_RETURN(const ToolTable tools, ParseToolTable(table, arguments.tool_table));
    // A value that is stated for a number goes before the table's, before those of the number by tool, too.
    const auto is_stated = [](const auto& stated, int number) {
      return std::any_of(stated.begin(), stated.end(), [number](const auto& known) {
        return known.number == number || (number >= nc::kEdgesOfTool && known.number == number % nc::kEdgesOfTool);
      });
    };
    const std::vector<nc::ToolRadius> radii = options.tool_radii;
    for (const nc::ToolRadius& radius : tools.radii)
      if (!is_stated(radii, radius.number)) options.tool_radii.push_back(radius);
    const std::vector<nc::ToolLength> lengths = options.tool_lengths;
    for (const nc::ToolLength& length : tools.lengths)
      if (!is_stated(lengths, length.number)) options.tool_lengths.push_back(length);
  }
  return options;
}

}  // namespace axiscal::cli
