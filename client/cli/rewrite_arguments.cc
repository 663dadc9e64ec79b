#include "client/cli/rewrite_arguments.h"

#include <CLI/CLI.hpp>
#include <algorithm>
#include <filesystem>
#include <map>

#include "client/cli/positive_number.h"
#include "client/cli/tool_table.h"
#include "core/base/files.h"
#include "core/base/units.h"

namespace axiscal::cli {
namespace {

const std::map<std::string, nc::OnUnsupported> kOnUnsupported = {
    {"refuse", nc::OnUnsupported::kRefuse}, {"pass", nc::OnUnsupported::kPass}, {"stop", nc::OnUnsupported::kStop}};

template <typename Value>
std::vector<std::string> NamesOf(const std::map<std::string, Value>& choices) {
  std::vector<std::string> names;
  for (const auto& [name, value] : choices) names.push_back(name);
  return names;
}

// What the options say, in the words of a profile.
machine::ProgramProfile WordsOf(const RewriteArguments& arguments) {
  machine::ProgramProfile words;
  words.tool_tip = arguments.tool_tip;
  words.dialect = arguments.dialect;
  words.unit = arguments.unit;
  words.integer_words = arguments.integer_words;
  words.block_delete = arguments.block_delete;
  words.harmless_m = arguments.harmless_m;
  words.start = arguments.start;
  words.tool_change_keeps = arguments.tool_change_keeps;
  if (arguments.decimals) words.decimals = absl::StrCat(*arguments.decimals);
  words.offsets = arguments.offsets;
  words.tool_lengths = arguments.tool_lengths;
  words.tool_radii = arguments.tool_radii;
  return words;
}

}  // namespace

void AddModelOptions(CLI::App& command, std::string& machine, std::string& errors, int64_t& calibration) {
  command.add_option("--machine", machine, "a stored machine; with --errors its machine.json")->required();
  CLI::Option* chosen =
      command.add_option("--calibration", calibration, "this calibration instead of the approved one");
  chosen->check(PositiveNumber());
  command.add_option("--errors", errors, "errors.json in um and urad: needs no database")->excludes(chosen);
}

void AddUnitOption(CLI::App& command, RewriteArguments& arguments) {
  command
      .add_option("--unit", arguments.unit,
                  "of a program that does not state it by G20, G21, G70, G71, MM or INCH: mm or inch")
      ->check(CLI::IsMember(nc::ProgramUnitNames()));
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
      ->check(CLI::IsMember(nc::BlockDeleteNames()));
  command
      .add_option("--integer-words", arguments.integer_words,
                  "X10 means 10 mm (units, the default) or 10 least increments, of --decimals: with 3 it is 0.010 mm")
      ->check(CLI::IsMember(nc::IntegerWordsNames()));
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

absl::StatusOr<machine::ProgramProfile> ToProfile(const RewriteArguments& arguments, const machine::Machine& machine) {
  ASSIGN_OR_RETURN(nc::StatedOptions stated, ToStatedOptions(arguments, machine));
  RETURN_IF_ERROR(nc::TakeProfile({}, machine, &stated).status());
  const nc::RewriteOptions& options = stated.options;
  RETURN_IF_ERROR(nc::Validate(options));
  machine::ProgramProfile profile = WordsOf(arguments);
  profile.tool_lengths.clear();
  profile.tool_radii.clear();
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

absl::StatusOr<Eigen::Vector3d> ToolTip(const std::string& text) {
  if (!text.empty()) return nc::ReadToolTip(text, "--tool-tip");
  return absl::InvalidArgumentError(
      "--tool-tip: '', expected the nominal tool point at home, in mm: \"0 0 -350\", here or in the machine's "
      "profile");
}

absl::StatusOr<Eigen::Vector3d> ToolTip(const nc::StatedOptions& stated) {
  if (stated.open.tool_tip) return ToolTip("");
  return stated.tool_tip_mm;
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

absl::StatusOr<nc::StatedOptions> ToStatedOptions(const RewriteArguments& arguments, const machine::Machine& machine) {
  ASSIGN_OR_RETURN(nc::StatedOptions stated, nc::ReadStated(WordsOf(arguments), nc::StatedBy::kOptions, machine));
  nc::RewriteOptions& options = stated.options;
  options.on_unsupported = kOnUnsupported.at(arguments.on_unsupported);
  options.max_correction_mm = arguments.max_correction_um * base::kMmPerUm;
  options.tolerance_mm = arguments.tolerance_um * base::kMmPerUm;
  options.cycle_tolerance_mm = arguments.cycle_tolerance_um * base::kMmPerUm;
  options.cutter_tolerance_mm = arguments.cutter_tolerance_um * base::kMmPerUm;
  options.orientation = arguments.orientation;
  options.max_rotary_correction_rad = arguments.max_rotary_correction_deg * base::kRadPerDeg;
  options.tolerance_rad = arguments.tolerance_urad * base::kRadPerUrad;
  ASSIGN_OR_RETURN(options.subprograms, ReadSubprograms("--subprograms", arguments.subprograms));
  if (!arguments.tool_table.empty()) {
    stated.open.tools = false;  // it holds the tools as they are now
    constexpr size_t kMostBytes = size_t{1} << 24;
    ASSIGN_OR_RETURN(const std::string table, base::ReadFile(arguments.tool_table, kMostBytes));
    ASSIGN_OR_RETURN(const ToolTable tools, ParseToolTable(table, arguments.tool_table));
    // A value that is stated for a number goes before the table's, before those of the number by tool, too.
    const auto is_stated = [](const auto& list, int number) {
      return std::any_of(list.begin(), list.end(), [number](const auto& known) {
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
  return stated;
}

}  // namespace axiscal::cli
