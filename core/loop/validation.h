// What sessions that were not used say of the extended model (docs/loop.md, "Steps", 5).
#ifndef AXISCAL_CORE_LOOP_VALIDATION_H_
#define AXISCAL_CORE_LOOP_VALIDATION_H_

#include <optional>
#include <vector>

#include "core/loop/check.h"
#include "core/loop/growth.h"

namespace axiscal::loop {

class Validation {
 public:
  // All must outlive it.
  Validation(const machine::Machine& machine, const identify::Options& identify_options, Check* check, Attempt* attempt)
      : machine_(machine), identify_options_(identify_options), check_(*check), attempt_(attempt) {}

  // Replaces members of a class that the check sessions speak against by others, and withdraws effects that do not help
  // there; true where one was replaced.
  absl::StatusOr<bool> Run(identify::Fit* fit);

 private:
  Extension& extension() const { return attempt_->extension; }
  std::vector<Added>& effects() const { return attempt_->extension.effects; }
  absl::StatusOr<std::optional<identify::Fit>> Joint(const identify::Fit& fit);
  absl::StatusOr<bool> SpeaksAgainst(size_t effect, const identify::Fit& fit, const identify::Fit& joint) const;
  enum class Wanted { kBetter, kNearlyAsGood, kAlike };
  std::vector<Candidate> Contenders(size_t effect, const identify::Fit& joint, Wanted wanted) const;
  absl::Status Foretell(size_t effect, const identify::Fit& joint, identify::Fit* fit);
  std::optional<Candidate> SlipInstead(size_t effect, double margin, const identify::Fit& fit,
                                       const identify::Fit& joint) const;
  absl::Status PutSlip(size_t effect, double margin, identify::Fit* fit);
  absl::StatusOr<bool> Replace(size_t effect, const identify::Fit& fit, const identify::Fit& joint);
  void AddSiblings(size_t effect, const identify::Fit& joint);
  absl::StatusOr<bool> Change(const std::vector<Added>& before, identify::Fit* fit);

  const machine::Machine& machine_;
  const identify::Options& identify_options_;
  Check& check_;
  Attempt* attempt_;
};

}  // namespace axiscal::loop

#endif  // AXISCAL_CORE_LOOP_VALIDATION_H_
