// The values of a shape at every row. Harmonics of one axis that follow each other at even steps of frequency (the
// dictionary's scans) are turned on from the last one instead of computed anew.
#ifndef AXISCAL_CORE_LOOP_SHAPE_COLUMNS_H_
#define AXISCAL_CORE_LOOP_SHAPE_COLUMNS_H_

#include <Eigen/Core>
#include <functional>
#include <vector>

#include "core/shapes/shape.h"

namespace axiscal::loop {

class ShapeColumns {
 public:
  // `state_of(row)` is the state at a row; it must outlive this.
  ShapeColumns(int row_count, std::function<shapes::State(int row)> state_of);

  // rows x BasisCount(shape), valid until the next call.
  const Eigen::MatrixXd& Of(const shapes::Shape& shape);

 private:
  void Turn(const shapes::Harmonic& harmonic);

  const int row_count_;
  const std::function<shapes::State(int)> state_of_;
  shapes::Shape shape_;
  bool is_filled_ = false;
  Eigen::MatrixXd values_;
  // cosine and sine of (step of frequency) times position
  int turned_axis_ = -1;
  double turned_by_ = 0.0;
  Eigen::ArrayXd cosine_, sine_, scratch_;
};

}  // namespace axiscal::loop

#endif  // AXISCAL_CORE_LOOP_SHAPE_COLUMNS_H_
