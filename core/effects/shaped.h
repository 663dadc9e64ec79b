// Columns that are a sensitivity times a shape: every effect of the error model. Products of all of them with a vector
// are a matrix of shapes times a matrix of sensitivities: no column is ever made for that.
#ifndef AXISCAL_CORE_EFFECTS_SHAPED_H_
#define AXISCAL_CORE_EFFECTS_SHAPED_H_

#include <optional>
#include <vector>

#include "core/effects/linearised.h"
#include "core/objective/source.h"
#include "core/shapes/shape.h"

namespace axiscal::effects {

struct ShapedItem {
  shapes::Shape shape;
  int sensitivity = 0;  // column of Linearised::sensitivity
  objective::Group group;
};

// A place of a group is that of its shape's non-linear parameter, a frequency or the logarithm of a length or time, or
// where a local shape stands.
double PlaceOf(const shapes::Shape& shape);
// The same shape at a place; as a group has it, with its size, too.
shapes::Shape AtPlace(shapes::Shape shape, double place);
shapes::Shape AsIn(const objective::Group& group, shapes::Shape shape);

class Shaped : public objective::Source {
 public:
  // Items of one shape stand together; harmonics of one axis whose frequencies rise by equal steps are computed by
  // recurrence. `linearised` must outlive it.
  Shaped(const Linearised& linearised, std::vector<ShapedItem> items, bool is_scan = false);

  bool IsScan() const override { return is_scan_; }

  Eigen::MatrixXd Columns(int group) const override;
  std::unique_ptr<objective::Source> Moved(int group, double place) const override;
  std::unique_ptr<objective::Source> Resized(int group, double size) const override;
  void AddProducts(int begin, const Eigen::MatrixXd& u, Eigen::Ref<Eigen::MatrixXd> products) const override;
  std::vector<Eigen::MatrixXd> Grams(const objective::Whitening& whitening) const override;

 protected:
  const Linearised& linearised_;
  std::vector<ShapedItem> items_;
  std::vector<int> sensitivities_;      // that any item has
  std::vector<size_t> sensitivity_of_;  // per item: of those

 private:
  // The earlier item of which the columns of an item are the first ones, where it is a beginning of one.
  std::optional<size_t> FinerOf(size_t item) const;
  // Values of the shapes first .. last at rows begin .. begin + values->rows(), side by side.
  void Fill(size_t first, size_t last, int begin, Eigen::Ref<Eigen::MatrixXd> values) const;

  const bool is_scan_;
  Eigen::MatrixXd kept_;  // values of all shapes at all rows, where they are few
  std::vector<shapes::Shape> shapes_;
  std::vector<Eigen::Index> first_value_;  // per shape, and behind the last one: where its values stand among all
  std::vector<bool> is_beginning_;         // per shape: of the one before it (shapes::IsBeginningOf)
  std::vector<size_t> shape_of_;           // per item
};

}  // namespace axiscal::effects

#endif  // AXISCAL_CORE_EFFECTS_SHAPED_H_
