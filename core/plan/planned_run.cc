#include "core/plan/planned_run.h"

#include "core/instruments/registry.h"

namespace axiscal::plan {

absl::StatusOr<instruments::MeasuringRun> PlannedRun(const machine::Machine& machine, session::Session session) {
  const instruments::Instrument* const instrument =
      instruments::FindInstrument(session::FindHeader(session, "instrument").value_or(""));
  if (instrument == nullptr) return absl::InvalidArgumentError("the planned session's instrument is not evaluated");
  for (const std::string& name : instrument->reading_columns)
    session.columns.push_back({name, std::vector<double>(session.reading_count(), 0.0), {}});
  return instruments::BindSession(session, machine);
}

}  // namespace axiscal::plan
