// The modal state of a controller and the positions of its axes.
#ifndef AXISCAL_CORE_NC_MODAL_H_
#define AXISCAL_CORE_NC_MODAL_H_

#include <array>
#include <cstdint>

#include "core/machine/machine.h"
#include "core/nc/decimal.h"
#include "core/nc/dialect.h"

namespace axiscal::nc {

enum class FeedMode : uint8_t { kPerMinute, kInverseTime, kPerTurn };

// Modal groups whose state may be unknown: behind a call, or a block that could not be read to its end.
enum ModalGroup : uint8_t {
  kMotionGroup = 1,
  kDistanceGroup = 2,
  kUnitGroup = 4,
  kPlaneGroup = 8,
  kFeedGroup = 16,
  kOffsetGroup = 32,
  kLengthGroup = 64,
  kCentreGroup = 128,  // G90.1 or G91.1; known behind calls, since no program is known that leaves it changed
};
inline constexpr uint8_t kAllGroups = 127;
inline constexpr uint8_t kCalledGroups = kAllGroups;  // what a subprogram may leave changed
inline constexpr uint16_t kAllAxes = 0xFFFF;

// Which way rotary axes that roll over go: M126 and M127 of Klartext.
enum class Way : uint8_t { kOfAxis, kShorter, kUnknown };

// A drilling cycle in force (kDrillCycle), along Z. Heights are axis positions.
struct DrillCycle {
  const CodeMeaning* code = nullptr;  // nullptr: none, or one that is not followed
  Ticks entry = 0, bottom = 0;        // where feeding begins (R), and ends
  Ticks level = 0;                    // where Z stood when the cycle began: G98 returns there
  bool is_level_known = false;
  Ticks z_offset = 0;  // of the coordinates in which R and Z were stated
  bool is_inch = false;

  bool operator==(const DrillCycle&) const = default;
};

struct Modal {
  Meaning motion = Meaning::kLinear;  // kRapid, kLinear, kArc, kCancelMotion, kDrillCycle or kOtherMotion. Power-on is
                                      // linear.
  DrillCycle cycle;
  // What G80 brings back into force: kRapid or kLinear in front of `cycle`, or kCancelMotion.
  Meaning motion_before_cycle = Meaning::kCancelMotion;
  // What a call drills, of the last CYCL DEF or of MCALL; `level`: where Z stands behind it.
  DrillCycle called;
  bool calls_at_moves = false;    // MCALL: behind each move
  bool returns_to_entry = false;  // G99
  bool is_return_unsure = true;   // until the program states it: controls begin with either
  bool is_clockwise = false;      // of kArc
  const char* motion_text = "";   // of kOtherMotion
  bool is_inch = false;
  bool is_incremental = false;
  bool are_centres_absolute = false;
  int8_t plane_normal = 2;  // 0 YZ, 1 ZX, 2 XY
  FeedMode feed_mode = FeedMode::kPerMinute;
  bool lacks_feed = false;       // the feed mode changed, and no F word since: the control has none
  bool is_rapid_unsure = false;  // a block that may be skipped changed between G00 and another motion code
  Way way = Way::kOfAxis;
  uint32_t blockers = 0;
  // The Blocker of the tool centre point control that is in force and followed: words of X, Y and Z stand in the
  // workpiece's frame (tool_point_frame.h); or those of kPlacedFrames that are (word_frame.h). 0: none.
  uint32_t tool_point = 0;
  // Of `tool_point`: I, J and K state the tool's direction, and no word turns a rotary axis.
  bool states_vectors = false;
  bool turns_by_vector = false;  // tools turn by a vector (ORIVECT, ORIWKS), not axis by axis
  uint16_t mirrored_axes = 0;  // of kMirror; bits of axes that are none of the machine's are set where it is not known
  uint16_t shifted_axes = 0;   // of kDatumShift: letters in the order of "XYZABCUVW", bit 15: not known which
  // Cutter compensation that is followed: 0 none, 1 the tool stands left of the contour, 2 right; its radius.
  int8_t cutter_side = 0;
  Ticks cutter_radius = 0;
  bool is_cutter_ending = false;  // it ended, and the move in X or Y that leads away is still to come
  uint8_t macro_depth = 0;        // of kModalMacro: how many calls are in force
  uint8_t uncertain = 0;          // ModalGroups

  bool operator==(const Modal&) const = default;
};

inline constexpr Ticks kTurn = 360 * kTicksPerMm;  // ticks of degrees are as many

using AxisTicks = std::array<Ticks, machine::kMaxAxes>;

struct Positions {
  AxisTicks ticks{};
  std::array<int8_t, machine::kMaxAxes> sense{};  // of the last motion: +1, -1, 0 unknown
  uint16_t known = 0;                             // bit i: axis i

  bool is_known(int axis) const { return known >> axis & 1; }

  // Of the first `count` axes: the machine has no more.
  void CopyFrom(const Positions& other, int count) {
    for (int i = 0; i < count; ++i) {
      ticks[static_cast<size_t>(i)] = other.ticks[static_cast<size_t>(i)];
      sense[static_cast<size_t>(i)] = other.sense[static_cast<size_t>(i)];
    }
    known = other.known;
  }
};

}  // namespace axiscal::nc

#endif  // AXISCAL_CORE_NC_MODAL_H_
