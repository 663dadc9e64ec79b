#include "core/instruments/stated.h"

#include <algorithm>
#include <cmath>
#include <map>

#include "core/instruments/evaluation.h"
#include "core/instruments/length/length_model.h"
#include "core/instruments/touch/touch_model.h"
#include "core/session/stated_facts.h"
#include "core/session/text.h"

namespace axiscal::instruments {
namespace {

using session::Expansion;

absl::Status RefuseStated(const MeasuringRun& run, const std::string& what) {
  return absl::InvalidArgumentError(absl::StrCat("session '", run.session, "': ", what));
}

// The temperatures of a column, or nothing.
const std::vector<double>* TemperaturesOf(const MeasuringRun& run, const std::string& column) {
  if (column == shapes::kTemperatureChannel) return run.has_temperature ? &run.temperature_celsius : nullptr;
  for (const MeasuringRun::Channel& channel : run.temperatures)
    if (ColumnOf(channel) == column) return &channel.celsius;
  return nullptr;
}

Evaluation AtNominal(const machine::Machine& machine, const MeasuringRun& run, int reading) {
  const machine::JointErrors<double> no_errors;
  const double no_setup[kMaxSetupParameters] = {};
  Evaluation evaluation;
  Evaluate(machine, run, reading, no_errors, no_setup, &evaluation);
  return evaluation;
}

// The length that a length's reading counts.
double LengthAt(const Evaluation& nominal, const MeasuringRun& run) {
  const double whole_mm = nominal.predicted_mm[0] - run.length.zero_mm;
  return run.length.is_beam ? whole_mm - run.length.beam.dot(run.tip_mm) : whole_mm;
}

// How a touched point moves off the stylus while its artefact grows by one.
double GapGrowth(const machine::Machine& machine, const MeasuringRun& run, int reading) {
  const touch::Feature& feature = run.touches.features[static_cast<size_t>(run.touches.feature_of[reading])];
  const Eigen::Vector3d lever_mm = feature.point_mm - run.touches.centre_mm;
  if (!feature.is_sphere) return feature.normal.dot(lever_mm);
  const auto pose = machine::EvaluateChain<double>(machine, run.PositionsOf(reading), machine::JointErrors<double>());
  const Eigen::Vector3d normal = pose.bed_from_table.rotation.transpose() * touch::NominalNormal(machine, run, reading);
  return normal.dot(lever_mm) + feature.radius_mm;
}

// d(reading) / d(growth), a growth being a share of the length: one column per reading.
Eigen::VectorXd GrowthOf(const Expansion& expansion, const machine::Machine& machine, const MeasuringRun& run,
                         int reading) {
  if (expansion.of == "bar") return Eigen::VectorXd::Constant(1, -run.bar_length_mm);
  if (expansion.of == "artefact") return Eigen::VectorXd::Constant(1, -GapGrowth(machine, run, reading));
  const Evaluation nominal = AtNominal(machine, run, reading);
  if (expansion.of == "instrument") return Eigen::VectorXd::Constant(1, -LengthAt(nominal, run));
  Eigen::VectorXd growth = Eigen::VectorXd::Zero(run.row_count);
  for (int axis = 0; axis < machine.axis_count(); ++axis) {
    const machine::Axis& a = machine.axes[axis];
    if (a.kind != machine::AxisKind::kLinear || (!expansion.axis.empty() && a.name != expansion.axis)) continue;
    growth += nominal.by_error.middleCols(machine::kComponents * Eigen::Index{axis}, 3) *
              (a.direction * run.PositionsOf(reading)[axis]);
  }
  return growth;
}

absl::Status BindCertifiedValues(const session::Session& session, const machine::Machine& machine, MeasuringRun* run) {
  for (const session::Certificate& certificate : run->certificates) {
    if (!certificate.value) continue;
    StatedEffect effect;
    effect.of = certificate.text();
    effect.mm.setZero(run->row_count, run->reading_count());
    if (certificate.of == "bar_length") {
      if (std::abs(certificate.value->value - run->bar_length_mm) > kCertifiedWithinMm)
        return RefuseStated(*run, absl::StrFormat("header 'certificate bar_length': %.4f mm, expected within %g mm of "
                                                  "bar_length_mm, %.4f",
                                                  certificate.value->value, kCertifiedWithinMm, run->bar_length_mm));
      run->bar_length_mm = certificate.value->value;
      effect.by_sigma_mm = Eigen::MatrixXd::Constant(run->row_count, run->reading_count(), -certificate.value->sigma);
      // What is left to find of it is what this mounting adds, where somebody states that.
      for (SetupParameter& parameter : run->setup) {
        if (parameter.name != "bar_length") continue;
        effect.setup_offset = parameter.name;
        effect.setup_sigma_mm = certificate.value->sigma;
        if (!session::FindHeader(session, "bar_length_sigma_um")) parameter.held = 0.0;
      }
    } else {
      effect.by_sigma_mm.setZero(run->row_count, run->reading_count());
      for (int k = 0; k < run->reading_count(); ++k) {
        const double length_mm = LengthAt(AtNominal(machine, *run, k), *run);
        effect.mm(0, k) = certificate.value->value * length_mm;
        effect.by_sigma_mm(0, k) = certificate.value->sigma * length_mm;
      }
    }
    run->stated.push_back(std::move(effect));
  }
  return absl::OkStatus();
}

// No shop is warmer or colder, and coefficients hold no further; a room in Fahrenheit is beyond it.
constexpr double kMostFromReferenceKelvin = 40.0;

absl::Status BindExpansions(const session::Session& session, const machine::Machine& machine, MeasuringRun* run) {
  // Of each thermometer; what workpieces grow by apart from the rest, as it is no part of a reading.
  std::map<std::pair<std::string, bool>, Eigen::MatrixXd> by_kelvin;
  for (const Expansion& expansion : session::ExpansionsOf(session.header)) {
    const std::vector<double>* const celsius = TemperaturesOf(*run, expansion.column);
    if (celsius == nullptr)
      return RefuseStated(*run, absl::StrCat("the ", expansion.text(), ", needs the temperature column ",
                                             expansion.column, ", which is missing"));
    if (const int axis = machine::FindAxis(machine, expansion.axis);
        !expansion.axis.empty() && (axis < 0 || machine.axes[axis].kind != machine::AxisKind::kLinear))
      return RefuseStated(*run, absl::StrCat("header 'expansion scale ", expansion.axis, "': ", expansion.axis,
                                             " is no linear axis of machine ", machine.id));
    StatedEffect effect;
    effect.of = expansion.text();
    effect.is_workpiece = expansion.of == "workpiece";
    effect.mm.setZero(run->row_count, run->reading_count());
    effect.by_sigma_mm = effect.mm;
    Eigen::MatrixXd& of_thermometer = by_kelvin[{expansion.column, effect.is_workpiece}];
    if (of_thermometer.size() == 0) of_thermometer = effect.mm;
    for (int k = 0; k < run->reading_count(); ++k) {
      const Eigen::VectorXd growth = GrowthOf(expansion, machine, *run, k);
      const double warmer_kelvin = (*celsius)[static_cast<size_t>(k)] - shapes::kReferenceTemperatureCelsius;
      if (!(std::abs(warmer_kelvin) <= kMostFromReferenceKelvin))
        return RefuseStated(
            *run, absl::StrFormat("reading %d: %s = %g, expected within %g K of 20 deg C where a length grows with it "
                                  "(%s): is it in Fahrenheit, or another column of the log?",
                                  run->readings_before + k + 1, expansion.column, (*celsius)[static_cast<size_t>(k)],
                                  kMostFromReferenceKelvin, expansion.text()));
      effect.mm.col(k) = expansion.per_kelvin * warmer_kelvin * growth;
      effect.by_sigma_mm.col(k) = expansion.sigma_per_kelvin * warmer_kelvin * growth;
      of_thermometer.col(k) += expansion.per_kelvin * growth;
    }
    run->stated.push_back(std::move(effect));
  }
  const std::optional<std::string> text = session::FindHeader(session, session::kTemperatureSigmaKey);
  std::vector<double> sigma_kelvin;
  if (!text || !session::ParseNumbers(*text, &sigma_kelvin) || sigma_kelvin.size() != 1) return absl::OkStatus();
  for (const auto& [of, mm_per_kelvin] : by_kelvin) {
    const auto& [column, is_workpiece] = of;
    StatedEffect effect;
    effect.of = session::ThermometerText(column, sigma_kelvin[0]);
    effect.is_workpiece = is_workpiece;
    effect.mm.setZero(run->row_count, run->reading_count());
    effect.by_sigma_mm = sigma_kelvin[0] * mm_per_kelvin;
    run->stated.push_back(std::move(effect));
  }
  return absl::OkStatus();
}

}  // namespace

void BindCertificates(const session::Session& session, MeasuringRun* run) {
  run->certificates = session::CertificatesOf(session.header);
  if (const auto started = session::FindHeader(session, "started")) run->started = session::ParseIso8601(*started);
}

absl::Status BindStated(const session::Session& session, const machine::Machine& machine, MeasuringRun* run) {
  BindCertificates(session, run);
  // The certified length is the one that grows.
  RETURN_IF_ERROR(BindCertifiedValues(session, machine, run));
  RETURN_IF_ERROR(BindExpansions(session, machine, run));
  for (const StatedEffect& effect : run->stated) {
    if (effect.is_workpiece) continue;
    if (run->stated_mm.size() == 0) run->stated_mm.setZero(run->row_count, run->reading_count());
    run->stated_mm += effect.mm;
  }
  return absl::OkStatus();
}

}  // namespace axiscal::instruments
