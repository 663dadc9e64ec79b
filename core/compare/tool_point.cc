#include "core/compare/tool_point.h"

#include <algorithm>
#include <cmath>

#include "core/base/units.h"
#include "core/predict/over_poses.h"
#include "core/predict/tool_point.h"

namespace axiscal::compare {
namespace {

constexpr double kNoticed = 1e-6;  // of a direction's effect, mm per file unit: less is rounding
constexpr size_t kMostNamed = 3;   // errors that are named where the difference is largest

// `alone`: 3 poses x numbers, what each number's difference does; `uncertain`: 3 poses x q, whose product with standard
// normal numbers is what the uncertainties do.
Size SizeOf(const Eigen::VectorXd& mm, const Eigen::MatrixXd& alone, const Eigen::MatrixXd& uncertain,
            const predict::BoxPoses& poses, const Numbers& numbers) {
  Size size;
  const int at = predict::LongestAt(mm);
  size.rms_mm = predict::RmsOver(mm);
  size.max_mm = mm.segment<3>(3 * at).norm();
  const double* positions = poses.PositionsOf(at);
  size.where.positions.assign(positions, positions + poses.At(at).axes.size());
  size.where.difference_mm = mm.segment<3>(3 * at);
  std::vector<std::pair<double, std::string>> shares;
  for (Eigen::Index i = 0; i < alone.cols() && size.max_mm > 0.0; ++i) {
    // Its part along the whole.
    const double share = alone.col(i).segment<3>(3 * at).dot(size.where.difference_mm) / (size.max_mm * size.max_mm);
    constexpr double kWorthNaming = 0.1;
    if (share > kWorthNaming) shares.emplace_back(-share, numbers.all[static_cast<size_t>(i)].name);
  }
  std::sort(shares.begin(), shares.end());
  for (size_t i = 0; i < std::min(shares.size(), kMostNamed); ++i) size.where.by.push_back(shares[i].second);
  size.chance_rms_mm = size.chance_max_mm = reports::kNoNumber;
  if (uncertain.cols() == 0) {
    size.where.sigma_mm.setConstant(reports::kNoNumber);
    return size;
  }
  size.where.sigma_mm = uncertain.middleRows<3>(3 * at).rowwise().norm();
  const predict::ChanceOver chance = predict::ChanceOf(uncertain);
  size.chance_rms_mm = chance.rms_mm;
  size.chance_max_mm = chance.max_mm;
  return size;
}

}  // namespace

OverBox DifferenceOver(const machine::Machine& machine, const Side& first, const Side& second, const Numbers& numbers,
                       const predict::Workspace& workspace) {
  const predict::BoxPoses poses(workspace);
  const predict::OverPoses over(machine, poses, workspace.tip_mm);
  const int count = poses.count();
  OverBox out;
  out.difference.poses = count;
  predict::ToolPoint of_first(machine, first.errors, workspace.tip_mm),
      of_second(machine, second.errors, workspace.tip_mm);
  Eigen::VectorXd mm(3 * count);
  double squares = 0.0;
  for (int k = 0; k < count; ++k) {
    const predict::ToolPointError error = of_second.ErrorAt(poses.At(k)) - of_first.ErrorAt(poses.At(k));
    mm.segment<3>(3 * k) = error.head<3>();
    const double tilt_rad = error.tail<3>().norm();
    squares += tilt_rad * tilt_rad;
    out.difference.tilt_max_rad = std::max(out.difference.tilt_max_rad, tilt_rad);
  }
  out.difference.tilt_rms_rad = std::sqrt(squares / count);

  machine::ErrorCovariance each;
  for (const Number& number : numbers.all) each.of.push_back(number.of);
  Eigen::MatrixXd by_number = over.ByNumber({numbers.both, each});  // mm per file unit
  for (Eigen::Index i = 0; i < by_number.cols(); ++i) by_number.col(i) *= numbers.all[static_cast<size_t>(i)].factor;
  Eigen::MatrixXd alone = by_number;
  for (Eigen::Index i = 0; i < by_number.cols(); ++i) {
    const Number& number = numbers.all[static_cast<size_t>(i)];
    alone.col(i) *= number.value[1] - number.value[0];
    out.rms_mm.push_back(predict::RmsOver(alone.col(i)));
  }
  Eigen::MatrixXd uncertain(3 * count, 0);
  for (const Side* side : {&first, &second}) {
    if (side->errors.covariance.is_empty()) continue;
    const Eigen::MatrixXd spread = over.ByNumber(side->errors) * side->errors.covariance.root;
    uncertain.conservativeResize(Eigen::NoChange, uncertain.cols() + spread.cols());
    uncertain.rightCols(spread.cols()) = spread;
  }
  out.difference.as_programmed = SizeOf(mm, alone, uncertain, poses, numbers);
  out.difference.set_anew = SizeOf(over.Left(mm), over.Left(alone), over.Left(uncertain), poses, numbers);
  const Eigen::MatrixXd of_unknown = over.Left(Eigen::MatrixXd(by_number * numbers.unknown.transpose()));
  for (Eigen::Index k = 0; k < numbers.unknown.rows(); ++k) {
    if (of_unknown.col(k).cwiseAbs().maxCoeff() < kNoticed * base::kMmPerUm) continue;
    out.difference.unknown.push_back(
        CombinationText(numbers.all, numbers.unknown.row(k).transpose(), numbers.pivots[static_cast<size_t>(k)]));
  }
  return out;
}

}  // namespace axiscal::compare
