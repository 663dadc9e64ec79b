// What the user states about a program before it is rewritten, and what may be done with it.
// Program units are those of the controller (mm, inch, deg); everything here is mm and rad.
#ifndef AXISCAL_CORE_NC_OPTIONS_H_
#define AXISCAL_CORE_NC_OPTIONS_H_

#include <Eigen/Core>
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "core/base/status.h"
#include "core/base/units.h"

namespace axiscal::nc {

// What to do with a block that moves axes in a way that cannot be corrected (cycles that are not followed, macros,
// unknown codes ...). Moves to machine positions (G28, G53 ...) are not of them: they are never touched, and listed.
enum class OnUnsupported {
  kRefuse,  // the job fails with all of them, by line, block and reason; nothing that was written may be used
  kPass,    // the block stays as it is and is listed; axis positions are unknown until they are programmed again
  kStop,    // the job fails at the first one, without reading on
};

// Blocks that begin with '/' are skipped when the operator's switch is on. Text of both cases must stay safe.
enum class BlockDelete {
  kEither,    // switch unknown: what such a block moves is unknown after it, until programmed again
  kExecuted,  // switch off for sure
  kSkipped,   // switch on for sure: such blocks stay as they are and move nothing
};

// Axis words without a decimal point.
enum class IntegerWords {
  kWholeUnits,  // X10 is 10 mm; five digits or more are refused, because they are least increments on other controllers
  kLeastIncrement,  // X10 is 10 times the machine's resolution (0.001 mm at three decimals); no decimals are added to
                    // such a word
};

// The unit of a program that does not state it (G20 and G21, G70 and G71, MM and INCH of BEGIN PGM). Controls begin in
// either, as a parameter says, or in that of the program before: a program's words mean nothing without it.
enum class ProgramUnit {
  kUnstated,  // axis words in front of the first such code cannot be corrected
  kMillimetre,
  kInch,
};

struct AxisValue {
  std::string axis;  // name in machine.json
  double value = 0;  // mm or rad
};

// A work offset that programs may select: axis position = programmed position + offset.
struct WorkOffset {
  std::string code;  // as programs select it: "G54", "G54.1 P5", "G505"; "PRESET" is Klartext's datum
  std::vector<AxisValue> offsets;
};

// The number of a length or radius that is D1 to D9999 of one tool (1 to 9999) alone: T5D1.
inline constexpr int kEdgesOfTool = 10'000;
inline constexpr int NumberOfEdge(int tool, int edge) { return tool * kEdgesOfTool + edge; }
// "5", "T5D1".
std::string ToolNumberText(int number);

// A tool length that programs select by number (H1, D1 of Sinumerik, TOOL CALL 1): it is added to Z, and the tool point
// stands that much farther along the tool than the stated one.
struct ToolLength {
  int number = 0;  // 1 to 9999, or NumberOfEdge: D1 of Sinumerik is another one of each tool
  double length_mm = 0;
};

// The radius of a cutter that programs select by number (G41 D1, D1 of Sinumerik, TOOL CALL 1): the one by which the
// control leads the tool beside a contour, wear included.
struct ToolRadius {
  int number = 0;  // as of ToolLength
  double radius_mm = 0;
};

// A file of subprograms: its name without folder, as calls or its first block name it, and its bytes.
struct Subprogram {
  std::string name;
  std::string text;
};

inline constexpr int kMaxHarmlessM = 9999;
inline constexpr double kMaxRotaryCorrectionRad = 0.1;  // far beyond what errors of machines need

struct RewriteOptions {
  // Name and version of the calibration, for the mark; letters, digits, blanks and "._-+:/".
  std::string calibration = "unnamed";
  // Name of the machine, for the program's head, which then also says what of the options its words hold for. "": no
  // such head.
  std::string machine;
  // With a head: of what the calibration's own report warns, kinds by their names ("size"), of which the head says so.
  std::vector<std::string> calibration_warns;
  std::string dialect = "fanuc";  // a name of Dialects()
  OnUnsupported on_unsupported = OnUnsupported::kRefuse;
  BlockDelete block_delete = BlockDelete::kEither;
  IntegerWords integer_words = IntegerWords::kWholeUnits;
  ProgramUnit unit = ProgramUnit::kUnstated;
  // The machine's resolution: corrected words get at least so many decimals. 0 to 6.
  int decimals_mm = 4;
  int decimals_inch = 5;
  // A larger correction of one axis stops the job: the calibration or the program is not what it seems. > 0.
  double max_correction_mm = 0.5;
  // A linear move is split where the correction along it departs from linear by more than this. > 0; infinity never
  // splits.
  double tolerance_mm = 0.001;
  // What may be left at a hole of a drilling cycle: the tool point's error at its bottom, which the cycle's words
  // cannot take away. More stops the job. > 0.
  double cycle_tolerance_mm = 0.02;
  // What may be left along a contour that the control offsets by the cutter's radius (G41, G42): words of the contour
  // say nothing of how errors differ between the contour and the cutter's centre. More stops the job. > 0.
  double cutter_tolerance_mm = 0.02;
  // Rotary commands are corrected too, where the machine's axes can turn the tool as programmed; what they cannot is
  // listed. The machine needs a rotary axis.
  bool orientation = false;
  // With orientation: largest change of a rotary command, in (0, 0.1]. Near singular poses the change is bounded by it
  // and falls to zero towards the pose (core/compensate/orientation.h).
  double max_rotary_correction_rad = 0.05 * base::kRadPerDeg;
  // With orientation: a move is also split where the tool's direction departs by more. > 0.
  double tolerance_rad = 1e-5;
  // Where axes stand when the program starts, for those that it does not program before they matter.
  std::vector<AxisValue> initial_position;
  // Rotary axes, by name in machine.json, that the tool changer leaves where they stand. All others, and linear ones
  // always, are unknown behind a tool change until the program states them.
  std::vector<std::string> tool_change_keeps;
  // M codes of the machine's builder that start no macro and move no axis (0 to 9999), beside those of the dialect's
  // table. Any other M code is not corrected past: it may do both.
  std::vector<int> harmless_m;
  // Offsets that the program may select. A program that selects another one is refused.
  std::vector<WorkOffset> work_offsets;
  // Lengths that the program may select. A program that selects another one is refused.
  std::vector<ToolLength> tool_lengths;
  // Radii that the program may select. Cutter compensation with another one is refused.
  std::vector<ToolRadius> tool_radii;
  // Files in which calls find what does not stand in the program itself.
  std::vector<Subprogram> subprograms;
  // Nominal tool point at home without the stated lengths, machine frame: from here the control counts them. Filled by
  // Rewriter (from its compensator) and Verify; programs under tool centre point control need it.
  Eigen::Vector3d tool_tip_mm = Eigen::Vector3d::Zero();
  // CRC-32C of the whole source for the mark; RewriteText and RewriteFile compute it themselves.
  std::optional<uint32_t> source_crc32c;
};

// INVALID_ARGUMENT that names field, value and rule.
absl::Status Validate(const RewriteOptions& options);

}  // namespace axiscal::nc

#endif  // AXISCAL_CORE_NC_OPTIONS_H_
