// Words of Heidenhain Klartext: L blocks are read, everything else is recognised and reported.
#include "core/nc/dialect_tables.h"

namespace axiscal::nc {

std::vector<CodeEntry> KlartextCodes() {
  using M = Meaning;
  return {
      {'M', 0, M::kEndOfBlock, 0, "stop"},
      {'M', 10, M::kEndOfBlock, 0, "optional stop"},
      {'M', 20, M::kEndOfProgram, 0, "end of program"},
      {'M', 30, M::kHarmless, 0, "spindle on"},
      {'M', 40, M::kHarmless, 0, "spindle on"},
      {'M', 70, M::kHarmless, 0, "coolant on"},
      {'M', 80, M::kHarmless, 0, "coolant on"},
      {'M', 130, M::kHarmless, 0, "spindle and coolant on"},
      {'M', 140, M::kHarmless, 0, "spindle and coolant on"},
      {'M', 50, M::kEndOfBlock, 0, "spindle stop"},
      {'M', 60, M::kEndOfBlock, 0, "stop"},
      {'M', 90, M::kEndOfBlock, 0, "coolant off"},
      {'M', 300, M::kEndOfProgram, 0, "end of program"},
      {'M', 890, M::kOneShot, 0, "calls a cycle"},
      {'M', 910, M::kMachineMove, 0, "machine coordinates"},
      {'M', 920, M::kMachineMove, 0, "machine coordinates"},
      {'M', 990, M::kOneShot, 0, "calls a cycle"},
      {'M', 1280, M::kBlockerOn, kToolControl, "tool centre point control"},
      {'M', 1290, M::kBlockerOff, kToolControl, "tool centre point control off"},
      {'M', 1300, M::kOneShot, 0, "position in the untilted system"},
      {'M', 1400, M::kOneShot, 0, "retraction along the tool"},
      {'M', 1440, M::kBlockerOn, kToolControl, "compensation of the kinematics"},
      {'M', 1450, M::kBlockerOff, kToolControl, "compensation of the kinematics off"},
      {'M', 940, M::kOneShot, 0, "reduces the position of a rotary axis"},
      {'M', 1360, M::kFeedPerTurn, 0, "feed per turn"},
      {'M', 1370, M::kFeedPerMinute, 0, "feed per minute"},
  };
}

std::vector<Keyword> KlartextKeywords() {
  using M = Meaning;
  return {
      {"L", M::kLinear, 0, false, "linear move"},
      {"LN", M::kOneShot, 0, true, "linear move with surface normals"},
      {"LP", M::kOneShot, 0, true, "polar linear move"},
      {"LBL", M::kJump, 0, true, "label"},
      {"CALL", M::kCall, 0, true, "call"},
      {"C", M::kOneShot, 0, true, "circular move"},
      {"CC", M::kHarmless, 0, true, "pole"},
      {"CR", M::kOneShot, 0, true, "circular move"},
      {"CT", M::kOneShot, 0, true, "circular move"},
      {"CP", M::kOneShot, 0, true, "circular move"},
      {"CTP", M::kOneShot, 0, true, "circular move"},
      {"CHF", M::kOneShot, 0, true, "chamfer"},
      {"RND", M::kOneShot, 0, true, "rounding"},
      {"APPR", M::kBlockerOn, kCutterCompensation, true, "approach with cutter compensation"},
      {"DEP", M::kOneShot, 0, true, "departure"},
      {"CYCL DEF 19", M::kBlockerOn, kTiltedPlane, true, "tilted plane"},
      {"CYCL DEF 10", M::kBlockerOn, kTiltedPlane, true, "rotation"},
      {"CYCL DEF 11", M::kBlockerOn, kScaling, true, "scaling"},
      {"CYCL DEF 26", M::kBlockerOn, kScaling, true, "scaling"},
      {"CYCL DEF 8", M::kBlockerOn, kMirror, true, "mirror"},
      {"CYCL DEF 7", M::kBlockerOn, kShift, true, "shift of coordinates"},
      {"CYCL DEF 247", M::kBlockerOn, kUnstatedOffset, true, "sets the datum"},
      {"CYCL DEF 32", M::kHarmless, 0, true, "tolerance"},
      {"CYCL DEF", M::kHarmless, 0, true, "defines a cycle"},
      {"CYCL CALL", M::kOneShot, 0, true, "calls a cycle"},
      {"TCH PROBE", M::kOneShot, 0, true, "probing"},
      {"TRANS DATUM", M::kBlockerOn, kShift, true, "shift of coordinates"},
      {"PRESET", M::kBlockerOn, kUnstatedOffset, true, "sets the datum"},
      {"PLANE RESET", M::kBlockerOff, kTiltedPlane, true, "tilted plane off"},
      {"PLANE", M::kBlockerOn, kTiltedPlane, true, "tilted plane"},
      {"FUNCTION TCPM", M::kBlockerOn, kToolControl, true, "tool centre point control"},
      {"FUNCTION RESET TCPM", M::kBlockerOff, kToolControl, true, "tool centre point control off"},
      {"FUNCTION", M::kHarmless, 0, true, "function"},
      {"TOOL CALL", M::kToolChange, 0, true, "tool change"},
      {"TOOL DEF", M::kHarmless, 0, true, "tool"},
      {"BEGIN PGM", M::kHead, 0, true, "program"},
      {"END PGM", M::kEndOfProgram, 0, true, "end of program"},
      {"BLK FORM", M::kHarmless, 0, true, "blank"},
      {"STOP", M::kEndOfBlock, 0, false, "stop"},
      {"FMAX", M::kRapidBlock, 0, false, "rapid move"},
      {"FAUTO", M::kHarmless, 0, false, "feed of the tool"},
      {"RL", M::kBlockerOn, kCutterCompensation, false, "cutter compensation"},
      {"RR", M::kBlockerOn, kCutterCompensation, false, "cutter compensation"},
      {"IX", M::kIncrementalAddress, 'X', false, ""},
      {"IY", M::kIncrementalAddress, 'Y', false, ""},
      {"IZ", M::kIncrementalAddress, 'Z', false, ""},
      {"IA", M::kIncrementalAddress, 'A', false, ""},
      {"IB", M::kIncrementalAddress, 'B', false, ""},
      {"IC", M::kIncrementalAddress, 'C', false, ""},
      {"FN", M::kJump, 0, true, "parameters or a jump"},
  };
}

}  // namespace axiscal::nc
