// Which session would tell apart the effects that this data cannot (docs/loop.md, "Steps", 7): the tests that the
// product knows for the machine (core/plan) are judged beforehand, by the information that they would add.
#ifndef AXISCAL_CORE_LOOP_NEXT_MEASUREMENT_H_
#define AXISCAL_CORE_LOOP_NEXT_MEASUREMENT_H_

#include <memory>
#include <string>
#include <vector>

#include "core/identify/problem.h"
#include "core/session/session.h"

namespace axiscal::loop {

// One session to measure next. Sessions of one effect build on each other: the second is judged with the first
// measured.
struct Proposal {
  machine::ErrorTerm effect;
  std::vector<machine::ErrorTerm> separates;  // members of the class that only this session tells from another one
  std::vector<machine::ErrorTerm> remaining;  // what the effect is still not told from afterwards
  std::vector<machine::ErrorTerm>
      same_always;           // the same effect by another name: no measurement of any kind tells them
  std::string test;          // core/plan's registry; empty: no known test separates anything more
  session::Session session;  // planned, without readings
  std::string text;          // what to do, one line
  std::string beyond;        // where it leaves the range of the linear axes so far
  bool needs_next = false;   // tells nothing alone: what stands here is what the next session tells
  // The largest canonical correlation of two members that it tells apart, everything else that is fitted projected off.
  double correlation_before = 1.0, correlation_after = 1.0;
  // Least chi-square by which the true one of two such members will beat the other.
  double expected_chi2 = 0.0;
};

// Judges all tests that the machine can run, for any number of effects.
class Proposer {
 public:
  // The fitted problem; both must outlive the proposer.
  Proposer(const identify::Problem& problem, const identify::Point& point);
  ~Proposer();

  // `effect` is a term of the point's model with its amplitude; `equivalent` simplest first, of which the first forty
  // that differ in some measurement count. At most four sessions; none when there are no others. One without a test
  // where the class stands although every known test was considered.
  std::vector<Proposal> Propose(const machine::ErrorTerm& effect, const std::vector<machine::ErrorTerm>& equivalent);

 private:
  class Tests;
  const identify::Problem& problem_;
  const identify::Point& point_;
  std::unique_ptr<Tests> tests_;  // planned when first needed
};

}  // namespace axiscal::loop

#endif  // AXISCAL_CORE_LOOP_NEXT_MEASUREMENT_H_
