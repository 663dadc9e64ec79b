#include "core/information/choice.h"

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>
#include <limits>

#include "core/information/null_space.h"
#include "core/information/smallest_set.h"

namespace axiscal::information {
namespace {

Told Nothing(size_t asked_count) {
  return {std::vector<bool>(asked_count, false),
          std::vector<double>(asked_count, std::numeric_limits<double>::quiet_NaN())};
}

}  // namespace

bool Told::IsBetterThan(const Told& other) const {
  if (determined_count != other.determined_count) return determined_count > other.determined_count;
  constexpr double kRounding = 1e-9;
  return log_determinant < other.log_determinant - kRounding;
}

std::vector<int> Told::Undetermined() const {
  std::vector<int> undetermined;
  for (size_t i = 0; i < is_determined.size(); ++i) {
    if (!is_determined[i]) undetermined.push_back(static_cast<int>(i));
  }
  return undetermined;
}

Told Tell(const TestInformation& together, const std::vector<int>& asked) {
  Told told = Nothing(asked.size());
  const NullSpace null_space = FindNullSpace(together.identifying);
  std::vector<int> free;
  for (int i = 0; i < static_cast<int>(null_space.involved.size()); ++i) {
    if (std::find(null_space.fixed.begin(), null_space.fixed.end(), i) == null_space.fixed.end()) free.push_back(i);
  }
  if (free.empty()) return told;
  const Eigen::MatrixXd covariance = CovarianceOf(together.informing, free);
  std::vector<int> seen;
  for (size_t i = 0; i < asked.size(); ++i) {
    const auto place = std::find(free.begin(), free.end(), asked[i]);
    if (null_space.involved[asked[i]] || place == free.end()) continue;
    told.is_determined[i] = true;
    ++told.determined_count;
    seen.push_back(static_cast<int>(place - free.begin()));
    told.sigma[i] = std::sqrt(std::max(0.0, covariance(seen.back(), seen.back())));
  }
  if (seen.empty()) return told;
  constexpr double kMicro2 = 1e6;  // um and urad
  const Eigen::MatrixXd block = covariance(seen, seen) * kMicro2;
  const Eigen::VectorXd pivots = block.ldlt().vectorD();
  for (Eigen::Index i = 0; i < pivots.size(); ++i) told.log_determinant += std::log(std::max(pivots[i], 1e-300));
  return told;
}

Choice ChooseTests(const std::vector<TestInformation>& tests, const std::vector<int>& asked) {
  if (tests.empty()) return {{}, Nothing(asked.size())};
  const auto tell = [&](const std::vector<int>& set) {
    TestInformation together = tests[set[0]];
    for (size_t i = 1; i < set.size(); ++i) together += tests[set[i]];
    return Tell(together, asked);
  };
  auto [chosen, told] = SmallestSet(static_cast<int>(tests.size()), tell);
  if (told.determined_count == 0) chosen.clear();  // nobody runs a test that tells nothing of what was asked
  return {std::move(chosen), std::move(told)};
}

}  // namespace axiscal::information
