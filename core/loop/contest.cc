#include "core/loop/contest.h"

#include <algorithm>

#include "core/loop/candidate.h"
#include "core/loop/dictionary.h"
#include "core/loop/same_always.h"

namespace axiscal::loop {
namespace {

using machine::ErrorTerm;

constexpr size_t kMostMembers = 40;

bool IsWarmingUp(const ErrorTerm& term) { return std::holds_alternative<shapes::DriftExp>(term.shape); }

}  // namespace

Contest::Contest(const identify::Problem& problem, const identify::Point& point, const ErrorTerm& effect,
                 const std::vector<ErrorTerm>& equivalent, const std::vector<ErrorTerm>& neighbours,
                 const std::vector<ErrorTerm>& confused, const std::vector<double>& ends_s) {
  std::vector<ErrorTerm> named = {effect};
  for (const ErrorTerm& other : equivalent) {
    const auto is_known = [&](const ErrorTerm& term) { return IsSameEffect(term, other); };
    const bool is_fitted = std::any_of(point.model.terms.begin(), point.model.terms.end(), is_known);
    if (!is_fitted && std::none_of(named.begin(), named.end(), is_known)) named.push_back(other);
  }
  const std::vector<int> first = FirstOfTheSame(*problem.machine, problem.runs.front().tip_mm, named);
  std::vector<ErrorTerm> terms;
  for (size_t i = 0; i < named.size(); ++i) {
    if (first[i] == 0 && i > 0) same_always_.push_back(named[i]);
    if (first[i] == static_cast<int>(i) && terms.size() < kMostMembers) terms.push_back(named[i]);
  }
  class_count_ = static_cast<int>(terms.size());
  if (class_count_ < 2) return;
  terms.insert(terms.end(), confused.begin(), confused.end());
  const int must_count = static_cast<int>(terms.size());
  for (const ErrorTerm& neighbour : neighbours) {
    const auto is_it = [&](const ErrorTerm& term) { return IsSameEffect(term, neighbour); };
    if (std::none_of(confused.begin(), confused.end(), is_it)) terms.push_back(neighbour);
  }
  const int named_count = static_cast<int>(terms.size());
  // The longer one looks, the longer the time constants that the loop tries: a session that tells a drift from a
  // warming as it would be fitted today need not tell it from a slower one.
  std::vector<Pair> slower;
  for (int m = 1; m < named_count; ++m) {
    if (!IsWarmingUp(terms[m]) || IsWarmingUp(effect)) continue;
    for (const double end_s : ends_s) {
      const double tau_s = kSlowestWarming * end_s;
      if (tau_s < std::get<shapes::DriftExp>(terms[m].shape).tau_s) continue;
      constexpr double kRounding = 0.99;
      slower.push_back(
          {0, static_cast<int>(terms.size()), m < class_count_ ? m : 0, m < must_count, kRounding * end_s});
      terms.push_back(terms[m]);
      std::get<shapes::DriftExp>(terms.back().shape).tau_s = tau_s;
    }
  }
  rivals_.emplace(problem, point, terms);
  AddPairs(named_count, must_count, slower);
}

void Contest::AddPairs(int named_count, int must_count, const std::vector<Pair>& slower) {
  for (int b = 1; b < named_count; ++b) pairs_.push_back({0, b, b < class_count_ ? b : 0, b < must_count, 0.0});
  for (const Pair& pair : slower) pairs_.push_back(pair);
  for (int a = 1; a < class_count_; ++a) {
    for (int b = a + 1; b < class_count_; ++b) pairs_.push_back({a, b, b, true, 0.0});
    if (IsWarmingUp(rivals_->term(a))) continue;
    for (const Pair& pair : slower) {
      if (pair.member > 0) pairs_.push_back({a, pair.b, pair.member, true, pair.from_s});
    }
  }
}

}  // namespace axiscal::loop
