// What a set of tests tells of the unknowns that were asked about, and which set to choose: the smallest that
// determines them beside all other unknowns; of equal size the one with the least determinant of their covariance
// (D_s-optimal: D-optimal for a subset of the unknowns; Atkinson, Donev and Tobias, Optimum Experimental Designs, 2007,
// ch. 10).
#ifndef AXISCAL_CORE_INFORMATION_CHOICE_H_
#define AXISCAL_CORE_INFORMATION_CHOICE_H_

#include <vector>

#include "core/information/information.h"

namespace axiscal::information {

// Of one test, or of what is measured already; all that are put together are about the same unknowns.
struct TestInformation {
  Information identifying;  // what the readings themselves say: decides what is determined
  Information informing;    // with all that is stated beforehand (priors): what uncertainties are computed from

  TestInformation& operator+=(const TestInformation& other) {
    identifying += other.identifying;
    informing += other.informing;
    return *this;
  }
};

struct Told {
  std::vector<bool> is_determined;  // per asked unknown: it has a value of its own beside all others
  std::vector<double> sigma;        // per asked unknown, mm or rad: expected standard uncertainty; NaN: not determined
  int determined_count = 0;
  double log_determinant = 0.0;  // of the covariance of the determined ones, um and urad; 0 of none

  bool TellsLessThan(const Told& other) const { return determined_count < other.determined_count; }
  bool IsBetterThan(const Told& other) const;
  std::vector<int> Undetermined() const;  // indices into what was asked
};

// `asked`: indices of unknowns.
Told Tell(const TestInformation& together, const std::vector<int>& asked);

struct Choice {
  std::vector<int> tests;  // indices; none where no test determines anything that was asked
  Told told;
};

// Where all tests together do not determine some of `asked`, the rest is what the set must determine.
Choice ChooseTests(const std::vector<TestInformation>& tests, const std::vector<int>& asked);

}  // namespace axiscal::information

#endif  // AXISCAL_CORE_INFORMATION_CHOICE_H_
