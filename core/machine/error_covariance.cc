#include "core/machine/error_covariance.h"

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>
#include <map>
#include <nlohmann/json.hpp>

#include "core/base/strict_json.h"
#include "core/base/units.h"
#include "core/machine/error_covariance_json.h"
#include "core/machine/error_json.h"

namespace axiscal::machine {
namespace {

using json = nlohmann::ordered_json;

absl::Status RefuseCovariance(const std::string& where, const std::string& what) {
  return absl::InvalidArgumentError(absl::StrCat("errors: covariance", where, ": ", what));
}

struct KnownNumber {
  ErrorCovariance::Number number;
  double factor = 1.0;
};

void NameNonlinear(const Machine& machine, const ErrorTerm& term, NamedNumber* number) {
  const std::optional<int> axis = shapes::VariableAxis(term.shape);
  const bool is_rotary = axis && machine.axes[*axis].kind == AxisKind::kRotary;
  if (std::holds_alternative<shapes::Harmonic>(term.shape)) {
    number->name += ".frequency";
    number->unit = is_rotary ? "1/turn" : "rad/mm";
    return;
  }
  const bool is_length = shapes::HasLength(term.shape);
  number->name += is_length ? ".length" : ".tau";
  number->unit = !is_length ? "s" : is_rotary ? "deg" : "mm";
  number->factor = is_length && is_rotary ? base::kRadPerDeg : 1.0;
}

NamedNumber NumberOf(const Machine& machine, const ErrorTerm& term, std::string name, int basis, bool is_nonlinear) {
  NamedNumber number{std::move(name), "", 1.0};
  if (is_nonlinear) {
    NameNonlinear(machine, term, &number);
    return number;
  }
  if (shapes::HasPhase(term.shape)) number.name += basis == 0 ? ".cos" : ".sin";
  if (shapes::IsFree(term.shape)) absl::StrAppend(&number.name, ".", basis + 1);
  number.unit = AmplitudeUnit(term, machine);
  number.factor = AmplitudeFactor(term);
  return number;
}

// By name, in the model's order for messages.
std::map<std::string, KnownNumber> NumbersOf(const Machine& machine, const ErrorModel& model) {
  std::map<std::string, KnownNumber> numbers;
  const std::vector<std::string> names = NamesOf(machine, model);
  const auto add = [&](int term, int basis, bool is_nonlinear) {
    const NamedNumber named =
        NumberOf(machine, model.terms[term], names[static_cast<size_t>(term)], basis, is_nonlinear);
    numbers[named.name] = {{term, basis, is_nonlinear}, named.factor};
  };
  for (int i = 0; i < static_cast<int>(model.terms.size()); ++i) {
    const shapes::Shape& shape = model.terms[i].shape;
    for (int k = 0; k < shapes::BasisCount(shape); ++k) add(i, k, false);
    const bool has_nonlinear =
        shapes::NonlinearParameter(shape) != nullptr || std::holds_alternative<shapes::Harmonic>(shape);
    if (has_nonlinear) add(i, 0, true);
  }
  return numbers;
}

absl::StatusOr<double> FiniteNumber(const json& value, const std::string& where) {
  if (!value.is_number() || !std::isfinite(value.get<double>()))
    return RefuseCovariance(where, absl::StrCat(value.dump(), ", expected a finite number"));
  return value.get<double>();
}

absl::StatusOr<const json*> List(const json& member, const std::string& key, size_t size) {
  const auto found = member.find(key);
  if (found == member.end()) return RefuseCovariance("", absl::StrCat("'", key, "' is missing"));
  if (!found->is_array() || (size > 0 && found->size() != size))
    return RefuseCovariance("." + key,
                            absl::StrCat(found->is_array() ? absl::StrCat(found->size(), " entries") : "no list",
                                         ", expected a list", size > 0 ? absl::StrCat(" of ", size) : ""));
  return &*found;
}

absl::Status ReadNames(const json& list, const std::map<std::string, KnownNumber>& numbers,
                       WrittenCovariance* covariance) {
  if (list.empty() || list.size() > kMostCovarianceNumbers)
    return RefuseCovariance(".of", absl::StrCat(list.size(), " names, expected 1 to ", kMostCovarianceNumbers));
  std::map<std::string, size_t> seen;
  for (size_t i = 0; i < list.size(); ++i) {
    const std::string where = absl::StrCat(".of[", i, "]");
    if (!list[i].is_string() || !numbers.contains(list[i].get<std::string>()))
      return RefuseCovariance(where,
                              absl::StrCat(list[i].dump(), ", expected the name of a number of these errors, such as ",
                                           numbers.empty() ? "EX0C" : numbers.begin()->first));
    covariance->of.push_back(list[i].get<std::string>());
    if (!seen.emplace(covariance->of.back(), i).second)
      return RefuseCovariance(where, absl::StrCat(list[i].dump(), " is there twice"));
  }
  return absl::OkStatus();
}

// covariance = root root'. A matrix that is none by more than the rounding of its text has a negative eigenvalue.
absl::StatusOr<Eigen::MatrixXd> RootOf(const Eigen::MatrixXd& correlation) {
  constexpr double kRounding = 1e-6;  // nine digits each, hundreds of them
  const Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd> solver(correlation);
  const double least = solver.eigenvalues().minCoeff();
  if (least < -kRounding * static_cast<double>(correlation.rows()))
    return RefuseCovariance(".correlation",
                            absl::StrFormat("its least eigenvalue is %.3g: these correlations contradict each "
                                            "other, expected 0 or more",
                                            least));
  return Eigen::MatrixXd(solver.eigenvectors() * solver.eigenvalues().cwiseMax(0.0).cwiseSqrt().asDiagonal());
}

}  // namespace

NamedNumber NameNumber(const Machine& machine, const ErrorModel& model, int term, int basis, bool is_nonlinear) {
  const ErrorTerm& its = model.terms[static_cast<size_t>(term)];
  const std::string name = NameOf(machine, its);
  int which = 1;
  // Only a length or time constant, which a name does not carry, makes two errors of one name.
  const bool may_share =
      shapes::NonlinearParameter(its.shape) != nullptr || std::holds_alternative<shapes::ThermalLag>(its.shape);
  for (int i = 0; may_share && i < term; ++i) {
    const ErrorTerm& other = model.terms[static_cast<size_t>(i)];
    which += other.joint == its.joint && other.component == its.component && NameOf(machine, other) == name;
  }
  return NumberOf(machine, its, which > 1 ? absl::StrCat(name, "#", which) : name, basis, is_nonlinear);
}

absl::StatusOr<WrittenCovariance> ReadWrittenCovariance(const json& member, const Machine& machine,
                                                        const ErrorModel& model) {
  if (!member.is_object()) return RefuseCovariance("", "expected an object with of, sigma and correlation");
  for (const auto& [key, value] : member.items()) {
    if (key != "of" && key != "sigma" && key != "correlation")
      return RefuseCovariance("", absl::StrCat("unknown field '", key, "', expected of, sigma and correlation"));
  }
  WrittenCovariance covariance;
  ASSIGN_OR_RETURN(const json* of, List(member, "of", 0));
  RETURN_IF_ERROR(ReadNames(*of, NumbersOf(machine, model), &covariance));
  const size_t count = covariance.of.size();
  ASSIGN_OR_RETURN(const json* sigma, List(member, "sigma", count));
  ASSIGN_OR_RETURN(const json* correlation, List(member, "correlation", count));
  covariance.correlation.setIdentity(static_cast<Eigen::Index>(count), static_cast<Eigen::Index>(count));
  for (size_t i = 0; i < count; ++i) {
    const std::string of_sigma = absl::StrCat(".sigma[", i, "]");
    ASSIGN_OR_RETURN(const double one, FiniteNumber((*sigma)[i], of_sigma));
    if (one < 0.0) return RefuseCovariance(of_sigma, absl::StrCat(one, ", must be >= 0"));
    covariance.sigma.push_back(one);
    const json& row = (*correlation)[i];
    const std::string of_row = absl::StrCat(".correlation[", i, "]");
    if (!row.is_array() || row.size() != i)
      return RefuseCovariance(of_row, absl::StrCat("expected a list of ", i, ": one for each number before"));
    for (size_t k = 0; k < i; ++k) {
      const std::string where = absl::StrCat(of_row, "[", k, "]");
      ASSIGN_OR_RETURN(const double value, FiniteNumber(row[k], where));
      constexpr double kRounding = 1e-6;
      if (std::abs(value) > 1.0 + kRounding)
        return RefuseCovariance(where, absl::StrCat(value, ", expected a correlation from -1 to 1"));
      covariance.correlation(static_cast<Eigen::Index>(i), static_cast<Eigen::Index>(k)) = value;
    }
  }
  return covariance;
}

absl::StatusOr<KnownErrors> ReadKnownErrors(const std::string& text, const Machine& machine) {
  KnownErrors known;
  ASSIGN_OR_RETURN(known.model, ReadErrors(text, machine));
  ASSIGN_OR_RETURN(const json root, base::ParseStrictJson(text));
  const auto member = root.find(kCovarianceKey);
  if (member == root.end()) return known;
  ASSIGN_OR_RETURN(const WrittenCovariance written, ReadWrittenCovariance(*member, machine, known.model));
  ASSIGN_OR_RETURN(known.covariance, CovarianceOf(written, machine, known.model));
  return known;
}

absl::StatusOr<ErrorCovariance> CovarianceOf(const WrittenCovariance& written, const Machine& machine,
                                             const ErrorModel& model) {
  ErrorCovariance covariance;
  if (written.of.empty()) return covariance;
  ASSIGN_OR_RETURN(covariance.root, RootOf(written.correlation.selfadjointView<Eigen::Lower>().toDenseMatrix()));
  const std::map<std::string, KnownNumber> numbers = NumbersOf(machine, model);
  for (size_t i = 0; i < written.of.size(); ++i) {
    const auto number = numbers.find(written.of[i]);
    if (number == numbers.end())
      return RefuseCovariance(absl::StrCat(".of[", i, "]"), written.of[i] + ", expected a number of these errors");
    covariance.of.push_back(number->second.number);
    covariance.root.row(static_cast<Eigen::Index>(i)) *= written.sigma[i] * number->second.factor;
  }
  return covariance;
}

WrittenCovariance OfWritten(const WrittenCovariance& covariance, const Machine& machine, const ErrorModel& model) {
  const std::map<std::string, KnownNumber> numbers = NumbersOf(machine, NamedErrors(model));
  std::vector<Eigen::Index> kept;
  WrittenCovariance out;
  for (size_t i = 0; i < covariance.of.size(); ++i) {
    if (!numbers.contains(covariance.of[i])) continue;
    kept.push_back(static_cast<Eigen::Index>(i));
    out.of.push_back(covariance.of[i]);
    out.sigma.push_back(covariance.sigma[i]);
  }
  out.correlation = covariance.correlation(kept, kept);
  return out;
}

std::string CovarianceText(const WrittenCovariance& covariance) {
  std::string of, sigma, correlation;
  for (size_t i = 0; i < covariance.of.size(); ++i) {
    absl::StrAppend(&of, i == 0 ? "" : ", ", json(covariance.of[i]).dump());
    absl::StrAppend(&sigma, i == 0 ? "" : ", ", json(covariance.sigma[i]).dump());
    absl::StrAppend(&correlation, i == 0 ? "\n   [" : ",\n   [");
    for (size_t k = 0; k < i; ++k)
      absl::StrAppendFormat(&correlation, "%s%.9g", k == 0 ? "" : ", ",
                            covariance.correlation(static_cast<Eigen::Index>(i), static_cast<Eigen::Index>(k)));
    absl::StrAppend(&correlation, "]");
  }
  return absl::StrCat("{\n  \"of\": [", of, "],\n  \"sigma\": [", sigma, "],\n  \"correlation\": [", correlation,
                      "]\n }");
}

}  // namespace axiscal::machine
