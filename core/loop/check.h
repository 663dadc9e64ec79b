// What sessions that were not used to fit errors say of an extended model: only their own setup offsets are refitted
// (docs/loop.md, "Steps", 5).
#ifndef AXISCAL_CORE_LOOP_CHECK_H_
#define AXISCAL_CORE_LOOP_CHECK_H_

#include <memory>
#include <optional>
#include <vector>

#include "core/identify/identify.h"
#include "core/loop/report.h"

namespace axiscal::loop {

class Check {
 public:
  // `runs` may be empty: then nothing is said.
  Check(const machine::Machine& machine, std::vector<instruments::MeasuringRun> runs, const identify::Options& options)
      : machine_(machine), runs_(std::move(runs)), options_(options) {}

  bool is_empty() const { return runs_.empty(); }
  const std::vector<instruments::MeasuringRun>& runs() const { return runs_; }
  // `runs`, then these sessions, to be fitted together; these keep names and set-ups of their own, "check CR", but for
  // set-ups that they state to share with `runs`.
  std::vector<instruments::MeasuringRun> After(std::vector<instruments::MeasuringRun> runs) const;
  // Fits the set-ups of these sessions under the errors of a fit; those that they share with its sessions stay as it
  // found them (identify::CheckRuns). DEMANDs that there are sessions; CANCELLED or the fit's errors.
  absl::StatusOr<identify::Fit> Under(const identify::Fit& fit);

  // Fits the setup offsets under the best model known and sets bad readings aside. The noise is that of the fit
  // sessions of the same instrument: a bad model must not be excused by the scatter that it causes itself.
  absl::Status Settle(const identify::Fit& best);
  // All sessions, those of the fit and these, fitted together with the fit's model, starting from its values. Misfit
  // that appears only together is more than chance and the uncertainty of the errors explain (a drift whose rate is
  // poorly known may be off two hours later). DEMANDs Settle before; CANCELLED or the fit's errors.
  absl::StatusOr<std::shared_ptr<const identify::Fit>> Joint(const identify::Fit& best);
  // Chi-square of these sessions under the errors of the fit sessions (Settle before), and in `joint`, which holds them
  // after its first `fitted` runs.
  double SquaresAlone() const;
  double SquaresIn(const identify::Fit& joint, size_t fitted) const;
  // Whether what `joint` leaves beyond `best` is chance, given also how well the fit sessions know the noise.
  bool IsExplained(const identify::Fit& joint, const identify::Fit& best) const;
  // Whether `best` foretells these sessions as well as it fits its own (Chow 1960, "Tests of equality between sets of
  // coefficients", the test of a prediction): what they add to chi-square in `joint` per degree of freedom that they
  // add, over what the fit sessions leave per degree of freedom of theirs. A model that is incomplete leaves as much in
  // both.
  static bool IsForetold(const identify::Fit& joint, const identify::Fit& best);
  // The sessions whose misfit is larger than that; empty where all is explained.
  absl::StatusOr<std::vector<Unexplained>> UnexplainedSessions(const identify::Fit& best);
  // The same where `best` was fitted to these sessions, too: those whose misfit under its errors is more than chance.
  std::vector<Unexplained> UnexplainedWhereFitted() const;

  // The result of Settle, and of later questions.
  struct Settled {
    // Of the fit that it was settled under.
    machine::ErrorModel model;
    std::vector<Eigen::VectorXd> setup;
    std::vector<identify::Noise> noise;
    std::vector<std::vector<bool>> is_used;

    identify::Problem problem;
    identify::Point point;
    double noise_readings = 0.0;                 // that the noise was judged from
    std::shared_ptr<const identify::Fit> joint;  // with that fit; none yet

    bool IsUnder(const identify::Fit& fit) const;
  };
  const Settled& settled() const { return settled_; }
  void PutBack(Settled settled) { settled_ = std::move(settled); }

 private:
  const machine::Machine& machine_;
  const std::vector<instruments::MeasuringRun> runs_;
  const identify::Options options_;
  bool IsChance(double squares, double count) const;
  bool SharesSetup(const identify::Problem& fit) const;
  double UsedOf(size_t run) const;
  Unexplained ExcessOf(size_t run, double squares) const;

  Settled settled_;
  std::optional<machine::ErrorModel> last_model_;  // asked for by Under
  std::vector<Eigen::VectorXd> last_setup_;
  identify::Fit under_last_model_;
};

}  // namespace axiscal::loop

#endif  // AXISCAL_CORE_LOOP_CHECK_H_
