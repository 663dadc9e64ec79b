#include "core/compare/compare.h"

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <boost/math/distributions/chi_squared.hpp>
#include <cmath>
#include <numbers>
#include <numeric>

#include "absl/strings/str_join.h"
#include "core/base/units.h"
#include "core/compare/numbers.h"
#include "core/compare/tool_point.h"
#include "core/predict/tool_point.h"

namespace axiscal::compare {
namespace {

constexpr double kChance = 0.05;  // of a difference being named where nothing changed
constexpr const char* kWhich[2] = {"the first", "the second"};

// One difference as a sum of numbers' differences.
struct Candidate {
  Eigen::VectorXd sum;  // coefficients, of all numbers
  Difference* difference = nullptr;
};

double TwoSided(double ratio) { return std::erfc(std::abs(ratio) / std::numbers::sqrt2); }

// What the members of a sum allow; `sum` has their coefficients.
Difference Describe(const Numbers& numbers, const Eigen::VectorXd& sum, Eigen::Index carrier) {
  Difference out;
  out.name = CombinationText(numbers.all, sum, carrier);
  out.unit = numbers.all[static_cast<size_t>(carrier)].unit;
  out.probability = out.rms_mm = reports::kNoNumber;
  bool has_sigma[2] = {false, false}, is_in[2] = {true, true};
  double value[2] = {0.0, 0.0};
  for (Eigen::Index i = 0; i < sum.size(); ++i) {
    if (sum[i] == 0.0) continue;
    const Number& number = numbers.all[static_cast<size_t>(i)];
    for (int side = 0; side < 2; ++side) {
      has_sigma[side] = has_sigma[side] || number.has_sigma[side];
      is_in[side] = is_in[side] && number.is_in[side];
      value[side] += sum[i] * number.value[side];
    }
  }
  out.first = value[0];
  out.second = value[1];
  out.difference = value[1] - value[0];
  out.sigma = std::sqrt(std::max(0.0, sum.dot((numbers.covariance[0] + numbers.covariance[1]) * sum)));
  for (int side = 0; side < 2; ++side) {
    if (is_in[side]) continue;
    (side == 0 ? out.first : out.second) = reports::kNoNumber;
    out.verdict = Verdict::kOnlyOne;
    out.reason = absl::StrCat(kWhich[side], " does not have it in its model");
  }
  if (out.verdict == Verdict::kOnlyOne) {
    out.sigma = out.sigma > 0.0 ? out.sigma : reports::kNoNumber;
    return out;
  }
  if (out.sigma > 0.0) {
    for (int side = 0; side < 2; ++side)
      if (!has_sigma[side]) out.reason = absl::StrCat(kWhich[side], " states no uncertainty: taken for exact");
    out.probability = TwoSided(out.difference / out.sigma);
    return out;
  }
  out.sigma = reports::kNoNumber;
  out.verdict = Verdict::kNoUncertainty;
  out.reason = "no uncertainty is stated";
  return out;
}

// Holm: the k-th smallest of n probabilities must be below 0.05 / (n - k), and all before it.
void Judge(const std::vector<Candidate>& candidates) {
  std::vector<Difference*> order;
  for (const Candidate& candidate : candidates) order.push_back(candidate.difference);
  std::stable_sort(order.begin(), order.end(),
                   [](const Difference* a, const Difference* b) { return a->probability < b->probability; });
  bool goes_on = true;
  for (size_t k = 0; k < order.size(); ++k) {
    goes_on = goes_on && order[k]->probability < kChance / static_cast<double>(order.size() - k);
    order[k]->verdict = goes_on                           ? Verdict::kDiffers
                        : order[k]->probability < kChance ? Verdict::kMayDiffer
                                                          : Verdict::kAgrees;
  }
}

Joint JointOf(const Numbers& numbers, const std::vector<Candidate>& candidates) {
  Joint joint;
  const auto count = static_cast<Eigen::Index>(candidates.size());
  if (count == 0) return joint;
  Eigen::MatrixXd sums(count, static_cast<Eigen::Index>(numbers.all.size()));
  Eigen::VectorXd ratio(count), per_sigma(count);
  for (Eigen::Index i = 0; i < count; ++i) {
    const Candidate& candidate = candidates[static_cast<size_t>(i)];
    sums.row(i) = candidate.sum.transpose() / candidate.difference->sigma;
    ratio[i] = candidate.difference->difference / candidate.difference->sigma;
  }
  const Eigen::MatrixXd correlation = sums * (numbers.covariance[0] + numbers.covariance[1]) * sums.transpose();
  const Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd> eigen(correlation);
  // Correlations are written with nine digits: a direction with less variance has none of its own.
  constexpr double kRounding = 1e-7;
  for (Eigen::Index i = 0; i < count; ++i) {
    if (eigen.eigenvalues()[i] < kRounding * static_cast<double>(count)) continue;
    const double along = eigen.eigenvectors().col(i).dot(ratio);
    joint.chi2 += along * along / eigen.eigenvalues()[i];
    ++joint.degrees_of_freedom;
  }
  if (joint.degrees_of_freedom > 0)
    joint.probability = boost::math::cdf(
        boost::math::complement(boost::math::chi_squared(static_cast<double>(joint.degrees_of_freedom)), joint.chi2));
  return joint;
}

// Named by the fit that could not tell it.
std::string WhyNotDetermined(const Side& first, const Side& second, const std::string& name) {
  std::vector<std::string> who;
  for (const Side* side : {&first, &second}) {
    bool is_unknown =
        std::find(side->without_number.begin(), side->without_number.end(), name) != side->without_number.end();
    for (const std::string& direction : side->not_separable) {
      const auto shares = ParseCombination(direction);
      is_unknown = is_unknown || (shares.ok() && std::any_of(shares->begin(), shares->end(),
                                                             [&](const Share& share) { return share.name == name; }));
    }
    if (is_unknown) who.push_back(kWhich[side == &second]);
  }
  if (who.empty()) return "what it was fitted to does not tell it from others";
  return absl::StrCat(absl::StrJoin(who, " and "), " could not tell it from others");
}

void AddNotes(const machine::Machine& machine, const Side& first, const Side& second,
              const std::optional<predict::Workspace>& workspace, Comparison* out) {
  const Side* sides[2] = {&first, &second};
  for (int side = 0; side < 2; ++side) {
    const Side& of = *sides[side];
    if (of.errors.covariance.is_empty()) {
      out->notes.push_back(absl::StrCat(kWhich[side], " states no uncertainties: its errors are taken for exact"));
      continue;
    }
    const std::vector<std::string> exact = predict::TakenForExact(machine, of.errors);
    if (!exact.empty())
      out->notes.push_back(
          absl::StrCat(kWhich[side], " states no uncertainty of ", absl::StrJoin(exact, ", "), ": taken for exact"));
    if (!of.has_report)
      out->notes.push_back(
          absl::StrCat(kWhich[side],
                       " has no report: an error that it holds at zero without an uncertainty is taken "
                       "for not determined, and what is determined only with it is not known to be"));
  }
  std::vector<std::string> shared;
  for (const std::string& session : first.sessions)
    if (std::find(second.sessions.begin(), second.sessions.end(), session) != second.sessions.end())
      shared.push_back(session);
  if (!shared.empty())
    out->notes.push_back(absl::StrCat("both come from ", absl::StrJoin(shared, ", "),
                                      ": where these are the same readings the two are not independent, and the sigmas "
                                      "of the differences are too large"));
  bool is_one_sided = false;
  for (const Difference& difference : out->errors)
    is_one_sided = is_one_sided || difference.verdict == Verdict::kOnlyOne;
  if (is_one_sided)
    out->notes.push_back(
        "the models differ: what an error that only one of them has does to the readings stands in "
        "other errors of the other one");
  if (!workspace) return;
  bool by_state = false;
  for (const Side* side : sides)
    for (const machine::ErrorTerm& term : side->errors.model.terms)
      by_state = by_state || machine::DependsOnMoreThanPosition(term);
  if (by_state)
    out->notes.push_back(
        absl::StrFormat("errors that depend on more than positions are taken at t = %g s, %g deg C, "
                        "axes at rest after a move of either sense",
                        workspace->time_s, workspace->temperature_celsius));
}

}  // namespace

absl::StatusOr<Comparison> Compare(const machine::Machine& machine, const Side& first, const Side& second,
                                   const std::optional<predict::Workspace>& workspace) {
  ASSIGN_OR_RETURN(const Numbers numbers, SideBySide(machine, first, second));
  const auto count = static_cast<Eigen::Index>(numbers.all.size());
  Comparison out;
  std::vector<Eigen::VectorXd> sums;  // of errors, then of combinations
  for (Eigen::Index i = 0; i < count; ++i) {
    sums.push_back(Eigen::VectorXd::Unit(count, i));
    Difference difference = Describe(numbers, sums.back(), i);
    if (numbers.unknown.rows() > 0 && (numbers.unknown.col(i).array() != 0.0).any() &&
        difference.verdict != Verdict::kOnlyOne) {
      difference.verdict = Verdict::kNotDetermined;
      difference.reason = WhyNotDetermined(first, second, difference.name);
      difference.first = difference.second = difference.difference = difference.sigma = difference.probability =
          reports::kNoNumber;
    }
    out.errors.push_back(std::move(difference));
  }
  for (Eigen::Index j = 0; j < count; ++j) {
    const bool is_pivot = std::find(numbers.pivots.begin(), numbers.pivots.end(), j) != numbers.pivots.end();
    if (is_pivot || numbers.unknown.rows() == 0 || (numbers.unknown.col(j).array() == 0.0).all()) continue;
    Eigen::VectorXd sum = Eigen::VectorXd::Unit(count, j);
    for (size_t k = 0; k < numbers.pivots.size(); ++k)
      sum[numbers.pivots[k]] = -numbers.unknown(static_cast<Eigen::Index>(k), j);
    out.combinations.push_back(Describe(numbers, sum, j));
    sums.push_back(std::move(sum));
  }
  for (size_t k = 0; k < numbers.pivots.size(); ++k)
    out.not_comparable.push_back(
        CombinationText(numbers.all, numbers.unknown.row(static_cast<Eigen::Index>(k)).transpose(), numbers.pivots[k]));

  std::vector<Candidate> candidates;
  for (size_t i = 0; i < sums.size(); ++i) {
    Difference& one = i < out.errors.size() ? out.errors[i] : out.combinations[i - out.errors.size()];
    if (std::isfinite(one.probability)) candidates.push_back({sums[i], &one});
  }
  Judge(candidates);
  out.joint = JointOf(numbers, candidates);
  if (workspace) {
    const OverBox over = DifferenceOver(machine, first, second, numbers, *workspace);
    out.tool_point = over.difference;
    for (size_t i = 0; i < out.errors.size(); ++i)
      if (out.errors[i].verdict != Verdict::kNotDetermined) out.errors[i].rms_mm = over.rms_mm[i];
  }
  AddNotes(machine, first, second, workspace, &out);
  return out;
}

}  // namespace axiscal::compare
