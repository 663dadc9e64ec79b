// Where the columns of effects come from. A source holds groups of one kind and makes their columns when asked: none
// keeps them all.
#ifndef AXISCAL_CORE_OBJECTIVE_SOURCE_H_
#define AXISCAL_CORE_OBJECTIVE_SOURCE_H_

#include <Eigen/Core>
#include <limits>
#include <vector>

#include "core/objective/whitening.h"

namespace axiscal::objective {

// The columns of one effect, one per amplitude.
struct Group {
  int family = 0;  // members of one family are looks at the same kind of effect
  int columns = 1;
  // Flat: every amplitude for itself, held by no more than `precision`, one over the variance of a wide prior per
  // column (empty: none). A block: amplitudes ~ N(0, variance x spectrum), one variance for all, found from the data.
  Eigen::VectorXd precision, spectrum;
  double largest_variance = std::numeric_limits<double>::infinity();  // of a block's `variance`
  // A flat effect with an amplitude beyond this is none that a machine has.
  double largest_amplitude = std::numeric_limits<double>::infinity();
  bool is_exotic = false;  // a plain name rivals it (Policy::exotic)
  // Groups of one kin whose places are less than `apart` from each other are one effect: a state holds one of them.
  // kin < 0: none.
  int kin = -1;
  double place = 0.0, apart = 0.0;

  bool IsBlock() const { return spectrum.size() > 0; }
};

inline bool IsSameEffect(const Group& a, const Group& b) {
  return a.kin >= 0 && a.kin == b.kin && std::abs(a.place - b.place) < std::min(a.apart, b.apart);
}

class Source {
 public:
  virtual ~Source() = default;

  const std::vector<Group>& groups() const { return groups_; }
  int column_count() const;

  // The raw columns of one group, all rows.
  virtual Eigen::MatrixXd Columns(int group) const = 0;
  // products += X' u, X the raw columns of all groups in the rows begin .. begin + u.rows() (whole series);
  // column_count() x u.cols().
  virtual void AddProducts(int begin, const Eigen::MatrixXd& u, Eigen::Ref<Eigen::MatrixXd> products) const;
  // X' X of each group's whitened columns.
  virtual std::vector<Eigen::MatrixXd> Grams(const Whitening& whitening) const;

 protected:
  std::vector<Group> groups_;
};

}  // namespace axiscal::objective

#endif  // AXISCAL_CORE_OBJECTIVE_SOURCE_H_
