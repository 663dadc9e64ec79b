#include "core/identify/residuals_csv.h"

#include "core/base/units.h"
#include "core/instruments/registry.h"

namespace axiscal::identify {
namespace {

using base::kUmPerMm;
using instruments::MeasuringRun;

// Why a reading is not used.
std::string WhySetAside(const MeasuringRun& run, int reading, int row) {
  for (const touch::Rejection& rejection : run.touches.rejected) {
    if (rejection.reading == reading)
      return absl::StrFormat("gate %s: %.4g um off; limit %.4g um", rejection.gate, rejection.off_mm * kUmPerMm,
                             rejection.limit_mm * kUmPerMm);
  }
  const size_t at = static_cast<size_t>(reading) * run.row_count + row;
  for (const size_t bad : run.bad_rows) {
    if (bad == at) return "bad reading: stands out alone under the model";
  }
  return "stands out of its series";
}

// A text cell: session names may hold any character but a line end.
std::string Cell(const std::string& text) {
  if (text.find_first_of(",\"") == std::string::npos) return text;
  std::string quoted = "\"";
  for (const char c : text) quoted.append(c == '"' ? 2 : 1, c);
  return quoted + "\"";
}

}  // namespace

std::string ResidualsCsvHeader() {
  return "part,session,row,reading,predicted_mm,residual_um,weight_per_um2,whitened,set_aside\n";
}

std::string ResidualsCsv(const std::string& part, const Fit& fit) {
  const Problem& problem = fit.problem;
  std::string text;
  for (size_t i = 0; i < problem.runs.size(); ++i) {
    const MeasuringRun& run = problem.runs[i];
    const Eigen::MatrixXd whitened = WhitenedOf(problem, i, fit.residuals_mm[i]);
    const double sigma_um = problem.noise[i].sigma_mm * kUmPerMm;
    const std::string session = Cell(run.session);
    const std::vector<std::string> names = instruments::ReadingNames(run);
    for (int k = 0; k < run.reading_count(); ++k) {
      const RowWeight* const weights = problem.WeightOf(i, k);
      const int line = run.path_readings != nullptr ? run.path_readings->readings[k].row : k;
      for (int r = 0; r < run.row_count; ++r) {
        const double residual_mm = fit.residuals_mm[i](r, k);
        const bool is_used = problem.is_used[i][static_cast<size_t>(k) * run.row_count + r];
        const double share = weights != nullptr ? weights->col(r).squaredNorm() : 1.0;
        const double weight = is_used ? share / (sigma_um * sigma_um) : 0.0;
        absl::StrAppendFormat(&text, "%s,%s,%d,%s,%.9f,%.6f,%.12g,", part, session, run.readings_before + line + 1,
                              names[run.path_readings != nullptr ? run.path_readings->readings[k].component : r],
                              run.measured_mm(r, k) + residual_mm, residual_mm * kUmPerMm, weight);
        if (is_used) absl::StrAppendFormat(&text, "%.9g,\n", whitened(r, k));
        if (!is_used) absl::StrAppend(&text, ",", WhySetAside(run, k, r), "\n");
      }
    }
  }
  return text;
}

}  // namespace axiscal::identify
