#include "core/instruments/touch/touch_bind.h"

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>
#include <optional>
#include <sstream>

#include "core/base/units.h"
#include "core/instruments/ballbar/ballbar_model.h"
#include "core/instruments/centres/centres_model.h"
#include "core/instruments/touch/touch_model.h"

namespace axiscal::touch {
namespace {

using instruments::MeasuringRun;

absl::StatusOr<std::vector<double>> Numbers(const std::string& key, const std::string& text, size_t count) {
  std::istringstream in(text);
  in.imbue(std::locale::classic());
  std::vector<double> numbers;
  double number = 0.0;
  while (in >> number) numbers.push_back(number);
  if (in.eof() && numbers.size() == count) return numbers;
  return absl::InvalidArgumentError(absl::StrCat("header '", key, ": ", text, "', expected ", count, " number(s)"));
}

bool IsSphere(const std::string& key) { return key.rfind("sphere ", 0) == 0; }

absl::Status ReadFeatures(const session::Session& session, MeasuringRun* run) {
  Touches& touches = run->touches;
  for (const session::HeaderEntry& entry : session.header) {
    if (!IsSphere(entry.key) && entry.key.rfind("plane ", 0) != 0) continue;
    auto feature = ParseFeature(entry.key, entry.value);
    if (!feature.ok()) return base::Within("session '" + run->session + "'", feature.status());
    for (const Feature& other : touches.features) {
      if (other.name != feature->name) continue;
      return absl::InvalidArgumentError(
          absl::StrCat("session '", run->session, "': feature '", feature->name, "' is stated twice"));
    }
    touches.centre_mm += feature->point_mm;
    touches.features.push_back(*std::move(feature));
  }
  if (touches.features.empty()) {
    return absl::InvalidArgumentError(absl::StrCat(
        "session '", run->session, "': no feature, expected headers 'sphere NAME: x y z radius' or 'plane NAME: ...'"));
  }
  touches.centre_mm /= static_cast<double>(touches.features.size());
  run->ball_mm = touches.centre_mm;  // where on the table this session measures
  return absl::OkStatus();
}

// `# feature_sigma_um: 1`: each feature stands out by an offset of its own, known to be zero within that.
absl::Status AddFeatureOffsets(const session::Session& session, MeasuringRun* run) {
  const std::string key = "feature_sigma_um";
  const std::optional<std::string> text = session::FindHeader(session, key);
  if (!text) return absl::OkStatus();
  const auto sigma_um = Numbers(key, *text, 1);
  if (!sigma_um.ok()) return base::Within("session '" + run->session + "'", sigma_um.status());
  const auto refuse = [&](const std::string& what) {
    return absl::InvalidArgumentError(
        absl::StrCat("session '", run->session, "': header '", key, ": ", *text, "', ", what));
  };
  if (!std::isfinite((*sigma_um)[0]) || (*sigma_um)[0] <= 0.0) return refuse("must be > 0");
  const std::vector<Feature>& features = run->touches.features;
  constexpr size_t kMost = instruments::kMaxInstrumentParameters - kPlaceOffsets;
  if (features.size() > kMost)
    return refuse(absl::StrCat("of ", features.size(), " features, expected at most ", kMost));
  std::vector<instruments::SetupParameter> offsets;
  for (const Feature& feature : features)
    offsets.push_back({"feature_" + feature.name, (*sigma_um)[0] * base::kMmPerUm, false, false});
  run->setup.insert(run->setup.begin() + kPlaceOffsets, offsets.begin(), offsets.end());  // before those of the datum
  return absl::OkStatus();
}

// The approach of reading k as the probe sees it on the nominal machine; azimuth from the first of the two machine axes
// across the tool towards the second.
shapes::Approach InSpindle(const machine::Machine& machine, const MeasuringRun& run, int k) {
  const auto pose = machine::EvaluateChain<double>(machine, run.PositionsOf(k), {});
  const Eigen::Vector3d direction = pose.bed_from_tool.rotation.transpose() * run.touches.approach[k];
  const Eigen::Vector2d across = ballbar::RunOutDirections(machine).transpose() * direction;
  shapes::Approach approach;
  approach.is_touch = true;
  approach.direction = {direction.x(), direction.y(), direction.z()};
  approach.azimuth_rad = std::atan2(across.y(), across.x());
  approach.across = across.norm();
  return approach;
}

// A touch ends a move along its approach: each linear axis that it moves came from that side, whatever the positions
// that were latched before. Axes whose side is stated or that stand still on the approach are left alone.
void SetSenses(const machine::Machine& machine, int k, MeasuringRun* run) {
  const Eigen::Matrix3Xd directions = centres::LinearDirections(machine, run->PositionsOf(k));
  const Eigen::Matrix3d reach = directions * directions.transpose();
  const Eigen::VectorXd along = directions.transpose() * reach.ldlt().solve(run->touches.approach[k]);
  const std::vector<int> linear = centres::LinearAxes(machine);
  constexpr double kMoves = 1e-3;  // of the approach; less is the rounding of its direction
  if (run->stated_senses.empty()) run->stated_senses.assign(run->positions.size(), 0.0);
  for (size_t i = 0; i < linear.size(); ++i) {
    double& sense = run->stated_senses[static_cast<size_t>(k) * run->axis_count + linear[i]];
    const double share = along[static_cast<Eigen::Index>(i)];
    if (sense == 0.0 && std::abs(share) > kMoves) sense = share > 0.0 ? 1.0 : -1.0;
  }
}

}  // namespace

absl::StatusOr<Feature> ParseFeature(const std::string& key, const std::string& value) {
  const bool is_sphere = IsSphere(key);
  ASSIGN_OR_RETURN(const std::vector<double> at, Numbers(key, value, is_sphere ? 4 : 6));
  Feature feature;
  feature.is_sphere = is_sphere;
  feature.name = key.substr(key.find(' ') + 1);
  feature.point_mm = {at[0], at[1], at[2]};
  if (is_sphere) {
    feature.radius_mm = at[3];
    if (feature.radius_mm > 0.0) return feature;
    return absl::InvalidArgumentError(absl::StrCat("header '", key, "': radius ", at[3], ", must be > 0"));
  }
  const Eigen::Vector3d normal(at[3], at[4], at[5]);
  if (normal.norm() < 1e-6)
    return absl::InvalidArgumentError(absl::StrCat("header '", key, "': normal 0 0 0, expected the outward normal"));
  feature.normal = normal.normalized();
  return feature;
}

absl::Status BindTouches(const machine::Machine& machine, const session::Session& session, MeasuringRun* run) {
  Touches& touches = run->touches;
  const auto radius = Numbers("stylus_radius_mm", session::FindHeader(session, "stylus_radius_mm").value_or(""), 1);
  if (!radius.ok()) return base::Within("session '" + run->session + "'", radius.status());
  touches.stylus_radius_mm = (*radius)[0];
  RETURN_IF_ERROR(ReadFeatures(session, run));
  RETURN_IF_ERROR(AddFeatureOffsets(session, run));
  const size_t readings = session.reading_count();
  const session::Column* columns[4];
  const char* const names[4] = {"nx", "ny", "nz", "feature"};
  for (int i = 0; i < 4; ++i) {
    columns[i] = session::FindColumn(session, names[i]);
    if (columns[i] != nullptr && (i < 3 ? columns[i]->values.size() : columns[i]->texts.size()) == readings) continue;
    return absl::InvalidArgumentError(
        absl::StrCat("session '", run->session, "': column '", names[i], "' is missing or short"));
  }
  for (size_t k = 0; k < readings; ++k) {
    const Eigen::Vector3d approach(columns[0]->values[k], columns[1]->values[k], columns[2]->values[k]);
    constexpr double kUnit = 1e-3;  // three decimals of a direction
    if (!(std::abs(approach.norm() - 1.0) <= kUnit)) {
      return absl::InvalidArgumentError(absl::StrCat("session '", run->session, "': reading ", k + 1,
                                                     ": approach (nx, ny, nz) has length ", approach.norm(),
                                                     ", expected a unit vector"));
    }
    touches.approach.push_back(approach.normalized());
    touches.approach_in_spindle.push_back(InSpindle(machine, *run, static_cast<int>(k)));
    SetSenses(machine, static_cast<int>(k), run);
    const auto at = std::find_if(touches.features.begin(), touches.features.end(),
                                 [&](const Feature& feature) { return feature.name == columns[3]->texts[k]; });
    if (at == touches.features.end()) {
      return absl::InvalidArgumentError(absl::StrCat("session '", run->session, "': reading ", k + 1, ": feature '",
                                                     columns[3]->texts[k], "' has no header 'sphere ",
                                                     columns[3]->texts[k], ": ...' or 'plane ...'"));
    }
    touches.feature_of.push_back(static_cast<int>(at - touches.features.begin()));
  }
  return absl::OkStatus();
}

}  // namespace axiscal::touch
