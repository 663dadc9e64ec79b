// X and C, or Y and C, moved together against a ball bar (Jiang, Yao, Liu, running head Chang, 2019).
#ifndef AXISCAL_TESTS_KNOWN_ANSWERS_CHANG_LINKED_H_
#define AXISCAL_TESTS_KNOWN_ANSWERS_CHANG_LINKED_H_

#include <algorithm>

#include "absl/strings/str_cat.h"
#include "core/base/demand.h"
#include "core/plan/test.h"
#include "tests/known_answers/published_machine.h"

namespace axiscal::known_answers::linked {

inline constexpr double kBarMm = 150, kRadiusMm = 100;

inline const machine::Machine& Machine() {
  static const auto& machine = *new machine::Machine(PublishedMachine("chang-linked/machine.json"));
  return machine;
}

// The registry's test with the balls as published: at t = 0 the table ball R from C and the spindle ball R + R_e, both
// `height_mm` above C's point, along `axis` (X or Y). `mounted_sigma_um`: how well balls and bar are known, where they
// are.
inline session::Session Planned(char axis, double height_mm, std::optional<double> mounted_sigma_um) {
  const Eigen::Vector3d along = axis == 'X' ? Eigen::Vector3d::UnitX() : Eigen::Vector3d::UnitY();
  plan::Mounted mounted;
  mounted.tips_mm = {(kRadiusMm + kBarMm) * along + height_mm * Eigen::Vector3d::UnitZ()};
  mounted.balls_mm = {kRadiusMm * along + height_mm * Eigen::Vector3d::UnitZ()};
  mounted.bars_mm = {kBarMm};
  const std::string name = absl::StrCat(std::string(1, axis), "C-linked-", height_mm);
  for (plan::PlannedSession& planned :
       plan::FindTest("ballbar-linked")->plan(plan::SituationOfMachine(Machine(), mounted))) {
    session::Session& session = planned.session;
    if (session::FindHeader(session, "session") != name) continue;
    for (const char* key : {"ball_x", "ball_y", "ball_z", "run_out_x", "run_out_y", "bar_length"}) {
      if (mounted_sigma_um) session.header.push_back({absl::StrCat(key, "_sigma_um"), absl::StrCat(*mounted_sigma_um)});
    }
    return std::move(session);
  }
  DEMAND(false);
}

}  // namespace axiscal::known_answers::linked

#endif  // AXISCAL_TESTS_KNOWN_ANSWERS_CHANG_LINKED_H_
