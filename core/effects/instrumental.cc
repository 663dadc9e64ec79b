#include "core/effects/instrumental.h"

#include <algorithm>
#include <cmath>
#include <set>

namespace axiscal::effects {
namespace {

using instruments::Carrier;
using instruments::Distortion;
using instruments::MeasuringRun;

// Those that take all amplitudes they can at once pay by their evidence; the others are one number.
bool IsOneNumber(const Distortion& one) { return one.kind == Distortion::kScale; }

}  // namespace

bool IsSameFault(const Distortion& a, const Distortion& b) {
  return a.kind == b.kind && a.instrument == b.instrument && a.carrier == b.carrier && a.order == b.order;
}

std::vector<Distortion> DistortionsOf(const std::vector<MeasuringRun>& runs) {
  constexpr int kFewestLobes = 2, kMostLobes = 12;  // fewer are a run-out; more are the surface's roughness
  constexpr double kTimeConstantsS[] = {30.0, 60.0, 120.0, 240.0, 480.0, 960.0, 1920.0};  // of gauges that warm up
  std::set<instruments::Kind> kinds;
  for (const MeasuringRun& run : runs) kinds.insert(run.kind);
  std::vector<Distortion> out;
  for (const instruments::Kind kind : kinds) {
    double from_s = INFINITY, to_s = -INFINITY;
    for (const MeasuringRun& run : runs) {
      if (run.kind != kind || run.time_s.empty()) continue;
      from_s = std::min(from_s, *std::min_element(run.time_s.begin(), run.time_s.end()));
      to_s = std::max(to_s, *std::max_element(run.time_s.begin(), run.time_s.end()));
    }
    const auto add = [&](Distortion one) {
      one.instrument = kind;
      const bool any = std::any_of(runs.begin(), runs.end(),
                                   [&](const MeasuringRun& run) { return instruments::CanHave(run, one); });
      if (any) out.push_back(one);
    };
    add({.kind = Distortion::kGain, .amplitude_mm = {}, .sigma_mm = {}});
    add({.kind = Distortion::kScale, .amplitude_mm = {}, .sigma_mm = {}});
    for (const Carrier carrier : {Carrier::kTool, Carrier::kTable}) {
      add({.kind = Distortion::kBall, .carrier = carrier, .amplitude_mm = {}, .sigma_mm = {}});
      for (int order = kFewestLobes; order <= kMostLobes; ++order)
        add({.kind = Distortion::kLobes, .carrier = carrier, .order = order, .amplitude_mm = {}, .sigma_mm = {}});
      if (to_s > from_s)
        add({.kind = Distortion::kMotion,
             .carrier = carrier,
             .from_s = from_s,
             .length_s = to_s - from_s,
             .amplitude_mm = {},
             .sigma_mm = {}});
    }
    for (const double tau_s : kTimeConstantsS)
      if (to_s > from_s) add({.kind = Distortion::kGrowth, .tau_s = tau_s, .amplitude_mm = {}, .sigma_mm = {}});
    if (to_s > from_s)
      add({.kind = Distortion::kClock,
           .from_s = from_s,
           .length_s = to_s - from_s,
           .amplitude_mm = {},
           .sigma_mm = {}});
  }
  return out;
}

Instrumental::Instrumental(const Linearised& linearised, std::vector<Item> items)
    : linearised_(linearised), items_(std::move(items)) {
  for (const Item& item : items_) {
    const Distortion& one = item.distortion;
    int row_count = 1;
    for (const MeasuringRun& run : linearised_.problem->runs)
      if (run.kind == one.instrument) row_count = run.row_count;
    objective::Group& group = groups_.emplace_back();
    group.family = kInstrumentFamily + static_cast<int>(one.kind);
    group.columns = instruments::AmplitudeCount(one, row_count);
    group.is_exotic = true;
    const double largest_mm = instruments::LargestSigmaMm(one);
    if (IsOneNumber(one)) {
      group.largest_amplitude = largest_mm;
    } else {
      const std::vector<double> spectrum = instruments::SpectrumOf(one, row_count);
      group.spectrum = Eigen::Map<const Eigen::VectorXd>(spectrum.data(), group.columns);
      group.largest_variance = largest_mm * largest_mm;
    }
    if (one.kind != Distortion::kGrowth) continue;
    constexpr double kApart = 0.26, kReach = 0.7;  // ln 1.3, ln 2: the next one on the grid
    group.kin = group.form = item.kin;
    group.place = std::log(one.tau_s);
    group.apart = kApart;
    group.reach = kReach;
  }
}

void Instrumental::Fill(size_t first, size_t last, int begin, Eigen::Ref<Eigen::MatrixXd> out) const {
  double basis[instruments::kMaxDistortionAmplitudes];
  for (Eigen::Index i = 0; i < out.rows(); ++i) {
    const auto at = static_cast<size_t>(begin + i);
    const MeasuringRun& run = linearised_.problem->runs[linearised_.run[at]];
    Eigen::Index column = 0;
    for (size_t k = first; k < last; ++k) {
      const int count = groups_[k].columns;
      if (instruments::CanHave(run, items_[k].distortion)) {
        instruments::DistortionBasis(items_[k].distortion, linearised_.sound[at], basis);
        for (int c = 0; c < count; ++c) out(i, column + c) = basis[c];
      } else {
        out.row(i).segment(column, count).setZero();
      }
      column += count;
    }
  }
}

Eigen::MatrixXd Instrumental::Columns(int group) const {
  Eigen::MatrixXd out(linearised_.count(), groups_[group].columns);
  Fill(static_cast<size_t>(group), static_cast<size_t>(group) + 1, 0, out);
  return out;
}

std::unique_ptr<objective::Source> Instrumental::Moved(int group, double place) const {
  Item item = items_[group];
  if (!(groups_[group].reach > 0.0)) return nullptr;
  item.distortion.tau_s = std::exp(place);
  return std::make_unique<Instrumental>(linearised_, std::vector<Item>{item});
}

void Instrumental::AddProducts(int begin, const Eigen::MatrixXd& u, Eigen::Ref<Eigen::MatrixXd> products) const {
  constexpr Eigen::Index kRows = 256;  // of a part that stays in the cache
  Eigen::MatrixXd part(std::min(kRows, u.rows()), column_count());
  for (Eigen::Index at = 0; at < u.rows(); at += kRows) {
    const Eigen::Index n = std::min(kRows, u.rows() - at);
    Fill(0, items_.size(), begin + static_cast<int>(at), part.topRows(n));
    products.noalias() += part.topRows(n).transpose() * u.middleRows(at, n);
  }
}

}  // namespace axiscal::effects
