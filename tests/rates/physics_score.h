// What the loop made of one machine with other physics (physics_case.h): what it named, what its errors.json leaves of
// the tool point's error over the box, and what it said about that.
#ifndef AXISCAL_TESTS_RATES_PHYSICS_SCORE_H_
#define AXISCAL_TESTS_RATES_PHYSICS_SCORE_H_

#include <string>

#include "tests/rates/physics_case.h"

namespace axiscal::rates {

struct PhysicsScore {
  // Over the box, um: what a fit of the declared errors leaves, what the loop's errors.json leaves, the same of a loop
  // that looks for nothing but the form of what is there (where it was asked for), and one who knows it exactly.
  double before_um = 0.0, after_um = 0.0, told_um = 0.0, known_um = 0.0, seconds = 0.0;
  // What would be left if nothing were held back.
  double all_um = 0.0;
  int held_back = 0;
  // What is there: effects, faults and nominal values. Named by a first name, by a member of a class, not at all; and
  // what was named that has the form of nothing that is there, local defects and slips not counted.
  int causes = 0, right = 0, in_class = 0, silent = 0, wrong = 0;
  // What the report says: the least and most (95 %) that is left over the box, and that there is a gain.
  bool has_interval = false, is_gain_held = false;
  double low_um = 0.0, high_um = 0.0;
  std::string verdict, text;

  // As a user would call it: more than 10 % and 0.2 um.
  bool IsHarmed() const { return IsWorse(after_um); }
  bool WouldBeHarmed() const { return IsWorse(all_um); }  // if nothing were held back
  bool IsWorse(double um) const { return um > 1.1 * before_um && um > before_um + 0.2; }
  bool IsIntervalRight() const { return low_um <= after_um && after_um <= high_um; }
  // All that is there by its first name and nothing beside; the same by members of classes; something else named;
  // nothing wrong, but something missing.
  const char* Verdict() const {
    return wrong > 0 ? "wrong" : silent > 0 ? "silent" : in_class > 0 ? "in class" : "right";
  }
};

PhysicsScore JudgePhysics(const PhysicsCase& physics, bool with_told);

}  // namespace axiscal::rates

#endif  // AXISCAL_TESTS_RATES_PHYSICS_SCORE_H_
