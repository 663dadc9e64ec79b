// Chooses the sessions that tell the members of a class apart, one after the other: each is judged with those chosen
// before it already measured.
#ifndef AXISCAL_CORE_LOOP_CHOOSER_H_
#define AXISCAL_CORE_LOOP_CHOOSER_H_

#include <optional>
#include <vector>

#include "core/loop/contest.h"
#include "core/loop/next_measurement.h"
#include "core/loop/planned_tests.h"

namespace axiscal::loop {

class Chooser {
 public:
  // Both must outlive the chooser. `last_s`: time of the last reading so far.
  Chooser(const Contest& contest, const std::vector<PlannedTest>& tests, double last_s);

  // At first two members count as told apart only with a reserve, as a measurement differs from its forecast (noise,
  // refitted decay lengths). Relaxed: as soon as the bounds of a class are exceeded, without reserve.
  void Relax() { is_relaxed_ = true; }

  // Every pair of the class is told.
  bool IsDone() const;
  // The best session to measure next: the one with which most members, each taken for the true one, would stand alone;
  // then the one that tells most pairs apart that are not yet, or comes nearest to it; of equal ones that with the best
  // worst pair, then the shortest. Nothing when none helps.
  std::optional<Proposal> Next(bool any_instrument);
  // Two sessions that only together tell members apart (a warm shop with a short tool and with a long one), of the
  // sessions in which the effect shows most. Empty when no two do.
  std::vector<Proposal> NextTwo();
  std::vector<const PlannedTest*> Chosen() const;
  // The members from which the reported effect is not told apart.
  std::vector<machine::ErrorTerm> Remaining() const;

 private:
  struct Judged {
    double alone = 0.0;  // members that it tells from all others, less those that it dilutes; simpler ones weigh more
    int told = 0;        // pairs of the class that it tells and that were not told before, less those that it dilutes
    double progress = 0.0;  // of the margins up to 1, neighbours too
    double worst = 0.0;     // margin of the worst pair that any test tells, capped: with that much reserve time counts
    double seconds = 0.0;

    bool Helps() const;
    bool IsBetterThan(const Judged& other) const;
  };

  bool IsTold(double margin) const;
  // Sum of the weights of the members that stand alone at these margins.
  double AloneAt(const std::vector<double>& margins) const;
  std::vector<double> MarginsWith(const Information& information, double last_s) const;
  // Of the pairs, with one test beside what is measured and chosen.
  const std::vector<double>& MarginsAfter(size_t test);
  Judged Judge(const std::vector<double>& after, const std::vector<double>& reachable, double seconds) const;
  Proposal Choose(size_t test, const std::vector<double>& after);

  const Rivals& of_;
  const int class_count_;
  const std::vector<PlannedTest>& tests_;
  const std::vector<Pair>& pairs_;
  bool is_relaxed_ = false;
  std::vector<bool> is_chosen_;
  double last_s_;
  Information information_;
  std::vector<Information> added_;          // per test
  std::vector<double> margins_;             // of the pairs, with what is measured and chosen
  std::vector<std::vector<double>> after_;  // per test, its MarginsAfter; empty where nobody has asked yet
};

}  // namespace axiscal::loop

#endif  // AXISCAL_CORE_LOOP_CHOOSER_H_
