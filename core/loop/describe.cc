#include "core/loop/describe.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "core/loop/aliases.h"
#include "core/loop/causes.h"
#include "core/loop/clustered_readings.h"
#include "core/loop/dictionary.h"
#include "core/loop/same_always.h"
#include "core/loop/signatures.h"

namespace axiscal::loop {

using identify::Fit;
using instruments::MeasuringRun;
using machine::ErrorTerm;
using machine::Machine;

namespace {

// The lowest orders are eccentricity and ovality before they are the image of a gear with hundreds of teeth.
constexpr int kLowOrder = 4;

std::vector<double> PositionsOf(const std::vector<MeasuringRun>& runs, int axis) {
  std::vector<double> positions;
  for (const MeasuringRun& run : runs) {
    for (int k = 0; k < run.reading_count(); ++k) positions.push_back(run.PositionsOf(k)[axis]);
  }
  return positions;
}

// Orders that the axis' positions in these sessions cannot tell from a harmonic's own.
std::vector<int> AliasOrdersOf(const std::vector<MeasuringRun>& runs, const ErrorTerm& term) {
  const auto* harmonic = std::get_if<shapes::Harmonic>(&term.shape);
  if (harmonic == nullptr || harmonic->is_frequency_free) return {};
  constexpr int kHighestOfLow = 100;
  const int order = static_cast<int>(std::lround(harmonic->frequency));
  return AliasOrders(PositionsOf(runs, harmonic->axis), order, order <= kLowOrder ? kHighestOfLow : kHighestOrder);
}

// Other frequencies of a harmonic that the axis' positions in these sessions cannot tell from its own, as terms with
// its name but for the frequency. `evidence`: chi-square that the harmonic explains; of that, those that are listed
// miss less than any member of a class may.
std::vector<ErrorTerm> ImagesOf(const Machine& machine, const std::vector<MeasuringRun>& runs, const ErrorTerm& term,
                                double evidence, double alike) {
  const auto* harmonic = std::get_if<shapes::Harmonic>(&term.shape);
  std::vector<ErrorTerm> images;
  if (harmonic == nullptr || !(evidence > 0.0)) return images;
  const bool is_rotary = machine.axes[harmonic->axis].kind == machine::AxisKind::kRotary;
  if (is_rotary && !harmonic->is_frequency_free && harmonic->frequency < kLowOrder + 0.5) return images;
  // The teeth of worm wheels and of strain wave gears 1:100; the ball screws of least lead.
  constexpr double kHighest = 100.0, kLeastLeadMm = 4.0;
  const double highest = is_rotary ? kHighest : 2.0 * std::numbers::pi / kLeastLeadMm;
  for (const Alias& alias :
       AliasesOf(PositionsOf(runs, harmonic->axis), harmonic->frequency, highest, alike / evidence)) {
    ErrorTerm image = term;
    // At even positions the images of whole orders are whole.
    constexpr double kWhole = 1e-3;
    const double whole = std::round(alias.frequency);
    const bool is_whole = !harmonic->is_frequency_free && std::abs(alias.frequency - whole) < kWhole;
    std::get<shapes::Harmonic>(image.shape).frequency = is_whole ? whole : alias.frequency;
    const Eigen::Vector2d amplitudes = alias.of_amplitudes * Eigen::Map<const Eigen::Vector2d>(term.amplitude.data());
    for (int k = 0; k < 2; ++k) image.amplitude[static_cast<size_t>(k)] = amplitudes[k];
    images.push_back(std::move(image));
  }
  return images;
}

// Adds them to what else the effect, term `at` of the fit, may be.
void AddImages(const Machine& machine, const std::vector<MeasuringRun>& runs, const Fit& fit, int at, double evidence,
               const ClassRule& rule, predict::OpenChoice* choice, std::vector<ErrorTerm>* equivalent) {
  const bool is_alone = choice->rivals.empty();
  const machine::ErrorModel as_found = is_alone ? fit.result.model : choice->as_found;
  const ErrorTerm& found = as_found.terms[static_cast<size_t>(at)];
  for (const ErrorTerm& image : ImagesOf(machine, runs, found, evidence, rule.alike)) {
    const double odds =
        std::pow(std::get<shapes::Harmonic>(found.shape).frequency / std::get<shapes::Harmonic>(image.shape).frequency,
                 rule.order_falloff);
    choice->rivals.push_back({as_found, odds});
    choice->rivals.back().model.terms[static_cast<size_t>(at)] = image;
    if (odds > std::exp(-0.5 * rule.alike)) equivalent->push_back(image);
  }
  if (is_alone && !choice->rivals.empty()) *choice = {machine::NameOf(machine, found), as_found, choice->rivals, {}};
}

// Ranges of one axis that overlap are one structure, its place that of the strongest part.
void AddRange(const Unexplained& range, Report* report) {
  for (Unexplained& known : report->unexplained) {
    if (known.variable != range.variable || known.from > range.to || range.from > known.to) continue;
    if (range.rms_mm > known.rms_mm) known = range;
    return;
  }
  report->unexplained.push_back(range);
}

std::string SessionWhereItShows(const Fit& fit, const shapes::Bump& bump) {
  std::string session;
  int most = 0;
  for (const MeasuringRun& run : fit.problem.runs) {
    int count = 0;
    for (int k = 0; k < run.reading_count(); ++k)
      count += std::abs(run.PositionsOf(k)[bump.axis] - bump.at) < bump.width;
    if (count > most) {
      most = count;
      session = run.session;
    }
  }
  return session;
}

Unexplained SlipOf(const MeasuringRun& run, const Candidate& candidate, size_t setup_at, const Fit& fit,
                   const Signatures& signatures) {
  constexpr double kSeen = 0.2;  // of what is known of any slip before it is measured
  Slipped slip{candidate.carrier, candidate.may_be_other, {}, {}};
  Eigen::Vector3d moved_mm = Eigen::Vector3d::Zero();
  for (size_t k = 0; k < 3; ++k) {
    const identify::SetupOffset& offset = fit.result.sessions[candidate.run].setup[setup_at + k];
    if (!(offset.sigma < kSeen * fit.problem.runs[candidate.run].setup[setup_at + k].prior_sigma)) continue;
    slip.moved_mm[k] = moved_mm[static_cast<Eigen::Index>(k)] = offset.value;
    slip.sigma_mm[k] = offset.sigma;
  }
  return {Unexplained::kSlip,
          "t",
          run.time_s[std::max(0, candidate.earliest - 1)],
          run.time_s[candidate.latest],
          run.session,
          signatures.RmsOf(candidate, moved_mm),
          slip};
}

}  // namespace

void Describe(const Machine& machine, const std::vector<MeasuringRun>& runs, const std::vector<MeasuringRun>& named_by,
              const Extension& extension, const Fit& fit, const ClassRule& rule, Report* report) {
  const std::vector<Added>& effects = extension.effects;
  const Signatures signatures(fit.problem, fit.point, {});
  const std::vector<identify::Parameter> parameters = identify::ListParameters(fit.point.model, true);
  for (size_t a = 0; a < effects.size(); ++a) {
    const Added& added = effects[a];
    if (added.candidate.family == Family::kInstrument) {
      report->causes.push_back(CauseOf(extension, a, fit));
      continue;
    }
    if (added.candidate.family == Family::kStep) {
      report->unexplained.push_back(
          SlipOf(runs[added.candidate.run], added.candidate, extension.SetupOf(a), fit, signatures));
      continue;
    }
    const int t = extension.TermOf(a);
    const ErrorTerm& term = fit.point.model.terms[t];
    const Eigen::VectorXd amplitude =
        Eigen::Map<const Eigen::VectorXd>(term.amplitude.data(), shapes::BasisCount(term.shape));
    Candidate fitted = added.candidate;
    fitted.term = term;
    const double rms_mm = signatures.RmsOf(fitted, amplitude);
    if (const auto* bump = std::get_if<shapes::Bump>(&term.shape)) {
      AddRange({Unexplained::kLocal, machine.axes[bump->axis].name, bump->at - bump->width, bump->at + bump->width,
                SessionWhereItShows(fit, *bump), rms_mm},
               report);
      continue;
    }
    Effect effect;
    effect.term = term;
    effect.rms_mm = rms_mm;
    effect.evidence = added.score;
    for (const Candidate& other : added.equivalent) effect.equivalent.push_back(other.term);
    predict::OpenChoice choice = added.choice;
    AddImages(machine, named_by, fit, t, added.score, rule, &choice, &effect.equivalent);
    if (!choice.rivals.empty()) report->choices.push_back(std::move(choice));
    effect.alias_orders = AliasOrdersOf(named_by, term);
    double variance = 0.0;
    // Of a free curve the rms over what was measured.
    effect.amplitude = amplitude.size() > 1 ? amplitude.norm() : term.amplitude[0];
    for (size_t i = 0; i < parameters.size(); ++i) {
      if (parameters[i].term != t || parameters[i].is_nonlinear) continue;
      const double share =
          amplitude.size() > 1 && effect.amplitude > 0.0 ? amplitude[parameters[i].basis] / effect.amplitude : 1.0;
      const double sigma = fit.result.estimates[i].sigma;
      if (std::isfinite(sigma)) variance += share * share * sigma * sigma;
    }
    effect.amplitude_sigma = std::sqrt(variance);
    report->effects.push_back(std::move(effect));
  }
  for (const Unexplained& range : ClusteredReadings(machine, fit)) AddRange(range, report);
  report->verdict = !report->unexplained.empty() ? Verdict::kUnexplained
                    : !report->effects.empty()   ? Verdict::kExtended
                                                 : Verdict::kAdequate;
  Proposer proposer(fit.problem, fit.point);
  for (Effect& effect : report->effects) {
    if (shapes::IsFree(effect.term.shape)) continue;  // which sessions would tell a free curve is not known
    std::vector<ErrorTerm> named = effect.equivalent;
    std::erase_if(named, [](const ErrorTerm& term) { return shapes::IsFree(term.shape); });
    effect.same_always = SameAlways(*fit.problem.machine, fit.problem.runs.front().tip_mm, effect.term, named);
    const std::vector<Proposal> proposals = proposer.Propose(effect.term, named);
    report->next_measurement.insert(report->next_measurement.end(), proposals.begin(), proposals.end());
  }
  const std::vector<AxisSpan> spans = SpansOf(fit.problem);
  for (int axis = 0; axis < machine.axis_count(); ++axis) {
    const bool is_rotary = machine.axes[axis].kind == machine::AxisKind::kRotary;
    if (spans[axis].highest - spans[axis].lowest < (is_rotary ? kStandsStillRad : kStandsStillMm))
      report->axes_at_rest.push_back(machine.axes[axis].name);
  }
  for (size_t i = 0; i < fit.problem.runs.size(); ++i) {
    const identify::Noise& noise = fit.problem.noise[i];
    report->noise.push_back(
        {fit.problem.runs[i].session, fit.problem.runs[i].sigma_mm, noise.sigma_mm, noise.NeighbourCorrelation()});
  }
  report->fitted = fit.result;
  report->fit_after = fit.result.fit;
}

}  // namespace axiscal::loop
