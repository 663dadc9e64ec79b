#include "core/instruments/plausible.h"

#include <cmath>

#include "core/instruments/eccentricity/eccentricity_bind.h"
#include "core/instruments/evaluation.h"
#include "core/instruments/registry.h"
#include "core/session/column_rules.h"

namespace axiscal::instruments {

absl::Status CheckPlausible(const session::Session& session, const machine::Machine& machine, size_t readings_before) {
  const Instrument* instrument = FindInstrument(session::FindHeader(session, "instrument").value_or(""));
  if (instrument == nullptr) return absl::OkStatus();
  // Eccentricities without paths are stored, but nothing is identified from them.
  if (instrument->kind == Kind::kEccentricity && !eccentricity::HasPaths(session)) return absl::OkStatus();
  ASSIGN_OR_RETURN(const MeasuringRun run, BindSession(session, machine, readings_before));
  if (run.kind == Kind::kTouch || run.kind == Kind::kEccentricity) return absl::OkStatus();  // gated when bound
  RETURN_IF_ERROR(CheckAlive(session, run));
  if (run.kind == Kind::kTracker) return absl::OkStatus();
  const machine::JointErrors<double> no_errors;
  const double no_setup[kMaxSetupParameters] = {};
  for (int reading = 0; reading < run.reading_count(); ++reading) {
    double predicted_mm[kMaxRows];
    Predict(machine, run, reading, no_errors, no_setup, predicted_mm);
    for (int row = 0; row < run.row_count; ++row) {
      const double measured_mm = run.measured_mm(row, reading);
      if (std::abs(predicted_mm[row] - measured_mm) <= kMaxDisagreementMm) continue;
      const size_t place = readings_before + static_cast<size_t>(reading);
      return absl::InvalidArgumentError(absl::StrFormat(
          "line %d: reading %d of session '%s': %s = %g mm, but at these positions the nominal machine would read %g "
          "mm, expected within %g mm: are the units (mm, deg), the signs of machine %s, tool_tip_mm and table_ball_mm "
          "right?",
          session::ReadingLine(session.header.size(), place), place + 1, run.session, instrument->reading_columns[row],
          measured_mm, predicted_mm[row], kMaxDisagreementMm, machine.id));
    }
  }
  return absl::OkStatus();
}

}  // namespace axiscal::instruments
