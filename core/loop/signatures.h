// Signatures: what an effect would do to every reading. The sensitivity of each reading to the six error components of
// every joint is computed once; a candidate's signature is a sensitivity times a shape, whitened, with what the
// declared errors and the setup offsets can explain projected off (design.md, "Close the loop", 2 and 3).
#ifndef AXISCAL_CORE_LOOP_SIGNATURES_H_
#define AXISCAL_CORE_LOOP_SIGNATURES_H_

#include <Eigen/Cholesky>
#include <Eigen/Core>
#include <vector>

#include "core/identify/problem.h"
#include "core/loop/candidate.h"

namespace axiscal::loop {

inline constexpr int kMaxColumns = 3;  // columns of one candidate

// Inner products of one candidate's projected signature with itself and with the residual.
struct Projection {
  int columns = 0;
  Eigen::Matrix3d own = Eigen::Matrix3d::Zero();            // X' X after projection, upper-left columns x columns
  Eigen::Vector3d with_residual = Eigen::Vector3d::Zero();  // X' r after projection
  double visible = 0.0;  // smallest share of a column's squares that is left after projection
};

class Signatures {
 public:
  // At a fitted point; `parameters` are the errors that are fitted along with the setups (projected off).
  Signatures(const identify::Problem& problem, const identify::Point& point,
             const std::vector<identify::Parameter>& parameters);

  int row_count() const { return static_cast<int>(run_.size()); }
  int degrees_of_freedom() const { return degrees_of_freedom_; }
  double residual_squares() const { return residual_squares_; }

  // One projection per candidate, in order.
  std::vector<Projection> Project(const std::vector<Candidate>& candidates) const;
  // For each candidate the smallest canonical correlation with `reference` after projection, over the smaller of the
  // two spaces.
  std::vector<double> CorrelationsWith(const Candidate& reference, const std::vector<Candidate>& candidates) const;
  // rms over all readings of the candidate's raw signature times amplitude, mm: what the effect does at the tool point
  // as the readings see it.
  double RmsOf(const Candidate& candidate, const Eigen::Vector3d& amplitude) const;

 private:
  struct Rows {
    int begin, end, group;
  };  // one run's rows

  int ColumnsOf(const Candidate& candidate) const;
  void FillRaw(const Candidate& candidate, Eigen::Ref<Eigen::MatrixXd> columns) const;
  void Whiten(Eigen::Ref<Eigen::MatrixXd> columns) const;
  // Coefficients of whitened columns on the orthonormal nuisance basis, stacked: all groups' setups, then the errors.
  Eigen::MatrixXd NuisanceOf(const Eigen::Ref<const Eigen::MatrixXd>& columns) const;

  const identify::Problem& problem_;
  std::vector<int> run_, reading_, series_row_;
  std::vector<Rows> rows_;
  Eigen::VectorXd weight_, correlation_;  // whitened_k = weight_k (x_k - correlation_k x_(k-1))
  Eigen::MatrixXd sensitivity_;           // rows x 6 joints, raw
  Eigen::MatrixXd setup_raw_;             // rows x 3: the first three setup offsets, raw
  Eigen::MatrixXd setup_, errors_;        // whitened nuisance columns; setup columns hold those of the row's own group
  std::vector<Eigen::MatrixXd> setup_basis_;  // per group: columns times this are orthonormal with the priors' rows
  std::vector<Eigen::MatrixXd> setup_error_;  // per group: setup-basis coefficients of the error columns
  Eigen::MatrixXd error_basis_;
  Eigen::VectorXd residual_;
  Eigen::VectorXd residual_nuisance_;
  double residual_squares_ = 0.0;
  int degrees_of_freedom_ = 0;
};

}  // namespace axiscal::loop

#endif  // AXISCAL_CORE_LOOP_SIGNATURES_H_
