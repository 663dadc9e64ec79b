#include "core/predict/tool_point.h"

#include <Eigen/Geometry>
#include <algorithm>

#include "core/base/status.h"

namespace axiscal::predict {
namespace {

bool DiffersFromZero(const machine::ErrorTerm& term) {
  return std::any_of(term.amplitude.begin(), term.amplitude.end(), [](double one) { return one != 0.0; });
}

std::array<double, machine::kMaxAxes> PositionsOf(const shapes::State& state) {
  std::array<double, machine::kMaxAxes> positions{};
  for (size_t i = 0; i < state.axes.size(); ++i) positions[i] = state.axes[i].position;
  return positions;
}

Eigen::Matrix3d ToolInTable(const machine::ChainPose<double>& pose) {
  return pose.bed_from_table.rotation.transpose() * pose.bed_from_tool.rotation;
}

}  // namespace

Propagation::Propagation(const machine::ErrorModel& model, const machine::ErrorCovariance& covariance)
    : root_(covariance.root) {
  for (const machine::ErrorTerm& term : model.terms) {
    if (shapes::IsFree(term.shape) || std::holds_alternative<shapes::ThermalLag>(term.shape) ||
        std::holds_alternative<shapes::Drift>(term.shape))
      reaching_.push_back(term);
  }
  for (const machine::ErrorCovariance::Number& of : covariance.of) {
    const machine::ErrorTerm& term = model.terms[of.term];
    Number number{term.joint,
                  static_cast<int>(term.component),
                  shapes::IsAlongApproach(term.shape),
                  term.shape,
                  term.amplitude,
                  of.basis,
                  of.is_nonlinear};
    // A harmonic whose frequency was fitted is written with the one that was found.
    auto* const harmonic = std::get_if<shapes::Harmonic>(&number.shape);
    if (harmonic != nullptr && of.is_nonlinear) harmonic->is_frequency_free = true;
    numbers_.push_back(std::move(number));
  }
}

double Propagation::FactorOf(const Number& number, const shapes::State& state) {
  double values[shapes::kMaxBasisCount];
  if (!number.is_nonlinear) {
    shapes::Basis(number.shape, state, values);
    return values[number.basis];
  }
  shapes::BasisSlope(number.shape, state, values);
  double factor = 0.0;
  for (int k = 0; k < shapes::BasisCount(number.shape); ++k) factor += number.amplitude[k] * values[k];
  return factor;
}

ToolPointError ToolPoint::ErrorAt(const shapes::State& state) {
  const auto positions = PositionsOf(state);
  const machine::JointErrors<double> errors = machine::ErrorsAt(machine_, errors_.model, state);
  const auto actual = machine::EvaluateChain<double>(machine_, positions.data(), errors);
  const auto nominal = machine::EvaluateChain<double>(machine_, positions.data(), machine::JointErrors<double>());
  ToolPointError error;
  error.head<3>() = machine::TipInTable(actual, tip_mm_) - machine::TipInTable(nominal, tip_mm_);
  const Eigen::AngleAxisd turn(Eigen::Matrix3d(ToolInTable(actual) * ToolInTable(nominal).transpose()));
  error.tail<3>() = turn.angle() * turn.axis();
  return error;
}

// With p the actual tool point in the table's frame, d p = R^T (d tip - d of the point of the table at p); and d of the
// rotation is that of the tool's branch less that of the table's, both seen from the table.
const Eigen::MatrixXd& ToolPoint::ByNumberAt(const shapes::State& state) {
  const auto positions = PositionsOf(state);
  const machine::JointErrors<double> errors = machine::ErrorsAt(machine_, errors_.model, state);
  const Eigen::Vector3d tip_in_table_mm =
      machine::TipInTable(machine::EvaluateChain<double>(machine_, positions.data(), errors), tip_mm_);
  machine::EvaluateRelativePoint(machine_, positions.data(), errors, tip_mm_, tip_in_table_mm, &point_);
  const Eigen::Matrix3d table_from_bed = point_.pose.bed_from_table.rotation.transpose();
  by_error_.setZero(6, point_.sensitivity.cols());
  by_error_.topRows<3>() = table_from_bed * point_.sensitivity;
  for (int joint = 0; joint < machine_.joint_count(); ++joint) {
    const machine::JointPlace& place = point_.places[joint];
    by_error_.block<3, 3>(3, machine::kComponents * joint + 3) =
        place.sign * table_from_bed * place.bed_from_parent * point_.turns[joint].axes;
  }
  propagation_.ByNumber(state, by_error_, &by_number_);
  return by_number_;
}

ToolPointError ToolPoint::SigmaAt(const shapes::State& state) {
  const Eigen::VectorXd known = propagation_.Sigma(ByNumberAt(state));
  return (known.cwiseAbs2() + propagation_.UnknownVariance(state, by_error_)).cwiseSqrt();
}

std::vector<std::string> TakenForExact(const machine::Machine& machine, const machine::KnownErrors& errors) {
  std::vector<std::string> names;
  for (size_t i = 0; i < errors.model.terms.size(); ++i) {
    const machine::ErrorTerm& term = errors.model.terms[i];
    const bool is_known = std::any_of(errors.covariance.of.begin(), errors.covariance.of.end(),
                                      [&](const auto& number) { return number.term == static_cast<int>(i); });
    if (!is_known && DiffersFromZero(term)) names.push_back(machine::NameOf(machine, term));
  }
  return names;
}

absl::Status RequireState(const machine::Machine& machine, const machine::ErrorModel& model, bool has_time,
                          const std::vector<std::string>& channels) {
  for (const machine::ErrorTerm& term : model.terms) {
    if (DiffersFromZero(term)) RETURN_IF_ERROR(machine::RequireState(machine, term, has_time, channels));
  }
  return absl::OkStatus();
}

}  // namespace axiscal::predict
