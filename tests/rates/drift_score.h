// How often the detector of drift is right on simulated machines (core/synthetic/machine_years.h): counts over many
// histories, and the table that docs/drift.md shows.
#ifndef AXISCAL_TESTS_RATES_DRIFT_SCORE_H_
#define AXISCAL_TESTS_RATES_DRIFT_SCORE_H_

#include <array>
#include <deque>
#include <map>
#include <string>
#include <vector>

#include "core/drift/detector.h"
#include "core/drift/forecast.h"
#include "core/synthetic/machine_years.h"

namespace axiscal::rates {

struct Share {
  int right = 0, all = 0;
  void Add(bool is_right) { right += is_right, ++all; }
  double share() const { return all > 0 ? static_cast<double>(right) / all : 0.0; }
};

// False alarms over machine-years.
struct FalseAlarms {
  double years = 0.0;
  int alarms = 0;
  double in_ten_years() const { return years > 0.0 ? 10.0 * alarms / years : 0.0; }
};

// Of a step: found with the second, third, fourth, eighth calibration after it.
struct Recall {
  static constexpr std::array<int, 4> kWithin = {2, 3, 4, 8};
  int all = 0;
  std::array<int, 4> found{};
};

struct DriftScore {
  int machines = 0;
  int64_t calibrations = 0;
  double seconds = 0.0;                      // of processor, in Advance
  FalseAlarms first;                         // in the first 26 calibrations of machines
  std::map<std::string, FalseAlarms> after;  // after them, by kind of machine; "all"
  std::map<std::string, Recall> recall;      // by size of step
  Share dated, named, named_of_moved;        // within one calibration; named errors that moved; moved ones named
  std::array<Share, 8> certainty;            // right alarms, by stated certainty (kCertainties)
  std::array<double, 8> stated{};            // sum of stated certainties
  std::array<Share, 12> by_score;            // right alarms, by score (kScores)
  Share suspected;                           // outliers that were told at once
  int suspects = 0, unstable = 0, revisions = 0, retractions = 0;
  int retracted_right = 0;                           // steps that were taken back though they were true
  Share seasons, seasons_right, wears, wears_right;  // true ones that were told; told ones that are true
  std::map<std::string, Share> forecasts;            // in the 90 % interval, by horizon
  std::map<std::string, Share> crossings;            // seen, by class of stated probability
  std::map<std::string, double> crossing_stated;
};
inline constexpr std::array<double, 8> kCertainties = {0.0, 0.45, 0.55, 0.7, 0.8, 0.9, 0.96, 0.985};
inline constexpr std::array<double, 12> kScores = {-99, -1, -0.5, 0, 0.5, 1, 2, 3, 4, 6, 8, 12};

// States of earlier machines at the same age, from which the prior of forecasts is made.
using Group = std::map<int, std::deque<drift::State>>;

// Goes through the history and adds what came out. `with_forecasts`: forecasts and crossings too.
void Judge(const synthetic::MachineYears& machine, bool with_forecasts, Group* group, DriftScore* score);

std::string ToText(const DriftScore& score);

}  // namespace axiscal::rates

#endif  // AXISCAL_TESTS_RATES_DRIFT_SCORE_H_
