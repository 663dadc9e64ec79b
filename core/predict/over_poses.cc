#include "core/predict/over_poses.h"

#include <Eigen/QR>
#include <algorithm>
#include <cmath>

#include "core/base/random.h"
#include "core/machine/chain.h"
#include "core/predict/tool_point.h"

namespace axiscal::predict {
namespace {

// What of a number's effect is left beyond work offset and tool centre; less is rounding.
constexpr double kLeftOver = 1e-6;
constexpr uint64_t kChanceSeed = 230;
constexpr int kChanceDraws = 1000;  // the 95 % quantile of what chance makes, to about 1 % of its place
constexpr double kChanceQuantile = 0.95;

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

// Orthonormal basis of what work offset and tool centre do to the tool point, 3 poses x rank.
Eigen::MatrixXd TakenUp(const machine::Machine& machine, const BoxPoses& poses) {
  Eigen::MatrixXd taken(3 * poses.count(), 6);
  for (int k = 0; k < poses.count(); ++k) {
    const machine::ChainPose<double> pose =
        machine::EvaluateChain<double>(machine, poses.PositionsOf(k), machine::JointErrors<double>());
    taken.block<3, 3>(3 * k, 0).setIdentity();
    taken.block<3, 3>(3 * k, 3) = pose.bed_from_table.rotation.transpose() * pose.bed_from_tool.rotation;
  }
  const Eigen::ColPivHouseholderQR<Eigen::MatrixXd> qr(taken);
  return qr.householderQ() * Eigen::MatrixXd::Identity(3 * poses.count(), qr.rank());
}

}  // namespace

double Quantile(std::vector<double>* values, double share) {
  const auto at = static_cast<std::ptrdiff_t>(share * static_cast<double>(values->size() - 1));
  std::nth_element(values->begin(), values->begin() + at, values->end());
  return (*values)[static_cast<size_t>(at)];
}

double RmsOver(const Eigen::VectorXd& mm) {
  return std::sqrt(mm.squaredNorm() / (static_cast<double>(mm.size()) / 3.0));
}

int LongestAt(const Eigen::VectorXd& mm) {
  int at = 0;
  for (int k = 1; k < mm.size() / 3; ++k)
    if (mm.segment<3>(3 * k).norm() > mm.segment<3>(3 * at).norm()) at = k;
  return at;
}

ChanceOver ChanceOf(const Eigen::MatrixXd& spread) {
  base::Random random(kChanceSeed);
  std::vector<double> rms, max;
  Eigen::VectorXd z(spread.cols());
  for (int i = 0; i < kChanceDraws; ++i) {
    for (double& one : z) one = random.Normal();
    const Eigen::VectorXd drawn = spread * z;
    rms.push_back(RmsOver(drawn));
    max.push_back(drawn.segment<3>(3 * LongestAt(drawn)).norm());
  }
  return {Quantile(&rms, kChanceQuantile), Quantile(&max, kChanceQuantile)};
}

OverPoses::OverPoses(const machine::Machine& machine, const BoxPoses& poses, const Eigen::Vector3d& tip_mm)
    : machine_(machine), poses_(poses), tip_mm_(tip_mm), taken_up_(TakenUp(machine, poses)) {}

Eigen::VectorXd OverPoses::ErrorsOf(const machine::ErrorModel& model) const {
  const machine::KnownErrors errors{model, {}};
  ToolPoint tool(machine_, errors, tip_mm_);
  Eigen::VectorXd out(rows());
  for (int k = 0; k < poses_.count(); ++k) out.segment<3>(3 * k) = tool.ErrorAt(poses_.At(k)).head<3>();
  return Left(out);
}

Eigen::MatrixXd OverPoses::ByNumber(const machine::KnownErrors& errors) const {
  ToolPoint tool(machine_, errors, tip_mm_);
  Eigen::MatrixXd out(rows(), static_cast<Eigen::Index>(errors.covariance.of.size()));
  for (int k = 0; k < poses_.count(); ++k) out.middleRows<3>(3 * k) = tool.ByNumberAt(poses_.At(k)).topRows<3>();
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
