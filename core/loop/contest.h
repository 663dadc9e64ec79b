// A class of effects that the data cannot tell apart, and the pairs to tell apart before the true one is alone.
#ifndef AXISCAL_CORE_LOOP_CONTEST_H_
#define AXISCAL_CORE_LOOP_CONTEST_H_

#include <optional>
#include <vector>

#include "core/loop/rivals.h"

namespace axiscal::loop {

// Two rivals, by their numbers in Contest::rivals().
struct Pair {
  int a = 0, b = 0;
  int member = 0;         // the member of the class that b is, below class_count(); 0 where it is none
  bool is_class = false;  // must be told
  double from_s = 0.0;    // counts once the last reading is later than this
};

class Contest {
 public:
  // `effect` as Proposer::Propose. `ends_s`: when planned sessions end, ascending (a slow warming looks different after
  // a longer time). `neighbours`: effects from which it is told apart already and must stay so;
  // `confused`: further effects that it must be told apart from.
  Contest(const identify::Problem& problem, const identify::Point& point, const machine::ErrorTerm& effect,
          const std::vector<machine::ErrorTerm>& equivalent, const std::vector<machine::ErrorTerm>& neighbours,
          const std::vector<machine::ErrorTerm>& confused, const std::vector<double>& ends_s);

  // Members that differ in some measurement, the effect first: the first class_count() rivals. Below 2: no contest.
  int class_count() const { return class_count_; }
  const Rivals& rivals() const { return *rivals_; }  // of a class with others in it
  // The members of the class from each other, the reported effect from its neighbours too; pairs of the effect first.
  const std::vector<Pair>& pairs() const { return pairs_; }
  // The effect by other names, which no measurement of any kind tells from it.
  const std::vector<machine::ErrorTerm>& same_always() const { return same_always_; }

 private:
  void AddPairs(int named_count, int must_count, const std::vector<Pair>& slower);

  int class_count_ = 0;
  std::vector<machine::ErrorTerm> same_always_;
  std::optional<Rivals> rivals_;
  std::vector<Pair> pairs_;
};

}  // namespace axiscal::loop

#endif  // AXISCAL_CORE_LOOP_CONTEST_H_
