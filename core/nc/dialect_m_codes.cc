// M codes that start nothing and move no axis, by dialect, each list from the manual that it names. Every other M code
// is a machine builder's: it may start a macro, a subprogram or a movement, and is refused unless
// RewriteOptions::harmless_m states it. Codes whose effect waits for the end of their block are kEndOfBlock.
#include <initializer_list>

#include "core/nc/dialect_tables.h"

namespace axiscal::nc {
namespace {

void AddM(std::initializer_list<int> codes, const char* text, std::vector<CodeEntry>* entries,
         Meaning meaning = Meaning::kHarmless, uint32_t detail = 0) {
  for (const int code : codes) entries->push_back({'M', 10 * code, meaning, detail, text});
}

// ISO 6983-1 and DIN 66025-2, table of M functions, as far as controls follow it.
std::vector<CodeEntry> IsoHarmless() {
  std::vector<CodeEntry> entries;
  AddM({3, 4}, "spindle on", &entries);
  AddM({7, 8}, "coolant on", &entries);
  AddM({13, 14}, "spindle and coolant on", &entries);
  AddM({19}, "oriented spindle stop", &entries, Meaning::kEndOfBlock);
  AddM({10, 11}, "clamp", &entries, Meaning::kEndOfBlock);
  AddM({40, 41, 42, 43, 44, 45}, "gear", &entries);
  AddM({48, 49}, "overrides", &entries);
  return entries;
}

}  // namespace

// Fanuc Series 30i/31i/32i, Operator's Manual B-64484EN, "Auxiliary function" and "Rigid tapping"; the rest as ISO
// 6983-1 has it. Mazak EIA the same.
std::vector<CodeEntry> FanucM() {
  std::vector<CodeEntry> entries = IsoHarmless();
  AddM({29}, "rigid tapping mode", &entries);
  // ISO 6983-1: workpiece change. The pallet changer takes the axes to its own positions.
  AddM({60}, "pallet change", &entries, Meaning::kAxesAway);
  return entries;
}

// Haas, Mill Operator's Manual 96-8200, "M-codes".
std::vector<CodeEntry> HaasM() {
  std::vector<CodeEntry> entries;
  AddM({3, 4}, "spindle on", &entries);
  AddM({7, 8}, "coolant on", &entries);
  AddM({10, 11, 12, 13}, "brake of a rotary axis", &entries, Meaning::kEndOfBlock);
  AddM({19}, "spindle orientation", &entries, Meaning::kEndOfBlock, kReadsNumber);
  AddM({31, 33}, "chip conveyor", &entries);
  AddM({34, 35}, "coolant spigot", &entries);
  AddM({41, 42}, "gear", &entries);
  AddM({59, 69}, "output", &entries, Meaning::kHarmless, kReadsNumber);
  AddM({83, 84}, "air", &entries);
  AddM({88, 89}, "coolant through the spindle", &entries);
  AddM({138, 139}, "spindle speed variation", &entries);
  AddM({16}, "tool change", &entries, Meaning::kToolChange);
  AddM({50, 60}, "pallet change", &entries, Meaning::kAxesAway);
  AddM({46}, "jump while a pallet is loaded", &entries, Meaning::kJump);
  return entries;
}

// LinuxCNC 2.9, "M-codes". M100 to M199 run programs of the user.
std::vector<CodeEntry> LinuxCncM() {
  std::vector<CodeEntry> entries;
  AddM({3, 4}, "spindle on", &entries);
  AddM({7, 8}, "coolant on", &entries);
  AddM({19}, "spindle orientation", &entries, Meaning::kEndOfBlock, kReadsNumber);
  AddM({48, 49}, "overrides", &entries);
  AddM({50, 51, 52, 53}, "overrides", &entries, Meaning::kHarmless, kReadsNumber);
  AddM({61}, "number of the tool in the spindle", &entries);
  AddM({62, 63, 64, 65}, "output", &entries, Meaning::kHarmless, kReadsNumber);
  AddM({67, 68}, "output", &entries);
  AddM({66}, "waits for an input", &entries, Meaning::kEndOfBlock, kReadsNumber);
  AddM({70, 71, 73}, "saves the modal state", &entries);
  AddM({60}, "pallet change", &entries, Meaning::kAxesAway);
  return entries;
}

// Siemens SINUMERIK 840D sl, Programming Manual Fundamentals, "M functions"; coolant and clamps as DIN 66025-2 has
// them.
std::vector<CodeEntry> SinumerikM() { return IsoHarmless(); }

// HEIDENHAIN TNC 640, User's Manual for Klartext Programming, "Miscellaneous functions"; M90 and M134 to M150 also of
// the iTNC 530.
std::vector<CodeEntry> KlartextM() {
  std::vector<CodeEntry> entries;
  AddM({3, 4}, "spindle on", &entries);
  AddM({8}, "coolant on", &entries);
  AddM({13, 14}, "spindle and coolant on", &entries);
  AddM({90}, "speed at corners", &entries);
  AddM({102}, "no automatic tool change", &entries);
  AddM({107, 108}, "check of replacement tools", &entries);
  AddM({109, 110, 111}, "feed at arcs", &entries);
  AddM({116, 117}, "feed of rotary axes", &entries);
  AddM({127}, "rotary axes go as they count", &entries, Meaning::kShorterWay);
  AddM({126}, "rotary axes go the shorter way", &entries, Meaning::kShorterWay);
  entries.back().detail = 1;
  AddM({134, 135}, "exact stop", &entries);
  AddM({141}, "check of the touch probe", &entries);
  AddM({148, 149}, "lift off at a stop", &entries);
  AddM({150}, "limit switch message", &entries);
  AddM({89}, "calls a cycle behind each move", &entries, Meaning::kBlockerOn);
  entries.back().detail = kModalMacro;
  return entries;
}

}  // namespace axiscal::nc
