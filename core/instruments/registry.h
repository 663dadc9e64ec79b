// What the product knows of each instrument that a session may name: one row each.
#ifndef AXISCAL_CORE_INSTRUMENTS_REGISTRY_H_
#define AXISCAL_CORE_INSTRUMENTS_REGISTRY_H_

#include <string>
#include <vector>

#include "core/instruments/run.h"

namespace axiscal::instruments {

struct Instrument {
  Kind kind;
  std::string name;                          // as in `# instrument: ballbar`
  std::vector<std::string> reading_columns;  // mm; none: a condition measured as 0 (touch), or a reader of its own
  bool has_table_ball = false;
  bool has_bar = false;
  // False: rotary columns only, or a path (eccentricity); linear commands follow from the condition.
  bool has_linear_columns = true;
  std::vector<SetupParameter> (*setup)();
};

const std::vector<Instrument>& Instruments();
// The row with this name, or nullptr.
const Instrument* FindInstrument(const std::string& name);
// What the numbers of a run's reading are called where they are listed, row by row: its columns ("dL_mm"), "gap_mm" of
// a touch, the components "ex_um" "ey_um" "ez_um" of a path.
std::vector<std::string> ReadingNames(const MeasuringRun& run);

}  // namespace axiscal::instruments

#endif  // AXISCAL_CORE_INSTRUMENTS_REGISTRY_H_
