// What a shop states once for the NC programs of a machine: the member `programs` of machine.json, in the words of the
// options of `axiscal compensate`. What they mean: core/nc/stated_options.h.
#ifndef AXISCAL_CORE_MACHINE_PROGRAM_PROFILE_H_
#define AXISCAL_CORE_MACHINE_PROGRAM_PROFILE_H_

#include <string>
#include <vector>

#include "core/base/status.h"

namespace axiscal::machine {

// Empty: not stated.
struct ProgramProfile {
  std::string tool_tip, dialect, unit, integer_words, decimals, block_delete, harmless_m, start, tool_change_keeps;
  std::vector<std::string> offsets, tool_lengths, tool_radii;

  bool operator==(const ProgramProfile&) const = default;
};

// Of a machine's description; without `programs` an empty one. Errors of MachineFromJson.
absl::StatusOr<ProgramProfile> ProgramProfileFromJson(const std::string& description_json);

// The description with another profile (none where it is empty); all else of it stays, as JSON of one line per member.
// Errors of MachineFromJson.
absl::StatusOr<std::string> WithProgramProfile(const std::string& description_json, const ProgramProfile& profile);

}  // namespace axiscal::machine

#endif  // AXISCAL_CORE_MACHINE_PROGRAM_PROFILE_H_
