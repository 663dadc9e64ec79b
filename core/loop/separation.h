// How well sessions tell effects of a class apart, from their information matrix about errors with set-ups eliminated
// (matrices of sessions with set-ups of their own add up). With everything else that is fitted projected off it gives
// canonical correlations, and the chi-square that is left when the wrong effect is fitted.
#ifndef AXISCAL_CORE_LOOP_SEPARATION_H_
#define AXISCAL_CORE_LOOP_SEPARATION_H_

#include <Eigen/Core>
#include <vector>

#include "core/identify/problem.h"
#include "core/information/information.h"
#include "core/loop/candidate.h"

namespace axiscal::loop {

using information::Information;

// Of the problem's sessions about `parameters`; all priors count.
Information InformationOf(const identify::Problem& problem, const identify::Point& point,
                          const std::vector<identify::Parameter>& parameters);

// One effect of a class: its columns in the information matrix, and its amplitudes (mm or rad) if it is the true one;
// none where that is not asked for.
struct Member {
  std::vector<int> columns;    // amplitudes
  std::vector<int> nonlinear;  // decay length, time constant: refitted by a rival
  Eigen::VectorXd amplitude;
};

class Separation {
 public:
  // Every column that belongs to no member is fitted along and projected off.
  Separation(const Information& information, const std::vector<Member>& members);

  // Smallest canonical correlation over the smaller of the two spaces that are seen; 1 where either is not seen at all.
  double Correlation(int a, int b) const;
  // Chi-square that is left when `truth` acts with its amplitude and `rival` is fitted in its place.
  double ExpectedChi2(int truth, int rival) const;
  // Amplitudes that `rival` takes when it is fitted in place of `truth`.
  Eigen::VectorXd FittedAmplitude(int truth, int rival) const;

 private:
  // Of one member's columns: on the stack, as there are thousands of pairs to judge.
  static constexpr int kMostColumns = kMostAmplitudes + 1;
  using Small = Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::ColMajor, kMostColumns, kMostColumns>;

  Small SmallBlock(const std::vector<int>& rows, const std::vector<int>& columns) const;

  // Per member, orthonormal bases B (B' G B = 1) of what is seen of its amplitudes and of all its columns.
  struct Root {
    std::vector<int> columns;  // amplitudes, then nonlinear
    Small amplitudes, all;
    Eigen::Index rank = 0;     // amplitudes that are seen
    bool acts = false;         // every amplitude shows in some reading
    Eigen::VectorXd response;  // p: products of every column with what the member does at its amplitudes
    double squares = 0.0;      // of what it does
  };

  const std::vector<Member>& members_;
  std::vector<Root> roots_;
  Eigen::MatrixXd projected_;  // p x p; rows and columns of members, scaled to unit norm before projection
  Eigen::VectorXd scale_;      // p: scaled = raw * scale
};

}  // namespace axiscal::loop

#endif  // AXISCAL_CORE_LOOP_SEPARATION_H_
