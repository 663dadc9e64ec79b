#include "core/loop/rivals.h"

#include <algorithm>
#include <map>

#include "core/base/demand.h"
#include "core/loop/dictionary.h"
#include "core/loop/same_always.h"
#include "core/loop/signatures.h"

namespace axiscal::loop {
namespace {

using machine::ErrorTerm;

// Columns of terms among the parameters of their model: of the term `effect`, then of those from `others` on.
std::vector<Member> MembersOf(const machine::ErrorModel& model, const std::vector<identify::Parameter>& parameters,
                              int effect, int others) {
  std::vector<Member> members(1 + model.terms.size() - others);
  for (size_t k = 0; k < parameters.size(); ++k) {
    const int term = parameters[k].term;
    if (term != effect && term < others) continue;
    Member& member = members[term == effect ? 0 : 1 + term - others];
    (parameters[k].is_nonlinear ? member.nonlinear : member.columns).push_back(static_cast<int>(k));
  }
  for (Member& member : members)
    member.amplitude = Eigen::VectorXd::Zero(static_cast<Eigen::Index>(member.columns.size()));
  return members;
}

int IndexOf(const machine::ErrorModel& model, const ErrorTerm& term) {
  const auto at = std::find_if(model.terms.begin(), model.terms.end(),
                               [&](const ErrorTerm& other) { return IsSameEffect(other, term); });
  DEMAND(at != model.terms.end());
  return static_cast<int>(at - model.terms.begin());
}

bool IsIn(const std::vector<ErrorTerm>& terms, const ErrorTerm& term) {
  return std::any_of(terms.begin(), terms.end(), [&](const ErrorTerm& other) { return IsSameEffect(other, term); });
}

// What the loop might find in the effect's place once other sessions stand beside these: the plain shapes of each axis
// in its own errors, the effect's shape anywhere; of what goes with time all.
bool CanBeNeighbour(const Candidate& candidate, const ErrorTerm& effect) {
  const auto is_time = [](const shapes::Shape& shape) {
    return std::holds_alternative<shapes::Drift>(shape) || std::holds_alternative<shapes::DriftExp>(shape) ||
           std::holds_alternative<shapes::Thermal>(shape);
  };
  switch (candidate.family) {
    case Family::kConstant:
    case Family::kLinear:
    case Family::kQuadratic:
    case Family::kHarmonic:
    case Family::kBacklash:
    case Family::kLag:
    case Family::kLobe:
      return true;
    case Family::kFineHarmonic:
      return shapes::VariableAxis(candidate.term.shape) == shapes::VariableAxis(effect.shape);
    case Family::kDrift:
    case Family::kDriftExp:
    case Family::kThermal:
      return is_time(effect.shape);
    default:
      return candidate.term.shape == effect.shape;
  }
}

}  // namespace

Rivals::Rivals(const identify::Problem& problem, const identify::Point& point, std::vector<ErrorTerm> terms)
    : point_(point), terms_(std::move(terms)) {
  const int others = static_cast<int>(point.model.terms.size());
  for (size_t i = 1; i < terms_.size(); ++i) {
    point_.model.terms.push_back(terms_[i]);
    point_.model.terms.back().amplitude = {};
  }
  parameters_ = identify::ListParameters(point_.model, true);
  members_ = MembersOf(point_.model, parameters_, IndexOf(point.model, terms_[0]), others);
  information_ = InformationOf(problem, point_, parameters_);
  FitAmplitudes(problem);
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
                                    const std::vector<ErrorTerm>& known, double near) {
  const ErrorTerm& effect = known[0];
  const int own = IndexOf(point.model, effect);
  std::vector<identify::Parameter> others = identify::ListParameters(point.model, true);
  std::erase_if(others, [own](const identify::Parameter& parameter) { return parameter.term == own; });
  // Readings that the machine would give without the effect: what is left of them is what the effect does.
  identify::Problem lacking = problem;
  identify::Point without = point;
  without.model.terms[own].amplitude = {};
  const std::vector<Eigen::MatrixXd> residuals_mm = identify::ResidualsOf(problem, without);
  for (size_t i = 0; i < lacking.runs.size(); ++i) lacking.runs[i].measured_mm += residuals_mm[i];
  const Signatures signatures(lacking, point, others);
  std::vector<Candidate> candidates = MakeDictionary(problem, point.model);
  std::erase_if(candidates, [&](const Candidate& one) {
    return !CanBeNeighbour(one, effect) || IsIn(known, one.term) || IsIn(point.model.terms, one.term);
  });
  std::map<Family, double> worth;
  for (const Candidate& one : candidates) worth[one.family] = near * near * signatures.residual_squares();
  const std::vector<Projection> projections = signatures.ProjectWorthy(candidates, worth, 0.0);
  std::vector<std::pair<double, ErrorTerm>> found;
  for (size_t i = 0; i < candidates.size(); ++i) {
    Eigen::Vector3d amplitude;
    if (projections[i].is_screened || projections[i].visible <= kVisible) continue;
    const double share = Gain(projections[i], &amplitude) / signatures.residual_squares();
    if (share > near * near) found.push_back({share, candidates[i].term});
  }
  std::stable_sort(found.begin(), found.end(), [](const auto& a, const auto& b) { return a.first > b.first; });
  constexpr size_t kCompared = 60, kMost = 16;
  std::vector<ErrorTerm> terms = known, neighbours;
  for (size_t i = 0; i < std::min(kCompared, found.size()); ++i) {
    if (!IsIn(terms, found[i].second)) terms.push_back(found[i].second);
  }
  const std::vector<int> first = FirstOfTheSame(*problem.machine, problem.runs.front().tip_mm, terms);
  for (size_t i = known.size(); i < terms.size() && neighbours.size() < kMost; ++i) {
    if (first[i] == static_cast<int>(i)) neighbours.push_back(terms[i]);
  }
  return neighbours;
}

}  // namespace axiscal::loop
