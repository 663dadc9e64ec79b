// A fit, linearised for the objective: what each used reading says once the effects, slips and distortions that were
// found are taken out of the model again (they are groups of columns like all others), with its sensitivity to every
// error component.
#ifndef AXISCAL_CORE_EFFECTS_LINEARISED_H_
#define AXISCAL_CORE_EFFECTS_LINEARISED_H_

#include <Eigen/Core>
#include <vector>

#include "core/identify/problem.h"
#include "core/instruments/distortion.h"
#include "core/objective/rows.h"

namespace axiscal::effects {

struct Linearised {
  const identify::Problem* problem = nullptr;
  objective::Rows rows;  // y: measured - predicted, without effects, slips and distortions; common: declared errors
  // Per row; rows of one series (one run, one reading column) stand together in time order.
  std::vector<int> run, reading, channel;
  // Raw, mm per mm or rad: column 6 j + c of component c of joint j; the last one of a move back along the approach of
  // a touch.
  Eigen::MatrixXd sensitivity;
  Eigen::MatrixXd artefact;  // rows x 3, raw: by the first three set-up offsets, where the artefact on the table stands

  std::vector<instruments::SoundRow> sound;  // what a sound instrument would have read; by errors and effects as fitted
  // Of rows that stand for several readings (thinned.h): by how much each axis may move on within one, mm or rad.
  std::vector<double> step;

  int count() const { return static_cast<int>(run.size()); }
  int along_approach() const { return static_cast<int>(sensitivity.cols()) - 1; }
  // Whether rows stand closely enough to tell a shape: of finer harmonics and of short accelerations their sums keep
  // nothing.
  bool Tells(const shapes::Shape& shape) const;
  shapes::State StateAt(int row) const { return problem->runs[run[row]].StateOf(reading[row]); }
};

// The sensitivity column of a term.
int SensitivityOf(const Linearised& linearised, const machine::ErrorTerm& term);

// Rows in which neighbours, a series, a session or a block of time may share what the model lacks.
std::vector<std::vector<int>> ClusteringsOf(const Linearised& linearised);

// At a fitted point, whose model holds `declared` terms first, then the effects. The slips and distortions of its runs
// count as effects too. `problem` must outlive the result.
Linearised Linearise(const identify::Problem& problem, const identify::Point& point, int declared);

}  // namespace axiscal::effects

#endif  // AXISCAL_CORE_EFFECTS_LINEARISED_H_
