#include "core/loop/rivals.h"

#include <algorithm>

#include "core/loop/same_always.h"

namespace axiscal::loop {
namespace {

using machine::ErrorTerm;

// Columns of each term among the parameters of a model that holds them all.
std::vector<Member> MembersOf(const machine::ErrorModel& model, const std::vector<identify::Parameter>& parameters,
                              const std::vector<ErrorTerm>& terms) {
  std::vector<Member> members;
  for (const ErrorTerm& term : terms) {
    Member member;
    for (size_t k = 0; k < parameters.size(); ++k) {
      if (!IsSameEffect(model.terms[parameters[k].term], term)) continue;
      (parameters[k].is_nonlinear ? member.nonlinear : member.columns).push_back(static_cast<int>(k));
    }
    member.amplitude = Eigen::VectorXd::Zero(static_cast<Eigen::Index>(member.columns.size()));
    members.push_back(std::move(member));
  }
  return members;
}

bool IsIn(const std::vector<ErrorTerm>& terms, const ErrorTerm& term) {
  return std::any_of(terms.begin(), terms.end(), [&](const ErrorTerm& other) { return IsSameEffect(other, term); });
}

}  // namespace

Rivals::Rivals(const identify::Problem& problem, const identify::Point& point, std::vector<ErrorTerm> terms)
    : point_(point), terms_(std::move(terms)) {
  for (size_t i = 1; i < terms_.size(); ++i) {
    point_.model.terms.push_back(terms_[i]);
    point_.model.terms.back().amplitude = {};
  }
  parameters_ = identify::ListParameters(point_.model, true);
  members_ = MembersOf(point_.model, parameters_, terms_);
  information_ = InformationOf(problem, point_, parameters_);
  FitAmplitudes(problem);
}

Information Rivals::InformationOfTest(const identify::Problem& test) const {
  return InformationOf(test, identify::StartingPoint(test, point_.model), parameters_);
}

// With its amplitude a rival's decay length or time constant shows too.
void Rivals::FitAmplitudes(const identify::Problem& problem) {
  for (size_t i = 0; i < members_[0].columns.size(); ++i)
    members_[0].amplitude[i] = identify::ValueOf(point_.model, parameters_[members_[0].columns[i]]);
  const Separation separation(information_, members_);
  std::vector<Eigen::VectorXd> amplitudes;
  for (int m = 1; m < count(); ++m) amplitudes.push_back(separation.FittedAmplitude(0, m));
  // All rivals stand in the model side by side: as small as leaves the machine where it is, whatever the amplitudes are
  // that they would take.
  constexpr double kSmall = 1e-6;  // mm or rad
  bool has_nonlinear = false;
  for (int m = 1; m < count(); ++m) {
    members_[m].amplitude = amplitudes[m - 1];
    if (members_[m].nonlinear.empty()) continue;
    has_nonlinear = true;
    const double norm = amplitudes[m - 1].norm();
    for (size_t i = 0; i < members_[m].columns.size(); ++i) {
      const double share = norm > 0.0 ? amplitudes[m - 1][i] / norm : i == 0;
      identify::SetValue(parameters_[members_[m].columns[i]], kSmall * share, &point_.model);
    }
  }
  if (has_nonlinear) information_ = InformationOf(problem, point_, parameters_);
}

std::vector<ErrorTerm> NeighboursOf(const identify::Problem& problem, const identify::Point& point,
                                    const std::vector<ErrorTerm>& named) {
  const machine::Machine& machine = *problem.machine;
  const ErrorTerm& effect = named[0];
  std::vector<ErrorTerm> candidates = {effect};
  const auto add = [&](const ErrorTerm& term) {
    if (!IsIn(named, term) && !IsIn(point.model.terms, term)) candidates.push_back(term);
  };
  for (int joint = 0; joint < machine.joint_count(); ++joint) {
    for (int c = 0; c < machine::kComponents; ++c) add({joint, static_cast<machine::Component>(c), effect.shape, {}});
  }
  const bool is_drift = std::holds_alternative<shapes::Drift>(effect.shape);
  const bool is_exponential = std::holds_alternative<shapes::DriftExp>(effect.shape);
  const bool is_thermal = std::holds_alternative<shapes::Thermal>(effect.shape);
  if (is_thermal || is_exponential) add({effect.joint, effect.component, shapes::Drift{}, {}});
  if (is_thermal || is_drift) add({effect.joint, effect.component, shapes::DriftExp{}, {}});

  identify::Point all = point;
  all.model.terms.insert(all.model.terms.end(), candidates.begin() + 1, candidates.end());
  const std::vector<identify::Parameter> parameters = identify::ListParameters(all.model, false);
  const std::vector<Member> members = MembersOf(all.model, parameters, candidates);
  const Separation separation(InformationOf(problem, all, parameters), members);
  const std::vector<int> first = FirstOfTheSame(machine, problem.runs.front().tip_mm, candidates);
  std::vector<std::pair<double, ErrorTerm>> near;
  for (size_t m = 1; m < candidates.size(); ++m) {
    if (first[m] != static_cast<int>(m)) continue;
    const double correlation = separation.Correlation(0, static_cast<int>(m));
    constexpr double kNear = 0.8, kUnseen = 1.0;
    if (correlation > kNear && correlation < kUnseen) near.push_back({correlation, candidates[m]});
  }
  std::stable_sort(near.begin(), near.end(), [](const auto& a, const auto& b) { return a.first > b.first; });
  constexpr size_t kMost = 6;
  std::vector<ErrorTerm> neighbours;
  for (size_t i = 0; i < std::min(kMost, near.size()); ++i) neighbours.push_back(near[i].second);
  return neighbours;
}

std::vector<ErrorTerm> StillEquivalent(const identify::Problem& problem, const identify::Point& point,
                                       const ErrorTerm& effect, const std::vector<ErrorTerm>& equivalent,
                                       double same_correlation, double indistinguishable) {
  std::vector<ErrorTerm> terms = {effect};
  for (const ErrorTerm& other : equivalent) {
    if (!IsIn(terms, other) && !IsIn(point.model.terms, other)) terms.push_back(other);
  }
  if (terms.size() < 2) return {};
  const Rivals rivals(problem, point, terms);
  const Separation separation(rivals.information(), rivals.members());
  std::vector<ErrorTerm> still;
  for (int m = 1; m < rivals.count(); ++m) {
    if (separation.Correlation(0, m) > same_correlation || separation.ExpectedChi2(0, m) < indistinguishable)
      still.push_back(terms[m]);
  }
  return still;
}

}  // namespace axiscal::loop
