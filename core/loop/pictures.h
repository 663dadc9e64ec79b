// The loop's report as pictures (SVG): residuals against each variable and ball-bar traces before and after, and the
// ranking of candidates.
#ifndef AXISCAL_CORE_LOOP_PICTURES_H_
#define AXISCAL_CORE_LOOP_PICTURES_H_

#include <string>
#include <vector>

#include "core/loop/report.h"

namespace axiscal::loop {

struct Picture {
  std::string file;  // "residual-X.svg": letters, digits, '-', '.'
  std::string svg;
};

// `fit` and `check`: the runs that the report was made of, in the same order.
//   residual-AXIS.svg, residual-time.svg, residual-temperature.svg   of variables that vary; um, mm, deg, s, deg C
//   trace-SESSION.svg     ball-bar sessions: deviation of the bar from its base circle (measured - predicted),
//                         by sense of motion;
//                         sessions over the same positions share a picture
//   ranking.svg           the first search's candidates by score
std::vector<Picture> Pictures(const machine::Machine& machine, const std::vector<instruments::MeasuringRun>& fit,
                              const std::vector<instruments::MeasuringRun>& check, const Report& report);

}  // namespace axiscal::loop

#endif  // AXISCAL_CORE_LOOP_PICTURES_H_
