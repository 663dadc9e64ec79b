#include "core/shapes/temperatures.h"

#include <algorithm>
#include <cmath>

#include "core/base/mutex.h"

namespace axiscal::shapes {

struct Temperatures::Memory {
  struct Kept {
    const Channel* channel = nullptr;
    double tau_s = 0.0;
    std::vector<Late> late;
  };
  base::Mutex mutex;
  std::vector<Kept> kept AXISCAL_GUARDED_BY(mutex);  // the last one computed is the last
};

Temperatures::Temperatures(std::vector<double> time_s, std::vector<Channel> channels)
    : time_s_(std::move(time_s)), channels_(std::move(channels)), memory_(std::make_unique<Memory>()) {}
Temperatures::~Temperatures() = default;

const Temperatures::Channel* Temperatures::Find(const std::string& name) const {
  for (const Channel& channel : channels_) {
    if (channel.name == name) return &channel;
  }
  return nullptr;
}

Temperatures::Late Temperatures::At(const Channel& channel, double tau_s, int moment) const {
  if (!(tau_s > 0.0)) return {channel.celsius[static_cast<size_t>(moment)], 0.0};
  constexpr size_t kMostKept = 24;  // more than a model has of them, so that none is computed again at every reading
  const base::MutexLock lock(memory_->mutex);
  std::vector<Memory::Kept>& kept = memory_->kept;
  for (size_t i = kept.size(); i-- > 0;) {
    if (kept[i].channel == &channel && kept[i].tau_s == tau_s) return kept[i].late[static_cast<size_t>(moment)];
  }
  if (kept.size() == kMostKept) kept.erase(kept.begin());
  kept.push_back({&channel, tau_s, LateOf(time_s_, channel.celsius, tau_s)});
  return kept.back().late[static_cast<size_t>(moment)];
}

std::vector<Temperatures::Late> LateOf(const std::vector<double>& time_s, const std::vector<double>& celsius,
                                       double tau_s) {
  std::vector<Temperatures::Late> late(celsius.size());
  if (!late.empty()) late[0].celsius = celsius[0];
  for (size_t k = 1; k < late.size(); ++k) {
    const double elapsed_s = time_s[k] - time_s[k - 1], change = celsius[k] - celsius[k - 1];
    if (!(elapsed_s > 0.0)) {
      late[k] = late[k - 1];
      continue;
    }
    // 1 - e by expm1, as a slow body changes by little from moment to moment.
    const double goes = -std::expm1(-elapsed_s / tau_s), keeps = 1.0 - goes;
    const double keeps_per_s = keeps * elapsed_s / (tau_s * tau_s);
    late[k].celsius = late[k - 1].celsius * keeps + celsius[k - 1] * goes + change * (1.0 - tau_s / elapsed_s * goes);
    late[k].per_s = late[k - 1].per_s * keeps + (late[k - 1].celsius - celsius[k - 1]) * keeps_per_s +
                    change * (tau_s / elapsed_s * keeps_per_s - goes / elapsed_s);
  }
  return late;
}

}  // namespace axiscal::shapes
