// What docs/validation.md says of plans (tests/validation/run): `planned_rates [TEST...]`, all tests where none is
// named. In Markdown: coverage of intervals per test, refusals, and the simulated inter-comparison.
#include <absl/strings/str_format.h>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <string>
#include <vector>

#include "core/plan/test.h"
#include "tests/rates/further_case.h"
#include "tests/rates/planned_score.h"

namespace {

using axiscal::rates::Coverage;
using axiscal::rates::FurtherCase;
using axiscal::rates::FurtherCases;
using axiscal::rates::PlannedScore;

constexpr int kIntervals = 2000, kMostFits = 600, kMachines = 3;

std::string Row(const std::string& test, const std::string& instrument, const Coverage& coverage) {
  const double count = coverage.intervals;
  return absl::StrFormat("| `%s` | %s | %d | %.1f | %.1f | %.2f |\n", test, instrument, coverage.intervals,
                         100.0 * coverage.share(), 100.0 * coverage.within_three / count,
                         std::sqrt(coverage.squares / count));
}

}  // namespace

int main(int argc, char** argv) {
  const std::vector<std::string> named(argv + 1, argv + argc);
  const auto is_asked = [&](const std::string& test) {
    return named.empty() || std::find(named.begin(), named.end(), test) != named.end();
  };
  std::vector<std::string> tests = axiscal::plan::TestNames();
  std::erase_if(tests, [&](const std::string& test) { return !is_asked(test); });
  std::printf(
      "## Coverage of intervals\n\nEvery test that `axiscal plan` knows, on three structures of machines and an arm: "
      "errors, set-ups and noise are drawn, what the sessions read goes through a log and `reduce`, `identify` fits "
      "the same terms.\nOf intervals at 95 %% so many hold the truth; every number that a fit tells is counted, errors "
      "and combinations (tests/rates/planned_case.h). Eccentricities that are typed off charts and the tool setter's "
      "own plans stand below the others (tests/rates/further_case.h).\n\n"
      "| test | instrument | numbers | hold the truth, %% | within 3 sigma, %% | deviation, rms of sigma |\n"
      "|---|---|---|---|---|---|\n");
  std::string refused;
  for (const std::string& test : tests) {
    const PlannedScore score = axiscal::rates::JudgePlanned(test, kIntervals, kMostFits);
    for (const auto& [kind, coverage] : score.coverage) {
      const std::string prefix = "instrument ";
      if (kind.rfind(prefix, 0) == 0 && coverage.intervals > 0)
        std::fputs(Row(test, kind.substr(prefix.size()), coverage).c_str(), stdout);
    }
    std::fflush(stdout);
    for (const std::string& why : score.refused) refused += "- `" + test + "` " + why + "\n";
  }
  for (const FurtherCase& further : FurtherCases()) {
    if (!is_asked(further.test)) continue;
    const PlannedScore score = axiscal::rates::JudgeFurther(further, kIntervals, kMostFits);
    std::fputs(Row(further.test, further.instrument, score.coverage.at("all")).c_str(), stdout);
    std::fflush(stdout);
    for (const std::string& why : score.refused) refused += "- `" + further.test + "` " + why + "\n";
  }
  if (!refused.empty()) std::printf("\nRefused:\n\n%s", refused.c_str());
  std::printf(
      "\n## Simulated inter-comparison\n\nEach test measures the same machines. For every error that two of them tell, "
      "E_n = (x1 - x2) / U(x1 - x2), U at 95 %%: within 1 in 95 of 100 cases.\n\n"
      "| machine | pairs | E_n within 1, %% |\n|---|---|---|\n");
  for (const auto& [machine, compared] : axiscal::rates::CompareTests(tests, kMachines))
    std::printf("| %s | %d | %.1f |\n", machine.c_str(), compared.pairs, 100.0 * compared.agree / compared.pairs);
}
