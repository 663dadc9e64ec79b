// A scenario: a machine that is not what its description says, measured by instruments and people that are not perfect;
// simulated sessions of it, and the truth.
#ifndef AXISCAL_CORE_SYNTHETIC_SCENARIO_H_
#define AXISCAL_CORE_SYNTHETIC_SCENARIO_H_

#include <array>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "core/synthetic/effect.h"
#include "core/synthetic/fault.h"
#include "core/synthetic/nominal_fault.h"
#include "core/synthetic/sampling.h"
#include "core/synthetic/simulate.h"

namespace axiscal::synthetic {

// Where machine and plan of a scenario.json come from. One of `case_folder`, `fit` and `tests` is there.
struct PlanSource {
  std::string machine;                                        // machine.json; of a case folder its own where empty
  std::string case_folder;                                    // its fit and check sessions, measured anew
  std::vector<std::string> fit, check;                        // session files, or plans of them
  std::vector<std::string> tests, check_tests;                // tests that the product plans (axiscal plan --list)
  std::optional<Eigen::Vector3d> tool_tip_mm, table_ball_mm;  // of those tests
  std::optional<double> bar_mm;
  std::vector<std::pair<std::string, std::array<double, 2>>> travel_deg;  // per axis whose travel is not stated
};

struct Scenario {
  machine::ErrorModel errors;
  Surroundings surroundings;
  Sampling sampling;
  std::vector<Temperature> temperatures;
  std::vector<Effect> effects;
  std::vector<Fault> faults;
  std::vector<NominalFault> nominal;
  NoiseOptions noise;      // without its seeds and bad_share
  double bad_share = 0.0;  // of the readings, listed in the truth
  std::string text;        // the JSON it was read from
};

// docs/formats.md, "Scenario". Both read the whole document and refuse what they do not know: INVALID_ARGUMENT with
// field, value and rule.
absl::StatusOr<PlanSource> ReadPlanSource(const std::string& text);
absl::StatusOr<Scenario> ReadScenario(const std::string& text, const machine::Machine& machine);

struct PlannedCase {
  std::vector<session::Session> fit, check;
};

// A sum of what errors.json can hold and what it cannot.
struct Truth {
  machine::Machine machine;
  machine::ErrorModel errors;  // the scenario's, and effects that are terms of errors.json
  struct NamedEffect {
    std::string name;
    DrawnEffect drawn;
  };
  std::vector<NamedEffect> effects;  // that are no such terms
  std::vector<Temperature> temperatures;
  std::vector<BadReading> bad;
  Eigen::Vector3d tip_mm = Eigen::Vector3d::Zero();  // of the first session

  bool is_as_described = true;                       // machine.json is the true machine's

  // errors.json and the machine.json that goes with it hold all that is wrong.
  bool is_all_in_errors() const { return effects.empty() && is_as_described; }
};

struct SimulatedCase {
  machine::Machine described;  // machine.json as its owner has it
  PlannedCase measured;
  History history;  // of all sessions, the fit's first
  Truth truth;
};

// The same for the same arguments, on every machine. INVALID_ARGUMENT with the place in the scenario or the session.
absl::StatusOr<SimulatedCase> RunScenario(const machine::Machine& machine, const Scenario& scenario,
                                          const PlannedCase& planned, Form form, uint64_t seed);

// Of the tool point against the table, actual - nominal, in the table's frame; turn: of the tool against the table.
struct ToolPointError {
  Eigen::Vector3d shift_mm, turn_rad;
};
// At every moment of a motion, which begins anew (settled heat, no memory of the sessions).
std::vector<ToolPointError> ErrorsAlong(const Truth& truth, const Eigen::Vector3d& tip_mm, const History& motion);

// `count` poses along straight ways between points anywhere in the box of positions that the sessions covered,
// kPosesPerWay on each way at equal steps, its first point first: from 100 s after the sessions on, 10 s a way or as
// much more as it takes to go no faster than the sessions went, with the temperatures of then.
inline constexpr int kPosesPerWay = 8;
History BoxPoses(const SimulatedCase& simulated, int count, uint64_t seed);

// Columns of a file of poses: t_s, axes, recorded temperatures.
std::string WritePoses(const Truth& truth, const History& motion);
// truth.csv: ex_um,ey_um,ez_um,ea_urad,eb_urad,ec_urad, a row per pose.
std::string WriteTruthTable(const std::vector<ToolPointError>& errors);
// truth.json: seed, form, errors, effects, bad readings, the scenario itself.
std::string WriteTruth(const SimulatedCase& simulated, const Scenario& scenario, Form form, uint64_t seed);

}  // namespace axiscal::synthetic

#endif  // AXISCAL_CORE_SYNTHETIC_SCENARIO_H_
