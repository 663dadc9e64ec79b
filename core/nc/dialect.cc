#include "core/nc/dialect.h"

#include "core/base/demand.h"

namespace axiscal::nc {
namespace {

// Fanuc, Mazak EIA, Haas milling and LinuxCNC where they agree. A code on which they differ is left out, and so
// refused.
std::vector<CodeEntry> FanucCodes() {
  using M = Meaning;
  return {
      {'G', 0, M::kRapid, 0, "rapid move"},
      {'G', 10, M::kLinear, 0, "linear move"},
      {'G', 20, M::kOtherMotion, 0, "circular move"},
      {'G', 30, M::kOtherMotion, 0, "circular move"},
      {'G', 22, M::kOtherMotion, 0, "involute move"},
      {'G', 32, M::kOtherMotion, 0, "involute move"},
      {'G', 40, M::kDwell, 0, "dwell"},
      {'G', 50, M::kOtherMotion, 0, "high-speed cycle or spline"},
      {'G', 51, M::kHarmless, 0, "look-ahead"},
      {'G', 61, M::kOtherMotion, 0, "splines"},
      {'G', 62, M::kOtherMotion, 0, "splines"},
      {'G', 71, M::kBlockerOn, kCylinder, "cylindrical interpolation"},
      {'G', 80, M::kHarmless, 0, "look-ahead"},
      {'G', 90, M::kHarmless, 0, "exact stop"},
      {'G', 100, M::kOneShot, 0, "data input: changes offsets"},
      {'G', 110, M::kHarmless, 0, "data input off"},
      {'G', 120, M::kOtherMotion, 0, "circular pocket"},
      {'G', 121, M::kBlockerOn, kPolar, "polar interpolation"},
      {'G', 130, M::kOtherMotion, 0, "circular pocket"},
      {'G', 131, M::kBlockerOff, kPolar, "polar interpolation off"},
      {'G', 150, M::kBlockerOff, kPolar, "polar coordinates off"},
      {'G', 160, M::kBlockerOn, kPolar, "polar coordinates"},
      {'G', 170, M::kHarmless, 0, "plane XY"},
      {'G', 180, M::kHarmless, 0, "plane ZX"},
      {'G', 190, M::kHarmless, 0, "plane YZ"},
      {'G', 200, M::kInch, 0, "inch"},
      {'G', 210, M::kMillimetre, 0, "mm"},
      {'G', 220, M::kHarmless, 0, "stored stroke check"},
      {'G', 230, M::kHarmless, 0, "stored stroke check off"},
      {'G', 270, M::kOneShot, 0, "reference return check, machine coordinates"},
      {'G', 280, M::kOneShot, 0, "reference return, machine coordinates"},
      {'G', 290, M::kOneShot, 0, "return from reference"},
      {'G', 300, M::kOneShot, 0, "reference return, machine coordinates"},
      {'G', 301, M::kOneShot, 0, "sets a reference position"},
      {'G', 281, M::kOneShot, 0, "sets a reference position"},
      {'G', 310, M::kOneShot, 0, "skip (probing) move"},
      {'G', 330, M::kOtherMotion, 0, "threading"},
      {'G', 331, M::kOtherMotion, 0, "rigid tapping"},
      {'G', 382, M::kOneShot, 0, "probing move"},
      {'G', 383, M::kOneShot, 0, "probing move"},
      {'G', 384, M::kOneShot, 0, "probing move"},
      {'G', 385, M::kOneShot, 0, "probing move"},
      {'G', 400, M::kBlockerOff, kCutterCompensation, "cutter compensation off"},
      {'G', 410, M::kBlockerOn, kCutterCompensation, "cutter compensation"},
      {'G', 411, M::kBlockerOn, kCutterCompensation, "cutter compensation"},
      {'G', 412, M::kBlockerOn, kCutterCompensation, "three-dimensional cutter compensation"},
      {'G', 420, M::kBlockerOn, kCutterCompensation, "cutter compensation"},
      {'G', 421, M::kBlockerOn, kCutterCompensation, "cutter compensation"},
      {'G', 422, M::kBlockerOn, kCutterCompensation, "three-dimensional cutter compensation"},
      {'G', 430, M::kBlockerOn, kToolLength, "tool length offset"},
      {'G', 431, M::kBlockerOn, kToolLength, "tool length offset along the tool"},
      {'G', 434, M::kBlockerOn, kToolLength, "tool centre point control"},
      {'G', 435, M::kBlockerOn, kToolLength, "tool centre point control"},
      {'G', 440, M::kBlockerOn, kToolLength, "tool length offset"},
      {'G', 490, M::kBlockerOff, kToolLength, "tool length offset off"},
      {'G', 500, M::kBlockerOff, kScaling, "scaling off, or spindle limit"},
      {'G', 501, M::kBlockerOff, kMirror, "mirror off"},
      {'G', 510, M::kBlockerOn, kScaling, "scaling"},
      {'G', 511, M::kBlockerOn, kMirror, "mirror"},
      {'G', 520, M::kBlockerOn, kShift, "local shift of coordinates"},
      {'G', 530, M::kOneShot, 0, "move in machine coordinates"},
      {'G', 531, M::kOneShot, 0, "turns the tool to the tilted plane"},
      {'G', 540, M::kWorkOffset, 0, "work offset"},
      {'G', 541, M::kWorkOffset, 0, "additional work offset"},
      {'G', 542, M::kBlockerOn, kShift, "dynamic fixture offset"},
      {'G', 544, M::kBlockerOn, kShift, "workpiece setting error"},
      {'G', 550, M::kWorkOffset, 0, "work offset"},
      {'G', 560, M::kWorkOffset, 0, "work offset"},
      {'G', 570, M::kWorkOffset, 0, "work offset"},
      {'G', 580, M::kWorkOffset, 0, "work offset"},
      {'G', 590, M::kWorkOffset, 0, "work offset"},
      {'G', 591, M::kWorkOffset, 0, "work offset"},
      {'G', 592, M::kWorkOffset, 0, "work offset"},
      {'G', 593, M::kWorkOffset, 0, "work offset"},
      {'G', 600, M::kOneShot, 0, "single-direction positioning"},
      {'G', 610, M::kHarmless, 0, "exact stop mode"},
      {'G', 611, M::kHarmless, 0, "exact path mode"},
      {'G', 640, M::kHarmless, 0, "continuous path mode"},
      {'G', 650, M::kSubprogram, 0, "macro call"},
      {'G', 660, M::kBlockerOn, kModalMacro, "modal macro call"},
      {'G', 661, M::kBlockerOn, kModalMacro, "modal macro call"},
      {'G', 670, M::kBlockerOff, kModalMacro, "modal macro call off"},
      {'G', 680, M::kBlockerOn, kTiltedPlane, "coordinate rotation"},
      {'G', 682, M::kBlockerOn, kTiltedPlane, "tilted plane"},
      {'G', 683, M::kBlockerOn, kTiltedPlane, "tilted plane"},
      {'G', 684, M::kBlockerOn, kTiltedPlane, "tilted plane"},
      {'G', 690, M::kBlockerOff, kTiltedPlane, "coordinate rotation off"},
      {'G', 730, M::kOtherMotion, 0, "canned cycle"},
      {'G', 740, M::kOtherMotion, 0, "canned cycle"},
      {'G', 750, M::kOtherMotion, 0, "canned cycle"},
      {'G', 760, M::kOtherMotion, 0, "canned cycle"},
      {'G', 770, M::kOtherMotion, 0, "canned cycle"},
      {'G', 780, M::kOtherMotion, 0, "canned cycle"},
      {'G', 790, M::kOtherMotion, 0, "canned cycle"},
      {'G', 800, M::kCancelMotion, 0, "canned cycle off"},
      {'G', 810, M::kOtherMotion, 0, "canned cycle"},
      {'G', 820, M::kOtherMotion, 0, "canned cycle"},
      {'G', 830, M::kOtherMotion, 0, "canned cycle"},
      {'G', 840, M::kOtherMotion, 0, "canned cycle"},
      {'G', 850, M::kOtherMotion, 0, "canned cycle"},
      {'G', 860, M::kOtherMotion, 0, "canned cycle"},
      {'G', 870, M::kOtherMotion, 0, "canned cycle"},
      {'G', 880, M::kOtherMotion, 0, "canned cycle"},
      {'G', 890, M::kOtherMotion, 0, "canned cycle"},
      {'G', 900, M::kAbsolute, 0, "absolute"},
      {'G', 901, M::kHarmless, 0, "arc centres absolute"},
      {'G', 910, M::kIncremental, 0, "incremental"},
      {'G', 911, M::kHarmless, 0, "arc centres incremental"},
      {'G', 920, M::kBlockerOn, kShift, "sets the coordinates of the present position"},
      {'G', 921, M::kBlockerOn, kShift, "changes the preset coordinates"},
      {'G', 922, M::kBlockerOn, kShift, "changes the preset coordinates"},
      {'G', 923, M::kBlockerOn, kShift, "changes the preset coordinates"},
      {'G', 930, M::kFeedInverseTime, 0, "inverse time feed"},
      {'G', 940, M::kFeedPerMinute, 0, "feed per minute"},
      {'G', 950, M::kFeedPerTurn, 0, "feed per turn"},
      {'G', 960, M::kHarmless, 0, "constant surface speed"},
      {'G', 970, M::kHarmless, 0, "constant spindle speed"},
      {'G', 980, M::kHarmless, 0, "return to the initial level"},
      {'G', 990, M::kHarmless, 0, "return to the R level"},
      {'M', 0, M::kEndOfBlock, 0, "stop"},
      {'M', 10, M::kEndOfBlock, 0, "optional stop"},
      {'M', 20, M::kEndOfProgram, 0, "end of program"},
      {'M', 50, M::kEndOfBlock, 0, "spindle stop"},
      {'M', 60, M::kToolChange, 0, "tool change"},
      {'M', 90, M::kEndOfBlock, 0, "coolant off"},
      {'M', 300, M::kEndOfProgram, 0, "end of program"},
      {'M', 600, M::kEndOfBlock, 0, "pallet change stop"},
      {'M', 960, M::kSubprogram, 0, "interrupt macro"},
      {'M', 970, M::kSubprogram, 0, "local subprogram call or jump"},
      {'M', 980, M::kSubprogram, 0, "subprogram call"},
      {'M', 990, M::kEndOfProgram, 0, "end of subprogram"},
      {'M', 1980, M::kSubprogram, 0, "subprogram call"},
  };
}

// A code that is not in the table: a G code is unknown, an M code moves no axis.
Dialect Make(const std::string& name, const std::vector<CodeEntry>& entries, const std::string& axis_letters,
             bool has_parenthesis_comments, char line_comment) {
  Dialect dialect{name, {}, {}, axis_letters, has_parenthesis_comments, line_comment};
  dialect.g_codes.assign(kCodes, {Meaning::kUnknown, 0, "unknown code"});
  dialect.m_codes.assign(kCodes, {Meaning::kHarmless, 0, ""});
  for (const CodeEntry& entry : entries) {
    auto& codes = entry.letter == 'G' ? dialect.g_codes : dialect.m_codes;
    codes[static_cast<size_t>(entry.tenths)] = {entry.meaning, entry.blocker, entry.text};
  }
  return dialect;
}

}  // namespace

const std::vector<Dialect>& Dialects() {
  static const std::vector<Dialect>* const dialects = new std::vector<Dialect>{
      Make("fanuc", FanucCodes(), "XYZABCUVW", true, ';'),
  };
  return *dialects;
}

const Dialect* FindDialect(const std::string& name) {
  for (const Dialect& dialect : Dialects()) {
    if (dialect.name == name) return &dialect;
  }
  return nullptr;
}

const char* BlockerText(uint16_t blockers) {
  DEMAND(blockers != 0);
  if (blockers & kCutterCompensation) return "cutter compensation is active";
  if (blockers & kToolLength) return "a tool length offset or tool centre point control is active";
  if (blockers & kTiltedPlane) return "a rotated or tilted plane is active";
  if (blockers & kShift) return "a shift of coordinates is active";
  if (blockers & kScaling) return "scaling is active";
  if (blockers & kMirror) return "mirroring is active";
  if (blockers & kPolar) return "polar coordinates are active";
  if (blockers & kModalMacro) return "a modal macro call is active";
  if (blockers & kCylinder) return "cylindrical interpolation is active";
  return "a work offset is active whose values are not stated";
}

}  // namespace axiscal::nc
