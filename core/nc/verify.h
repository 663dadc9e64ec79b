// Runs an original and a compensated program through the machine's chain and compares tool points, independent of how
// the correction was computed: both texts are read, their moves paired, and core/machine/chain.h evaluated with the
// errors at what each program commands.
//
//   end error     tip(commanded; machine with errors) - tip(original's command; nominal machine), table frame, length
//   path error    the same inside moves, perpendicular to the nominal path; feed moves (G01, arcs) only
//   tilt          the angle between the tool directions of the same two, at the ends of moves and inside them
// What is passed (docs/nc.md), and moves behind it until every axis is programmed again, is not judged: its ranges of
// lines are listed. The compensated program may have blocks of its own in front of it, back to where the original is.
// A move may have become several; the next move of the compensated program that reaches the original's end ends the
// pair.
#ifndef AXISCAL_CORE_NC_VERIFY_H_
#define AXISCAL_CORE_NC_VERIFY_H_

#include <cstddef>
#include <cstdint>
#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "core/base/status.h"
#include "core/machine/error_model.h"
#include "core/nc/move_reader.h"
#include "core/nc/options.h"
#include "core/nc/report.h"

namespace axiscal::nc {

struct VerifyOptions {
  Eigen::Vector3d tool_tip_mm =
      Eigen::Vector3d::Zero();  // nominal tool point at home, machine frame; tool lengths come to it
  // How both programs are read: dialect, initial position, offsets, block delete, integer words, max_correction_mm (how
  // far apart two ends may be to be the same), with orientation max_rotary_correction_rad too.
  RewriteOptions reading;
  // Files in which calls of the compensated program find what is not in it; reading.subprograms: the original's.
  std::vector<Subprogram> compensated_subprograms;
  double time_s = 0;
  double temperature_celsius = shapes::kReferenceTemperatureCelsius;
};

struct VerifyReport {
  int64_t moves = 0;               // of the original
  int64_t pieces = 0;              // moves of the compensated program
  int64_t moves_unknown = 0;       // paired but not evaluated: an axis position is unknown
  int64_t blocks_unsupported = 0;  // blocks of the original that are not linear moves in axis positions: not evaluated
  Spread end_before, end_after;    // tool-point error at the ends of moves
  Spread path_before, path_after;  // inside them
  AngleSpread end_tilt_before, end_tilt_after;
  AngleSpread path_tilt_before, path_tilt_after;
  int64_t blocks_passed = 0;  // of blocks_unsupported: not followed at all; the others go to machine positions
  LineRanges not_judged;      // of the original: what is not evaluated
  int64_t worst_line = 0;     // of the original, where end_after or path_after is largest
};

// In constant memory. INVALID_ARGUMENT with the lines when the moves of the programs do not pair; errors of the
// readers.
absl::StatusOr<VerifyReport> Verify(const ByteReader& original, const ByteReader& compensated,
                                    const machine::Machine& machine, const machine::ErrorModel& errors,
                                    const VerifyOptions& options);
absl::StatusOr<VerifyReport> VerifyText(const std::string& original, const std::string& compensated,
                                        const machine::Machine& machine, const machine::ErrorModel& errors,
                                        const VerifyOptions& options);
// NOT_FOUND or UNAVAILABLE with the path when a file cannot be read.
absl::StatusOr<VerifyReport> VerifyFiles(const std::string& original_path, const std::string& compensated_path,
                                         const machine::Machine& machine, const machine::ErrorModel& errors,
                                         const VerifyOptions& options);

// The report as JSON text, um. Never fails.
std::string ToJson(const VerifyReport& report);

}  // namespace axiscal::nc

#endif  // AXISCAL_CORE_NC_VERIFY_H_
