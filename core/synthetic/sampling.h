// Plans made like sessions that were really measured: thinner, slower, with readings lost, and in changing temperature.
#ifndef AXISCAL_CORE_SYNTHETIC_SAMPLING_H_
#define AXISCAL_CORE_SYNTHETIC_SAMPLING_H_

#include <functional>
#include <string>
#include <vector>

#include "core/base/random.h"
#include "core/session/session.h"

namespace axiscal::synthetic {

struct Sampling {
  int stride = 1;            // every so manieth reading
  double kept_share = 1.0;   // of the readings, each by chance: irregular steps
  double lost_share = 0.0;   // of each session, one stretch that is missing
  double slower = 1.0;       // factor on all times
  double time_jitter = 0.0;  // every time is late by up to this share of the step that follows it: uneven speeds
  double gap_s = 300.0;      // between sessions of which the later one would begin before the earlier one ended
};

// A temperature over time: start + rise (1 - exp(-t / tau)) + per hour + swing sin(2 pi t / period), deg C.
struct Temperature {
  std::string name = "temp_C";  // of its column, and of the effects that follow it
  bool is_recorded = true;      // false: it acts, and no session shows it
  double start_celsius = 20.0, rise_celsius = 0.0, tau_s = 3600.0, celsius_per_hour = 0.0;
  double swing_celsius = 0.0, period_s = 86400.0;

  double At(double time_s) const;
};

// The column to be changed, or nullptr.
session::Column* ColumnIn(session::Session* session, const std::string& name);
// Times of a session, or nothing where it has none.
const std::vector<double>* TimesOf(const session::Session& session);
// The session's column of that name with a value per time, rounded to 0.001; added behind the axes' where it had none.
void SetTemperature(const std::string& name, const std::function<double(double time_s)>& celsius,
                    session::Session* session);

// Every `stride`-th reading.
void KeepEvery(int stride, session::Session* session);
// `n` readings for each one, on straight lines between it and the next in all columns of numbers.
void Refine(int n, session::Session* session);
// All times times `factor`.
void Slow(double factor, session::Session* session);
// As `sampling` says; sessions of fewer than 40 readings (poses at rest, chosen one by one) keep all of them.
void Resample(const Sampling& sampling, base::Random* random, session::Session* session);
// Moves sessions so that each begins after the one before it (in this order) ended.
void RunOn(double gap_s, std::vector<session::Session*> sessions);

}  // namespace axiscal::synthetic

#endif  // AXISCAL_CORE_SYNTHETIC_SAMPLING_H_
