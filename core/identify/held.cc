#include "core/identify/held.h"

#include <algorithm>
#include <cmath>
#include <map>

#include "core/identify/naming.h"

namespace axiscal::identify {
namespace {

// What a report says about its errors' uncertainties, held ones of a stage before it included.
struct Reported {
  std::map<std::string, int> index;  // of the name
  std::vector<double> sigma;         // um, urad ...; NaN where there is none
  std::vector<std::string> unknown;  // errors without a number
  Eigen::MatrixXd correlation;       // NaN where there is none
  std::vector<MeasuredIn> from;
};

void Add(const std::string& name, double sigma, Reported* out) {
  out->index[name] = static_cast<int>(out->sigma.size());
  out->sigma.push_back(sigma);
}

// Rows from `first` on, both ways.
void AddCorrelation(const reports::Correlation& rows, int first, Eigen::MatrixXd* correlation) {
  for (size_t i = 0; i < rows.size(); ++i) {
    const Eigen::Index row = first + static_cast<Eigen::Index>(i);
    for (size_t j = 0; j < rows[i].size(); ++j) {
      const Eigen::Index column = static_cast<Eigen::Index>(j);
      if (row >= correlation->rows() || column >= correlation->cols() || !std::isfinite(rows[i][j])) continue;
      (*correlation)(row, column) = (*correlation)(column, row) = rows[i][j];
    }
  }
}

Reported ReportedBy(const reports::CalibrationReport& report) {
  Reported out;
  const reports::Fitted& fitted = reports::FittedOf(report);
  for (const reports::SessionFit& session : fitted.sessions) out.from.push_back({session.in.session, session.in.setup});
  for (const reports::Error& error : fitted.errors) {
    Add(error.name, error.sigma, &out);
    if (!error.identifiable) out.unknown.push_back(error.name);
  }
  const auto* const identification = std::get_if<reports::Identification>(&report);
  const reports::Held held =
      identification != nullptr ? identification->held.value_or(reports::Held{}) : reports::Held{};
  for (const reports::HeldError& error : held.errors) Add(error.name, error.sigma, &out);
  for (const reports::MeasuredIn& in : held.sessions) out.from.push_back({in.session, in.setup});
  const Eigen::Index count = static_cast<Eigen::Index>(out.sigma.size());
  out.correlation = Eigen::MatrixXd::Constant(count, count, NAN);
  if (identification == nullptr) return out;
  AddCorrelation(identification->correlation, 0, &out.correlation);
  AddCorrelation(held.correlation, static_cast<int>(fitted.errors.size()), &out.correlation);
  return out;
}

void TakeUncertainties(const Reported& reported, HeldErrors* held) {
  std::vector<int> from(held->errors.size(), -1);
  for (size_t i = 0; i < held->errors.size(); ++i) {
    const auto found = reported.index.find(held->errors[i].name);
    if (found == reported.index.end() || !std::isfinite(reported.sigma[found->second])) continue;
    from[i] = found->second;
    held->errors[i].sigma = reported.sigma[found->second] * held->errors[i].factor;
  }
  for (size_t i = 0; i < from.size(); ++i) {
    for (size_t j = 0; j < from.size(); ++j) {
      if (from[i] < 0 || from[j] < 0) continue;
      const double known = i == j ? 1.0 : reported.correlation(from[i], from[j]);
      held->covariance(i, j) = (std::isfinite(known) ? known : 0.0) * held->errors[i].sigma * held->errors[j].sigma;
    }
  }
}

absl::Status CheckKnown(const Reported& reported, const HeldErrors& held) {
  for (const Estimate& error : held.errors) {
    if (std::find(reported.unknown.begin(), reported.unknown.end(), error.name) == reported.unknown.end()) continue;
    return absl::InvalidArgumentError(
        absl::StrCat("held errors: ", error.name,
                     " has no value of its own, its sessions cannot tell it: hold only what they can tell, identify "
                     "from all sessions together, or hold an errors.json of values that are known"));
  }
  return absl::OkStatus();
}

}  // namespace

absl::StatusOr<HeldErrors> HoldErrors(machine::ErrorModel model,
                                      const std::optional<reports::CalibrationReport>& report,
                                      const machine::Machine& machine) {
  HeldErrors held;
  held.model = std::move(model);
  if (held.model.terms.empty()) return absl::InvalidArgumentError("held errors: there is none in it");
  for (const Parameter& parameter : ListParameters(held.model, true)) {
    Estimate error = NamedEstimate(machine, held.model, parameter);
    error.value = ValueOf(held.model, parameter);
    held.errors.push_back(std::move(error));
  }
  const Eigen::Index count = static_cast<Eigen::Index>(held.errors.size());
  held.covariance = Eigen::MatrixXd::Zero(count, count);
  if (!report) return held;
  Reported reported = ReportedBy(*report);
  RETURN_IF_ERROR(CheckKnown(reported, held));
  TakeUncertainties(reported, &held);
  held.from = std::move(reported.from);
  return held;
}

absl::StatusOr<machine::ErrorModel> BesideHeld(const machine::Machine& machine, const machine::ErrorModel& model,
                                               bool is_asked_for, const HeldErrors& held) {
  const std::vector<std::string> held_names = machine::NamesOf(machine, held.model),
                                 names = machine::NamesOf(machine, model);
  machine::ErrorModel left;
  for (size_t i = 0; i < names.size(); ++i) {
    const bool is_held = std::find(held_names.begin(), held_names.end(), names[i]) != held_names.end();
    if (is_held && is_asked_for) {
      return absl::InvalidArgumentError(names[i] + " is held and asked for too: expected it in one of them");
    }
    if (!is_held) left.terms.push_back(model.terms[i]);
  }
  if (left.terms.empty()) {
    return absl::InvalidArgumentError(
        "nothing is left to identify: all declared errors are held, expected others to be asked for");
  }
  return left;
}

}  // namespace axiscal::identify
