#include "core/nc/dialect.h"

#include <cstring>

#include "core/base/demand.h"
#include "core/nc/dialect_tables.h"

namespace axiscal::nc {
namespace {

void AddCodes(const std::vector<CodeEntry>& entries, Dialect* dialect) {
  for (const CodeEntry& entry : entries) {
    auto& codes = entry.letter == 'G' ? dialect->g_codes : dialect->m_codes;
    codes[static_cast<size_t>(entry.tenths)] = {entry.meaning, entry.detail, entry.text};
  }
}

void SetRole(const char* letters, Role role, Dialect* dialect) {
  for (; *letters != 0; ++letters) dialect->roles[static_cast<size_t>(*letters - 'A')] = role;
}

// A code that is not in the table is unknown: a G code might move axes, an M code of the machine's builder too.
Dialect Make(const std::string& name, std::initializer_list<std::vector<CodeEntry>> codes,
             std::initializer_list<std::vector<Keyword>> keywords) {
  Dialect dialect;
  dialect.name = name;
  dialect.g_codes.assign(kCodes, {Meaning::kUnknown, 0, "unknown code"});
  dialect.m_codes.assign(kCodes, {Meaning::kUnknown, 0, "unknown code"});
  for (const auto& table : codes) AddCodes(table, &dialect);
  for (const auto& table : keywords) dialect.keywords.insert(dialect.keywords.end(), table.begin(), table.end());
  for (const Keyword& keyword : dialect.keywords) {
    dialect.keyword_codes.push_back({keyword.meaning, keyword.detail, keyword.text});
    if (keyword.name[0] != ',') dialect.keyword_letters |= 1u << (keyword.name[0] - 'A');
  }
  dialect.roles.fill(Role::kParameter);
  SetRole("XYZABCUVW", Role::kAxis, &dialect);
  SetRole("GM", Role::kCode, &dialect);
  SetRole("S", Role::kPassive, &dialect);
  SetRole("IJK", Role::kCentre, &dialect);
  SetRole("N", Role::kLineNumber, &dialect);
  SetRole("O", Role::kProgramNumber, &dialect);
  SetRole("F", Role::kFeed, &dialect);
  SetRole("T", Role::kToolNumber, &dialect);
  SetRole("H", Role::kToolLength, &dialect);
  SetRole("D", Role::kToolRadius, &dialect);
  SetRole("R", Role::kRadius, &dialect);
  return dialect;
}

Dialect Fanuc(const std::string& name) {
  Dialect dialect = Make(name, {IsoCodes(), FanucCodes(), FanucM()}, {MacroKeywords(), FanucCorners()});
  dialect.has_angle_names = true;
  dialect.has_semicolon_ends = true;
  // B-64484EN, "Linear interpolation (G01)": the feed of a linear and a rotary axis is the tangential one in their
  // plane, 40 deg taken as 40 mm.
  dialect.feeds_all_axes = true;
  dialect.cycles_keep_motion = true;
  dialect.packs_repeats = true;       // the same, "Subprogram (M98, M99)"
  dialect.numbered_offset = "G54.1";  // the same, "Workpiece coordinate system": G10 L20
  dialect.additional_offsets = 300;
  dialect.integers_may_be_increments = dialect.tools_may_switch_offsets = true;
  return dialect;
}

Dialect Haas() {
  Dialect dialect = Make("haas", {IsoCodes(), FanucCodes(), HaasCodes(), HaasM()}, {MacroKeywords(), FanucCorners()});
  dialect.has_semicolon_ends = true;
  dialect.integers_may_be_increments = dialect.tools_may_switch_offsets = true;
  dialect.cycles_keep_motion = true;  // the same manual, "G80": group 09, G00 and G01 are of group 01
  dialect.lengths_along_z = true;     // Mill Operator's Manual 96-8200, "G43": the Z axis
  dialect.numbered_offset = "G154";
  dialect.additional_offsets = 99;
  return dialect;
}

Dialect LinuxCnc() {
  Dialect dialect = Make("linuxcnc", {IsoCodes(), LinuxCncCodes(), LinuxCncM()}, {MacroKeywords(), LinuxCncKeywords()});
  dialect.takes_loaded_tool = true;
  dialect.lengths_along_z = true;  // LinuxCNC 2.9, "G43 Tool Length Offset": what the tool table states of Z
  dialect.plain_offsets = 9;       // G59.1 to G59.3 are P7 to P9
  // LinuxCNC 2.9, LINELEN of its interpreter: 255 with the line end, the final NUL and one byte that stays free.
  dialect.max_block_bytes = 253;
  // The least CENTER_ARC_RADIUS_TOLERANCE_MM that a machine's ini file may state (rs274 of 2.9); 0.028 mm unless it
  // does.
  dialect.arc_radius_tolerance_mm = 0.00127;
  dialect.takes_finer_words = true;
  return dialect;
}

Dialect Sinumerik() {
  Dialect dialect = Make("sinumerik", {IsoCodes(), SinumerikCodes(), SinumerikM()}, {SinumerikKeywords()});
  dialect.has_parenthesis_comments = false;
  dialect.has_equals = true;
  dialect.distance_names = SinumerikDistances();
  dialect.takes_finer_words = true;
  dialect.g91_takes_new_offsets = true;
  dialect.transformation_may_drop_offset = true;
  dialect.max_block_bytes = 512;  // 840D sl, Programming Manual Fundamentals, "Block length": comment and LF included
  dialect.variable = 'R';
  dialect.first_offset = "";
  SetRole("D", Role::kActiveToolLength, &dialect);
  SetRole("HOLR", Role::kParameter, &dialect);  // R is a variable
  SetRole("Q", Role::kRadius, &dialect);        // stands for CR
  dialect.radius_address = "CR=";
  dialect.vector_addresses = {"A3=", "B3=", "C3="};
  return dialect;
}

Dialect Heidenhain() {
  Dialect dialect = Make("heidenhain", {KlartextCodes(), KlartextM()}, {KlartextKeywords()});
  dialect.has_parenthesis_comments = false;
  dialect.line_comment2 = '*';
  dialect.variable = 'Q';
  dialect.has_assignment_blocks = true;
  dialect.has_bare_keywords = true;
  dialect.has_poles = true;
  dialect.tool_call_sets_length = true;
  dialect.first_offset = "PRESET";
  dialect.piece_prefix = "L ";
  dialect.vector_addresses = {"TX", "TY", "TZ"};
  dialect.writes_plus = true;
  SetRole("GNOHTDIJK", Role::kParameter, &dialect);
  SetRole("R", Role::kRadiusCompensation, &dialect);
  SetRole("Q", Role::kRadius, &dialect);  // stands for the R of CR
  return dialect;
}

}  // namespace

const std::vector<Dialect>& Dialects() {
  static const std::vector<Dialect>* const dialects = new std::vector<Dialect>{
      Fanuc("fanuc"), Fanuc("mazak"), Haas(), LinuxCnc(), Sinumerik(), Heidenhain(),
  };
  return *dialects;
}

const Dialect* FindDialect(const std::string& name) {
  for (const Dialect& dialect : Dialects()) {
    if (dialect.name == name) return &dialect;
  }
  return nullptr;
}

const char* BlockerText(uint32_t blockers) {
  static constexpr struct {
    uint32_t blockers;
    const char* text;
  } kTexts[] = {
      {kCutterCompensation, "cutter compensation is active"},
      {kToolControl | kToolControlFunction, "tool centre point control is active"},
      {kTiltCorrection | kTiltedKinematics, "a correction for tilting axes is active"},
      {kUnstatedLength, "a tool length is active that is not stated"},
      {kTiltedPlane | kRotation | kWorkpieceRotation | kSwivel | kWorkingPlane, "a rotated or tilted plane is active"},
      {kFrame, "a programmable frame (TRANS, ROT, SCALE, MIRROR) is active"},
      {kShift | kDynamicOffset | kDatumShift, "a shift of coordinates of unknown size is active"},
      {kScaling, "scaling is active"},
      {kMirror, "mirroring is active"},
      {kPolar | kPolarInterpolation, "polar coordinates are active"},
      {kModalMacro, "a modal macro call is active"},
      {kCylinder, "cylindrical interpolation is active"},
      {kDiameter, "words are diameters"},
      {kNormalDirection, "normal direction control is active"},
      {kKinematics, "another kinematic transformation may be active"},
      {kUnfollowedMode, "a function is active that is not followed"},
      {kTurretOffset,
       "a tool offset of a lathe may be active, which a T word of three digits or more switches (T0101), and no M06 in "
       "front of it says that it is a mill's tool alone; its values cannot be stated"},
      {kUnstatedOffset, "a work offset is active whose values are not stated"},
  };
  DEMAND(blockers != 0);
  for (const auto& known : kTexts) {
    if (blockers & known.blockers) return known.text;
  }
  return "a mode is active that is not followed";
}

}  // namespace axiscal::nc
