// Whitening of rows whose noise may remember the row above:
//   innovation_k = x_k - correlation_k x_(k-1) + echo_k innovation_(k-1),   whitened_k = weight_k innovation_k
// (core/identify/whitening.h has the model of the noise). correlation and echo are 0 in the first row of a series, so
// that series stand one below the other.
#ifndef AXISCAL_CORE_OBJECTIVE_WHITENING_H_
#define AXISCAL_CORE_OBJECTIVE_WHITENING_H_

#include <Eigen/Core>

namespace axiscal::objective {

class Whitening {
 public:
  Whitening() = default;
  // One entry per row; weight > 0.
  Whitening(Eigen::ArrayXd weight, Eigen::ArrayXd correlation, Eigen::ArrayXd echo);

  int rows() const { return static_cast<int>(weight_.size()); }
  bool is_white() const { return is_white_; }  // rows do not remember each other
  bool has_echo() const { return has_echo_; }
  const Eigen::ArrayXd& weight() const { return weight_; }
  const Eigen::ArrayXd& correlation() const { return correlation_; }
  const Eigen::ArrayXd& echo() const { return echo_; }
  // In place, the rows begin .. begin + columns.rows() of whole series; as if everything above them were zero.
  void Apply(int begin, Eigen::Ref<Eigen::MatrixXd> columns) const;
  // The inverse of Apply.
  void Undo(int begin, Eigen::Ref<Eigen::MatrixXd> columns) const;
  // Vectors u of all rows with x' u = (whitened x)' v for every column x.
  Eigen::MatrixXd Adjoint(Eigen::MatrixXd v) const;
  // Rows after which a change that began in row `first` is forgotten, the row itself counted; of one series, which ends
  // at `end`.
  int Memory(int first, int end) const;

 private:
  Eigen::ArrayXd weight_, correlation_, echo_;
  bool is_white_ = true, has_echo_ = false;
};

}  // namespace axiscal::objective

#endif  // AXISCAL_CORE_OBJECTIVE_WHITENING_H_
