#include "core/instruments/length/length_model.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <limits>

namespace axiscal::length {
namespace {

// An anchor and a target are measured with a rule; a beam is aligned by eye over the travel. An interferometer or a
// tracker knows its scale to 1 um/m (the air's index); a draw wire states less (`scale_sigma_um`). docs/formats.md
constexpr double kPlaceMm = 5.0, kTiltRad = 0.01, kScaleMm = 0.001;

void AddCommon(std::vector<instruments::SetupParameter>* setup) {
  for (const char* name : {"target_x", "target_y", "target_z"}) setup->push_back({name, kPlaceMm, true, false});
  setup->push_back({"zero", std::numeric_limits<double>::infinity(), true, false});
  setup->push_back({kScaleName, kScaleMm, false, false});
}

void ClearWorkBranch(const machine::Machine& machine, Eigen::Ref<Eigen::RowVectorXd> by_error) {
  for (const int axis : machine.work_branch) by_error.segment<6>(6 * axis).setZero();
  by_error.segment<6>(6 * machine.work_joint()).setZero();
}

}  // namespace

std::vector<instruments::SetupParameter> SetupParameters() {
  std::vector<instruments::SetupParameter> setup;
  for (const char* name : {"anchor_x", "anchor_y", "anchor_z"}) setup.push_back({name, kPlaceMm, true, false});
  AddCommon(&setup);
  return setup;
}

std::vector<instruments::SetupParameter> BeamSetupParameters() {
  std::vector<instruments::SetupParameter> setup = {{"beam_a", kTiltRad, true, true}, {"beam_b", kTiltRad, true, true}};
  AddCommon(&setup);
  return setup;
}

Eigen::Matrix<double, 3, 2> AcrossOf(const Eigen::Vector3d& direction) {
  int least = 0;
  direction.cwiseAbs().minCoeff(&least);
  Eigen::Matrix<double, 3, 2> across;
  across.col(0) = direction.cross(Eigen::Vector3d::Unit(least)).normalized();
  across.col(1) = direction.cross(across.col(0));
  return across;
}

bool HasStatedZero(const instruments::MeasuringRun& run) {
  return std::any_of(run.setup.begin(), run.setup.end(), [](const instruments::SetupParameter& parameter) {
    return parameter.name == "zero" && std::isfinite(parameter.prior_sigma);
  });
}

double StartingZero(const machine::Machine& machine, const instruments::MeasuringRun& run) {
  instruments::MeasuringRun from_zero = run;
  from_zero.length.zero_mm = 0.0;
  const machine::JointErrors<double> no_errors;
  const double no_setup[instruments::kMaxInstrumentParameters] = {};
  std::vector<double> off_mm;
  for (int k = 0; k < run.reading_count(); ++k) {
    double predicted_mm = 0.0;
    Predict<double>(machine, from_zero, run.PositionsOf(k), no_errors, no_setup, &predicted_mm);
    off_mm.push_back(run.measured_mm(0, k) - predicted_mm);
  }
  const auto middle = off_mm.begin() + static_cast<std::ptrdiff_t>(off_mm.size() / 2);
  std::nth_element(off_mm.begin(), middle, off_mm.end());
  return *middle;
}

void Evaluate(const machine::Machine& machine, const instruments::MeasuringRun& run, int reading,
              const machine::JointErrors<double>& errors, const double* setup, instruments::Evaluation* out) {
  const bool is_beam = run.length.is_beam, is_on_bed = run.length.is_on_bed;
  const Eigen::Index target = is_beam ? 2 : 3;
  const double stretch = 1.0 + kPerMetre * setup[target + 4];
  const Eigen::Vector3d tip_mm = run.tip_mm + Eigen::Map<const Eigen::Vector3d>(setup + target);
  const double* const positions = run.PositionsOf(reading);
  out->predicted_mm.resize(1);
  out->by_error.resize(1, machine::kComponents * machine.joint_count());
  out->by_setup.setZero(1, target + 5);
  Eigen::Vector3d along;  // in the bed's axes: the reading's direction
  double length_mm = 0.0;
  if (is_beam) {
    const Eigen::Matrix<double, 3, 2> across = AcrossOf(run.length.beam);
    const Eigen::Vector3d by_a = across.col(0).cross(run.length.beam), by_b = across.col(1).cross(run.length.beam);
    const Eigen::Vector3d tilted = run.length.beam + setup[0] * by_a + setup[1] * by_b;
    const machine::ChainPose<double> pose = machine::EvaluateChain<double>(machine, positions, errors);
    const Eigen::Vector3d tip_in_bed_mm = pose.bed_from_tool * tip_mm;
    const Eigen::Vector3d seen_mm = is_on_bed ? tip_in_bed_mm
                                              : Eigen::Vector3d(pose.bed_from_table.rotation.transpose() *
                                                                (tip_in_bed_mm - pose.bed_from_table.translation_mm));
    // An error of the table's branch moves the beam as if the table's point at the target moved.
    machine::EvaluatePlaces(machine, positions, errors, tip_mm, is_on_bed ? Eigen::Vector3d::Zero().eval() : seen_mm,
                            &out->point);
    along = is_on_bed ? tilted : Eigen::Vector3d(out->point.pose.bed_from_table.rotation * tilted);
    length_mm = tilted.dot(seen_mm);
    out->by_setup(0, 0) = stretch * by_a.dot(seen_mm);
    out->by_setup(0, 1) = stretch * by_b.dot(seen_mm);
  } else {
    const Eigen::Vector3d anchor_mm = run.ball_mm + Eigen::Vector3d(setup[0], setup[1], setup[2]);
    machine::EvaluatePlaces(machine, positions, errors, tip_mm, anchor_mm, &out->point);
    const Eigen::Vector3d wire_mm = out->point.tip_in_bed_mm - (is_on_bed ? anchor_mm : out->point.ball_in_bed_mm);
    length_mm = wire_mm.norm();
    along = wire_mm / length_mm;
    const Eigen::RowVector3d by_anchor = -stretch * along.transpose();
    out->by_setup.leftCols<3>() =
        is_on_bed ? by_anchor : Eigen::RowVector3d(by_anchor * out->point.pose.bed_from_table.rotation);
  }
  machine::SensitivityAlong(machine, out->point, along, out->by_error.data());
  out->by_error *= stretch;
  if (is_on_bed) {
    Eigen::RowVectorXd by_error = out->by_error;
    ClearWorkBranch(machine, by_error);
    out->by_error = by_error;
  }
  out->predicted_mm[0] = stretch * length_mm + run.length.zero_mm + setup[target + 3];
  out->by_setup.middleCols<3>(target) = stretch * along.transpose() * out->point.pose.bed_from_tool.rotation;
  out->by_setup(0, target + 3) = 1.0;
  out->by_setup(0, target + 4) = kPerMetre * length_mm;
}

}  // namespace axiscal::length
