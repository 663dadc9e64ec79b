// What the words of one block ask for, before anything is done. Private to the interpreter.
#ifndef AXISCAL_CORE_NC_REQUEST_H_
#define AXISCAL_CORE_NC_REQUEST_H_

#include <array>
#include <string>

#include "core/nc/interpreter.h"

namespace axiscal::nc {

std::string WordText(const Word& word);
// The rest of a block behind a keyword: capitals, one blank between words, no comment.
std::string RestOf(const char* begin, const char* end);

struct Interpreter::Request {
  const Code* motion = nullptr;
  const Code* distance = nullptr;  // G90, G91
  const Code* unit = nullptr;      // G20, G21
  const Code* feed = nullptr;      // G93 to G95
  const Code* plane = nullptr;
  const Code* sense = nullptr;  // DR+, DR-
  const Code* machine_move = nullptr;
  const Code* preset = nullptr;       // G92
  const Code* scaling_off = nullptr;  // G50
  const Code* mirror_on = nullptr;
  const Code* mirror_off = nullptr;
  const Code* shift = nullptr;          // G52
  const Code* owner = nullptr;          // whose words axis words are (G22, G50.1)
  const Code* length = nullptr;         // G43, G44
  const Code* cutter_side = nullptr;    // G41, G42
  const Word* radius_number = nullptr;  // D
  int8_t cutter_side_before = 0;
  const Code* tool_point = nullptr;
  const Word* tool_point_word = nullptr;
  const Code* frame = nullptr;  // G68, G68.2, G51, G51.1, G254
  const Word* frame_word = nullptr;
  std::shared_ptr<const WordFrame> word_frame_before;
  const Code* turn_to_plane = nullptr;  // G53.1
  const Code* by_rest = nullptr;
  const Word* by_rest_word = nullptr;
  const Code* data_input = nullptr;  // G10
  const Code* cycle_call = nullptr;
  const Word* cycle_call_word = nullptr;
  uint32_t tool_point_before = 0;
  int length_before = -1;
  const Word* length_number = nullptr;
  const Word* offset = nullptr;  // G54
  const Code* offset_code = nullptr;
  const Word* speed_mode = nullptr;  // G5
  std::string problem;               // first reason to refuse
  uint32_t blockers_before = 0;
  uint8_t uncertain_before = 0;
  uint8_t stated = 0;  // modal groups that this block states
  bool has_axis = false;
  bool has_code = false;
  bool has_centre = false;
  // Of I, J and K, and of the tool's direction: the words, nullptr: none.
  std::array<const Word*, 3> centre{}, vector{};
  bool has_normal = false;
  bool has_feed = false;
  bool has_two_offsets = false;
  bool is_whole = true;  // read to its end
  const Word* radius = nullptr;
  const char* away = nullptr;      // what takes the axes away and back in this block: a tool change, a pallet change
  bool goes_away_behind = false;   // behind the block's own move
  bool changes_pallet = false;     // or turns axes home: none stands where it stood, whatever a tool change keeps
  bool may_switch_offset = false;  // T0101
  bool is_dwell = false;
  bool is_end = false;
  bool is_subprogram_end = false;
  bool is_call = false;
  bool is_local_call = false;  // M97
  bool is_jump = false;
  bool is_rapid_block = false;
  bool departs = false;     // DEP LT, LN, CT
  bool is_pole = false;     // CC
  bool has_corner = false;  // RND=
  char foreign_axis = 0;
  char parameter = 0;
  const Word* number_of_parameter = nullptr;  // P

  // APPR, DEP LCT.
  bool IsOfContour(uint32_t detail) const {
    return motion != nullptr && motion->meaning == Meaning::kLinear && motion->detail == detail;
  }
  bool HasVector() const { return vector[0] != nullptr || vector[1] != nullptr || vector[2] != nullptr; }
  void Refuse(const std::string& reason) {
    if (problem.empty()) problem = reason;
  }
  // Controllers differ: the last of two counts for the block, or each for the words behind it (G90 X5. G91 Y1.).
  void Choose(const Code** chosen, const Code& code, const char* what) {
    if (*chosen != nullptr && (*chosen)->meaning != code.meaning)
      Refuse(absl::StrCat("two different ", what, " codes in one block"));
    *chosen = &code;
  }
};

}  // namespace axiscal::nc

#endif  // AXISCAL_CORE_NC_REQUEST_H_
