// Pairs of cubes on a swivel head's and a double head's machine (Liu, Li, Wang): where they are touched, pattern by
// pattern. mm and deg.
#ifndef AXISCAL_TESTS_KNOWN_ANSWERS_LIU_BLOCKS_H_
#define AXISCAL_TESTS_KNOWN_ANSWERS_LIU_BLOCKS_H_

#include "tests/known_answers/published_machine.h"
#include "tests/known_answers/touch_session.h"

namespace axiscal::known_answers::blocks {

inline constexpr double kPairMm = 30, kCubeMm = 10;          // centres at +-30 on x and on y
inline constexpr double kHeadMm = 202.684, kDoubleMm = 200;  // pivot to stylus centre

inline const machine::Machine& SwivelHead() {
  static const auto& machine = *new machine::Machine(PublishedMachine("liu-blocks/swivel-head/machine.json"));
  return machine;
}
inline const machine::Machine& DoubleHead() {
  static const auto& machine = *new machine::Machine(PublishedMachine("liu-blocks/double-head/machine.json"));
  return machine;
}

// Outer faces of the pairs at the height of the cubes' centres, and the cubes' tops; `height_mm` of the centres.
inline Face FaceOf(const std::string& name, double height_mm) {
  const double sign = name[1] == '+' ? 1.0 : -1.0;
  const Eigen::Vector3d along = sign * Eigen::Vector3d::Unit(name[0] == 'x' ? 0 : 1), z = Eigen::Vector3d::UnitZ();
  if (name.size() > 2) return {kPairMm * along + (height_mm + kCubeMm / 2) * z, z};  // "x+top"
  return {(kPairMm + kCubeMm / 2) * along + height_mm * z, along};
}

struct Pattern {
  std::string what;  // 'x' or 'y': the pair whose outer faces are touched; "xtop", "ytop": its tops
  std::map<std::string, double> rotary_deg;
};

// Every pattern's touches as a session. `place_sigma_um`: how well the cubes' place in machine coordinates is known.
inline session::Session Touches(const machine::Machine& machine, const std::string& name, double tool_mm,
                                const std::vector<Pattern>& patterns, std::optional<double> place_sigma_um,
                                const Eigen::Vector3d& placed_mm = Eigen::Vector3d::Zero()) {
  constexpr double kStylusMm = 3.0, kSigmaUm = 0.5, kHeightMm = 30.0, kAsideMm = 3.0;
  TouchSession session(machine, name, {0, 0, -tool_mm}, kStylusMm, kSigmaUm);
  for (const char* face : {"x+", "x-", "y+", "y-", "x+top", "x-top", "y+top", "y-top"}) {
    Face placed = FaceOf(face, kHeightMm);
    placed.point_mm += placed_mm;
    session.AddFace(face, placed);
  }
  if (place_sigma_um) {
    for (const char* key : {"artefact_x_sigma_um", "artefact_y_sigma_um", "artefact_z_sigma_um"})
      session.Header(key, absl::StrCat(*place_sigma_um));
    for (const char* key : {"artefact_a_sigma_urad", "artefact_b_sigma_urad", "artefact_c_sigma_urad"})
      session.Header(key, absl::StrCat(10.0 * *place_sigma_um));
  }
  for (const Pattern& pattern : patterns) {
    // Two touches a face, aside of its middle: a cube's turn is its own, and not taken for an error.
    const Eigen::Vector3d aside_mm = kAsideMm * Eigen::Vector3d::Unit(pattern.what[0] == 'x' ? 1 : 0);
    for (const char* side : {"+", "-"}) {
      for (const double sign : {-1.0, 1.0})
        session.Touch(pattern.what.substr(0, 1) + side + pattern.what.substr(1), pattern.rotary_deg, sign * aside_mm);
    }
  }
  return session.planned();
}

// Patterns 1, 2-a, 2-b, 2-c, 3 of the head (3-1 to 3-5).
inline std::vector<Pattern> HeadPatterns() {
  return {{"x", {{"B", 0}}}, {"y", {{"B", 0}}}, {"x", {{"B", -90}}}, {"y", {{"B", -90}}}, {"y", {{"B", -30}}}};
}
// The table's sums and differences (3-6 to 3-9) at four angles of C.
inline std::vector<Pattern> TablePatterns() {
  std::vector<Pattern> patterns;
  for (const double c_deg : {0.0, 90.0, 180.0, 270.0}) {
    for (const char* what : {"xtop", "y", "x", "ytop"}) patterns.push_back({what, {{"C", c_deg}}});
  }
  return patterns;
}
// Patterns 1, 2-a, 2-b, 2-c, 2-d, 2-e, 3 of the double head (4-3 to 4-9).
inline std::vector<Pattern> DoubleHeadPatterns() {
  return {{"x", {{"B", 0}, {"A", 0}}},   {"y", {{"B", 0}, {"A", 0}}},   {"x", {{"B", -90}, {"A", 0}}},
          {"y", {{"B", -90}, {"A", 0}}}, {"x", {{"B", 0}, {"A", -90}}}, {"y", {{"B", 0}, {"A", -90}}},
          {"x", {{"B", -30}, {"A", 0}}}};
}

}  // namespace axiscal::known_answers::blocks

#endif  // AXISCAL_TESTS_KNOWN_ANSWERS_LIU_BLOCKS_H_
