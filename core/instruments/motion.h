// The motion that led to each of a series of positions: the same states for the readings of a session (run.h) and for
// poses that are predicted. The sense of motion is that of the last commanded change; before the first change it is
// that of the first change, at the same speed (the axis is taken to come from behind and go on). Travel counts from the
// last change of sense, or from the first motion. Where it is stated from which side an axis came (an overrun that no
// position shows), that is its sense, and it turned just now if its last way went the other way. Speed is that at the
// position, not that of the way to it: the slope of the parabola through the positions before, here and next (so nearly
// none where an axis turns round); at the first and last position that of the one way there is. Acceleration is that
// of the same parabola, none at the first and the last position.
#ifndef AXISCAL_CORE_INSTRUMENTS_MOTION_H_
#define AXISCAL_CORE_INSTRUMENTS_MOTION_H_

#include <vector>

#include "core/shapes/state.h"

namespace axiscal::instruments {

// Of the way from one moment to the next; 0 where nothing moves or no time has passed.
double SpeedOf(double change, double elapsed_s);

// How each axis starts: what the first position is taken to be approached with, known once the axis has moved.
class FirstMotion {
 public:
  struct Start {
    double sense = 0.0;  // of the first change; 0 if the axis never moves
    double speed = 0.0;  // of the change from the first to the second position, mm/s or rad/s
  };

  explicit FirstMotion(int axis_count) : starts_(axis_count), last_(axis_count) {}
  // Positions in time order, mm or rad; `time_s` is nullptr where there is none.
  void Add(const double* positions, const double* time_s);
  const std::vector<Start>& starts() const { return starts_; }
  // Every axis has moved: what follows changes no start.
  bool is_known() const { return count_ == 2 && still_ == 0; }

 private:
  std::vector<Start> starts_;
  std::vector<double> last_;
  double last_time_s_ = 0.0;
  int count_ = 0;  // of positions, up to two
  int still_ = 0;  // axes that have not moved yet
};

// Positions at a time, nullptr where there is none; positions are nullptr where there is no such row.
struct Moment {
  const double* positions = nullptr;
  const double* time_s = nullptr;
  const double* senses = nullptr;  // stated: 1, -1, or 0 where it is not; nullptr where none is
};

// From position to position.
class Motion {
 public:
  explicit Motion(const std::vector<FirstMotion::Start>& starts);
  // Fills the state of every axis at the next positions, in time order; `after`: the positions after them.
  void Next(const Moment& now, const Moment& after, shapes::AxisState* states);

 private:
  std::vector<FirstMotion::Start> starts_;
  std::vector<shapes::AxisState> now_;
  double last_time_s_ = 0.0;
  bool is_first_ = true;
};

}  // namespace axiscal::instruments

#endif  // AXISCAL_CORE_INSTRUMENTS_MOTION_H_
