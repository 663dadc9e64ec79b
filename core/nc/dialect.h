// What the codes, keywords and letters of a controller family mean, as a table. A dialect is data: the lexer, the
// interpreter and the rewriter only look it up.
#ifndef AXISCAL_CORE_NC_DIALECT_H_
#define AXISCAL_CORE_NC_DIALECT_H_

#include <array>
#include <cstdint>
#include <string>
#include <vector>

#include "core/nc/arc.h"
#include "core/nc/block.h"

namespace axiscal::nc {

// What a code or a keyword does to the modal state. `detail` below refines it.
enum class Meaning : uint8_t {
  kUnknown,   // not in the table: refused; an M code may call a macro
  kHarmless,  // moves nothing and changes nothing that matters here
  kLimits,    // the same; axis words of its block are parameters of the code (G22, G25)
  kRapid,
  kLinear,
  kRapidBlock,    // rapid in this block only (FMAX)
  kArc,           // detail: 1 clockwise, 0 counterclockwise, seen against the plane's normal; with poles kArcWithRadius
  kCancelMotion,  // G80: axis words after it have no meaning
  kDrillCycle,    // G81 ...: drills at each block with axis words until another motion code; detail: CycleWords
  kCallCycle,     // drills at the place of the tool, or at the block's end; detail: kBy..., kAtPosition
  kDefineCycle,   // CYCL DEF 200: for calls behind it
  kReturnLevel,   // G98, G99; detail 1: cycles end at the R level
  kOtherMotion,   // moves axes in a way that is not corrected, stays in force until another motion code;
                  // detail: kCurve, kTangential
  kOneShot,       // moves axes or changes positions in this block only; detail likewise
  kMachineMove,  // moves to machine positions (G53, G28, SUPA, M91): never touched, also not refused; detail 1: without
                 // axis words
  kDataInput,    // stated offsets and lengths hold no longer; detail kWorkOffsetInput: G10, which may state offsets
  kSelectDatum,  // CYCL DEF 247: selects an offset by the number that its lines state
  kDwell,        // X and U of this block are times
  kSpeedMode,    // G5 P0, P2, P10000: look-ahead off and on; with another number it moves axes
  kInch,
  kMillimetre,
  kAbsolute,
  kIncremental,
  kCentreAbsolute,
  kCentreIncremental,
  kPlane,       // detail: index of the normal, 2 is XY
  kShorterWay,  // M126; detail: 1 rotary axes that roll over go the shorter way, 0 as the axis counts
  kFeedPerMinute,
  kFeedInverseTime,
  kFeedPerTurn,
  kWorkOffset,    // selects an offset: needs to be stated; detail 1: the number stands in the P word, or
                  // kOffsetMayHaveNumber
  kNoWorkOffset,  // G500: none
  kToolLength,    // detail: 1 added (G43), 2 subtracted (G44)
  kNoToolLength,
  kPreset,              // G92; detail: 0 set, 1 cleared, 2 suspended, 3 restored, kPresetOrThread
  kScalingOffOrPreset,  // G50: with axis words it sets coordinates, of lathes
  kLocalShift,          // G52
  // Tool centre point control, followed where it can be and else a kBlockerOn; detail: its Blocker, with kSelectsLength
  // too where its block states the tool length (G43.4 H1).
  kToolPoint,
  kTurnByVector,   // how tools turn under it; detail: 1 by a vector, 0 axis by axis
  kToolVector,     // a component of the tool's direction, from its tip to the spindle (A3=, TX); detail: 0 to 2
  kSurfaceNormal,  // NX of LN: where differences of the tool's radius would move the path to
  kDepart,         // DEP LT, LN, CT: ends cutter compensation, and moves in X and Y to where the control computes
  kCutterSide,     // cutter compensation; detail: 1 the tool stands left of the contour, 2 right
  kBlockerOn,      // a mode in which axis words are not axis positions; detail: a Blocker
  // The same, followed where its words are plain numbers (tilt.cc); detail: its Blocker.
  kRotate,       // G68
  kTilt,         // G68.2: three angles about Z, X and Z; of Haas' G268 about X, Y and Z, with kAnglesXyz
  kScale,        // G51
  kMirrorOn,     // G51.1
  kMoveOrigin,   // G254: the work offset goes with the turned table
  kTurnToPlane,  // G53.1: the rotary axes turn the tool to the tilted plane
  // The same with what stands behind the keyword; without it, or with what states nothing (ROT+0, X+0), the mode
  // ends.
  kBlockerByRest,
  kBlockerOff,    // of mirroring: axis words of its block say which axes
  kToolChange,    // axes may have moved; detail: kBehindMove
  kAxesAway,      // the same without a new tool (a pallet change); detail: the Blockers that it ends
  kEndOfProgram,  // detail 1: of one that may have been called (M99)
  kCall,          // control leaves this text and comes back; detail 1: it restores a state that was stored (M72)
  kJump,          // behind it blocks do not run in the order of the text
  kEndOfBlock,  // takes effect after the block's move (M00, M05 ...): such a move cannot be split; so may M codes that
                // the user states as harmless
  kHead,        // names the program (BEGIN PGM)
  kAddress,     // a word of more than one letter: CR=5; detail: the letter that stands for it
  kIncrementalAddress,  // IX+5; detail: the letter
  kPole,                // CC: the centre of arcs behind it
  kArcSense,            // DR+, DR-; detail: 1 clockwise
  kTurns,               // TURN=1: whole turns of a helix beside its arc
  kCorner,  // RND=5; ,R5. of Fanuc: the control rounds or chamfers the corner at the block's end; detail 1: every
            // corner, until 0
};

// Whether it states a mode and asks for no other word of its block: G90, G01, G21.
constexpr bool IsPlainMode(Meaning meaning) {
  switch (meaning) {
    case Meaning::kRapid:
    case Meaning::kLinear:
    case Meaning::kInch:
    case Meaning::kMillimetre:
    case Meaning::kAbsolute:
    case Meaning::kIncremental:
    case Meaning::kPlane:
    case Meaning::kFeedPerMinute:
    case Meaning::kFeedInverseTime:
    case Meaning::kFeedPerTurn:
      return true;
    default:
      return false;
  }
}

// Modes that keep moves from being corrected. Bits of Modal::blockers.
// Each has its own codes that end it: two modes share a bit only where the same code ends both.
enum Blocker : uint32_t {
  kCutterCompensation = 1,
  kToolControl = 2,  // tool centre point control; of Klartext M128
  kTiltedPlane = 4,
  kShift = 8,
  kScaling = 16,
  kMirror = 32,
  kPolar = 64,
  kModalMacro = 128,
  kCylinder = 256,
  kUnstatedOffset = 512,
  kDiameter = 1024,
  kUnstatedLength = 2048,
  kUnfollowedMode = 4096,
  kRotation = 1 << 13,             // G68, which G69 ends, of Haas not G269; CYCL DEF 10, which PLANE RESET does not end
  kKinematics = 1 << 14,           // M428, TCARR: no code that is read here ends it
  kPolarInterpolation = 1 << 15,   // G12.1, TRANSMIT
  kNormalDirection = 1 << 16,      // G41.1 of Fanuc
  kDynamicOffset = 1 << 17,        // G254 of Haas
  kToolControlFunction = 1 << 18,  // FUNCTION TCPM
  kTiltCorrection = 1 << 19,       // M114
  kTiltedKinematics = 1 << 20,     // M144
  kWorkpieceRotation = 1 << 21,    // G68.5, G68.6, which G69.1 ends
  kFrame = 1 << 22,                // TRANS, ROT, SCALE, MIRROR of Sinumerik, which any of them alone ends
  kSwivel = 1 << 23,               // CYCLE800, which CYCLE800() ends
  kWorkingPlane = 1 << 24,         // CYCL DEF 19
  kDatumShift = 1 << 25,           // CYCL DEF 7
  kTurretOffset = 1 << 26,         // T0101 of lathes, which M06 shows to be a tool's number alone
};

// Modes that are followed by placing the words of X, Y and Z (word_frame.h): tilted planes, and what turns words in
// their plane.
inline constexpr uint32_t kTiltedPlanes = kTiltedPlane | kSwivel | kWorkingPlane | kDynamicOffset;
inline constexpr uint32_t kTurnedFrames = kRotation | kFrame | kMirror | kScaling;
inline constexpr uint32_t kPlacedFrames = kTiltedPlanes | kTurnedFrames;

inline constexpr uint32_t kSelectsLength = 1u << 31;  // of kToolPoint
inline constexpr uint32_t kStatesVectors = 1u << 30;  // likewise: I, J and K say how the tool stands (G43.5)
inline constexpr uint32_t kWithNormals = 1;           // of kLinear: LN
// Of kLinear: APPR leads to the first point of a contour, DEP LCT away from its last one; the control lays a line or an
// arc that touches the contour between them.
inline constexpr uint32_t kApproach = 2;
inline constexpr uint32_t kDeparture = 3;
inline constexpr uint32_t kAnglesXyz = 1u << 31;  // of kTilt
// Of kDrillCycle: words of its block beside those of axes, R, Q, P and F.
enum CycleWords : uint32_t {
  kCycleRepeatsK = 1,  // K: how often
  kCycleRepeatsL = 2,
  kCycleCentres = 4,  // I, J and K: pecks, or the shift of a fine boring tool
};
// Of kCallCycle.
inline constexpr uint32_t kByArguments = 1;   // CYCLE81(10,0,2,-20)
inline constexpr uint32_t kByDefinition = 2;  // CYCL CALL, M99: the last CYCL DEF
inline constexpr uint32_t kAtPosition = 3;    // CYCL CALL POS: at X and Y, heights shifted by Z
// Of harmless keywords: defines another cycle than those that are followed, or writes Q parameters, which may be those
// of a definition.
inline constexpr uint32_t kDefines = 3;
inline constexpr uint32_t kArcWithRadius = 2;  // Klartext's CR, whose R is a radius
// Of kOneShot and kOtherMotion.
inline constexpr uint32_t kCurve = 1;                // a circle or curve that depends on where it begins
inline constexpr uint32_t kTangential = 2;           // its shape follows the direction of the move in front of it
inline constexpr uint32_t kBehindMove = 1;           // the block's own words are moved to first
inline constexpr uint32_t kOffsetMayHaveNumber = 2;  // G54 P2 is G54.1 P2
inline constexpr uint32_t kWorkOffsetInput = 1;
inline constexpr uint32_t kMaySetTransformation = 2;  // of harmless keywords
inline constexpr uint32_t kReadsNumber = 1;           // of harmless M codes: a P word of their block is theirs
inline constexpr uint32_t kPresetOrThread = 4;        // G92 with an F word is a thread on lathes of the same family

struct CodeEntry {
  char letter;  // G or M
  int tenths;   // G54.1 is 541
  Meaning meaning;
  uint32_t detail;
  const char* text;  // what the code does, for refusals
};

struct Keyword {
  const char* name;  // capitals
  Meaning meaning;
  uint32_t detail;
  bool takes_rest;  // the rest of the block is its argument, not words
  const char* text;
};

inline constexpr int kCodes = 10000;  // up to G999.9

struct CodeMeaning {
  Meaning meaning;
  uint32_t detail;
  const char* text;
};

// What a letter's word is.
enum class Role : uint8_t {
  kParameter,  // of whatever code stands in the block
  kCode,
  kAxis,
  kLineNumber,
  kProgramNumber,
  kPassive,
  kFeed,
  kToolNumber,
  kToolLength,        // H: number of the length that G43 adds
  kToolRadius,        // D: number of the radius of G41
  kActiveToolLength,  // D of Sinumerik: the length acts as soon as it is named
  kCentre,            // I, J, K
  kRadius,
  kRadiusCompensation,  // R0 of Klartext
};

// The name of a distance that a word says itself: "IC" of X=IC(5).
struct DistanceName {
  const char* name;
  Distance distance;
};

struct Dialect {
  std::string name;
  std::vector<CodeMeaning> g_codes, m_codes;  // by tenths, kCodes each
  std::vector<Keyword> keywords;              // a keyword that begins like another stands behind the longer one
  std::array<Role, 26> roles;
  std::string axis_letters = "XYZABCUVW";  // in the order in which inserted words are written
  bool has_parenthesis_comments = true;    // ( ... )
  char line_comment = ';';                 // to the end of the line; 0: none
  char line_comment2 = 0;                  // '*' of Klartext; only at the begin of a block
  bool has_semicolon_ends = false;         // ';' may end a block: words behind it are not taken for a comment
  bool has_angle_names = false;            // <NAME> or O<NAME> begins a program
  bool has_equals = false;                 // X=5 is a word
  std::vector<DistanceName> distance_names;
  char variable = '#';                 // letter of variables; 0: none is told apart
  bool has_assignment_blocks = false;  // Q1 = Q2 * 3 is a block of its own, and no such variable moves an axis
  bool has_bare_keywords = false;      // single letters may be keywords (L), blocks begin with their number
  bool has_poles = false;              // arcs stand about a pole (CC), in XY, and say their sense (DR)
  bool takes_loaded_tool = false;      // G43 without H takes the length of the tool in the spindle
  bool g91_takes_new_offsets = false;  // G91 behind a change of the work offset moves by that too (SD42440)
  // A transformation that begins or ends may drop the work offset (Sinumerik: MD10602), and how the tool turns under it
  // is the builder's to choose: both must be stated.
  bool transformation_may_drop_offset = false;
  // On lathes of the family T0101 turns the turret and switches the offset of its last two digits at once.
  bool tools_may_switch_offsets = false;
  bool integers_may_be_increments = false;  // X10 is 10 mm or 0.010 mm, as a parameter of the control says
  bool cycles_keep_motion = false;     // G80 ends a cycle alone: behind it G00 or G01 is in force as it was in front
  bool lengths_along_z = false;        // G43 and G44 act along Z in every plane
  bool tool_call_sets_length = false;  // the tool's length acts from the tool change on, without a code
  // F is the speed in the space of all axes, degrees counted as mm: a rotary axis that moves alone goes on at its speed
  // when a linear one moves a little with it. Else F is that of the linear axes as soon as one of them moves.
  bool feeds_all_axes = false;
  // How far both ends of an arc with a centre may differ in their distance from it, where that is more than 0.1 %.
  double arc_radius_tolerance_mm = kRadiusToleranceMm;
  bool takes_finer_words = false;  // words may have more decimals than the machine's resolution, and mean them
  size_t max_block_bytes = 0;      // that the control reads, line end included; 0: no limit is known
  bool packs_repeats = false;      // M98 P51002 runs O1002 five times
  // G10 L2 P1 to so many are G54 and those behind it; L20 P1 to `additional_offsets` are numbered_offset P1 and so on.
  int plain_offsets = 6, additional_offsets = 0;
  std::string numbered_offset;
  std::string first_offset = "G54";  // the work offset that is selected at the begin
  std::string piece_prefix;          // what inserted pieces begin with: "L "
  std::string radius_address = "R";  // what a piece's radius word begins with
  // What the words of the tool's direction begin with.
  std::array<std::string, 3> vector_addresses = {"I", "J", "K"};
  bool writes_plus = false;  // inserted words carry their sign

  std::vector<CodeMeaning> keyword_codes;  // of `keywords`, in their order
  uint32_t keyword_letters = 0;            // bit i: a keyword begins with the letter i; those with a comma apart
};

const std::vector<Dialect>& Dialects();
// nullptr when there is none of that name. "mazak" and "haas" are names of the table "fanuc" with their own codes.
const Dialect* FindDialect(const std::string& name);
// "cutter compensation is active", of the lowest bit set. `blockers` != 0.
const char* BlockerText(uint32_t blockers);

}  // namespace axiscal::nc

#endif  // AXISCAL_CORE_NC_DIALECT_H_
