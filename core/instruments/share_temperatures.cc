#include <algorithm>

#include "core/instruments/run.h"

namespace axiscal::instruments {
namespace {

using Channels = std::vector<shapes::Temperatures::Channel>;

Channels ChannelsOf(const MeasuringRun& run) {
  Channels channels;
  if (run.has_temperature) channels.push_back({shapes::kTemperatureChannel, run.temperature_celsius});
  for (const MeasuringRun::Channel& one : run.temperatures) channels.push_back({ColumnOf(one), one.celsius});
  return channels;
}

// The same channels in the same order.
bool Match(const Channels& a, const Channels& b) {
  return std::equal(a.begin(), a.end(), b.begin(), b.end(),
                    [](const auto& one, const auto& other) { return one.name == other.name; });
}

// Sessions that follow each other, their temperatures one behind the other.
struct Sequence {
  std::vector<MeasuringRun*> runs;
  std::vector<double> time_s;
  Channels channels;

  void Close() {
    if (runs.empty()) return;
    const auto history = std::make_shared<const shapes::Temperatures>(std::move(time_s), std::move(channels));
    for (MeasuringRun* run : runs) run->history = history;
    *this = {};
  }
};

}  // namespace

void ShareTemperatures(const std::vector<std::vector<MeasuringRun>*>& sessions) {
  std::vector<MeasuringRun*> in_order;
  for (std::vector<MeasuringRun>* some : sessions) {
    for (MeasuringRun& run : *some) {
      const bool has_any = run.has_temperature || !run.temperatures.empty();
      if (run.history == nullptr && has_any && run.reading_count() > 0 && run.path_readings == nullptr)
        in_order.push_back(&run);
    }
  }
  std::stable_sort(in_order.begin(), in_order.end(),
                   [](const MeasuringRun* a, const MeasuringRun* b) { return a->time_s.front() < b->time_s.front(); });
  Sequence sequence;
  for (MeasuringRun* run : in_order) {
    Channels channels = ChannelsOf(*run);
    const bool follows = !sequence.runs.empty() && run->has_time && sequence.runs.back()->has_time &&
                         sequence.time_s.back() <= run->time_s.front() && Match(sequence.channels, channels);
    if (!follows) {
      sequence.Close();
      sequence.channels.resize(channels.size());
      for (size_t i = 0; i < channels.size(); ++i) sequence.channels[i].name = channels[i].name;
    }
    run->first_moment = static_cast<int>(sequence.time_s.size());
    sequence.runs.push_back(run);
    sequence.time_s.insert(sequence.time_s.end(), run->time_s.begin(), run->time_s.end());
    for (size_t i = 0; i < channels.size(); ++i) {
      std::vector<double>& celsius = sequence.channels[i].celsius;
      celsius.insert(celsius.end(), channels[i].celsius.begin(), channels[i].celsius.end());
    }
  }
  sequence.Close();
}

}  // namespace axiscal::instruments
