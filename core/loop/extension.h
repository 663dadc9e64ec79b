// The effects that have been added to the declared model so far.
#ifndef AXISCAL_CORE_LOOP_EXTENSION_H_
#define AXISCAL_CORE_LOOP_EXTENSION_H_

#include <string>
#include <vector>

#include "core/identify/problem.h"
#include "core/loop/search.h"

namespace axiscal::loop {

struct Added {
  Candidate candidate;
  double score = 0.0;
  std::vector<Candidate> equivalent, rivals;
};

class Extension {
 public:
  // `machine` and `runs` (the fit sessions) must outlive it.
  Extension(const machine::Machine& machine, const std::vector<instruments::MeasuringRun>& runs)
      : machine_(&machine), runs_(&runs) {}

  std::vector<Added> effects;  // in the order in which they were added

  // Declared errors, then the effects that are terms.
  machine::ErrorModel Model() const;
  // Which term of Model() an effect is.
  int TermOf(size_t effect) const;
  // The fit sessions. A slipped artefact: from that reading on the session is another session with a setup of its own.
  std::vector<instruments::MeasuringRun> Runs() const;
  // A slip that was found in the runs of `problem`, which may be parts of sessions: back to the session's own readings.
  void MapSlip(const identify::Problem& problem, Candidate* candidate) const;
  // As in error model and report; slips by their session.
  std::string NameOf(size_t effect) const;

 private:
  const machine::Machine* machine_;
  const std::vector<instruments::MeasuringRun>* runs_;
};

// The class without the effect itself, each effect once, unnamed structure left out.
void SetClass(const Finding& finding, Added* added);

}  // namespace axiscal::loop

#endif  // AXISCAL_CORE_LOOP_EXTENSION_H_
