// How programs are to be read and rewritten, as somebody states it in words: whoever asks, by the options of `axiscal
// compensate`, and a machine's profile (core/machine/program_profile.h), which says what the former left open.
#ifndef AXISCAL_CORE_NC_STATED_OPTIONS_H_
#define AXISCAL_CORE_NC_STATED_OPTIONS_H_

#include <Eigen/Core>
#include <string>

#include "core/base/status.h"
#include "core/machine/machine.h"
#include "core/machine/program_profile.h"
#include "core/nc/options.h"

namespace axiscal::nc {

// Which of the options nobody has stated yet. Lists and the unit are open where they are empty, beside these.
struct OpenOptions {
  bool tool_tip = false, dialect = false, integer_words = false, decimals = false, block_delete = false;
  bool tools = true;  // more lengths and radii than those that are there; false: they are of a whole tool table
};

struct StatedOptions {
  RewriteOptions options;                                 // what is open has its default
  Eigen::Vector3d tool_tip_mm = Eigen::Vector3d::Zero();  // nominal tool point at home, machine frame
  OpenOptions open;
};

// Who states the words, for the texts of errors: "--offset", "programs.offsets".
enum class StatedBy { kOptions, kProfile };

// Words of the profile's form (docs/formats.md, `programs`), lengths in mm and angles in deg. Work offsets get the code
// by which they are known ("g54.1P05": "G54.1 P5"). INVALID_ARGUMENT that names the option or member, its value and
// what was expected; an axis that the machine lacks, a code or number that stands twice.
absl::StatusOr<StatedOptions> ReadStated(const machine::ProgramProfile& words, StatedBy by,
                                         const machine::Machine& machine);

// "0 0 -350": three numbers in mm. INVALID_ARGUMENT that begins with `name`.
absl::StatusOr<Eigen::Vector3d> ReadToolTip(const std::string& text, const std::string& name);

// What is open in `stated` and the profile says; offsets by code, tools by number. Says what it took, in the names of
// the options ("--tool-tip, --offset G54"); "": nothing. INVALID_ARGUMENT: errors of ReadStated; an offset that states
// less of its axes than the profile; least increments without decimals, or one of both stated beside the other of the
// profile (together they say what X100 means).
absl::StatusOr<std::string> TakeProfile(const machine::ProgramProfile& profile, const machine::Machine& machine,
                                        StatedOptions* stated);

// The names that words may have, in the order of the alphabet.
std::vector<std::string> ProgramUnitNames();
std::vector<std::string> IntegerWordsNames();
std::vector<std::string> BlockDeleteNames();

}  // namespace axiscal::nc

#endif  // AXISCAL_CORE_NC_STATED_OPTIONS_H_
