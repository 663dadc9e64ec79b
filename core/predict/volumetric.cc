#include "core/predict/volumetric.h"

#include <Eigen/Cholesky>
#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

#include "core/base/random.h"
#include "core/predict/over_poses.h"

namespace axiscal::predict {
namespace {

using instruments::MeasuringRun;

// The ends of a 95 % interval are drawn to about 2 % of its width.
constexpr int kDraws = 4000;
constexpr uint64_t kSeed = 230;

}  // namespace

// The poses, and draws of errors V a + A z over them beside those that were found: z standard normal, a by the choices.
class BoxOdds::Drawn {
 public:
  // Per pose of the machine as it may be, and of each draw of it.
  struct Left {
    double expected_mm = 0.0;    // root of the expected mean square
    std::vector<double> rms_mm;  // the n-th draw is of the same machine in all of these
  };

  RootMeanSquare IntervalOf(Left left, const Unsure& unsure) const {
    for (size_t i = 0; i < left.rms_mm.size(); ++i) {
      const auto normal = unsure_.col(static_cast<Eigen::Index>(i));
      left.rms_mm[i] =
          std::hypot(left.rms_mm[i] * std::exp(unsure.sigma_share * normal[0]), unsure.form_mm * normal[1]);
    }
    return {std::hypot(left.expected_mm, unsure.form_mm), Quantile(&left.rms_mm, kLowQuantile),
            Quantile(&left.rms_mm, kHighQuantile)};
  }

  static double ShareOf(const Worse& worse, const Left& before, const Left& after) {
    int count = 0;
    for (size_t i = 0; i < after.rms_mm.size(); ++i) {
      const double mm = after.rms_mm[i] - before.rms_mm[i];
      count += mm > worse.share * before.rms_mm[i] && mm > worse.mm;
    }
    return static_cast<double>(count) / static_cast<double>(after.rms_mm.size());
  }

  Drawn(const machine::Machine& machine, const std::vector<MeasuringRun>& runs, const machine::ErrorModel& before,
        machine::KnownErrors found, const std::vector<OpenChoice>& choices)
      : poses_(runs, kBoxPoses, MeasuredBox(runs)),
        over_(machine, poses_, runs.front().tip_mm),
        found_(std::move(found)),
        found_mm_(over_.ErrorsOf(found_.model)),
        by_number_(over_.Left(over_.ByNumber(found_))),
        uncertain_(by_number_ * found_.covariance.root),
        choices_(over_, choices) {
    const Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd> eigen(uncertain_.transpose() * uncertain_ / kBoxPoses);
    axes_ = eigen.eigenvectors();
    const Eigen::VectorXd squares = eigen.eigenvalues().cwiseMax(0.0);
    scatter_ = choices_.scatter() / kBoxPoses + squares.sum();
    const Eigen::MatrixXd of_choices = axes_.transpose() * (uncertain_.transpose() * choices_.columns()) / kBoxPoses;
    const Eigen::MatrixXd choices_gram = choices_.columns().transpose() * choices_.columns() / kBoxPoses;
    z_.resize(uncertain_.cols(), kDraws);
    acts_.resize(choices_.columns().cols(), kDraws);
    squares_.resize(kDraws);
    base::Random random(kSeed);
    for (Eigen::Index i = 0; i < kDraws; ++i) {
      for (double& one : z_.col(i)) one = random.Normal();
      acts_.col(i) = choices_.Draw(&random);
      const auto z = z_.col(i), acts = acts_.col(i);
      squares_[i] = acts.dot(choices_gram * acts) + 2.0 * z.dot(of_choices * acts) + squares.dot(z.cwiseAbs2());
    }
    unsure_.resize(Eigen::NoChange, kDraws);
    for (double& one : unsure_.reshaped()) one = random.Normal();
    before_ = LeftBy(over_.ErrorsOf(before));
  }

  const Box& box() const { return poses_.box(); }
  const OverPoses& over() const { return over_; }
  const machine::ErrorModel& model() const { return found_.model; }
  const Left& before() const { return before_; }
  std::vector<std::string> Weakest() const { return over_.WeakestOf(found_, by_number_, uncertain_); }
  std::vector<std::string> Undecided() const {
    return choices_.Weak(uncertain_.squaredNorm() + choices_.mean().squaredNorm() + choices_.scatter());
  }

  // Where errors over the poses are corrected.
  Left LeftBy(const Eigen::VectorXd& corrected_mm) const {
    const Eigen::VectorXd off = found_mm_ - corrected_mm;
    const Eigen::VectorXd by_z = axes_.transpose() * (uncertain_.transpose() * off) / kBoxPoses,
                          by_acts = choices_.columns().transpose() * off / kBoxPoses;
    const Eigen::VectorXd squares = (squares_ + 2.0 * (z_.transpose() * by_z + acts_.transpose() * by_acts)).array() +
                                    off.squaredNorm() / kBoxPoses;
    Left left{std::sqrt((off + choices_.mean()).squaredNorm() / kBoxPoses + scatter_), {}};
    for (const double square : squares) left.rms_mm.push_back(std::sqrt(std::max(0.0, square)));
    return left;
  }

  // Of a fit whose numbers have the covariance C, those of the terms (H) held at zero: the others move by -C_rH C_HH^-1
  // times what these were.
  Eigen::VectorXd FittedWithout(const std::vector<int>& terms) const {
    constexpr double kRidge = 1e-9;  // of a variance: there may be combinations that are known exactly
    const auto is_out = [&terms](int term) { return std::find(terms.begin(), terms.end(), term) != terms.end(); };
    machine::ErrorModel rest;
    for (int i = 0; i < static_cast<int>(found_.model.terms.size()); ++i)
      if (!is_out(i)) rest.terms.push_back(found_.model.terms[i]);
    std::vector<Eigen::Index> out;
    std::vector<double> were;
    for (size_t i = 0; i < found_.covariance.of.size(); ++i) {
      const machine::ErrorCovariance::Number& number = found_.covariance.of[i];
      if (!is_out(number.term)) continue;
      out.push_back(static_cast<Eigen::Index>(i));
      were.push_back(number.is_nonlinear ? 0.0 : found_.model.terms[number.term].amplitude[number.basis]);
    }
    const Eigen::VectorXd left = over_.ErrorsOf(machine::NamedErrors(rest));
    if (out.empty()) return left;
    const Eigen::MatrixXd root = found_.covariance.root(out, Eigen::all);
    const Eigen::VectorXd sigma = root.rowwise().norm().cwiseMax(std::numeric_limits<double>::min());
    const Eigen::MatrixXd scaled = sigma.cwiseInverse().asDiagonal() * root;
    Eigen::MatrixXd correlation = scaled * scaled.transpose();
    correlation.diagonal().array() += kRidge;
    const Eigen::VectorXd in_sigma =
        Eigen::Map<const Eigen::VectorXd>(were.data(), static_cast<Eigen::Index>(were.size())).cwiseQuotient(sigma);
    Eigen::VectorXd moved = found_.covariance.root * (scaled.transpose() * correlation.ldlt().solve(in_sigma));
    moved(out).setZero();
    return left - by_number_ * moved;
  }

 private:
  // What a machine may be off by beyond a number's uncertainty: by a rival of each choice, drawn by its odds.
  class Choices {
   public:
    // Columns: errors of each rival less those of what was found, mm.
    Choices(const OverPoses& over, const std::vector<OpenChoice>& choices) {
      Eigen::Index count = 0;
      for (const OpenChoice& choice : choices) count += static_cast<Eigen::Index>(choice.rivals.size());
      columns_.resize(over.rows(), count);
      std::vector<std::string> overruled;
      for (const OpenChoice& choice : choices)
        overruled.insert(overruled.end(), choice.overrules.begin(), choice.overrules.end());
      // Of those that another one overrules, of that one, of all others.
      Moments under{over.rows()}, ruling{over.rows()}, others{over.rows()};
      double ruling_acts = 0.0;
      Eigen::Index at = 0;
      for (const OpenChoice& choice : choices) {
        const Eigen::VectorXd as_found = over.ErrorsOf(choice.as_found);
        double odds = 1.0;
        for (const OpenChoice::Rival& rival : choice.rivals) odds += rival.odds;
        const bool is_under = std::find(overruled.begin(), overruled.end(), choice.name) != overruled.end();
        One& one = choices_.emplace_back(One{choice.name, at, {}, 0.0, !choice.overrules.empty(), is_under});
        Eigen::VectorXd mean = Eigen::VectorXd::Zero(over.rows());
        for (const OpenChoice::Rival& rival : choice.rivals) {
          columns_.col(at) = over.ErrorsOf(rival.model) - as_found;
          const double probability = rival.odds / odds;
          one.probability.push_back(probability);
          mean += probability * columns_.col(at);
          one.squares += probability * columns_.col(at).squaredNorm();
          if (one.is_ruling) ruling_acts += probability;
          ++at;
        }
        (one.is_ruling ? ruling : is_under ? under : others).Add(mean, one.squares);
      }
      const double left = 1.0 - ruling_acts;
      mean_ = others.mean + ruling.mean + left * under.mean;
      const double of_both =
          ruling.scatter + ruling.mean.squaredNorm() + left * (under.scatter + under.mean.squaredNorm());
      scatter_ = others.scatter + of_both - (ruling.mean + left * under.mean).squaredNorm();
    }

    const Eigen::MatrixXd& columns() const { return columns_; }
    const Eigen::VectorXd& mean() const { return mean_; }
    // Of all choices, sum over the poses, mm^2: what their draws scatter about the mean.
    double scatter() const { return scatter_; }
    // One where its rival acts.
    Eigen::VectorXd Draw(base::Random* random) const {
      Eigen::VectorXd acts = Eigen::VectorXd::Zero(columns_.cols());
      bool is_overruled = false;
      for (const One& one : choices_) {
        double left = random->Uniform();
        for (size_t k = 0; k < one.probability.size(); ++k) {
          left -= one.probability[k];
          if (left >= 0.0) continue;
          acts[one.first + static_cast<Eigen::Index>(k)] = 1.0;
          is_overruled |= one.is_ruling;
          break;
        }
      }
      for (const One& one : choices_)
        if (is_overruled && one.is_under)
          acts.segment(one.first, static_cast<Eigen::Index>(one.probability.size())).setZero();
      return acts;
    }
    // Those that make at least kWeak of this sum of squares, the largest first.
    std::vector<std::string> Weak(double squares) const {
      std::vector<std::pair<double, std::string>> shares;
      for (const One& one : choices_)
        if (!one.name.empty() && one.squares > 0.0 && one.squares >= kWeak * squares)
          shares.emplace_back(-one.squares, one.name);
      std::sort(shares.begin(), shares.end());
      std::vector<std::string> names;
      for (const auto& [share, name] : shares) names.push_back(name);
      return names;
    }

   private:
    struct One {
      std::string name;
      Eigen::Index first = 0;
      std::vector<double> probability;
      double squares = 0.0;  // expected
      bool is_ruling = false, is_under = false;
    };
    // Of a sum of independent choices.
    struct Moments {
      explicit Moments(Eigen::Index rows) : mean(Eigen::VectorXd::Zero(rows)) {}
      void Add(const Eigen::VectorXd& one, double squares) {
        mean += one;
        scatter += squares - one.squaredNorm();
      }
      Eigen::VectorXd mean;
      double scatter = 0.0;  // expected square of what is beside the mean
    };
    Eigen::MatrixXd columns_;
    std::vector<One> choices_;
    Eigen::VectorXd mean_;
    double scatter_ = 0.0;
  };

  const BoxPoses poses_;
  const OverPoses over_;
  const machine::KnownErrors found_;
  const Eigen::VectorXd found_mm_;
  const Eigen::MatrixXd by_number_;  // of the found errors
  const Eigen::MatrixXd uncertain_;  // the same times the root of their covariance: A
  const Choices choices_;            // their columns are V
  Eigen::MatrixXd axes_;             // of A' A: z is about these
  Eigen::MatrixXd z_, acts_;         // a column per draw
  Eigen::VectorXd squares_;          // |V a + A z|^2 / poses of each draw
  Eigen::Matrix2Xd unsure_;          // standard normal, for Unsure: of the sigmas, of the forms
  double scatter_ = 0.0;             // expected
  Left before_;
};

std::unique_ptr<const BoxOdds> BoxOdds::Over(const machine::Machine& machine, const std::vector<MeasuringRun>& runs,
                                             const machine::ErrorModel& before, machine::KnownErrors found,
                                             const std::vector<OpenChoice>& choices) {
  if (found.covariance.is_empty()) return nullptr;
  const Box box = MeasuredBox(runs);
  if (box.low == box.high) return nullptr;
  return std::unique_ptr<const BoxOdds>(
      new BoxOdds(std::make_unique<const Drawn>(machine, runs, before, std::move(found), choices)));
}

BoxOdds::BoxOdds(std::unique_ptr<const Drawn> drawn) : drawn_(std::move(drawn)) {}
BoxOdds::~BoxOdds() = default;

double BoxOdds::ProbabilityOf(const Worse& worse, const machine::ErrorModel& after) const {
  return Drawn::ShareOf(worse, drawn_->before(), drawn_->LeftBy(drawn_->over().ErrorsOf(machine::NamedErrors(after))));
}

double BoxOdds::ProbabilityWithout(const std::vector<int>& terms, const Worse& worse) const {
  return Drawn::ShareOf(worse, drawn_->before(), drawn_->LeftBy(drawn_->FittedWithout(terms)));
}

VolumetricError BoxOdds::Figures(const machine::ErrorModel& after, const std::vector<std::string>& unknown,
                                 const Unsure& unsure) const {
  VolumetricError out;
  out.box = drawn_->box();
  out.poses = kBoxPoses;
  out.weakest = drawn_->Weakest();
  out.undecided = drawn_->Undecided();
  const OverPoses& over = drawn_->over();
  const Drawn::Left& of_before = drawn_->before();
  const Drawn::Left uncorrected = drawn_->LeftBy(Eigen::VectorXd::Zero(over.rows())),
                    of_after = drawn_->LeftBy(over.ErrorsOf(machine::NamedErrors(after)));
  out.uncorrected = drawn_->IntervalOf(uncorrected, unsure);
  out.before = drawn_->IntervalOf(of_before, unsure);
  out.after = drawn_->IntervalOf(of_after, unsure);
  std::vector<double> gain;
  for (size_t i = 0; i < of_after.rms_mm.size(); ++i) gain.push_back(of_before.rms_mm[i] - of_after.rms_mm[i]);
  out.is_gain_held = Quantile(&gain, kLowQuantile) > 0.0;
  out.unknown = over.ActingOf(drawn_->model(), unknown);
  return out;
}

}  // namespace axiscal::predict
