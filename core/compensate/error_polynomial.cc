#include "core/compensate/error_polynomial.h"

#include <Eigen/Geometry>
#include <cstring>

namespace axiscal::compensate {
namespace {

constexpr int kProducts = 9;

// A vector as factors of the products: 3 i + k belongs to term i of the first turn and term k of the second.
struct Expanded {
  Eigen::Vector3d factor[kProducts];

  explicit Expanded(const Eigen::Vector3d& constant) {
    for (Eigen::Vector3d& each : factor) each.setZero();
    factor[0] = constant;
  }
  void Rotate(const Eigen::Matrix3d& rotation) {
    for (Eigen::Vector3d& each : factor) each = (rotation * each).eval();
  }
  void Turn(const Eigen::Vector3d& direction, int turn) {
    const int step = turn == 0 ? 3 : 1;
    for (int i = 0; i < kProducts; ++i) {
      if (i / step % 3 != 0) continue;
      factor[i + step] = direction.cross(factor[i]);
      factor[i + 2 * step] = direction.cross(factor[i + step]);
    }
  }
};

// The tool point with the linear axes at zero, the tool's direction, and the tool point's motion per mm of each axis.
struct ExpandedTool {
  Expanded tip, direction, columns[3];
};

ExpandedTool Expand(const FoldedChain& chain, const Eigen::Vector3d& tip_mm, const Eigen::Vector3d& tool_direction) {
  const Expanded nothing{Eigen::Vector3d::Zero()};
  ExpandedTool tool{Expanded(tip_mm), Expanded(tool_direction), {nothing, nothing, nothing}};
  int turn = 0;
  for (const FoldedChain::Stage& stage : chain.stages) {
    if (stage.has_rotation) {
      for (Expanded* each : {&tool.tip, &tool.direction, &tool.columns[0], &tool.columns[1], &tool.columns[2]})
        each->Rotate(stage.rotation);
    }
    tool.tip.factor[0] += stage.translation_mm;
    for (int k = 0; stage.has_columns && k < 3; ++k) tool.columns[k].factor[0] += stage.columns.of_axis[k];
    if (stage.turn_axis < 0) continue;
    for (Expanded* each : {&tool.tip, &tool.direction, &tool.columns[0], &tool.columns[1], &tool.columns[2]})
      each->Turn(stage.turn_direction, turn);
    ++turn;
  }
  return tool;
}

}  // namespace

std::optional<ErrorPolynomial> ErrorPolynomial::Create(const FoldedChain& nominal, const FoldedChain& actual,
                                                       const Eigen::Vector3d& tip_mm,
                                                       const Eigen::Vector3d& tool_direction) {
  ErrorPolynomial polynomial;
  if (actual.stages.front().columns.count != 3) return std::nullopt;
  int turns = 0;
  for (const FoldedChain::Stage& stage : actual.stages) {
    if (stage.turn_axis < 0) continue;
    if (turns == 2) return std::nullopt;
    polynomial.axis_[turns] = stage.turn_axis;
    polynomial.sign_[turns++] = stage.turn_sign;
  }
  const ExpandedTool is = Expand(actual, tip_mm, tool_direction), shall = Expand(nominal, tip_mm, tool_direction);
  for (int i = 0; i < kProducts; ++i) {
    ToolErrors errors;
    for (int k = 0; k < 3; ++k) {
      errors.tip_per_mm[k] = is.columns[k].factor[i];
      errors.error_per_mm[k] = is.columns[k].factor[i] - shall.columns[k].factor[i];
    }
    errors.tip_error_mm = is.tip.factor[i] - shall.tip.factor[i];
    errors.direction_error = is.direction.factor[i] - shall.direction.factor[i];
    std::memcpy(polynomial.factors_[i], &errors, sizeof(errors));
  }
  return polynomial;
}

void ErrorPolynomial::Evaluate(const Turns& turns, ToolErrors* errors) const {
  double of_turn[2][3] = {{1, 0, 0}, {1, 0, 0}};
  for (int turn = 0; turn < 2; ++turn) {
    if (axis_[turn] < 0) continue;
    of_turn[turn][1] = sign_[turn] * turns.sine[axis_[turn]];
    of_turn[turn][2] = turns.one_minus_cosine[axis_[turn]];
  }
  double products[kProducts];
  for (int i = 0; i < kProducts; ++i) products[i] = of_turn[0][i / 3] * of_turn[1][i % 3];
  // Two numbers at once. Four (AVX) measured slower as a whole: the processor's clock goes down for them.
  using Two = double __attribute__((vector_size(16)));
  for (int j = 0; j < kNumbers; j += 2) {
    Two sums[3];
    for (int i = 0; i < kProducts; ++i) {
      Two factor;
      std::memcpy(&factor, &factors_[i][j], sizeof(factor));
      sums[i / 3] = i % 3 == 0 ? factor * products[i] : sums[i / 3] + factor * products[i];
    }
    const Two sum = sums[0] + sums[1] + sums[2];
    std::memcpy(reinterpret_cast<char*>(errors) + static_cast<size_t>(j) * sizeof(double), &sum, sizeof(sum));
  }
}

}  // namespace axiscal::compensate
