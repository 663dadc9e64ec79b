// Grows the declared model by what it lacks: one effect at a time, each followed by a full refit, exchange of effects
// that were alike, and removal of what is no longer needed (docs/loop.md, "Steps", 3 and 4).
#ifndef AXISCAL_CORE_LOOP_GROWTH_H_
#define AXISCAL_CORE_LOOP_GROWTH_H_

#include <optional>
#include <string>
#include <vector>

#include "core/identify/identify.h"
#include "core/loop/close_loop.h"
#include "core/loop/extension.h"
#include "core/loop/fitting.h"

namespace axiscal::loop {

// Where an attempt starts, and what it must not do.
struct Way {
  std::vector<Added> prefix;         // effects to begin with
  std::vector<BadRow> bad_rows;      // that were found beside them
  std::vector<Candidate> not_first;  // that led astray before when they came next
  bool names_first = false;          // local defects only once nothing with a name is significant
  bool with_check = false;           // the check sessions are fitted like the others
  int most_effects = 0;
};

// One way from the declared model to what explains the sessions.
struct Attempt {
  Extension extension;
  Way way;
  std::vector<Candidate> refused;  // that promised much and did not fit
  std::optional<Added> first;      // what was added first
  bool has_close_name = false;     // a local defect was added for which a name would have explained nearly as much
  bool has_taken_back = false;     // bad readings that agreed with what was found after them, once
  Report report;                   // steps and ranking, as they come

  void Note(SelectionStep::Change change, const std::string& name, const identify::Fit& fit) {
    report.steps.push_back({change, name, fit.result.fit.rms_mm});
  }
};

class Growth {
 public:
  // All must outlive it.
  Growth(const machine::Machine& machine, const Options& options, const identify::Options& identify_options,
         Attempt* attempt)
      : machine_(machine), options_(options), identify_options_(identify_options), attempt_(attempt) {}

  // Adds effects until nothing significant is left; `fit` is that of the extension before and after.
  absl::Status Extend(identify::Fit* fit);
  // Drops effects that stand for nothing once others have been replaced.
  absl::Status Prune(identify::Fit* fit);

 private:
  // FitChanged of the attempt's extension.
  absl::StatusOr<bool> Change(const Extension& before, identify::Fit* fit) {
    return FitChanged(machine_, identify_options_, before, &attempt_->extension, fit);
  }
  Extension& extension() const { return attempt_->extension; }
  std::vector<Added>& effects() const { return attempt_->extension.effects; }
  std::vector<Candidate> Candidates(const identify::Fit& fit) const;
  absl::StatusOr<bool> Forward(identify::Fit* fit);
  Finding NamedOfWeak(const Signatures& signatures, const std::vector<Candidate>& named, Finding local) const;
  absl::StatusOr<Finding> NamedInstead(const identify::Fit& fit, const Signatures& signatures,
                                       std::vector<Candidate> candidates, Finding unnamed) const;
  absl::StatusOr<Finding> Decide(const identify::Fit& fit, const Signatures& signatures, Finding finding) const;
  absl::Status Swap(identify::Fit* fit);
  std::vector<Scored> ScoreOf(const Signatures& signatures, const std::vector<Candidate>& members) const;
  absl::StatusOr<bool> SwapOne(size_t effect, identify::Fit* fit);
  absl::StatusOr<bool> Consolidate(identify::Fit* fit);
  absl::StatusOr<bool> TakeOneForTwo(identify::Fit* fit);
  absl::StatusOr<bool> Straighten(identify::Fit* fit);
  absl::Status Backward(size_t count, identify::Fit* fit);
  absl::Status DropSlips(identify::Fit* fit);
  absl::StatusOr<bool> SetEndAside(const Scored& found, identify::Fit* fit);
  absl::StatusOr<bool> SetScatteredAside(size_t effect, identify::Fit* fit);
  absl::StatusOr<bool> SettleSlip(size_t effect, identify::Fit* fit);
  absl::Status SettleMoment(size_t effect, identify::Fit* fit);
  absl::StatusOr<bool> TakeBack(identify::Fit* fit);

  const machine::Machine& machine_;
  const Options& options_;
  const identify::Options& identify_options_;
  Attempt* attempt_;
};

}  // namespace axiscal::loop

#endif  // AXISCAL_CORE_LOOP_GROWTH_H_
