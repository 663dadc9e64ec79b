#include "server/jobs/new_calibration.h"

#include <cmath>
#include <map>

#include "core/base/units.h"
#include "core/machine/error_json.h"

namespace axiscal::jobs {
namespace {

// The store knows um and urad; what is per a reference says so in its name: "EXX:linear/m".
std::optional<records::Estimate> ToRecord(const identify::Estimate& estimate) {
  records::Estimate record;
  const bool is_angle = estimate.unit.rfind("urad", 0) == 0;
  if (!is_angle && estimate.unit.rfind("um", 0) != 0) return std::nullopt;  // a decay length, a time constant
  record.symbol = estimate.name + estimate.unit.substr(is_angle ? 4 : 2);
  record.unit = is_angle ? records::EstimateUnit::kUrad : records::EstimateUnit::kUm;
  record.identifiable = estimate.identifiable && std::isfinite(estimate.value);
  if (!record.identifiable) return record;
  record.value = estimate.value / estimate.factor;
  if (std::isfinite(estimate.sigma)) record.sigma = estimate.sigma / estimate.factor;
  return record;
}

// The nodes of a map that stand from `first` on in a model, one term each.
size_t NodesOfMap(const std::vector<machine::ErrorTerm>& terms, size_t first) {
  const auto* const map = std::get_if<shapes::Tabulated>(&terms[first].shape);
  size_t end = first + 1;
  for (; map != nullptr && end < terms.size(); ++end) {
    const auto* const other = std::get_if<shapes::Tabulated>(&terms[end].shape);
    if (other == nullptr || terms[end].joint != terms[first].joint || terms[end].component != terms[first].component ||
        other->axis != map->axis || other->second_axis != map->second_axis)
      break;
  }
  return end - first;
}

// An error with many numbers is followed by two: the root mean square of a map's nodes and its largest node, sizes
// both. No number where one of its nodes has none.
class MapSummary {
 public:
  MapSummary(const machine::Machine& machine, const identify::Result& result) : machine_(machine), result_(result) {
    for (const identify::Estimate& estimate : result.estimates) found_[estimate.name] = &estimate;
    for (size_t i = 0; i < result.covariance.of.size(); ++i) row_[result.covariance.of[i]] = i;
  }

  // Nothing for a map that this fit held at its values.
  std::vector<records::Estimate> Of(size_t first, size_t count) const {
    const std::vector<machine::ErrorTerm>& terms = result_.model.terms;
    const auto& map = std::get<shapes::Tabulated>(terms[first].shape);
    Eigen::VectorXd amplitude(count), sigma(count);
    Eigen::MatrixXd correlation = Eigen::MatrixXd::Identity(amplitude.size(), amplitude.size());
    std::map<std::pair<double, double>, Eigen::RowVectorXd> nodes;  // by place: what each amplitude adds there
    bool is_known = true;
    std::string unit;
    for (size_t i = 0; i < count; ++i) {
      const auto& node = std::get<shapes::Tabulated>(terms[first + i].shape);
      const auto estimate = found_.find(machine::NameOf(machine_, terms[first + i]));
      if (estimate == found_.end()) return {};
      unit = estimate->second->unit;
      const auto row = row_.find(estimate->first);
      is_known &= estimate->second->identifiable && row != row_.end();
      if (!is_known) break;
      const auto at = static_cast<Eigen::Index>(i);
      amplitude[at] = estimate->second->value / estimate->second->factor;
      sigma[at] = result_.covariance.sigma[row->second];
      for (size_t k = 0; k <= i; ++k) {
        const auto other = row_.at(machine::NameOf(machine_, terms[first + k]));
        correlation(at, static_cast<Eigen::Index>(k)) = correlation(static_cast<Eigen::Index>(k), at) =
            result_.covariance.correlation(static_cast<Eigen::Index>(row->second), static_cast<Eigen::Index>(other));
      }
      const auto add = [&](double place, double part) {
        auto& of_node =
            nodes.try_emplace({place, node.second.at}, Eigen::RowVectorXd::Zero(amplitude.size())).first->second;
        of_node[at] += part;
      };
      add(node.node.at, 1.0);
      if (node.is_tied) add(node.tied_to.at, -1.0);
    }
    const std::string name = NameOfMap(terms[first], map);
    records::Estimate rms;
    rms.symbol = name + ".rms";
    rms.unit = unit == "urad" ? records::EstimateUnit::kUrad : records::EstimateUnit::kUm;
    records::Estimate largest = rms;
    largest.symbol = name + ".max";
    rms.identifiable = largest.identifiable = is_known;
    if (!is_known) return {rms, largest};
    const Eigen::MatrixXd covariance = sigma.asDiagonal() * correlation * sigma.asDiagonal();
    Eigen::RowVectorXd slope = Eigen::RowVectorXd::Zero(amplitude.size()), of_largest = slope;
    double squares = 0.0, size = -1.0;
    for (const auto& [place, parts] : nodes) {
      const double value = parts.dot(amplitude);
      squares += value * value;
      slope += value * parts;
      if (std::abs(value) > size) of_largest = parts;
      size = std::max(size, std::abs(value));
    }
    const double count_of_nodes = static_cast<double>(nodes.size());
    rms.value = std::sqrt(squares / count_of_nodes);
    if (squares > 0.0) slope /= std::sqrt(squares * count_of_nodes);
    rms.sigma = std::sqrt(std::max(0.0, (slope * covariance).dot(slope)));
    largest.value = size;
    largest.sigma = std::sqrt(std::max(0.0, (of_largest * covariance).dot(of_largest)));
    return {rms, largest};
  }

 private:
  // "EYC:tabulated" over the error's own axis, "EYC:tabulated(C,A)" over two.
  std::string NameOfMap(const machine::ErrorTerm& term, const shapes::Tabulated& map) const {
    std::string over = map.axis == term.joint ? "" : machine_.axes[map.axis].name;
    if (map.second_axis >= 0) over = machine_.axes[map.axis].name + "," + machine_.axes[map.second_axis].name;
    return machine::SymbolOf(machine_, term) + ":tabulated" + (over.empty() ? "" : "(" + over + ")");
  }

  const machine::Machine& machine_;
  const identify::Result& result_;
  std::map<std::string, const identify::Estimate*> found_;
  std::map<std::string, size_t> row_;
};

std::optional<double> IfFinite(double value) { return std::isfinite(value) ? std::optional(value) : std::nullopt; }

}  // namespace

records::NewCalibration MakeCalibration(const MachineInput& input, const MeasuredSessions& fit,
                                        const identify::FitStatistics& before, const identify::Result& result,
                                        const records::JobRecord& job) {
  records::NewCalibration calibration;
  calibration.machine = input.record.id;
  calibration.machine_revision = input.record.revision;
  for (const records::SessionRecord& record : fit.records) calibration.sessions.push_back(record.id);
  calibration.measured_at = fit.measured_at;
  calibration.model_json = machine::WriteErrors(result.model, input.machine, result.covariance);
  calibration.engine_version = AXISCAL_VERSION;
  calibration.rank = result.rank;
  calibration.condition = IfFinite(result.condition);
  calibration.chi2_per_dof = IfFinite(result.fit.chi2_per_dof);
  calibration.rms_before_um = IfFinite(before.rms_mm * base::kUmPerMm);
  calibration.rms_after_um = IfFinite(result.fit.rms_mm * base::kUmPerMm);
  std::map<std::string, int> uses;
  for (const identify::Estimate& estimate : result.estimates) {
    std::optional<records::Estimate> record = ToRecord(estimate);
    if (!record) continue;
    // Two decays of one component differ in their length only, which the name does not hold.
    if (const int use = ++uses[record->symbol]; use > 1) absl::StrAppend(&record->symbol, "#", use);
    calibration.estimates.push_back(*std::move(record));
  }
  const MapSummary summary(input.machine, result);
  const std::vector<machine::ErrorTerm>& terms = result.model.terms;
  for (size_t i = 0, count = 1; i < terms.size(); i += count) {
    count = NodesOfMap(terms, i);
    if (!std::holds_alternative<shapes::Tabulated>(terms[i].shape)) continue;
    for (records::Estimate& one : summary.Of(i, count)) calibration.estimates.push_back(std::move(one));
  }
  calibration.created_by = job.created_by;
  return calibration;
}

}  // namespace axiscal::jobs
