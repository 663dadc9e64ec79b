#include "tests/rates/planned_score.h"

#include <cmath>
#include <utility>

#include "core/session/session.h"

namespace axiscal::rates {

PlannedScore JudgePlanned(const std::string& test, int intervals, int most_fits) {
  const std::vector<PlannedCase> cases = PlannedCases(test);
  PlannedScore score;
  score.cases = static_cast<int>(cases.size());
  const auto is_done = [&] { return score.fits >= score.cases && score.coverage["all"].intervals >= intervals; };
  for (int n = 0; n < most_fits && score.cases > 0 && !is_done(); ++n) {
    const PlannedCase& planned = cases[static_cast<size_t>(n % score.cases)];
    ++score.fits;
    const int round = n / score.cases;
    const absl::StatusOr<PlannedFit> identified = IdentifyPlanned(planned, static_cast<uint64_t>(n), round % 2 == 0);
    if (!identified.ok()) {
      score.refused.push_back(session::FindHeader(planned.sessions[0], "session").value_or("") + ": " +
                              std::string(identified.status().message()));
      continue;
    }
    AddResult(
        identified->fit.result, identified->truth, {"all", "instrument " + planned.instrument},
        [&](const identify::Parameter*) { return planned.sessions.size() > 1 ? "together" : "alone"; },
        &score.coverage);
  }
  return score;
}

std::map<std::string, Compared> CompareTests(const std::vector<std::string>& tests, int machines) {
  // By machine, seed and error: what each test says of it, value and expanded uncertainty.
  std::map<std::pair<std::string, int>, std::map<std::string, std::vector<std::pair<double, double>>>> told;
  for (const std::string& test : tests) {
    for (const PlannedCase& planned : PlannedCases(test)) {
      if (planned.sessions.size() == 1) continue;  // together they tell most
      for (int seed = 0; seed < machines; ++seed) {
        const absl::StatusOr<PlannedFit> identified = IdentifyPlanned(planned, static_cast<uint64_t>(seed), true);
        if (!identified.ok() || identified->truth.terms.size() == planned.machine.declared.size()) continue;
        for (const identify::Estimate& estimate : identified->fit.result.estimates) {
          if (!estimate.identifiable) continue;
          told[{planned.machine.id, seed}][estimate.name].emplace_back(
              estimate.value, identified->fit.result.coverage_factor * estimate.sigma);
        }
      }
    }
  }
  std::map<std::string, Compared> compared;
  for (const auto& [machine, errors] : told) {
    Compared& one = compared[machine.first];
    for (const auto& [error, values] : errors) {
      for (size_t i = 0; i < values.size(); ++i) {
        for (size_t j = 0; j < i; ++j) {
          ++one.pairs;
          one.agree += std::abs(values[i].first - values[j].first) <= std::hypot(values[i].second, values[j].second);
        }
      }
    }
  }
  return compared;
}

}  // namespace axiscal::rates
