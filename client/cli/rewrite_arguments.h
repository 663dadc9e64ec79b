// The options of `compensate` as they are typed, in um, mm and deg, and what the engine takes.
#ifndef AXISCAL_CLIENT_CLI_REWRITE_ARGUMENTS_H_
#define AXISCAL_CLIENT_CLI_REWRITE_ARGUMENTS_H_

#include <Eigen/Core>
#include <optional>
#include <string>
#include <vector>

#include "core/machine/machine.h"
#include "core/machine/program_profile.h"
#include "core/nc/options.h"
#include "core/nc/stated_options.h"

namespace CLI {
class App;
}

namespace axiscal::cli {

struct RewriteArguments {
  std::string tool_tip;  // "0 0 -350"
  std::string dialect;   // "": the program's words say it (dialect_choice.h)
  std::string on_unsupported = "refuse";
  std::string block_delete;   // "": either
  std::string integer_words;  // "": units
  std::string unit;           // "mm", "inch"; "": the program states it
  std::optional<int> decimals;
  double max_correction_um = 500;
  double tolerance_um = 1;
  double cycle_tolerance_um = 20, cutter_tolerance_um = 20;
  bool orientation = false;
  double max_rotary_correction_deg = 0.05;
  double tolerance_urad = 10;
  std::string start;                      // "X=0 Y=0 B=90"
  std::string tool_change_keeps;          // "B C"
  std::vector<std::string> offsets;       // "G54 X=-490 C=90" or "G54=-490 0 0 0 90"
  std::vector<std::string> tool_lengths;  // "H1=120.5"
  std::vector<std::string> tool_radii;    // "D1=5"
  std::string harmless_m;                 // "47,120-129"
  std::string subprograms;                // a folder
  std::string tool_table;                 // a file
  std::optional<double> time_s, temperature_celsius;
};

// --machine, and --errors or --calibration.
void AddModelOptions(CLI::App& command, std::string& machine, std::string& errors, int64_t& calibration);
// --unit alone, for commands that only read programs.
void AddUnitOption(CLI::App& command, RewriteArguments& arguments);
void AddRewriteOptions(CLI::App& command, RewriteArguments& arguments);
// Those of them that a machine's profile may hold.
void AddProfileOptions(CLI::App& command, RewriteArguments& arguments);

// The profile that the options make; a tool table is read and stands as lengths and radii. Errors of ToStatedOptions.
absl::StatusOr<machine::ProgramProfile> ToProfile(const RewriteArguments& arguments, const machine::Machine& machine);
// The options of a profile as they are typed, a line each.
std::string ProfileText(const machine::ProgramProfile& profile);

// --tool-tip, of a text or of what options and profile state together. INVALID_ARGUMENT naming option and value.
absl::StatusOr<Eigen::Vector3d> ToolTip(const std::string& text);
absl::StatusOr<Eigen::Vector3d> ToolTip(const nc::StatedOptions& stated);
// The files of a folder, in the order of their names; none for "".
absl::StatusOr<std::vector<nc::Subprogram>> ReadSubprograms(const std::string& option, const std::string& folder);
// What the command line says, before the machine's profile (nc::TakeProfile). Errors of nc::ReadStated, of the tool
// table and of the folder of subprograms.
absl::StatusOr<nc::StatedOptions> ToStatedOptions(const RewriteArguments& arguments, const machine::Machine& machine);

}  // namespace axiscal::cli

#endif  // AXISCAL_CLIENT_CLI_REWRITE_ARGUMENTS_H_
