// Codes and words of LinuxCNC 2.9 (RS274/NGC) where they differ from the ISO family.
#include "core/nc/dialect_tables.h"

namespace axiscal::nc {

std::vector<CodeEntry> LinuxCncCodes() {
  using M = Meaning;
  std::vector<CodeEntry> codes = {
      {'G', 50, M::kOtherMotion, 0, "spline"},
      {'G', 51, M::kOtherMotion, 0, "spline"},
      {'G', 52, M::kOtherMotion, 0, "NURBS"},
      {'G', 53, M::kOtherMotion, 0, "NURBS"},
      {'G', 62, M::kOtherMotion, 0, "NURBS"},
      {'G', 70, M::kBlockerOn, kDiameter, "diameter programming"},
      {'G', 80, M::kBlockerOff, kDiameter, "diameter programming off"},
      {'G', 100, M::kDataInput, kWorkOffsetInput, "data input: changes offsets"},
      {'G', 171, M::kUnknown, 0, "plane UV"},
      {'G', 181, M::kUnknown, 0, "plane WU"},
      {'G', 191, M::kUnknown, 0, "plane VW"},
      {'G', 200, M::kInch, 0, "inch"},
      {'G', 210, M::kMillimetre, 0, "mm"},
      {'G', 280, M::kMachineMove, 0, "reference return, machine coordinates"},
      {'G', 281, M::kHarmless, 0, "stores the reference position"},
      {'G', 300, M::kMachineMove, 0, "reference return, machine coordinates"},
      {'G', 301, M::kHarmless, 0, "stores the reference position"},
      {'G', 330, M::kOneShot, 0, "spindle-synchronised move"},
      {'G', 331, M::kOneShot, 0, "rigid tapping"},
      {'G', 382, M::kOneShot, 0, "probing move"},
      {'G', 383, M::kOneShot, 0, "probing move"},
      {'G', 384, M::kOneShot, 0, "probing move"},
      {'G', 385, M::kOneShot, 0, "probing move"},
      {'G', 411, M::kBlockerOn, kCutterCompensation, "cutter compensation"},
      {'G', 421, M::kBlockerOn, kCutterCompensation, "cutter compensation"},
      {'G', 430, M::kToolLength, 1, "tool length offset"},
      // Their axis words are the offset, and move nothing.
      {'G', 431, M::kBlockerOn, kToolControl | kDynamicOffset, "dynamic tool length offset"},
      {'G', 432, M::kBlockerOn, kToolControl | kDynamicOffset, "additional tool length offset"},
      {'G', 490, M::kNoToolLength, kDynamicOffset, "tool length offset off"},
      {'G', 520, M::kLocalShift, 0, "local shift of coordinates"},
      {'G', 580, M::kWorkOffset, 0, "work offset"},
      {'G', 590, M::kWorkOffset, 0, "work offset"},
      {'G', 591, M::kWorkOffset, 0, "work offset"},
      {'G', 592, M::kWorkOffset, 0, "work offset"},
      {'G', 593, M::kWorkOffset, 0, "work offset"},
      {'G', 610, M::kHarmless, 0, "exact path mode"},
      {'G', 611, M::kHarmless, 0, "exact stop mode"},
      {'G', 640, M::kHarmless, 0, "path blending"},
      {'G', 800, M::kCancelMotion, 0, "canned cycle off"},
      {'G', 901, M::kCentreAbsolute, 0, "arc centres absolute"},
      {'G', 911, M::kCentreIncremental, 0, "arc centres incremental"},
      {'G', 920, M::kPreset, 0, "sets the coordinates of the present position"},
      {'G', 921, M::kPreset, 1, "preset coordinates off"},
      {'G', 922, M::kPreset, 2, "preset coordinates suspended"},
      {'G', 923, M::kPreset, 3, "preset coordinates restored"},
      {'G', 980, M::kReturnLevel, 0, "return to the initial level"},
      {'G', 990, M::kReturnLevel, 1, "return to the R level"},
      {'M', 4280, M::kBlockerOn, kKinematics, "switches the kinematics"},
      {'M', 4290, M::kBlockerOn, kKinematics, "switches the kinematics"},
      {'M', 4300, M::kBlockerOn, kKinematics, "switches the kinematics"},
      {'M', 720, M::kCall, 1, "restores the modal state"},
      {'M', 980, M::kCall, 0, "subprogram call"},
      {'M', 990, M::kEndOfProgram, 1, "end of subprogram"},
  };
  for (const int cycle : {87, 88}) {
    codes.push_back({'G', 10 * cycle, M::kOtherMotion, 0, "boring cycle that LinuxCNC does not run"});
  }
  for (const int cycle : {70, 71, 72, 76}) {
    codes.push_back({'G', 10 * cycle, M::kOtherMotion, 0, "canned cycle"});
  }
  for (const int cycle : {73, 74, 81, 82, 83, 84, 85, 86, 89}) {
    codes.push_back({'G', 10 * cycle, M::kDrillCycle, kCycleRepeatsL, "canned cycle"});
  }
  return codes;
}

// Behind an O word.
std::vector<Keyword> LinuxCncKeywords() {
  using M = Meaning;
  return {
      {"SUB", M::kJump, 0, true, "subprogram"},       {"ENDSUB", M::kJump, 0, true, "end of a subprogram"},
      {"CALL", M::kCall, 0, true, "subprogram call"}, {"RETURN", M::kJump, 0, true, "return"},
      {"ELSEIF", M::kJump, 0, true, "condition"},     {"ELSE", M::kJump, 0, true, "condition"},
      {"ENDIF", M::kJump, 0, true, "condition"},      {"ENDWHILE", M::kJump, 0, true, "loop"},
      {"REPEAT", M::kJump, 0, true, "loop"},          {"ENDREPEAT", M::kJump, 0, true, "loop"},
      {"BREAK", M::kJump, 0, true, "loop"},           {"CONTINUE", M::kJump, 0, true, "loop"},
  };
}

}  // namespace axiscal::nc
