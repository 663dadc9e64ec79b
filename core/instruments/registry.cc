#include "core/instruments/registry.h"

#include "core/instruments/ballbar/ballbar_model.h"
#include "core/instruments/centres/centres_model.h"
#include "core/instruments/direction/direction_model.h"
#include "core/instruments/length/length_model.h"
#include "core/instruments/rtest/rtest_model.h"
#include "core/instruments/touch/touch_model.h"
#include "core/instruments/tracker/tracker_model.h"

namespace axiscal::instruments {

const std::vector<Instrument>& Instruments() {
  static const std::vector<Instrument>& rows = *new std::vector<Instrument>{
      {Kind::kBallbar, "ballbar", {"dL_mm"}, true, true, true, ballbar::SetupParameters},
      {Kind::kRtest, "rtest", {"dx_mm", "dy_mm", "dz_mm"}, true, false, true, rtest::SetupParameters},
      {Kind::kCentres, "centres", {"cx_mm", "cy_mm", "cz_mm"}, true, false, false, centres::SetupParameters},
      {Kind::kTracker, "tracker", {"px_mm", "py_mm", "pz_mm"}, false, false, true, tracker::SetupParameters},
      {Kind::kTouch, "touch", {}, false, false, true, touch::SetupParameters},
      {Kind::kEccentricity, "eccentricity", {}, true, true, false, ballbar::SetupParameters},
      {Kind::kLength, "length", {"L_mm"}, false, false, true, length::SetupParameters},
      {Kind::kDirection, "direction", {"turn_mm_per_m"}, false, false, true, direction::SetupParameters},
  };
  return rows;
}

const Instrument* FindInstrument(const std::string& name) {
  for (const Instrument& row : Instruments()) {
    if (row.name == name) return &row;
  }
  return nullptr;
}

std::vector<std::string> ReadingNames(const MeasuringRun& run) {
  if (run.path_readings != nullptr) return {"ex_um", "ey_um", "ez_um"};
  for (const Instrument& instrument : Instruments()) {
    if (instrument.kind == run.kind && !instrument.reading_columns.empty()) return instrument.reading_columns;
  }
  return {"gap_mm"};
}

}  // namespace axiscal::instruments
