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

// "G54 X=-490 C=90", "G54.1 P5 X=1", or with all axes "G54=-490 0 0 0 90".
absl::StatusOr<nc::WorkOffset> ParseOffset(const std::string& text, const machine::Machine& machine) {
  const std::string head = text.substr(0, text.find('='));
  const size_t blank = head.rfind(' ');
  nc::WorkOffset offset;
  const bool names_axes = blank != std::string::npos && machine::FindAxis(machine, head.substr(blank + 1)) >= 0;
  if (names_axes || head.size() == text.size()) {
    offset.code = names_axes ? head.substr(0, blank) : text;
    std::istringstream words(names_axes ? text.substr(blank) : "");
    ASSIGN_OR_RETURN(offset.offsets, ParseAxisValues("--offset", words, machine));
    return offset;
  }
  offset.code = head;
  std::string names;
  std::vector<double> numbers;
  const bool are_numbers = session::ParseNumbers(text.substr(head.size() + 1), &numbers);
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

// "H1=120.5"; the letter may be H, D, T or nothing.
absl::StatusOr<nc::ToolLength> ParseToolLength(const std::string& text) {
  const size_t equals = text.find('=');
  const size_t begin = text.find_first_not_of("HDThdt");
  std::vector<double> number, length;
  if (equals == std::string::npos || begin > 1 || !session::ParseNumbers(text.substr(begin, equals - begin), &number) ||
      !session::ParseNumbers(text.substr(equals + 1), &length) || number.size() != 1 || length.size() != 1 ||
      !(number[0] >= 1 && number[0] <= 9999)) {
    return absl::InvalidArgumentError(
        absl::StrCat("--tool-length: '", text, "', expected a number and a length in mm: H1=120.5"));
  }
  return nc::ToolLength{static_cast<int>(number[0]), length[0]};
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

void AddRewriteOptions(CLI::App& command, RewriteArguments& arguments) {
  command
      .add_option("--tool-tip", arguments.tool_tip,
                  "nominal tool point with all axes at zero, machine coordinates: \"X Y Z\" in mm")
      ->required();
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
  command.add_option("--dialect", arguments.dialect, "of the controller")->capture_default_str();
  command
      .add_option(
          "--decimals", arguments.decimals,
          "least number of decimals of corrected words in mm and deg, one more in inch (4); the control's least "
          "increment")
      ->check(CLI::Range(0, 6));
  command
      .add_option("--block-delete", arguments.block_delete,
                  "blocks that begin with /: executed, skipped, or either (not known)")
      ->check(CLI::IsMember(NamesOf(kBlockDelete)))
      ->capture_default_str();
  command
      .add_option("--integer-words", arguments.integer_words,
                  "X10 means 10 mm (units) or 10 least increments, of --decimals: with 3 it is 0.010 mm")
      ->check(CLI::IsMember(NamesOf(kIntegerWords)))
      ->capture_default_str();
  AddUnitOption(command, arguments);
  command.add_option("--start", arguments.start, "where axes stand when the program starts, mm and deg: \"X=0 B=90\"");
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
                  "H1=120.5; may be given again")
      ->allow_extra_args(false);
  command.add_option("--tool-table", arguments.tool_table,
                     "the control's table of tools, for the lengths that --tool-length does not state: of LinuxCNC "
                     "(T5 P5 Z120.5), Fanuc and Haas (G10 L10 P5 R120.5), Sinumerik ($TC_DP3[5,1]=120.5) or "
                     "Heidenhain (TOOL.T)");
  command.add_option("--harmless-m", arguments.harmless_m,
                     "M codes of the machine's builder that start no macro and move no axis, beside those of the "
                     "dialect's table (docs/nc.md): 47,120-129");
  command.add_option("--subprograms", arguments.subprograms,
                     "a folder with the subprograms that the program calls and does not hold itself");
  command.add_option("--time-s", arguments.time_s,
                     "when the program runs, s of the sessions' clock; needed for errors that drift");
  command.add_option("--temperature-c", arguments.temperature_celsius,
                     "at which temperature; needed for thermal errors");
}

absl::StatusOr<Eigen::Vector3d> ToolTip(const RewriteArguments& arguments) {
  std::vector<double> numbers;
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
  options.dialect = arguments.dialect;
  options.on_unsupported = kOnUnsupported.at(arguments.on_unsupported);
  options.block_delete = kBlockDelete.at(arguments.block_delete);
  options.integer_words = kIntegerWords.at(arguments.integer_words);
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
  options.orientation = arguments.orientation;
  options.max_rotary_correction_rad = arguments.max_rotary_correction_deg * base::kRadPerDeg;
  options.tolerance_rad = arguments.tolerance_urad * base::kRadPerUrad;
  ASSIGN_OR_RETURN(options.harmless_m, ParseCodes(arguments.harmless_m));
  ASSIGN_OR_RETURN(options.subprograms, ReadSubprograms("--subprograms", arguments.subprograms));
  std::istringstream start(arguments.start);
  ASSIGN_OR_RETURN(options.initial_position, ParseAxisValues("--start", start, machine));
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
      if (known.number == length.number) return Twice("--tool-length", absl::StrCat("H", length.number));
    }
    options.tool_lengths.push_back(length);
  }
  if (!arguments.tool_table.empty()) {
    constexpr size_t kMostBytes = size_t{1} << 24;
    ASSIGN_OR_RETURN(const std::string table, base::ReadFile(arguments.tool_table, kMostBytes));
    ASSIGN_OR_RETURN(const std::vector<nc::ToolLength> lengths, ParseToolTable(table, arguments.tool_table));
    for (const nc::ToolLength& length : lengths) {
      const bool is_stated = std::any_of(options.tool_lengths.begin(), options.tool_lengths.end(),
                                         [&](const nc::ToolLength& known) { return known.number == length.number; });
      if (!is_stated) options.tool_lengths.push_back(length);
    }
  }
  return options;
}

}  // namespace axiscal::cli
