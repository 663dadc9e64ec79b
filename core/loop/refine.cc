#include "core/loop/refine.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <numbers>

#include "core/base/demand.h"
#include "core/loop/dictionary.h"
#include "core/loop/search.h"

namespace axiscal::loop {
namespace {

Candidate RefinedBump(const Signatures& signatures, Candidate candidate) {
  const double widest = WidestBump(*signatures.problem().machine, std::get<shapes::Bump>(candidate.term.shape).axis);
  double spread = 0.5;
  for (int round = 0; round < 5; ++round) {
    const shapes::Bump best = std::get<shapes::Bump>(candidate.term.shape);
    std::vector<Candidate> around;
    for (int i = -2; i <= 2; ++i) {
      for (int j = -1; j <= 1; ++j) {
        Candidate moved = candidate;
        const double width = std::min(widest, best.width * std::pow(1.0 + spread, j));
        moved.term.shape = shapes::Bump{best.axis, best.at + 0.5 * i * spread * best.width, width};
        around.push_back(moved);
      }
    }
    candidate = BestOf(signatures, around);
    spread *= 0.6;
  }
  return candidate;
}

Candidate RefinedPitch(const Signatures& signatures, Candidate candidate, double range) {
  double step = kPitchStep * 2.0 * std::numbers::pi / range;
  for (int round = 0; round < 6; ++round) {
    const double best = std::get<shapes::Harmonic>(candidate.term.shape).frequency;
    std::vector<Candidate> around(5, candidate);
    for (int i = -2; i <= 2; ++i)
      std::get<shapes::Harmonic>(around[i + 2].term.shape).frequency = best + 0.5 * i * step;
    candidate = BestOf(signatures, around);
    step *= 0.5;
  }
  return candidate;
}

// A decay length or time constant.
Candidate RefinedDecay(const Signatures& signatures, Candidate candidate) {
  const double longest =
      candidate.family == Family::kDriftExp ? kSlowestWarming * LastReadingS(signatures.problem()) : INFINITY;
  double spread = 0.35;
  for (int round = 0; round < 4; ++round) {
    std::vector<Candidate> around(5, candidate);
    for (int i = -2; i <= 2; ++i) {
      double* parameter = shapes::NonlinearParameter(around[i + 2].term.shape);
      *parameter = std::min(longest, *parameter * std::pow(1.0 + spread, 0.5 * i));
    }
    candidate = BestOf(signatures, around);
    spread *= 0.5;
  }
  return candidate;
}

}  // namespace

Candidate AtBestMoment(const Signatures& signatures, Candidate slip, double indistinguishable) {
  DEMAND(slip.family == Family::kStep);
  const instruments::MeasuringRun& run = signatures.problem().runs[slip.run];
  const int last = run.reading_count() - 1, stride = StepStride(run);
  std::map<int, double> explained;  // likelihood ratio by the first reading after the slip
  const auto explain = [&](const std::vector<int>& moments) {
    std::vector<Candidate> candidates(moments.size(), slip);
    for (size_t i = 0; i < moments.size(); ++i) candidates[i].first_reading = moments[i];
    const std::vector<Projection> projections = signatures.Project(candidates);
    for (size_t i = 0; i < moments.size(); ++i) {
      Eigen::Vector3d amplitude;
      const double gain = projections[i].visible > kVisible ? Gain(projections[i], &amplitude) : 0.0;
      explained[moments[i]] = LikelihoodRatio(signatures.residual_squares(), gain, signatures.degrees_of_freedom());
    }
  };
  const auto by_value = [](const auto& a, const auto& b) { return a.second < b.second; };
  std::vector<int> moments = {slip.first_reading};
  for (int k = 1; k <= last; k += stride) moments.push_back(k);
  explain(moments);
  // Of a slip that a session hardly sees the profile is rugged: every reading near moments that come close.
  constexpr double kClose = 25.0;
  const double close = std::max_element(explained.begin(), explained.end(), by_value)->second - kClose;
  moments.clear();
  for (const auto& [moment, value] : explained) {
    for (int k = std::max(1, moment - stride); value >= close && k <= std::min(last, moment + stride); ++k) {
      if (!explained.contains(k) && (moments.empty() || k > moments.back())) moments.push_back(k);
    }
  }
  if (!moments.empty()) explain(moments);
  const auto best = std::max_element(explained.begin(), explained.end(), by_value);
  slip.first_reading = slip.earliest = slip.latest = best->first;
  for (const auto& [moment, value] : explained) {
    if (value < best->second - indistinguishable) continue;
    slip.earliest = std::min(slip.earliest, moment);
    slip.latest = std::max(slip.latest, moment);
  }
  return slip;
}

Candidate WithCarrierTold(const Signatures& signatures, Candidate slip, double indistinguishable) {
  using instruments::Carrier;
  if (signatures.problem().runs[slip.run].kind == instruments::Kind::kTracker) return slip;
  Candidate other = slip;
  other.carrier = slip.carrier == Carrier::kTable ? Carrier::kTool : Carrier::kTable;
  other = AtBestMoment(signatures, other, indistinguishable);
  const std::vector<Projection> projections = signatures.Project({slip, other});
  double ratio[2] = {};
  for (size_t i = 0; i < 2; ++i) {
    Eigen::Vector3d amplitude;
    const double gain = projections[i].visible > kVisible ? Gain(projections[i], &amplitude) : 0.0;
    ratio[i] = LikelihoodRatio(signatures.residual_squares(), gain, signatures.degrees_of_freedom());
  }
  slip.may_be_other = ratio[1] > ratio[0] - indistinguishable;
  return slip;
}

bool IsGrid(Family family) {
  return family == Family::kBump || family == Family::kPitch || family == Family::kReversal ||
         family == Family::kDriftExp;
}

Candidate BestOf(const Signatures& signatures, const std::vector<Candidate>& candidates) {
  DEMAND(!candidates.empty());
  const std::vector<Projection> projections = signatures.Project(candidates);
  double largest = -1.0;
  Candidate best = candidates.front();
  for (size_t i = 0; i < candidates.size(); ++i) {
    Eigen::Vector3d amplitude;
    const double gain = projections[i].visible > kVisible ? Gain(projections[i], &amplitude) : 0.0;
    if (gain <= largest) continue;
    largest = gain;
    best = candidates[i];
    for (int b = 0; b < kMostAmplitudes; ++b) best.term.amplitude[b] = gain > 0.0 ? amplitude[b] : 0.0;
  }
  return best;
}

Candidate Refined(const Signatures& signatures, const Candidate& candidate, double range) {
  switch (candidate.family) {
    case Family::kBump:
      return RefinedBump(signatures, candidate);
    case Family::kPitch:
      return RefinedPitch(signatures, candidate, range);
    case Family::kReversal:
    case Family::kDriftExp:
      return RefinedDecay(signatures, candidate);
    default:
      return candidate;
  }
}

std::optional<Candidate> StraightFormOf(const identify::Problem& problem, const machine::ErrorTerm& term) {
  constexpr double kFar = 5.0;
  if (const auto* warming = std::get_if<shapes::DriftExp>(&term.shape)) {
    if (warming->tau_s > kFar * LastReadingS(problem))
      return Candidate{Family::kDrift, {term.joint, term.component, shapes::Drift{}, {}}};
  } else if (const auto* spike = std::get_if<shapes::Reversal>(&term.shape)) {
    const AxisSpan span = SpansOf(problem)[spike->axis];
    if (spike->length > kFar * (span.highest - span.lowest))
      return Candidate{Family::kBacklash, {term.joint, term.component, shapes::Backlash{spike->axis}, {}}};
  }
  return std::nullopt;
}

Candidate AtPlaceOf(const Signatures& signatures, const Candidate& candidate, const std::vector<Candidate>& leaders) {
  std::vector<Candidate> places = {candidate};
  for (const Candidate& leader : leaders) {
    places.push_back(candidate);
    places.back().term.shape = leader.term.shape;
  }
  return BestOf(signatures, places);
}

}  // namespace axiscal::loop
