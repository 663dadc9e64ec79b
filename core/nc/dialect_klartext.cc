// Words of Heidenhain Klartext: L, LN, C, CR and CC blocks are read, everything else is recognised and reported.
#include <cstring>

#include "core/nc/dialect_tables.h"

namespace axiscal::nc {

std::vector<CodeEntry> KlartextCodes() {
  using M = Meaning;
  return {
      {'M', 0, M::kEndOfBlock, 0, "stop"},
      {'M', 10, M::kEndOfBlock, 0, "optional stop"},
      {'M', 20, M::kEndOfProgram, 0, "end of program"},
      {'M', 50, M::kEndOfBlock, 0, "spindle stop"},
      // TNC 640 User's Manual: tool change, a function of the machine's builder, at the end of its block.
      {'M', 60, M::kToolChange, kBehindMove, "tool change"},
      {'M', 90, M::kEndOfBlock, 0, "coolant off"},
      {'M', 300, M::kEndOfProgram, 0, "end of program"},
      {'M', 910, M::kMachineMove, 0, "machine coordinates"},
      {'M', 920, M::kMachineMove, 0, "machine coordinates"},
      {'M', 990, M::kCallCycle, kByDefinition, "calls a cycle"},
      {'M', 1280, M::kToolPoint, kToolControl, "tool centre point control"},
      {'M', 1290, M::kBlockerOff, kToolControl, "tool centre point control off"},
      {'M', 1300, M::kOneShot, 0, "position in the untilted system"},
      {'M', 1400, M::kMachineMove, 1, "retraction along the tool"},
      {'M', 1140, M::kBlockerOn, kTiltCorrection, "correction of the geometry with tilting axes"},
      {'M', 1150, M::kBlockerOff, kTiltCorrection, "correction of the geometry with tilting axes off"},
      {'M', 1440, M::kBlockerOn, kTiltedKinematics, "compensation of the kinematics"},
      {'M', 1450, M::kBlockerOff, kTiltedKinematics, "compensation of the kinematics off"},
      {'M', 940, M::kOneShot, 0, "reduces the position of a rotary axis"},
      {'M', 1360, M::kFeedPerTurn, 0, "feed per turn"},
      {'M', 1370, M::kFeedPerMinute, 0, "feed per minute"},
  };
}

namespace {

// Cycles that start nothing where they are defined: they wait for their call, or state data. HEIDENHAIN TNC 640, User's
// Manual for Cycle Programming, "Defining a cycle" (cycles that act by definition) and the cycles' own pages. Of all
// others (220 and 221 run the last cycle at the points of a pattern, those of touch probes and of the machine's
// builder) the definition may move axes or change coordinates.
constexpr const char* kCyclesThatWait[] = {
    "CYCL DEF 1",   "CYCL DEF 2",   "CYCL DEF 3",   "CYCL DEF 4",   "CYCL DEF 5",   "CYCL DEF 9",   "CYCL DEF 12",
    "CYCL DEF 13",  "CYCL DEF 14",  "CYCL DEF 17",  "CYCL DEF 18",  "CYCL DEF 20",  "CYCL DEF 21",  "CYCL DEF 22",
    "CYCL DEF 23",  "CYCL DEF 24",  "CYCL DEF 25",  "CYCL DEF 27",  "CYCL DEF 28",  "CYCL DEF 29",  "CYCL DEF 32",
    "CYCL DEF 39",  "CYCL DEF 204", "CYCL DEF 208", "CYCL DEF 210", "CYCL DEF 211", "CYCL DEF 212", "CYCL DEF 213",
    "CYCL DEF 214", "CYCL DEF 215", "CYCL DEF 225", "CYCL DEF 230", "CYCL DEF 231", "CYCL DEF 232", "CYCL DEF 233",
    "CYCL DEF 240", "CYCL DEF 241", "CYCL DEF 251", "CYCL DEF 252", "CYCL DEF 253", "CYCL DEF 254", "CYCL DEF 256",
    "CYCL DEF 257", "CYCL DEF 258", "CYCL DEF 262", "CYCL DEF 263", "CYCL DEF 264", "CYCL DEF 265", "CYCL DEF 267",
    "CYCL DEF 270", "CYCL DEF 271", "CYCL DEF 272", "CYCL DEF 273", "CYCL DEF 274", "CYCL DEF 275", "CYCL DEF 276",
};

constexpr const char* kPattern =
    "runs the last cycle at the points of a pattern, which no word states: call it at each (L X Y FMAX M99)";

constexpr const char* kDrillingCycles[] = {"CYCL DEF 200", "CYCL DEF 201", "CYCL DEF 202", "CYCL DEF 203",
                                           "CYCL DEF 205", "CYCL DEF 206", "CYCL DEF 207", "CYCL DEF 209"};

}  // namespace

std::vector<Keyword> KlartextKeywords() {
  using M = Meaning;
  std::vector<Keyword> keywords = {
      {"CYCL DEF 220", M::kOneShot, 0, true, kPattern},
      {"CYCL DEF 221", M::kOneShot, 0, true, kPattern},
      {"CYCL DEF", M::kBlockerOn, kUnfollowedMode, true, "cycle that may act where it is defined"},
      {"FUNCTION COUNT REPEAT", M::kJump, 0, true, "jumps back while parts are left"},
      {"L", M::kLinear, 0, false, "linear move"},
      {"LN", M::kLinear, kWithNormals, false, "linear move with surface normals"},
      {"TX", M::kToolVector, 0, false, "tool vector"},
      {"TY", M::kToolVector, 1, false, "tool vector"},
      {"TZ", M::kToolVector, 2, false, "tool vector"},
      {"NX", M::kSurfaceNormal, 0, false, "surface normal"},
      {"NY", M::kSurfaceNormal, 1, false, "surface normal"},
      {"NZ", M::kSurfaceNormal, 2, false, "surface normal"},
      {"LP", M::kOneShot, 0, true, "polar linear move: no word of an axis could be corrected"},
      {"LBL", M::kJump, 0, true, "label"},
      {"CALL", M::kCall, 0, true, "call"},
      {"C", M::kArc, 0, false, "circular move"},
      {"CC", M::kPole, 0, false, "pole"},
      {"CR", M::kArc, kArcWithRadius, false, "circular move"},
      {"DR+", M::kArcSense, 0, false, "sense of an arc"},
      {"DR-", M::kArcSense, 1, false, "sense of an arc"},
      {"CT", M::kOneShot, kTangential, true, "tangential circular move: its centre follows from the block before"},
      {"CP", M::kOneShot, kCurve, true, "polar circular move: no word of an axis could be corrected"},
      {"CTP", M::kOneShot, kTangential, true, "polar circular move: no word of an axis could be corrected"},
      {"CHF", M::kCorner, 0, true, "chamfer"},
      {"RND", M::kCorner, 0, true, "rounding"},
      {"FPOL", M::kOneShot, 0, true, "free contour: no word of an axis could be corrected"},
      {"FL", M::kOneShot, kTangential, true, "free contour: no word of an axis could be corrected"},
      {"FLT", M::kOneShot, kTangential, true, "free contour: no word of an axis could be corrected"},
      {"FC", M::kOneShot, kTangential, true, "free contour: no word of an axis could be corrected"},
      {"FCT", M::kOneShot, kTangential, true, "free contour: no word of an axis could be corrected"},
      {"FSELECT", M::kHarmless, 0, true, "free contour"},
      {"MB MAX", M::kHarmless, 0, false, "to the travel limit"},
      {"MB", M::kAddress, 'S', false, "length of a retraction"},
      // In polar coordinates, which stand in no word of an axis.
      {"APPR", M::kBlockerOn, kCutterCompensation, true, "approach with cutter compensation"},
      {"DEP", M::kOneShot, kTangential, true, "departure"},
      {"APPR LT", M::kLinear, kApproach, false, "approach"},
      {"APPR LN", M::kLinear, kApproach, false, "approach"},
      {"APPR CT", M::kLinear, kApproach, false, "approach"},
      {"APPR LCT", M::kLinear, kApproach, false, "approach"},
      {"DEP LCT", M::kLinear, kDeparture, false, "departure"},
      {"DEP LT", M::kDepart, 0, false, "departure"},
      {"DEP LN", M::kDepart, 0, false, "departure"},
      {"DEP CT", M::kDepart, 0, false, "departure"},
      {"LEN", M::kAddress, 'S', false, "length of an approach"},
      {"CCA", M::kAddress, 'S', false, "angle of an approach"},
      {"CYCL DEF 19", M::kBlockerByRest, kWorkingPlane, true, "tilted plane"},
      {"CYCL DEF 10", M::kBlockerByRest, kRotation, true, "rotation"},
      {"CYCL DEF 11", M::kBlockerByRest, kScaling, true, "scaling"},
      {"CYCL DEF 26", M::kBlockerOn, kUnfollowedMode, true, "scaling"},
      {"CYCL DEF 8", M::kBlockerByRest, kMirror, true, "mirror"},
      {"CYCL DEF 7", M::kBlockerByRest, kDatumShift, true, "shift of coordinates"},
      {"CYCL DEF 247", M::kSelectDatum, 0, true, "sets the datum"},
      {"CYCL CALL", M::kCallCycle, kByDefinition, true, "calls a cycle"},
      {"CYCL CALL POS", M::kCallCycle, kAtPosition, false, "calls a cycle"},
      {"TCH PROBE 0", M::kOneShot, 0, true, "probing"},
      {"TCH PROBE 1", M::kOneShot, 0, true, "probing"},
      {"TCH PROBE 3", M::kOneShot, 0, true, "probing"},
      {"TCH PROBE", M::kBlockerOn, kUnstatedOffset, true, "probing: it may set the datum"},
      {"TRANS DATUM", M::kBlockerOn, kShift, true, "shift of coordinates"},
      {"PRESET", M::kBlockerOn, kUnstatedOffset, true, "sets the datum"},
      // Turns the tilting axes home; MOVE takes the linear axes along.
      {"PLANE RESET TURN", M::kAxesAway, kTiltedPlane | kWorkingPlane, true, "turns the tilting axes home"},
      {"PLANE RESET MOVE", M::kAxesAway, kTiltedPlane | kWorkingPlane, true, "turns the tilting axes home"},
      {"PLANE RESET", M::kBlockerOff, kTiltedPlane | kWorkingPlane, true, "tilted plane off"},
      {"PLANE SPATIAL", M::kBlockerByRest, kTiltedPlane, true, "tilted plane"},
      {"PLANE", M::kBlockerOn, kTiltedPlane, true, "tilted plane"},
      {"FUNCTION TCPM", M::kToolPoint, kToolControlFunction, true, "tool centre point control"},
      {"FUNCTION RESET TCPM", M::kBlockerOff, kToolControlFunction, true, "tool centre point control off"},
      {"FUNCTION MODE TURN", M::kBlockerOn, kDiameter, true, "turning: words may be diameters"},
      {"FUNCTION MODE MILL", M::kBlockerOff, kDiameter, true, "milling"},
      {"FUNCTION COUNT", M::kHarmless, 0, true, "counter"},
      {"FUNCTION DCM", M::kHarmless, 0, true, "collision watch"},
      {"FUNCTION DWELL", M::kHarmless, 0, true, "dwell"},
      {"FUNCTION FEED", M::kHarmless, 0, true, "recurring dwell"},
      {"FUNCTION FILE", M::kHarmless, 0, true, "files"},
      {"FUNCTION LIFTOFF", M::kHarmless, 0, true, "liftoff behind a power failure"},
      {"FUNCTION S-PULSE", M::kHarmless, 0, true, "pulsing spindle speed"},
      {"FUNCTION", M::kBlockerOn, kUnfollowedMode, true, "function that is not followed"},
      {"TOOL CALL", M::kToolChange, 0, true, "tool change"},
      {"TOOL DEF", M::kHarmless, 0, true, "tool"},
      {"BEGIN PGM", M::kHead, 0, true, "program"},
      {"END PGM", M::kEndOfProgram, 0, true, "end of program"},
      {"BLK FORM", M::kHarmless, 0, true, "blank"},
      {"STOP", M::kEndOfBlock, 0, false, "stop"},
      {"FMAX", M::kRapidBlock, 0, false, "rapid move"},
      {"F MAX", M::kRapidBlock, 0, false, "rapid move"},  // of older controls
      {"FAUTO", M::kHarmless, 0, false, "feed of the tool"},
      {"RL", M::kCutterSide, 1, false, "cutter compensation"},
      {"RR", M::kCutterSide, 2, false, "cutter compensation"},
      {"IX", M::kIncrementalAddress, 'X', false, ""},
      {"IY", M::kIncrementalAddress, 'Y', false, ""},
      {"IZ", M::kIncrementalAddress, 'Z', false, ""},
      {"IA", M::kIncrementalAddress, 'A', false, ""},
      {"IB", M::kIncrementalAddress, 'B', false, ""},
      {"IC", M::kIncrementalAddress, 'C', false, ""},
      {"QL", M::kHarmless, kDefines, true, "parameter"},
      {"QR", M::kHarmless, kDefines, true, "parameter"},
      {"QS", M::kHarmless, kDefines, true, "parameter"},
      // Arithmetic; the others jump, or write to the control.
      {"FN 0", M::kHarmless, kDefines, true, "parameter"},
      {"FN 1", M::kHarmless, kDefines, true, "parameter"},
      {"FN 2", M::kHarmless, kDefines, true, "parameter"},
      {"FN 3", M::kHarmless, kDefines, true, "parameter"},
      {"FN 4", M::kHarmless, kDefines, true, "parameter"},
      {"FN 5", M::kHarmless, kDefines, true, "parameter"},
      {"FN 6", M::kHarmless, kDefines, true, "parameter"},
      {"FN 7", M::kHarmless, kDefines, true, "parameter"},
      {"FN 8", M::kHarmless, kDefines, true, "parameter"},
      {"FN 18", M::kHarmless, kDefines, true, "reads a value of the control"},
      {"FN", M::kJump, 0, true, "parameters or a jump"},
  };
  for (const char* const name : kCyclesThatWait) {
    const bool is_called = std::strcmp(name, "CYCL DEF 9") != 0 && std::strcmp(name, "CYCL DEF 32") != 0;
    keywords.push_back({name, M::kHarmless, is_called ? kDefines : 0, true, "defines a cycle"});
  }
  // Drilling, reaming, boring, tapping: Q200, Q201, Q203 and Q204 say where.
  for (const char* const name : kDrillingCycles)
    keywords.push_back({name, M::kDefineCycle, 0, true, "defines a cycle"});
  return keywords;
}

}  // namespace axiscal::nc
