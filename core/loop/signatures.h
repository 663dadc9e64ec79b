// Signatures: what an effect would do to every reading. The sensitivity of each reading to the six error components of
// every joint is computed once; a candidate's signature is a sensitivity times a shape, whitened, with what the
// declared errors and the setup offsets can explain projected off (docs/loop.md, "Steps", 2).
#ifndef AXISCAL_CORE_LOOP_SIGNATURES_H_
#define AXISCAL_CORE_LOOP_SIGNATURES_H_

#include <Eigen/Core>
#include <map>
#include <vector>

#include "core/identify/problem.h"
#include "core/loop/candidate.h"
#include "core/loop/nuisance.h"

namespace axiscal::loop {

inline constexpr int kMaxColumns = 3;  // columns of one candidate

// A signature of which less than this share stands beyond the declared errors and setups cannot be seen in this data.
inline constexpr double kVisible = 1e-5;

// Inner products of one candidate's projected signature with itself and with the residual.
struct Projection {
  int columns = 0;
  // X' X after projection, upper-left columns x columns; of a slip with its prior.
  Eigen::Matrix3d own = Eigen::Matrix3d::Zero();
  Eigen::Vector3d with_residual = Eigen::Vector3d::Zero();  // X' r after projection
  // Share of a column's squares that is left after projection: the smallest; of a slip the largest, as a session sees
  // few of its directions.
  double visible = 0.0;
  bool is_screened = false;  // too far from the residual to matter: nothing else is known
};

// What a projected signature explains of the residual's squares, and the amplitudes that do so (the residual is
// predicted - measured).
double Gain(const Projection& projection, Eigen::Vector3d* amplitude);

class Signatures {
 public:
  // At a fitted point; `parameters` are the errors that are fitted along with the setups (projected off).
  Signatures(const identify::Problem& problem, const identify::Point& point,
             const std::vector<identify::Parameter>& parameters);

  const identify::Problem& problem() const { return problem_; }
  int row_count() const { return static_cast<int>(run_.size()); }
  int degrees_of_freedom() const { return degrees_of_freedom_; }
  double residual_squares() const { return residual_squares_; }

  // One projection per candidate, in order.
  std::vector<Projection> Project(const std::vector<Candidate>& candidates) const;
  // The same for those that matter: members of the scans (frequencies, places) that, even if most of them were
  // projected off, would explain less than `worth[family]` of the residual's squares or less than `share` of what the
  // best candidate does, are screened out unprojected.
  std::vector<Projection> ProjectWorthy(const std::vector<Candidate>& candidates, const std::map<Family, double>& worth,
                                        double share) const;
  // For each candidate the smallest canonical correlation with `reference` after projection, over the smaller of the
  // two spaces.
  std::vector<double> CorrelationsWith(const Candidate& reference, const std::vector<Candidate>& candidates) const;
  // rms over all readings of the candidate's raw signature times amplitude, mm: what the effect does at the tool point
  // as the readings see it.
  double RmsOf(const Candidate& candidate, const Eigen::Ref<const Eigen::VectorXd>& amplitude) const;
  // Whitened squares of each run's sensitivity to every component: runs x 6 joints.
  Eigen::MatrixXd SensitivitySquares() const;
  // The largest value (mm or rad) that the error itself takes with these amplitudes, at about a hundred of the
  // readings.
  double LargestValue(const machine::ErrorTerm& term, const Eigen::Vector3d& amplitude) const;

 private:
  friend class RowSink;

  int ColumnsOf(const Candidate& candidate) const;
  // A raw column's product with this is the whitened column's with `whitened`.
  Eigen::ArrayXd ByRawRow(const Eigen::VectorXd& whitened) const;
  shapes::State StateAt(int row) const { return problem_.runs[run_[row]].StateOf(reading_[row]); }
  // Raw signatures side by side at the rows begin .. begin + columns.rows().
  void FillRaw(const std::vector<const Candidate*>& candidates, int begin, Eigen::Ref<Eigen::MatrixXd> columns) const;
  void ProjectPending(const std::vector<Candidate>& candidates, std::vector<Projection>* projections) const;
  // Rows of a slip that happened before all of them: count x 3, raw.
  Eigen::Ref<const Eigen::MatrixXd> SlipOf(const Candidate& slip, Eigen::Index begin, Eigen::Index count) const;
  // Slips of one run and carrier, or others.
  void ProjectFully(const std::vector<const Candidate*>& candidates, const std::vector<Projection*>& projections) const;
  // Products of whitened columns before projection, with themselves and the residual and, added to `coefficients`
  // (nuisance size x columns side by side), with the nuisance; of any but slips, and of slips of one run and carrier.
  void SumColumns(const std::vector<const Candidate*>& candidates, const std::vector<Projection*>& projections,
                  Eigen::MatrixXd* coefficients) const;
  void SumSlips(const std::vector<const Candidate*>& slips, const std::vector<Projection*>& projections,
                Eigen::MatrixXd* coefficients) const;
  // Calls visit(series, first row, whitened columns) for blocks of rows of all series.
  template <typename Visit>
  void ForEachBlock(const std::vector<const Candidate*>& candidates, Eigen::Index width, Visit visit) const;

  const identify::Problem& problem_;
  std::vector<int> run_, reading_;
  std::vector<Series> series_;
  // Per row (identify/whitening.h): innovation_k = x_k - correlation_k x_(k-1) + echo_k innovation_(k-1), whitened_k =
  // weight_k innovation_k.
  Eigen::ArrayXd weight_, correlation_, echo_;
  bool is_white_ = true;   // no correlation anywhere
  bool has_echo_ = false;  // noise that remembers has white noise beside it, somewhere
  // The same of identify::BoundingAr1, and the most by which it exceeds.
  Eigen::ArrayXd bounding_weight_, bounding_correlation_;
  double bounding_excess_ = 1.0;
  Eigen::MatrixXd sensitivity_;  // rows x 6 joints, raw
  Eigen::MatrixXd setup_raw_;    // rows x 3: the first three setup offsets, raw
  Nuisance nuisance_;
  Eigen::VectorXd residual_;  // whitened, projected
  double residual_squares_ = 0.0;
  int degrees_of_freedom_ = 0;
};

}  // namespace axiscal::loop

#endif  // AXISCAL_CORE_LOOP_SIGNATURES_H_
