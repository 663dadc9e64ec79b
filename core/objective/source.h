// Where the columns of effects come from. A source holds groups of one kind and makes their columns when asked: none
// keeps them all.
#ifndef AXISCAL_CORE_OBJECTIVE_SOURCE_H_
#define AXISCAL_CORE_OBJECTIVE_SOURCE_H_

#include <Eigen/Core>
#include <limits>
#include <memory>
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
  bool has_usual_size = false;  // of a flat effect: Policy::largest_hidden holds for it
  double looks = 1.0;           // for how many its family counts it: less where neighbours are alike
  bool is_counted = true;       // among the effects of which a state holds so many at most
  bool is_exotic = false;       // a plain name rivals it (Policy::exotic)
  int one_sign = -1;            // of one column: those of one number that act together have the same sign; < 0: none
  // Groups of one kin whose places are less than `apart` from each other are one effect: a state holds one of them.
  // kin < 0: none.
  int kin = -1;
  double place = 0.0, apart = 0.0;
  // A better place (length, frequency, moment ...) may be this far from it, as a grid holds only some: 0 where not.
  double reach = 0.0;
  // Likewise of a second parameter (the logarithm of a local shape's width).
  double size = 0.0, size_reach = 0.0;
  int form = -1;  // groups of one form are alike only at the same place; < 0: places do not compare

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

  // Scans (frequencies, places): many flat groups of which neighbours are alike and hardly any is mostly explained by
  // the nuisance. They are projected only where they may matter.
  virtual bool IsScan() const { return false; }
  // The raw columns of one group, all rows.
  virtual Eigen::MatrixXd Columns(int group) const = 0;
  // A source with this group alone at another place. Null where a group has no reach.
  virtual std::unique_ptr<Source> Moved(int group, double place) const { return nullptr; }
  // The same of another size.
  virtual std::unique_ptr<Source> Resized(int group, double size) const { return nullptr; }
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
