#include "core/predict/over_poses.h"

#include <algorithm>

namespace axiscal::predict {
namespace {

// What of a number's effect is left beyond work offset and tool centre; less is rounding.
constexpr double kLeftOver = 1e-6;

// Numbers of the model by these names, each with one mm or rad.
machine::ErrorCovariance NumbersNamed(const machine::Machine& machine, const machine::ErrorModel& model,
                                      const std::vector<std::string>& names, std::vector<std::string>* found) {
  machine::ErrorCovariance numbers;
  for (int i = 0; i < static_cast<int>(model.terms.size()); ++i) {
    for (int k = 0; k < shapes::BasisCount(model.terms[i].shape); ++k) {
      const std::string name = machine::NameNumber(machine, model, i, k, false).name;
      if (std::find(names.begin(), names.end(), name) == names.end()) continue;
      numbers.of.push_back({i, k, false});
      found->push_back(name);
    }
  }
  const auto count = static_cast<Eigen::Index>(numbers.of.size());
  numbers.root.setIdentity(count, count);
  return numbers;
}

}  // namespace

double Quantile(std::vector<double>* values, double share) {
  const auto at = static_cast<std::ptrdiff_t>(share * static_cast<double>(values->size() - 1));
  std::nth_element(values->begin(), values->begin() + at, values->end());
  return (*values)[static_cast<size_t>(at)];
}

OverPoses::OverPoses(const machine::Machine& machine, const BoxStates& states, const Eigen::Vector3d& tip_mm)
    : machine_(machine), states_(states), tip_mm_(tip_mm) {
  taken_up_ = TakenUp(machine, states.count(), [&](int k) { return states.PositionsOf(k); });
}

Eigen::VectorXd OverPoses::ErrorsOf(const machine::ErrorModel& model) const {
  const machine::KnownErrors errors{model, {}};
  ToolPoint tool(machine_, errors, tip_mm_);
  Eigen::VectorXd out(rows());
  for (int k = 0; k < states_.count(); ++k) out.segment<3>(3 * k) = tool.ErrorAt(states_.At(k)).head<3>();
  return Left(out);
}

Eigen::MatrixXd OverPoses::ByNumber(const machine::KnownErrors& errors) const {
  ToolPoint tool(machine_, errors, tip_mm_);
  Eigen::MatrixXd out(rows(), static_cast<Eigen::Index>(errors.covariance.of.size()));
  for (int k = 0; k < states_.count(); ++k) out.middleRows<3>(3 * k) = tool.ByNumberAt(states_.At(k)).topRows<3>();
  return out;
}

// The square of A = B root is the sum of B_j' A root_j over the numbers j.
std::vector<std::string> OverPoses::WeakestOf(const machine::KnownErrors& errors, const Eigen::MatrixXd& by_number,
                                              const Eigen::MatrixXd& uncertain) const {
  std::vector<std::pair<double, std::string>> shares;
  for (size_t j = 0; j < errors.covariance.of.size(); ++j) {
    const machine::ErrorCovariance::Number& number = errors.covariance.of[j];
    const auto column = static_cast<Eigen::Index>(j);
    const double share = by_number.col(column).dot(uncertain * errors.covariance.root.row(column).transpose());
    if (share < kWeak * uncertain.squaredNorm() || share <= 0.0) continue;
    shares.emplace_back(
        -share, machine::NameNumber(machine_, errors.model, number.term, number.basis, number.is_nonlinear).name);
  }
  std::sort(shares.begin(), shares.end());
  std::vector<std::string> names;
  for (const auto& [share, name] : shares) names.push_back(name);
  return names;
}

std::vector<std::string> OverPoses::ActingOf(const machine::ErrorModel& model,
                                             const std::vector<std::string>& names) const {
  std::vector<std::string> found, acting;
  const machine::KnownErrors open{model, NumbersNamed(machine_, model, names, &found)};
  const Eigen::MatrixXd raw = ByNumber(open), left = Left(raw);
  for (Eigen::Index i = 0; i < raw.cols(); ++i) {
    if (left.col(i).squaredNorm() > kLeftOver * raw.col(i).squaredNorm())
      acting.push_back(found[static_cast<size_t>(i)]);
  }
  return acting;
}

}  // namespace axiscal::predict
