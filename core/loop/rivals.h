// Effects that compete for one signature: the fitted one and others in its place, each as it would be fitted to what
// the first one does; what the sessions say of them.
#ifndef AXISCAL_CORE_LOOP_RIVALS_H_
#define AXISCAL_CORE_LOOP_RIVALS_H_

#include <vector>

#include "core/loop/candidate.h"
#include "core/loop/separation.h"
#include "core/loop/test_rows.h"

namespace axiscal::loop {

class Rivals {
 public:
  // `terms`: the first is a term of the point's model, with its amplitude; the others are not in the model.
  Rivals(const identify::Problem& problem, const identify::Point& point, std::vector<machine::ErrorTerm> terms);

  int count() const { return static_cast<int>(terms_.size()); }
  const machine::ErrorTerm& term(int rival) const { return terms_[rival]; }
  const std::vector<Member>& members() const { return members_; }
  const Information& information() const { return information_; }
  // Of another session with its own setup; its rows are at the point's model.
  Information InformationOfTest(const TestRows& test) const { return test.InformationOf(point_.model); }

 private:
  void FitAmplitudes(const identify::Problem& problem);

  identify::Point point_;
  std::vector<machine::ErrorTerm> terms_;
  std::vector<identify::Parameter> parameters_;
  std::vector<Member> members_;
  Information information_;
};

// Terms that would explain most of what the first of `known` does in the sessions (correlation above `near`): the plain
// shapes of each axis, the harmonics of the effect's axis and the same shape elsewhere in the machine. A proposed
// session should tell the effect from these too. Without `known` itself; at most sixteen, no two of which are
// always the same effect.
std::vector<machine::ErrorTerm> NeighboursOf(const identify::Problem& problem, const identify::Point& point,
                                             const std::vector<machine::ErrorTerm>& known, double near);

}  // namespace axiscal::loop

#endif  // AXISCAL_CORE_LOOP_RIVALS_H_
