// The effects that have been added to the declared model so far.
#ifndef AXISCAL_CORE_LOOP_EXTENSION_H_
#define AXISCAL_CORE_LOOP_EXTENSION_H_

#include <string>
#include <vector>

#include "core/identify/problem.h"
#include "core/loop/candidate.h"
#include "core/predict/volumetric.h"

namespace axiscal::loop {

struct Added {
  Candidate candidate;
  double score = 0.0;
  // Root of the share of the readings' squares that this effect and those before it leave; 1 where nothing is found.
  double left = 1.0;
  std::vector<Candidate> equivalent;
  predict::OpenChoice choice;  // of the class, as far as it was fitted in full
};

// A row of a reading that counts as bad, whatever the running median of its series says.
struct BadRow {
  int run = 0;
  size_t row = 0;  // MeasuringRun::bad_rows
};

class Extension {
 public:
  // `machine` and `runs` (the fit sessions) must outlive it.
  Extension(const machine::Machine& machine, const std::vector<instruments::MeasuringRun>& runs)
      : machine_(&machine), runs_(&runs) {}

  std::vector<Added> effects;  // in the order in which they were added
  std::vector<BadRow> bad_rows;

  // Declared errors, then the effects that are terms.
  machine::ErrorModel Model() const;
  // Which term of Model() an effect is.
  int TermOf(size_t effect) const;
  // The fit sessions, with the distortions, slips and bad readings found in them.
  std::vector<instruments::MeasuringRun> Runs() const;
  // Index, in the session's setup, of the offsets of its first slip.
  size_t FirstSlipOf(int run) const;
  // Index, in its session's setup, of the three offsets of an effect that is a slip.
  size_t SetupOf(size_t effect) const;
  // The same of a session's first amplitude of an effect that is an instrument's fault.
  size_t AmplitudesOf(size_t effect, int run) const;
  // As in error model and report; slips by their session, faults of instruments by their kind.
  std::string NameOf(size_t effect) const;

 private:
  const machine::Machine* machine_;
  const std::vector<instruments::MeasuringRun>* runs_;
};

}  // namespace axiscal::loop

#endif  // AXISCAL_CORE_LOOP_EXTENSION_H_
