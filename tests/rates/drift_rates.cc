// Rates at which the detector of drift is right on simulated histories, as the tables of docs/drift.md:
//   drift_rates KIND MACHINES YEARS SEED [INTERVAL_DAYS]
// KIND: all (everything at once), clean (steps only), or steps and one disturbance: wear, season, outliers,
// outliers3 (3 %), plans, sigma, gaps; or all but outliers: no-outliers, and all with 3 %: all3.
#include <cstdio>
#include <cstdlib>
#include <string>

#include "tests/rates/drift_score.h"

namespace {

using axiscal::synthetic::Disturbances;

bool Parse(const std::string& kind, Disturbances* has) {
  if (kind == "all") return true;
  if (kind == "no-outliers") return has->outlier_share = 0.0, true;
  if (kind == "all3") return has->outlier_share = 0.03, true;
  *has = {true, false, false, false, false, false, 0.0};
  if (kind == "clean") return true;
  if (kind == "wear") return has->wear = true;
  if (kind == "season") return has->season = true;
  if (kind == "plans") return has->plans = true;
  if (kind == "sigma") return has->wrong_sigma = true;
  if (kind == "gaps") return has->gaps = true;
  if (kind == "outliers") return has->outlier_share = 0.01, true;
  if (kind == "outliers3") return has->outlier_share = 0.03, true;
  return false;
}

}  // namespace

int main(int argc, char** argv) {
  axiscal::synthetic::YearsToDraw asked;
  if (argc < 5 || argc > 6 || !Parse(argv[1], &asked.disturbances)) {
    std::fprintf(stderr,
                 "usage: drift_rates KIND MACHINES YEARS SEED [INTERVAL_DAYS], KIND one of all clean wear season "
                 "outliers outliers3 plans sigma gaps no-outliers all3\n");
    return 2;
  }
  const int machines = std::atoi(argv[2]);
  asked.years = std::atof(argv[3]);
  asked.seed = std::strtoull(argv[4], nullptr, 10);
  if (argc == 6) asked.interval_days = std::atof(argv[5]);
  if (const absl::Status status = axiscal::synthetic::Check(asked); !status.ok()) {
    std::fprintf(stderr, "%s\n", std::string(status.message()).c_str());
    return 2;
  }
  axiscal::rates::DriftScore score;
  axiscal::rates::Group group;
  const bool with_forecasts = std::string(argv[1]) == "all";
  for (int number = 0; number < machines; ++number)
    axiscal::rates::Judge(axiscal::synthetic::DrawMachineYears(asked, number), with_forecasts, &group, &score);
  std::printf("%s, seed %llu, every %g days: %s", argv[1], static_cast<unsigned long long>(asked.seed),
              asked.interval_days, axiscal::rates::ToText(score).c_str());
  return 0;
}
