#include "core/synthetic/history.h"

#include <algorithm>
#include <cmath>

namespace axiscal::synthetic {

bool History::BeginsSession(size_t moment) const {
  return std::binary_search(session_begin.begin(), session_begin.end(), moment);
}

shapes::State History::StateOf(size_t moment) const {
  const auto channel = celsius.find("temp_C");
  return {{axis_states.data() + moment * axis_count, static_cast<size_t>(axis_count)},
          time_s[moment],
          channel == celsius.end() ? shapes::kReferenceTemperatureCelsius : channel->second[moment],
          {},
          temperatures.get(),
          static_cast<int>(moment)};
}

std::vector<double> History::PathOf(int axis) const {
  std::vector<double> path(size());
  for (size_t k = 0; k < path.size(); ++k) path[k] = PositionsOf(k)[axis];
  return path;
}

void Append(const instruments::MeasuringRun& run, const std::map<std::string, std::vector<double>>& celsius,
            History* history) {
  history->axis_count = run.axis_count;
  history->session_begin.push_back(history->size());
  history->positions.insert(history->positions.end(), run.positions.begin(), run.positions.end());
  history->axis_states.insert(history->axis_states.end(), run.axis_states->begin(), run.axis_states->end());
  history->time_s.insert(history->time_s.end(), run.time_s.begin(), run.time_s.end());
  for (const auto& [name, values] : celsius) {
    std::vector<double>& channel = history->celsius[name];
    channel.insert(channel.end(), values.begin(), values.end());
  }
  std::vector<shapes::Temperatures::Channel> channels;
  for (const auto& [name, values] : history->celsius) channels.push_back({name, values});
  history->temperatures = std::make_shared<const shapes::Temperatures>(history->time_s, std::move(channels));
}

Range RangeOf(const History& history, int axis) {
  Range range{INFINITY, -INFINITY};
  for (size_t k = 0; k < history.size(); ++k) {
    const double value = axis < 0 ? history.time_s[k] : history.PositionsOf(k)[axis];
    range = {std::min(range.low, value), std::max(range.high, value)};
  }
  return range;
}

Path::Path(const History& history, int axis)
    : time_s_(history.time_s), position_(history.PathOf(axis)), speed_(history.size(), 0.0) {
  const size_t count = history.size();
  for (size_t k = 0; k < count; ++k) {
    const size_t before = k == 0 || history.BeginsSession(k) ? k : k - 1;
    const size_t after = k + 1 == count || history.BeginsSession(k + 1) ? k : k + 1;
    const double elapsed_s = time_s_[after] - time_s_[before];
    if (elapsed_s > 0.0) speed_[k] = (position_[after] - position_[before]) / elapsed_s;
  }
}

Path::Point Path::At(size_t moment, double time_s) const {
  if (moment + 1 >= time_s_.size()) return {position_.back(), 0.0, 0.0};
  const double step = time_s_[moment + 1] - time_s_[moment];
  if (!(step > 0.0)) return {position_[moment + 1], speed_[moment + 1], 0.0};
  const double u = (time_s - time_s_[moment]) / step;
  const double p0 = position_[moment], p1 = position_[moment + 1];
  const double m0 = speed_[moment] * step, m1 = speed_[moment + 1] * step;
  // p(u) = p0 + m0 u + b u^2 + a u^3
  const double a = 2.0 * (p0 - p1) + m0 + m1, b = 3.0 * (p1 - p0) - 2.0 * m0 - m1;
  return {p0 + u * (m0 + u * (b + u * a)), (m0 + u * (2.0 * b + 3.0 * a * u)) / step,
          (2.0 * b + 6.0 * a * u) / (step * step)};
}

double Path::PositionAt(double time_s) const {
  if (time_s <= time_s_.front()) return position_.front() + speed_.front() * (time_s - time_s_.front());
  if (time_s >= time_s_.back()) return position_.back() + speed_.back() * (time_s - time_s_.back());
  const auto after = std::upper_bound(time_s_.begin(), time_s_.end(), time_s);
  return At(static_cast<size_t>(after - time_s_.begin()) - 1, time_s).position;
}

}  // namespace axiscal::synthetic
