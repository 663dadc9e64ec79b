#include "core/synthetic/sampling.h"

#include <cmath>
#include <numbers>

namespace axiscal::synthetic {
namespace {

constexpr size_t kFewReadings = 40;  // fewer are poses that somebody chose, not samples of a motion

// The rows for which `keeps` is true.
void Keep(const std::vector<bool>& keeps, session::Session* session) {
  for (session::Column& column : session->columns) {
    size_t to = 0;
    for (size_t k = 0; k < keeps.size(); ++k) {
      if (!keeps[k]) continue;
      if (!column.values.empty()) column.values[to] = column.values[k];
      if (!column.texts.empty()) column.texts[to] = column.texts[k];
      ++to;
    }
    if (!column.values.empty()) column.values.resize(to);
    if (!column.texts.empty()) column.texts.resize(to);
  }
}

}  // namespace

double Temperature::At(double time_s) const {
  constexpr double kSecondsPerHour = 3600.0;
  return start_celsius + rise_celsius * (1.0 - std::exp(-time_s / tau_s)) +
         celsius_per_hour * time_s / kSecondsPerHour +
         swing_celsius * std::sin(2.0 * std::numbers::pi * time_s / period_s);
}

session::Column* ColumnIn(session::Session* session, const std::string& name) {
  return const_cast<session::Column*>(session::FindColumn(*session, name));
}

const std::vector<double>* TimesOf(const session::Session& session) {
  const session::Column* column = session::FindColumn(session, "t_s");
  return column == nullptr ? nullptr : &column->values;
}

void SetTemperature(const std::string& name, const std::function<double(double time_s)>& celsius,
                    session::Session* session) {
  const std::vector<double>* times = TimesOf(*session);
  if (times == nullptr) return;
  std::vector<double> values(times->size());
  for (size_t k = 0; k < values.size(); ++k) values[k] = std::round(1e3 * celsius((*times)[k])) / 1e3;
  if (session::Column* column = ColumnIn(session, name)) {
    column->values = std::move(values);
  } else {
    session->columns.push_back({name, std::move(values), {}});
  }
}

void KeepEvery(int stride, session::Session* session) {
  std::vector<bool> keeps(session->reading_count());
  for (size_t k = 0; k < keeps.size(); ++k) keeps[k] = k % stride == 0;
  Keep(keeps, session);
}

void Refine(int n, session::Session* session) {
  for (session::Column& column : session->columns) {
    std::vector<double> values;
    for (size_t k = 0; k + 1 < column.values.size(); ++k)
      for (int part = 0; part < n; ++part)
        values.push_back(column.values[k] + part * (column.values[k + 1] - column.values[k]) / n);
    if (!column.values.empty()) values.push_back(column.values.back());
    column.values = std::move(values);
  }
}

void Slow(double factor, session::Session* session) {
  session::Column* const time = ColumnIn(session, "t_s");
  if (time == nullptr) return;
  for (double& t : time->values) t *= factor;
}

void Resample(const Sampling& sampling, base::Random* random, session::Session* session) {
  Slow(sampling.slower, session);
  if (session->reading_count() < kFewReadings) return;
  if (sampling.stride > 1) KeepEvery(sampling.stride, session);
  std::vector<bool> keeps(session->reading_count(), true);
  if (sampling.kept_share < 1.0) {
    for (size_t k = 0; k < keeps.size(); ++k) keeps[k] = random->Uniform() < sampling.kept_share;
  }
  if (sampling.lost_share > 0.0) {
    const double lost = sampling.lost_share * static_cast<double>(keeps.size());
    const double first = random->Uniform() * (static_cast<double>(keeps.size()) - lost);
    for (size_t k = 0; k < keeps.size(); ++k) {
      if (static_cast<double>(k) >= first && static_cast<double>(k) < first + lost) keeps[k] = false;
    }
  }
  keeps.front() = keeps.back() = true;
  Keep(keeps, session);
  session::Column* const time = ColumnIn(session, "t_s");
  if (time == nullptr || sampling.time_jitter == 0.0) return;
  for (size_t k = 0; k + 1 < time->values.size(); ++k)
    time->values[k] += sampling.time_jitter * random->Uniform() * (time->values[k + 1] - time->values[k]);
  for (double& t : time->values) t = std::round(1e4 * t) / 1e4;
}

void RunOn(double gap_s, std::vector<session::Session*> sessions) {
  double ended_s = -INFINITY;
  for (session::Session* session : sessions) {
    session::Column* const time = ColumnIn(session, "t_s");
    if (time == nullptr || time->values.empty()) continue;
    if (time->values.front() <= ended_s) {
      const double later_s = ended_s + gap_s - time->values.front();
      for (double& t : time->values) t += later_s;
    }
    ended_s = time->values.back();
  }
}

}  // namespace axiscal::synthetic
