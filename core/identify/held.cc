#include "core/identify/held.h"

#include <algorithm>
#include <cmath>
#include <map>

#include "core/base/strict_json.h"
#include "core/identify/naming.h"
#include "core/machine/error_json.h"

namespace axiscal::identify {
namespace {

using json = nlohmann::ordered_json;

// What a report says about its errors' uncertainties, held ones of a stage before it included.
struct Reported {
  std::map<std::string, int> index;  // of the name
  std::vector<double> sigma;         // um, urad ...; NaN where there is none
  std::vector<std::string> unknown;  // errors without a number
  Eigen::MatrixXd correlation;       // NaN where there is none
  std::vector<MeasuredIn> from;
};

double NumberOr(const json& object, const char* key, double otherwise) {
  const auto value = object.is_object() ? object.find(key) : object.end();
  return value != object.end() && value->is_number() ? value->get<double>() : otherwise;
}

const json* ArrayIn(const json& object, const char* key) {
  if (!object.is_object()) return nullptr;
  const auto value = object.find(key);
  return value != object.end() && value->is_array() ? &*value : nullptr;
}

std::string TextIn(const json& object, const char* key) {
  if (!object.is_object()) return "";
  const auto value = object.find(key);
  return value != object.end() && value->is_string() ? value->get<std::string>() : "";
}

void ReadSigmas(const json& object, Reported* out) {
  const json* const errors = ArrayIn(object, "errors");
  if (errors == nullptr) return;
  for (const json& error : *errors) {
    const std::string own = TextIn(error, "name"), name = own.empty() ? TextIn(error, "symbol") : own;
    out->index[name] = static_cast<int>(out->sigma.size());
    out->sigma.push_back(NumberOr(error, "sigma", NAN));
    const auto identifiable = error.is_object() ? error.find("identifiable") : error.end();
    if (identifiable != error.end() && identifiable->is_boolean() && !identifiable->get<bool>())
      out->unknown.push_back(name);
  }
}

// Rows of `object`'s "correlation" from `first` on, both ways.
void ReadCorrelation(const json& object, int first, Eigen::MatrixXd* correlation) {
  const json* const rows = ArrayIn(object, "correlation");
  if (rows == nullptr) return;
  for (size_t i = 0; i < rows->size(); ++i) {
    const Eigen::Index row = first + static_cast<Eigen::Index>(i);
    const json& cells = (*rows)[i];
    for (size_t j = 0; cells.is_array() && j < cells.size(); ++j) {
      const Eigen::Index column = static_cast<Eigen::Index>(j);
      if (row >= correlation->rows() || column >= correlation->cols() || !cells[j].is_number()) continue;
      (*correlation)(row, column) = (*correlation)(column, row) = cells[j].get<double>();
    }
  }
}

void ReadSessions(const json& object, std::vector<MeasuredIn>* out) {
  const json* const sessions = ArrayIn(object, "sessions");
  if (sessions == nullptr) return;
  for (const json& session : *sessions) {
    const std::string name = TextIn(session, "session"), shared = TextIn(session, "shared_setup");
    if (!name.empty()) out->push_back({name, shared.empty() ? name : shared});
  }
}

Reported ReadReport(const json& report) {
  Reported out;
  ReadSessions(report, &out.from);
  ReadSigmas(report, &out);
  const int fitted = static_cast<int>(out.sigma.size());
  const json held = report.is_object() ? report.value("held", json()) : json();
  ReadSigmas(held, &out);
  ReadSessions(held, &out.from);
  const Eigen::Index count = static_cast<Eigen::Index>(out.sigma.size());
  out.correlation = Eigen::MatrixXd::Constant(count, count, NAN);
  ReadCorrelation(report, 0, &out.correlation);
  ReadCorrelation(held, fitted, &out.correlation);
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

absl::Status CheckCalibration(const json& root, const Reported& reported, const HeldErrors& held,
                              const machine::Machine& machine) {
  const std::string of = TextIn(root, "machine");
  if (!of.empty() && of != machine.id) {
    return absl::InvalidArgumentError(
        absl::StrCat("held errors: they are of machine ", of, ", expected of ", machine.id));
  }
  for (const Estimate& error : held.errors) {
    if (std::find(reported.unknown.begin(), reported.unknown.end(), error.name) == reported.unknown.end()) continue;
    return absl::InvalidArgumentError(
        absl::StrCat("held errors: ", error.name,
                     " has no value of its own, its sessions cannot tell it: hold only what they can tell, identify "
                     "from all sessions together, or hold an errors.json of values that are known"));
  }
  return absl::OkStatus();
}

std::vector<std::string> NamesOf(const machine::Machine& machine, const machine::ErrorModel& model) {
  std::vector<std::string> names;
  for (const machine::ErrorTerm& term : model.terms) names.push_back(machine::NameOf(machine, term));
  return names;
}

}  // namespace

absl::StatusOr<HeldErrors> ReadHeldErrors(const std::string& text, const machine::Machine& machine) {
  const auto root = base::ParseStrictJson(text);
  if (!root.ok()) return base::Within("held errors", root.status());
  const bool is_calibration = root->is_object() && root->contains("model") && root->contains("report");
  if (root->is_object() && !is_calibration && (root->contains("verdict") || root->contains("estimates"))) {
    return absl::InvalidArgumentError(
        "held errors: a report, expected an errors.json or a calibration (calibration show ID --json)");
  }
  Reported reported;
  if (is_calibration) reported = ReadReport((*root)["report"]);
  HeldErrors held;
  absl::StatusOr<machine::ErrorModel> model =
      machine::ReadErrors(is_calibration ? (*root)["model"].dump() : text, machine);
  if (!model.ok()) return base::Within("held errors", model.status());
  held.model = *std::move(model);
  if (held.model.terms.empty()) return absl::InvalidArgumentError("held errors: there is none in it");
  for (const Parameter& parameter : ListParameters(held.model, true)) {
    Estimate error = NamedEstimate(machine, held.model, parameter);
    error.value = ValueOf(held.model, parameter);
    held.errors.push_back(std::move(error));
  }
  if (is_calibration) RETURN_IF_ERROR(CheckCalibration(*root, reported, held, machine));
  const Eigen::Index count = static_cast<Eigen::Index>(held.errors.size());
  held.covariance = Eigen::MatrixXd::Zero(count, count);
  TakeUncertainties(reported, &held);
  held.from = reported.from;
  return held;
}

absl::StatusOr<machine::ErrorModel> BesideHeld(const machine::Machine& machine, const machine::ErrorModel& model,
                                               bool is_asked_for, const HeldErrors& held) {
  const std::vector<std::string> held_names = NamesOf(machine, held.model), names = NamesOf(machine, model);
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
