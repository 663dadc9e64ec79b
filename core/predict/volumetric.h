// The volumetric error of a machine over the box of axis positions that sessions covered: the root mean square of the
// tool point's error (tool_point.h) at poses anywhere in the box, less the work offset (a shift in the table's frame)
// and the tool's length and centre (a shift in the tool's frame) that suit all poses best. These two are set anew
// before a part is cut, and no sessions tell them from the errors.
#ifndef AXISCAL_CORE_PREDICT_VOLUMETRIC_H_
#define AXISCAL_CORE_PREDICT_VOLUMETRIC_H_

#include <Eigen/Core>
#include <optional>
#include <string>
#include <vector>

#include "core/instruments/run.h"
#include "core/predict/box_poses.h"
#include "core/predict/tool_point.h"

namespace axiscal::predict {

// Positions that the readings of `runs` covered; empty without readings.
Box MeasuredBox(const std::vector<instruments::MeasuringRun>& runs);

// States at poses drawn evenly from a box, one after the other, no axis faster than it was in the runs.
// Time, temperature and whatever else a state holds are those of readings drawn from the runs: nothing is said of times
// and temperatures that nobody measured. The same runs give the same states.
class BoxStates {
 public:
  // `runs`: at least one reading; must outlive it. Without `box`: MeasuredBox().
  BoxStates(const std::vector<instruments::MeasuringRun>& runs, int count, const std::optional<Box>& box = {});

  const Box& box() const { return box_; }
  int count() const { return path_.reading_count(); }
  shapes::State At(int pose) const;
  const double* PositionsOf(int pose) const { return path_.PositionsOf(pose); }

 private:
  struct Reading {
    const instruments::MeasuringRun* run = nullptr;
    int reading = 0;
  };

  Box box_;
  instruments::MeasuringRun path_;  // positions and motion of the poses
  std::vector<Reading> at_;         // whose time and temperature a pose has
};

// Root of the expected mean square, and the 95 % interval, mm.
struct RootMeanSquare {
  double expected_mm = 0.0, low_mm = 0.0, high_mm = 0.0;
};

// An error that the readings do not tell from others: one of these models may hold in place of what was found.
struct OpenChoice {
  struct Rival {
    machine::ErrorModel model;
    double odds = 0.0;  // against what was found
  };
  std::string name;              // of the error that was found
  machine::ErrorModel as_found;  // what the rivals were fitted beside
  std::vector<Rival> rivals;
};

struct VolumetricError {
  Box box;
  int poses = 0;
  // Of the machine as it is; where it is corrected for the errors of `before`, whose values count as they are; where it
  // is corrected for those that were found and have a name. Their covariance and the open choices are what the
  // expectation is over: what they do not model is in none of these.
  RootMeanSquare uncorrected, before, after;
  // The interval of the difference of `before` and `after` is above zero.
  bool is_gain_held = false;
  // Numbers (machine::NameNumber) whose uncertainty makes most of `after`, each a quarter of its square or more; the
  // largest first. Of the open choices the same.
  std::vector<std::string> weakest, undecided;
  // Of the numbers `unknown`: those that move the tool point over the box. What they do is in none of the figures.
  std::vector<std::string> unknown;
};

// `found`: errors with their covariance, as they were fitted to `runs`; `before`: the errors that would be corrected
// without them. `unknown`: names (machine::NameNumber) of numbers of `found` that nothing is known of. `choices`: which
// rival acts is drawn by its odds, each choice by itself. Nothing where there is no covariance or the runs moved no
// axis.
std::optional<VolumetricError> VolumetricErrorOver(const machine::Machine& machine,
                                                   const std::vector<instruments::MeasuringRun>& runs,
                                                   const machine::ErrorModel& before, const machine::KnownErrors& found,
                                                   const std::vector<std::string>& unknown = {},
                                                   const std::vector<OpenChoice>& choices = {});

}  // namespace axiscal::predict

#endif  // AXISCAL_CORE_PREDICT_VOLUMETRIC_H_
