#include "core/loop/causes.h"

#include <cmath>

#include "absl/strings/str_format.h"
#include "absl/strings/str_join.h"
#include "core/base/language.h"
#include "core/base/units.h"
#include "core/instruments/distortion.h"
#include "core/instruments/registry.h"

namespace axiscal::loop {
namespace {

using instruments::Distortion;
using instruments::MeasuringRun;

struct Mean {
  double value = 0.0, sigma = 0.0;
};

// Each amplitude's mean over the sessions, by the weight of what each session tells.
std::vector<Mean> MeansOf(const Extension& extension, size_t effect, const identify::Fit& fit,
                          const std::vector<int>& sessions, int count) {
  std::vector<Mean> means;
  for (int k = 0; k < count; ++k) {
    double weights = 0.0, sum = 0.0;
    for (const int s : sessions) {
      const identify::SetupOffset& one =
          fit.result.sessions[s].setup[extension.AmplitudesOf(effect, s) + static_cast<size_t>(k)];
      if (!(one.sigma > 0.0) || !std::isfinite(one.value)) continue;
      weights += 1.0 / (one.sigma * one.sigma);
      sum += one.value / (one.sigma * one.sigma);
    }
    means.push_back(weights > 0.0 ? Mean{sum / weights, 1.0 / std::sqrt(weights)} : Mean{0.0, INFINITY});
  }
  return means;
}

// Those that stand out of their uncertainty, in a unit.
std::string Clear(const std::vector<Mean>& means, const std::vector<std::string>& names, double factor,
                  const char* unit, base::Language language) {
  constexpr double kClear = 3.0;  // standard uncertainties
  std::vector<std::string> texts;
  for (size_t k = 0; k < means.size(); ++k) {
    if (std::abs(means[k].value) < kClear * means[k].sigma) continue;
    const double value = means[k].value * factor, sigma = means[k].sigma * factor;
    texts.push_back(names[k] + (language == base::Language::kEnglish
                                    ? absl::StrFormat("%+.3g +- %.2g %s", value, sigma, unit)
                                    : base::NumberIn(language, absl::StrFormat("%+.3g ± %.2g ", value, sigma)) +
                                          (unit[0] == 'u' ? "µ" + std::string(unit + 1) : unit)));
  }
  return absl::StrJoin(texts, ", ");
}

std::vector<std::string> ChannelNames(int rows) {
  if (rows == 1) return {""};
  std::vector<std::string> names;
  for (const char of : {'x', 'y', 'z'})
    for (const char by : {'x', 'y', 'z'}) names.push_back(absl::StrFormat("%c by %c ", of, by));
  return names;
}

std::string NameOf(instruments::Kind kind) {
  for (const instruments::Instrument& one : instruments::Instruments())
    if (one.kind == kind) return one.name;
  return "";
}

// Root of the sum of squares.
double SizeOf(const std::vector<Mean>& means) {
  double squares = 0.0;
  for (const Mean& one : means) squares += std::isfinite(one.sigma) ? one.value * one.value : 0.0;
  return std::sqrt(squares);
}

std::string CorrectionOf(const Distortion& one, const std::vector<Mean>& means, int rows, base::Language language) {
  const bool is_german = language == base::Language::kGerman;
  // By how much; the numbers that are clear behind it.
  const auto say = [&](const char* english, const char* german, const std::vector<Mean>& of,
                       const std::vector<std::string>& names, double factor, const char* unit) {
    const std::string values = Clear(of, names, factor, unit, language);
    return absl::StrCat(is_german ? german : english, values.empty() ? "" : ": ", values);
  };
  const auto size = [&](const char* english, const char* german) {
    const std::string of = absl::StrFormat("%.2g", SizeOf(means) * base::kUmPerMm);
    return is_german ? absl::StrCat(german, base::NumberIn(language, of), " µm, Wurzel der Summe der Quadrate")
                     : absl::StrCat(english, of, " um, root of the sum of squares");
  };
  const std::vector<std::string> nothing(means.size());
  switch (one.kind) {
    case Distortion::kGain:
      return say("calibrate the instrument; it reads too much", "das Messmittel kalibrieren; es zeigt zu viel", means,
                 ChannelNames(rows), 100.0 / instruments::kGainReadingMm, "%");
    case Distortion::kScale:
      return say("state the expansion of the instrument's length, or correct it for temperature",
                 "die Ausdehnung seiner Länge angeben, oder sie auf die Temperatur korrigieren", means, nothing,
                 1e6 / instruments::kScaleLengthMm, "um/m/K");
    case Distortion::kClock:
      // The speeds beside the first do not change how late it is.
      return say("set the instrument's clock by the control's; it reads late by",
                 "seine Uhr nach der der Steuerung stellen; es misst zu spät, um", {means.front()}, {""},
                 1e3 / instruments::kClockSpeedMmPerS, "ms");
    case Distortion::kBall:
    case Distortion::kLobes:
      return size("clean, check or change the ball; it is off by ",
                  "die Kugel reinigen, prüfen oder wechseln; sie weicht ab um ");
    case Distortion::kGrowth:
      return say("let the instrument warm up; it grows by", "das Messmittel warm werden lassen; es wächst um", means,
                 nothing, base::kUmPerMm, "um");
    case Distortion::kMotion:
      return size("clamp it better, or wait until it rests; it moves by ",
                  "besser spannen, oder warten, bis es ruht; es wandert um ");
  }
  return "";
}

}  // namespace

Cause CauseOf(const Extension& extension, size_t effect, const identify::Fit& fit) {
  const Added& added = extension.effects[effect];
  const Distortion& distortion = added.candidate.distortion;
  std::vector<int> sessions;
  std::vector<std::string> names;
  for (size_t i = 0; i < fit.problem.runs.size(); ++i) {
    const MeasuringRun& run = fit.problem.runs[i];
    if (!instruments::CanHave(run, distortion)) continue;
    sessions.push_back(static_cast<int>(i));
    names.push_back(run.session);
  }
  const int rows = fit.problem.runs[static_cast<size_t>(sessions.front())].row_count;
  const std::vector<Mean> means =
      MeansOf(extension, effect, fit, sessions, instruments::AmplitudeCount(distortion, rows));
  const auto subject = [&](base::Language language) {
    return absl::StrCat(NameOf(distortion.instrument), ": ", instruments::TextOf(distortion, language),
                        language == base::Language::kGerman ? "; Messungen " : "; sessions ",
                        absl::StrJoin(names, ", "));
  };
  using enum base::Language;
  return {Cause::kInstrument, subject(kEnglish),
          added.score,        CorrectionOf(distortion, means, rows, kEnglish),
          subject(kGerman),   CorrectionOf(distortion, means, rows, kGerman)};
}

}  // namespace axiscal::loop
