// Weights of the rows of one reading. A source of error that is drawn anew for every reading (Budget) scatters the rows
// unequally and together: the positioning error of a rotary axis moves the three numbers of a reading along the arc.
// Rows times their weight scatter alike and are not correlated (Fang 2022, section 4.4.3: without weights the noise
// along the arc gets into the angles).
#ifndef AXISCAL_CORE_IDENTIFY_ROW_WEIGHTS_H_
#define AXISCAL_CORE_IDENTIFY_ROW_WEIGHTS_H_

#include "core/identify/budget.h"
#include "core/identify/problem.h"

namespace axiscal::identify {

// Sets problem->row_weights from the sensitivities at `model`:
//   W = (e I + sum_s (sigma_s / sigma)^2 t_s t_s')^(-1/2),   t_s = d(rows)/d(source s), sigma = noise[run].sigma_mm
// e = 1; in a budget without the readings' own noise (with_reading_noise) a millionth of the largest variance that the
// sources give a row, for directions that none of them moves. Runs in which no such source acts get none: they weigh by
// sigma.
void WeighRows(const Budget& budget, const machine::ErrorModel& model, Problem* problem);

}  // namespace axiscal::identify

#endif  // AXISCAL_CORE_IDENTIFY_ROW_WEIGHTS_H_
