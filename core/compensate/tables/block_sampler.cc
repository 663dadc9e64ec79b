#include "core/compensate/tables/block_sampler.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>

#include "core/compensate/bend.h"
#include "core/compensate/tables/text.h"

namespace axiscal::tables {
namespace {

using compensate::Curve;
using compensate::TableBlock;
using compensate::TableColumn;
using machine::ErrorTerm;

constexpr int kLeastSamples = 2000, kMostSamples = 60000;
constexpr double kSamplesPerPeriod = 32.0;
constexpr double kMoreNodes = 1.2;  // growth of the number of equal steps that is tried next

struct EqualSteps {
  double start = 0.0, step = 0.0;
  size_t count = 0;
};

// At most `points` nodes at equal steps that span the range; with the reference among them where the format asks.
EqualSteps StepsFor(const Plan& plan, int argument, size_t points) {
  const compensate::TableRange& range = plan.ranges[argument];
  const double least = plan.position_step(argument), travel = range.max - range.min;
  constexpr double kRounding = 1e-6;
  const auto whole = [](double steps) { return std::ceil(steps - kRounding); };
  double step = least * std::max(1.0, whole(travel / static_cast<double>(points - 1) / least));
  if (plan.format.limits.power_of_two_steps) step = least * std::exp2(whole(std::log2(step / least)));
  if (!plan.format.limits.from_reference) {
    const double start = least * std::floor(range.min / least + kRounding);
    return {start, step, static_cast<size_t>(std::max(1.0, whole((range.max - start) / step))) + 1};
  }
  // Of all ways to spread the steps over both sides of the reference the one with the shortest step.
  const double reference = Round(plan.reference.position[argument], least);
  const double lower = std::max(0.0, reference - range.min), upper = std::max(0.0, range.max - reference);
  step = std::numeric_limits<double>::infinity();
  for (size_t below = 0; below < points; ++below) {
    const double above = static_cast<double>(points - 1 - below);
    if ((below == 0 && lower > kRounding) || (above == 0 && upper > kRounding)) continue;
    const double longest =
        std::max(below == 0 ? 0.0 : lower / static_cast<double>(below), above == 0 ? 0.0 : upper / above);
    step = std::min(step, least * std::max(1.0, whole(longest / least)));
  }
  const double below = whole(lower / step), above = whole(upper / step);
  return {reference - below * step, step, static_cast<size_t>(below + above) + 1};
}

// Whether increments from node to node stay within what the controller's smallest step allows.
bool IncrementsFit(const Sampler& sampler, const Curve& curve, const std::vector<double>& nodes) {
  const Plan& plan = sampler.plan;
  if (plan.format.limits.most_increments == 0) return true;
  for (size_t f = 0; f < curve.values.size(); ++f) {
    const std::vector<double> values = compensate::FitNodes(curve.position, curve.values[f], nodes);
    const double most = plan.format.limits.most_increments * plan.value_step(sampler.argument) /
                        sampler.tolerance[f % sampler.tolerance.size()];
    for (size_t i = 0; i + 1 < values.size(); ++i) {
      if (std::abs(values[i + 1] - values[i]) > most) return false;
    }
  }
  return true;
}

absl::StatusOr<std::vector<double>> ChooseEqual(const Sampler& sampler) {
  const Plan& plan = sampler.plan;
  const auto most = static_cast<size_t>(plan.max_points);
  size_t points =
      static_cast<size_t>(std::max(plan.format.limits.min_points, plan.format.limits.from_reference ? 3 : 2));
  while (true) {
    points = std::min(points, most);
    const EqualSteps steps = StepsFor(plan, sampler.argument, points);
    std::vector<double> nodes = EqualNodes(steps.start, steps.step, steps.count);
    if (points == most) return nodes;
    // Fewer samples than bends between the nodes would not show what those leave.
    const size_t count = std::max(sampler.sample_count() / 2, 8 * nodes.size());
    ASSIGN_OR_RETURN(const Curve curve, sampler.Sample(sampler.Even(nodes.front(), nodes.back(), count,
                                                                    plan.position_step(sampler.argument))));
    const double departure =
        sampler.is_fitted ? compensate::LargestDeparture(curve, nodes) : compensate::LargestOwnDeparture(curve, nodes);
    if (departure <= 1.0 && IncrementsFit(sampler, curve, nodes)) return nodes;
    points = std::max(points + 1, static_cast<size_t>(static_cast<double>(points) * kMoreNodes));
  }
}

}  // namespace

size_t Sampler::sample_count() const {
  const compensate::TableRange& range = plan.ranges[argument];
  double count = kLeastSamples;
  for (const ErrorTerm& term : plan.sampled.terms) {
    if (const auto* curve = shapes::CurveOf(term.shape); curve != nullptr && curve->axis == argument) {
      const int order = curve->span.OrderOf(curve->functions - 1, shapes::Curve::kFirst);
      constexpr double kEighths = 8.0;  // SmoothTravel is one of a period
      count = std::max(count, kSamplesPerPeriod * (range.max - range.min) /
                                  (kEighths * compensate::SmoothTravel(curve->span, order)));
    }
    const auto* harmonic = std::get_if<shapes::Harmonic>(&term.shape);
    if (harmonic == nullptr || harmonic->axis != argument) continue;
    const double periods = (range.max - range.min) * std::abs(harmonic->frequency) / (2.0 * std::numbers::pi);
    count = std::max(count, kSamplesPerPeriod * periods);
  }
  return static_cast<size_t>(std::min<double>(count, kMostSamples));
}

absl::StatusOr<Curve> Sampler::Sample(const std::vector<double>& positions) const {
  Curve curve;
  curve.position = positions;
  const size_t columns = tolerance.size();
  curve.values.assign(columns * (by_sense ? 2 : 1), {});
  std::vector<double> values(columns);
  for (const double position : positions) {
    for (size_t s = 0; s < (by_sense ? 2u : 1u); ++s) {
      RETURN_IF_ERROR(evaluate(position, !by_sense ? 0.0 : s == 0 ? 1.0 : -1.0, &values));
      for (size_t c = 0; c < columns; ++c) curve.values[s * columns + c].push_back(values[c] / tolerance[c]);
    }
  }
  return curve;
}

std::vector<double> Sampler::Even(double from, double to, size_t count, double step) const {
  std::vector<double> positions;
  for (size_t i = 0; i < count; ++i) {
    const double position = Round(from + (to - from) * static_cast<double>(i) / static_cast<double>(count - 1), step);
    if (positions.empty() || position > positions.back()) positions.push_back(position);
  }
  return positions;
}
absl::StatusOr<std::vector<double>> ChooseNodes(const Sampler& sampler) {
  const Plan& plan = sampler.plan;
  if (plan.format.limits.equal_steps) return ChooseEqual(sampler);
  const compensate::TableRange& range = plan.ranges[sampler.argument];
  const double step = plan.position_step(sampler.argument);
  ASSIGN_OR_RETURN(const Curve curve, sampler.Sample(sampler.Even(range.min, range.max, sampler.sample_count(), step)));
  std::vector<double> nodes;
  for (const size_t i : compensate::BestFreeNodes(curve, static_cast<size_t>(plan.max_points)))
    nodes.push_back(curve.position[i]);
  return nodes;
}

absl::StatusOr<TableBlock> SampleBlock(const Sampler& sampler, const std::vector<int>& targets) {
  TableBlock block;
  ASSIGN_OR_RETURN(std::vector<double> nodes, ChooseNodes(sampler));
  const double step = sampler.plan.position_step(sampler.argument);
  const size_t count = std::max(sampler.sample_count(), std::min<size_t>(kMostSamples, 8 * nodes.size()));
  ASSIGN_OR_RETURN(const Curve curve, sampler.Sample(sampler.Even(nodes.front(), nodes.back(), count, step)));
  for (size_t c = 0; c < targets.size(); ++c) {
    TableColumn column;
    column.target = targets[c];
    column.forward = compensate::FitNodes(curve.position, curve.values[c], nodes);
    if (sampler.by_sense && curve.values[c] != curve.values[targets.size() + c])
      column.reverse = compensate::FitNodes(curve.position, curve.values[targets.size() + c], nodes);
    for (double& value : column.forward) value *= sampler.tolerance[c];
    for (double& value : column.reverse) value *= sampler.tolerance[c];
    block.columns.push_back(std::move(column));
  }
  block.arguments.push_back({sampler.argument, std::move(nodes)});
  return block;
}

}  // namespace axiscal::tables
