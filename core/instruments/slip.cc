#include "absl/strings/str_cat.h"
#include "core/base/demand.h"
#include "core/instruments/run.h"

namespace axiscal::instruments {

void AddDatum(const machine::Machine& machine, int axis, MeasuringRun* run) {
  DEMAND(run->free_datum.size() < kMaxDatumAxes && run->distortions.empty() && run->slips.empty() &&
         run->path_readings == nullptr);
  run->free_datum.push_back(axis);
  run->setup.push_back({absl::StrCat("datum_", machine.axes[axis].name), kDatumSigmaMm, true, false, false});
}

void AddSlip(const Slip& slip, MeasuringRun* run) {
  DEMAND(run->slips.size() < kMaxSlips && run->path_readings == nullptr && run->kind != Kind::kDirection);
  run->slips.push_back(slip);
  run->setup_name = run->session;
  run->is_setup_stated = false;
  const std::string number = run->slips.size() > 1 ? absl::StrCat(run->slips.size()) : "";
  for (const char* direction : {"x", "y", "z"})
    run->setup.push_back({absl::StrCat("slip", number, "_", direction), kSlipSigmaMm, true, false, false});
}

}  // namespace axiscal::instruments
