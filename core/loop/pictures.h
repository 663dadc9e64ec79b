// The loop's report as pictures (SVG): residuals against each variable and ball-bar traces before and after, and the
// ranking of candidates.
#ifndef AXISCAL_CORE_LOOP_PICTURES_H_
#define AXISCAL_CORE_LOOP_PICTURES_H_

#include <string>
#include <vector>

#include "core/base/language.h"
#include "core/loop/report.h"
#include "core/plot/charts.h"

namespace axiscal::loop {

struct Picture {
  std::string file;  // "residual-X.svg": letters, digits, '-', '.'
  std::string svg;
  // What it shows; of the ranking nothing, which the report holds.
  std::string x_label, y_label;
  std::vector<plot::Panel> panels;
};

// All texts in `language`, of the ranking in English. `fit` and `check`: the runs that the report was made of, in the
// same order.
//   residual-AXIS.svg, residual-time.svg, residual-temperature.svg   of variables that vary; um, mm, deg, s, deg C;
//                         along an axis by the sense of its motion, where a session went both ways
//   spectrum-AXIS.svg     of what goes once about a rotary axis or over the most of a linear axis' way: amplitude of
//                         each order, fitted one by one (root of the sum of squares over the rows of a reading)
//   trace-SESSION.svg     ball-bar sessions: deviation of the bar from its base circle (measured - predicted),
//                         by sense of motion;
//                         sessions over the same positions share a picture
//   found-SYMBOL-AXIS.svg errors of `report.fitted` that change along one axis, over the measured positions; um or urad
//   orders-SYMBOL-AXIS.svg    amplitude of each order of that
//   ranking.svg           the first search's candidates by score
std::vector<Picture> Pictures(const machine::Machine& machine, const std::vector<instruments::MeasuringRun>& fit,
                              const std::vector<instruments::MeasuringRun>& check, const Report& report,
                              base::Language language = base::Language::kEnglish);

}  // namespace axiscal::loop

#endif  // AXISCAL_CORE_LOOP_PICTURES_H_
