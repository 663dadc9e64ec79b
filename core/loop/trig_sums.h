// Sums of cosines and sines over readings, at many evenly spaced frequencies at once:
//   S(m) = sum_k c_k exp(i (first + m step) x_k),   m = 0 .. count - 1
// The readings are spread onto a fine grid by a Gaussian, the grid is transformed, the Gaussian divided out (Dutt and
// Rokhlin 1993; Greengard and Lee, SIAM Review 46 (2004) 443, type 1): linear in readings, where the plain sums cost
// readings times frequencies.
#ifndef AXISCAL_CORE_LOOP_TRIG_SUMS_H_
#define AXISCAL_CORE_LOOP_TRIG_SUMS_H_

#include <Eigen/Core>
#include <vector>

namespace axiscal::loop {

class TrigSums {
 public:
  // Frequencies in rad per unit of `positions`; step > 0, count > 0.
  TrigSums(const Eigen::ArrayXd& positions, double first, double step, int count);

  // count x columns of `strengths` (one row per position), right to 1e-6 of the sum of a column's magnitudes.
  Eigen::MatrixXcd Of(const Eigen::Ref<const Eigen::MatrixXd>& strengths) const;

 private:
  int count_;
  int grid_;                      // points per period, a power of two
  Eigen::ArrayXcd turned_;        // exp(i middle frequency x_k)
  std::vector<int> first_point_;  // per position, the lowest grid point that it is spread to
  Eigen::MatrixXd spread_;        // points x positions
  Eigen::ArrayXd undone_;         // per frequency: what the Gaussian took off
};

}  // namespace axiscal::loop

#endif  // AXISCAL_CORE_LOOP_TRIG_SUMS_H_
