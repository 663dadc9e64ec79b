#include "core/figures/positioning.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace axiscal::figures {
namespace {

std::optional<Direction> DirectionOf(const std::vector<double>& deviations_mm) {
  if (deviations_mm.empty()) return std::nullopt;
  Direction out;
  out.approaches = static_cast<int>(deviations_mm.size());
  for (const double one : deviations_mm) out.mean_mm += one / out.approaches;
  if (out.approaches < 2) return out;
  double squares = 0.0;
  for (const double one : deviations_mm) squares += (one - out.mean_mm) * (one - out.mean_mm);
  out.deviation_mm = std::sqrt(squares / (out.approaches - 1));
  return out;
}

// Largest less smallest of what was added.
class Range {
 public:
  void Add(double low, double high) {
    low_ = std::min(low_, low);
    high_ = std::max(high_, high);
  }
  std::optional<double> width() const { return low_ <= high_ ? std::optional<double>(high_ - low_) : std::nullopt; }

 private:
  double low_ = std::numeric_limits<double>::infinity(), high_ = -std::numeric_limits<double>::infinity();
};

void AddScattered(const Direction& direction, Range* range) {
  range->Add(direction.mean_mm - 2.0 * *direction.deviation_mm, direction.mean_mm + 2.0 * *direction.deviation_mm);
}

Unidirectional OneWay(const std::vector<Target>& targets, std::optional<Direction> Target::*way) {
  Unidirectional out;
  Range means, scattered;
  double largest_mm = 0.0;
  bool is_repeated = true;
  for (const Target& target : targets) {
    const std::optional<Direction>& direction = target.*way;
    if (!direction) continue;
    means.Add(direction->mean_mm, direction->mean_mm);
    is_repeated = is_repeated && direction->deviation_mm.has_value();
    if (!is_repeated) continue;
    largest_mm = std::max(largest_mm, *direction->deviation_mm);
    AddScattered(*direction, &scattered);
  }
  out.systematic_mm = means.width();
  if (!out.systematic_mm || !is_repeated) return out;
  out.repeatability_mm = 4.0 * largest_mm;
  out.accuracy_mm = scattered.width();
  return out;
}

void BothWays(Positioning* out) {
  Range means, of_both, scattered;
  double reversal_mm = 0.0, sum_mm = 0.0, repeatability_mm = 0.0;
  int count = 0;
  bool is_repeated = true;
  for (const Target& target : out->targets) {
    if (!target.up || !target.down) continue;
    const Direction &up = *target.up, &down = *target.down;
    const double reversal = up.mean_mm - down.mean_mm;
    ++count;
    sum_mm += reversal;
    reversal_mm = std::max(reversal_mm, std::abs(reversal));
    means.Add(std::min(up.mean_mm, down.mean_mm), std::max(up.mean_mm, down.mean_mm));
    of_both.Add(0.5 * (up.mean_mm + down.mean_mm), 0.5 * (up.mean_mm + down.mean_mm));
    is_repeated = is_repeated && up.deviation_mm && down.deviation_mm;
    if (!is_repeated) continue;
    repeatability_mm =
        std::max({repeatability_mm, 2.0 * *up.deviation_mm + 2.0 * *down.deviation_mm + std::abs(reversal),
                  4.0 * *up.deviation_mm, 4.0 * *down.deviation_mm});
    AddScattered(up, &scattered);
    AddScattered(down, &scattered);
  }
  if (count == 0) return;
  out->systematic_mm = means.width();
  out->mean_mm = of_both.width();
  out->reversal_mm = reversal_mm;
  out->mean_reversal_mm = sum_mm / count;
  if (!is_repeated) return;
  out->repeatability_mm = repeatability_mm;
  out->accuracy_mm = scattered.width();
}

// Where others were repeated; how many.
int LeaveOutOnce(std::vector<Target>* targets) {
  const auto is_once = [](const std::optional<Direction>& one) { return one && one->approaches == 1; };
  int once = 0, all = 0;
  for (const Target& target : *targets) {
    once += is_once(target.up) + is_once(target.down);
    all += target.up.has_value() + target.down.has_value();
  }
  if (once == all) return 0;
  for (Target& target : *targets) {
    if (is_once(target.up)) target.up.reset();
    if (is_once(target.down)) target.down.reset();
  }
  return once;
}

}  // namespace

Positioning PositioningOf(std::vector<Approach> approaches, double same) {
  Positioning out;
  std::stable_sort(approaches.begin(), approaches.end(),
                   [](const Approach& a, const Approach& b) { return a.target < b.target; });
  out.fewest_approaches = std::numeric_limits<int>::max();
  for (size_t first = 0; first < approaches.size();) {
    Target target;
    target.target = approaches[first].target;
    std::vector<double> up, down;
    size_t next = first;
    for (; next < approaches.size() && approaches[next].target - target.target <= same; ++next)
      (approaches[next].sense > 0.0 ? up : down).push_back(approaches[next].deviation_mm);
    target.up = DirectionOf(up);
    target.down = DirectionOf(down);
    out.targets.push_back(target);
    first = next;
  }
  out.approached_once = LeaveOutOnce(&out.targets);
  for (const Target& target : out.targets)
    for (const std::optional<Direction>& direction : {target.up, target.down})
      if (direction) out.fewest_approaches = std::min(out.fewest_approaches, direction->approaches);
  if (out.targets.empty()) out.fewest_approaches = 0;
  out.up = OneWay(out.targets, &Target::up);
  out.down = OneWay(out.targets, &Target::down);
  BothWays(&out);
  return out;
}

}  // namespace axiscal::figures
