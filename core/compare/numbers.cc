#include "core/compare/numbers.h"

#include <algorithm>
#include <cmath>
#include <map>

namespace axiscal::compare {
namespace {

constexpr double kNormalCoverage = 1.959964;  // of the factor by which a sigma is a 95 % interval
// Reports write coefficients with four digits: what is left of a direction below this share of it is their rounding.
constexpr double kRounding = 2e-3;

// All numbers of a model by name, its lengths and time constants among them.
struct ModelNumber {
  machine::NamedNumber named;
  machine::ErrorCovariance::Number of;
  double value = 0.0;  // of files
};

std::vector<ModelNumber> NumbersOf(const machine::Machine& machine, const machine::ErrorModel& model) {
  std::vector<ModelNumber> numbers;
  for (int i = 0; i < static_cast<int>(model.terms.size()); ++i) {
    const machine::ErrorTerm& term = model.terms[static_cast<size_t>(i)];
    for (int k = 0; k < shapes::BasisCount(term.shape); ++k) {
      machine::NamedNumber named = machine::NameNumber(machine, model, i, k, false);
      const double value = term.amplitude[static_cast<size_t>(k)] / named.factor;
      numbers.push_back({std::move(named), {i, k, false}, value});
    }
    if (const double* nonlinear = shapes::NonlinearParameter(term.shape); nonlinear != nullptr) {
      machine::NamedNumber named = machine::NameNumber(machine, model, i, 0, true);
      const double value = *nonlinear / named.factor;
      numbers.push_back({std::move(named), {i, 0, true}, value});
    }
  }
  return numbers;
}

class Builder {
 public:
  Builder(const machine::Machine& machine, const Side& first, const Side& second)
      : machine_(machine), sides_{&first, &second} {}

  absl::StatusOr<Numbers> Build() {
    for (int side = 0; side < 2; ++side) AddNumbers(side);
    for (int side = 0; side < 2; ++side) AddCovariance(side);
    for (int side = 0; side < 2; ++side) RETURN_IF_ERROR(AddUnknown(side));
    Reduce();
    return std::move(out_);
  }

 private:
  void AddNumbers(int side) {
    const machine::ErrorModel& model = sides_[side]->errors.model;
    std::map<int, int> term_in_both;
    for (const ModelNumber& number : NumbersOf(machine_, model)) {
      const auto found = at_.find(number.named.name);
      if (found != at_.end()) {
        out_.all[found->second].is_in[side] = true;
        out_.all[found->second].value[side] = number.value;
        continue;
      }
      const auto [term, is_new] = term_in_both.try_emplace(number.of.term, static_cast<int>(out_.both.terms.size()));
      if (is_new) out_.both.terms.push_back(model.terms[static_cast<size_t>(number.of.term)]);
      Number added{number.named.name, number.named.unit, number.named.factor, number.of, {}, {}, {}};
      added.of.term = term->second;
      added.is_in[side] = true;
      added.value[side] = number.value;
      at_[added.name] = out_.all.size();
      out_.all.push_back(std::move(added));
    }
  }

  void AddCovariance(int side) {
    const auto count = static_cast<Eigen::Index>(out_.all.size());
    out_.covariance[side].setZero(count, count);
    const machine::KnownErrors& errors = sides_[side]->errors;
    std::vector<Eigen::Index> to;
    std::vector<double> factor;
    for (const machine::ErrorCovariance::Number& of : errors.covariance.of) {
      const machine::NamedNumber named =
          machine::NameNumber(machine_, errors.model, of.term, of.basis, of.is_nonlinear);
      const auto found = at_.find(named.name);  // not there: a frequency, which names the error and is not compared
      to.push_back(found == at_.end() ? -1 : static_cast<Eigen::Index>(found->second));
      factor.push_back(named.factor);
      if (found != at_.end()) out_.all[found->second].has_sigma[side] = true;
    }
    const Eigen::MatrixXd covariance = errors.covariance.root * errors.covariance.root.transpose();
    const double widened = std::pow(sides_[side]->coverage_factor / kNormalCoverage, 2);
    for (size_t i = 0; i < to.size(); ++i)
      for (size_t k = 0; k < to.size(); ++k)
        if (to[i] >= 0 && to[k] >= 0)
          out_.covariance[side](to[i], to[k]) = widened *
                                                covariance(static_cast<Eigen::Index>(i), static_cast<Eigen::Index>(k)) /
                                                (factor[i] * factor[k]);
  }

  void AddRow(const Eigen::VectorXd& row) {
    out_.unknown.conservativeResize(out_.unknown.rows() + 1, static_cast<Eigen::Index>(out_.all.size()));
    out_.unknown.bottomRows<1>() = row.transpose();
  }

  absl::Status AddUnknown(int side) {
    const Side& of = *sides_[side];
    const auto count = static_cast<Eigen::Index>(out_.all.size());
    std::vector<bool> is_in_direction(out_.all.size(), false);
    for (const std::string& text : of.not_separable) {
      ASSIGN_OR_RETURN(const std::vector<Share> shares, ParseCombination(text));
      Eigen::VectorXd row = Eigen::VectorXd::Zero(count);
      for (const Share& share : shares) {
        const auto found = at_.find(share.name);
        if (found == at_.end()) continue;  // a frequency
        row[static_cast<Eigen::Index>(found->second)] = share.coefficient;
        is_in_direction[found->second] = true;
      }
      if (row.squaredNorm() > 0.0) AddRow(row);
    }
    const auto alone = [&](size_t i) { AddRow(Eigen::VectorXd::Unit(count, static_cast<Eigen::Index>(i))); };
    for (const std::string& name : of.without_number) {
      const auto found = at_.find(name);
      if (found != at_.end() && !is_in_direction[found->second]) alone(found->second);
    }
    // Without a report: what a fit held at zero stands in its model at zero and is not in its covariance.
    for (size_t i = 0; i < out_.all.size() && !of.has_report && !of.errors.covariance.is_empty(); ++i) {
      const Number& number = out_.all[i];
      if (number.is_in[side] && !number.has_sigma[side] && number.value[side] == 0.0) alone(i);
    }
    return absl::OkStatus();
  }

  // Gauss-Jordan with full pivoting.
  void Reduce() {
    Eigen::MatrixXd& rows = out_.unknown;
    for (Eigen::Index i = 0; i < rows.rows(); ++i) rows.row(i) /= rows.row(i).cwiseAbs().maxCoeff();
    Eigen::Index rank = 0;
    while (rank < rows.rows()) {
      Eigen::Index row = 0, column = 0;
      if (rows.bottomRows(rows.rows() - rank).cwiseAbs().maxCoeff(&row, &column) < kRounding) break;
      rows.row(rank).swap(rows.row(rank + row));
      rows.row(rank) /= rows(rank, column);
      for (Eigen::Index i = 0; i < rows.rows(); ++i) {
        if (i == rank) continue;
        const double share = rows(i, column);
        rows.row(i) -= share * rows.row(rank);
        rows(i, column) = 0.0;
      }
      out_.pivots.push_back(static_cast<int>(column));
      ++rank;
    }
    rows.conservativeResize(rank, static_cast<Eigen::Index>(out_.all.size()));
    rows = (rows.array().abs() < kRounding).select(0.0, rows);
  }

  const machine::Machine& machine_;
  const Side* sides_[2];
  std::map<std::string, size_t> at_;
  Numbers out_;
};

}  // namespace

absl::StatusOr<Numbers> SideBySide(const machine::Machine& machine, const Side& first, const Side& second) {
  return Builder(machine, first, second).Build();
}

std::string CombinationText(const std::vector<Number>& numbers, const Eigen::VectorXd& coefficients,
                            Eigen::Index carrier) {
  std::string text;
  const auto add = [&](Eigen::Index i) {
    const double ratio = coefficients[i] / coefficients[carrier];
    if (std::abs(ratio) < kRounding) return;
    const std::string size = std::abs(std::abs(ratio) - 1.0) < 5e-4 ? "" : absl::StrFormat("%.4g ", std::abs(ratio));
    absl::StrAppend(&text, text.empty() ? "" : ratio > 0.0 ? " + " : " - ", size, numbers[static_cast<size_t>(i)].name);
  };
  add(carrier);
  for (Eigen::Index i = 0; i < coefficients.size(); ++i)
    if (i != carrier) add(i);
  return text;
}

}  // namespace axiscal::compare
