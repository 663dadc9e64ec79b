// The objective: how well a set of effects explains the rows, less what it costs to have looked for them.
//
//   J(S) = dof/D ln(rss(S) / dof) + ln det(I + L^(1/2) (K / D) L^(1/2)) + sum over effects e in S of price(e)
//   price(e) = evidence + per_look ln(visible members of its family) + per_column (columns - 1), the last not of
//   blocks; at least what rounding may look like (Rows::rounding_squares), but for bad rows
//
// rss: squares left with the nuisance, the flat amplitudes and the blocks' posterior means taken off, their priors'
// squares added. K: Gram matrix of the blocks' columns beyond nuisance and flat ones, L: the blocks' prior variances.
// D: design effect (design_effect.h). dof: rows less common nuisance. Differences of J are likelihood ratios in
// chi-square units, the scale of the noise profiled out; flat effects pay a fixed price, blocks their evidence.
// Whatever the columns are is not known here.
//
// Kept: norms and products with y of all columns, the columns of groups that any scored state held, and their products
// with all others where additions to such a state were asked for. Everything else is a triangular solve.
#ifndef AXISCAL_CORE_OBJECTIVE_SCORER_H_
#define AXISCAL_CORE_OBJECTIVE_SCORER_H_

#include <Eigen/Core>
#include <map>
#include <memory>
#include <optional>
#include <set>
#include <tuple>
#include <vector>

#include "core/objective/nuisance.h"
#include "core/objective/policy.h"
#include "core/objective/rows.h"
#include "core/objective/source.h"

namespace axiscal::objective {

struct Member {
  int group = 0;
  double variance = 0.0;  // of a block's prior; no meaning for flat ones

  bool operator==(const Member&) const = default;
};
using State = std::vector<Member>;  // in the order in which they were found

struct Score {
  bool is_possible = false;  // false: its columns are combinations of each other, or an amplitude is none
  double objective = std::numeric_limits<double>::infinity();
  double squares = 0.0;                    // rss
  std::vector<Eigen::VectorXd> amplitude;  // per member
};

// One more member, and the objective with it.
struct Move {
  Member member;
  double objective = std::numeric_limits<double>::infinity();
};

class Scorer {
 public:
  // `rows` and `sources` must outlive it. Groups are numbered through the sources, in order.
  Scorer(const Rows& rows, std::vector<std::unique_ptr<Source>> sources, const Policy& policy);

  const Policy& policy() const { return policy_; }
  const Rows& rows() const { return rows_; }
  int group_count() const { return static_cast<int>(at_.size()); }
  const Group& group(int group) const;
  // A group alone in its source, which is group `of` at another place; its number: that of before where it is known.
  int Append(std::unique_ptr<Source> source, int of);
  // The group that it was at first, itself where it was never moved.
  int OriginOf(int group) const { return origin_[group]; }
  bool IsVisible(int group) const { return is_visible_[group]; }
  // Takes no part in any search; the looks of its family stay what they were.
  void Exclude(int group);
  // Per family: how many effects that the data see were looked at.
  const std::map<int, double>& looks() const { return visible_members_; }
  // Those that another scorer of the same readings has looked at count too.
  void AddLooks(const std::map<int, double>& looks);
  // `design`: what rounding may look like is no less noise than others.
  double PriceOf(int group, double design) const;
  double degrees_of_freedom() const { return dof_; }

  Score ScoreOf(const State& state, double design);
  // Variance of each amplitude of a possible state, per member; of blocks with what their priors say.
  std::vector<Eigen::VectorXd> VariancesOf(const State& state, double design);
  // The best `most` additions, of those that cost at most Policy::evidence more than they gain, among groups that
  // `allowed` holds (by group; empty: all), best first; their blocks' variances are those of the most evidence. What
  // was asked before is not looked for again.
  std::vector<Move> Additions(const State& state, double design, const std::vector<bool>& allowed, int most);
  // Makes additions to this state, and to what is left of it without one member, cheap until another one is kept.
  void Keep(const State& state, double design);
  // All additions whose objective is at most `limit`.
  std::vector<Move> AdditionsWithin(const State& state, double design, double limit);
  // The objective with a flat group that is at another place than all that are known here.
  double ObjectiveWith(const State& state, const Source& moved, int of, double design);
  // A group alone at another place; null where it has none.
  std::unique_ptr<Source> MovedTo(int group, double place) const;
  // A member at the place and of the size of least objective within its reach, the others given: true where it gained.
  bool RefinePlace(size_t member, double design, State* state);
  // The variance of each block at which the objective is least, the others given.
  void RefineVariances(double design, State* state);
  // y less nuisance and effects, whitened rows.
  Eigen::VectorXd ResidualOf(const State& state, double design);
  // The whitened columns of a group less what the nuisance explains.
  Eigen::MatrixXd Projected(int group) const;

 private:
  struct Loaded {
    Eigen::MatrixXd whitened, columns;  // before projection and after it, rows x columns of the group
    // Columns of all groups x columns of this one, projected; empty until asked for, without what was appended since.
    Eigen::MatrixXd products;
  };
  struct Factor;
  // A state that is kept, with what it takes to say what is left of it without any one member.
  struct Ground {
    State state;
    double design = 1.0;
    std::vector<Eigen::Index> first;  // per member: where its columns stand
    Eigen::Index flat = 0;            // columns of flat members, which stand first
    // K^-1 and K^-1 P, P the products of the state's columns with all columns; the same of the flat members alone,
    // empty where there are no blocks.
    Eigen::MatrixXd inverse, flat_inverse, flat_weights;
    std::vector<double> weights;      // K^-1 P by columns; may be longer: its memory is taken once, as that of half_
    Eigen::VectorXd amplitude, of_y;  // K^-1 b, and per column what the state explains of its product with y
    std::vector<Eigen::MatrixXd> taken, taken_flat;  // per group: what the state, its flat members explain of its Gram

    Eigen::Map<const Eigen::MatrixXd> Weights() const { return {weights.data(), inverse.rows(), of_y.size()}; }
  };
  // What Additions answered.
  struct Answer {
    std::vector<bool> allowed;
    int most = 0;
    std::vector<Move> moves;
  };
  // What a state explains of all columns: half' half, half = lower^-1 P; or, of a ground without a member, what the
  // ground explains less back' back (the inverse of a part of a matrix; Golub and Van Loan, Matrix Computations,
  // "Updating matrix factorizations").
  struct Explained {
    Explained() = default;
    Explained(Explained&&) = default;
    Explained& operator=(Explained&&) = delete;  // of a map it would copy the numbers
    const Ground* ground = nullptr;
    Eigen::MatrixXd back, flat_back;
    Eigen::Map<Eigen::MatrixXd> half{nullptr, 0, 0};  // in half_: of one state at a time
    Eigen::Index flat = 0;
    Eigen::VectorXd of_y;  // per column
  };

  // ln(rss / dof), rss at least Rows::least_squares; and what is left of it.
  double LogSquares(double squares) const;
  double LogRatio(double left, double squares) const;
  const Source& SourceOf(int group, int* within) const;
  void Take(const Source& source, size_t number);
  // Of whitened columns.
  Eigen::MatrixXd ProjectedOf(Eigen::MatrixXd columns) const;
  Eigen::MatrixXd WhitenedOf(const Source& source, int within) const;
  // Of a flat group's columns: what holds its amplitudes beside the rows; `raw`: their squares before projection.
  double PrecisionOf(const Group& group, int column, double raw) const;
  const Loaded& Load(int group);
  // Products of the columns of all members with all columns: one pass over the sources for those that have none yet.
  void LoadProducts(const State& state);
  // Products of two loaded groups' columns.
  const Eigen::MatrixXd& Cross(int group, int other);
  // Gram matrix of the state's columns, flat ones first; where each member's columns are in it.
  Factor FactorOf(const State& state, double design);
  // The answer where it follows from those that were given for the same state.
  std::optional<std::vector<Move>> Known(const std::vector<Answer>& answers, const std::vector<bool>& allowed,
                                         int most) const;
  // From what is kept where it can be.
  Explained ExplainedBy(const State& state, double design, const Factor& factor);
  // Takes what is explained, by the flat members alone where asked, off the Gram matrix of a group.
  template <typename Gram>
  void TakeOff(const Explained& explained, int group, bool by_flat, Gram* gram) const;
  template <typename Make>
  bool RefineAlong(size_t member, double design, double middle, double reach, Make make, State* state);
  // Projects a member of a scan.
  void MakeExact(int group);
  // Calls visit(move) for each addition whose objective may be at most base + limit(), base being that of the state.
  template <typename Limit, typename Visit>
  void ForEachAddition(const State& state, double design, const std::vector<bool>& allowed, Limit limit, Visit visit);
  // At least what BestBlock changes the objective by, its price aside.
  double LeastOfBlock(int group, const Eigen::MatrixXd& gram, const Eigen::VectorXd& right, double squares,
                      double design) const;
  Move BestBlock(int group, const Eigen::MatrixXd& gram, const Eigen::VectorXd& right, double squares,
                 double design) const;

  const Rows& rows_;
  std::vector<std::unique_ptr<Source>> sources_;
  const Policy policy_;
  const Nuisance nuisance_;
  std::vector<std::pair<int, int>> at_;     // per group: source, number within
  std::vector<Eigen::Index> first_column_;  // per group
  Eigen::Index column_count_ = 0;
  std::vector<bool> is_visible_, is_exact_;
  std::vector<int> origin_;
  std::map<std::tuple<int, double, double>, int> moved_;  // what was appended, by origin, place and size
  std::map<int, double> visible_members_;                 // per family: their looks
  std::vector<Eigen::MatrixXd> gram_;                     // per group, projected
  Eigen::VectorXd with_y_;                                // per column, projected
  Eigen::VectorXd raw_;                                   // per column: its squares before projection
  Eigen::MatrixXd own_, common_;      // nuisance columns for products with raw columns (Whitening::Adjoint)
  Eigen::VectorXd y_;                 // projected, at the rows
  double squares_ = 0.0, dof_ = 1.0;  // of y, projected
  std::map<int, Loaded> loaded_;
  std::optional<Ground> ground_;
  // Explained::half of the state that was asked for last. Its memory is taken once: it may be a hundred megabytes.
  std::vector<double> half_;
  struct {
    State state;
    double design = 0.0;
    Eigen::Index columns = -1;
  } half_of_;
  // By design effect and members in ascending order; of as many groups as there are now.
  std::map<std::vector<double>, std::vector<Answer>> answers_;
  std::set<std::vector<int>> at_best_;  // a group, then all of its state in ascending order: no place is better
  std::map<std::pair<int, int>, Eigen::MatrixXd> cross_;  // of groups in ascending order
};

}  // namespace axiscal::objective

#endif  // AXISCAL_CORE_OBJECTIVE_SCORER_H_
