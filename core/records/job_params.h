// What a job is to do, as client and job runner see it.
#ifndef AXISCAL_CORE_RECORDS_JOB_PARAMS_H_
#define AXISCAL_CORE_RECORDS_JOB_PARAMS_H_

#include <Eigen/Core>
#include <cstdint>
#include <optional>
#include <string>
#include <variant>
#include <vector>

#include "core/base/ids.h"
#include "core/nc/options.h"
#include "core/nc/stated_options.h"

namespace axiscal::records {

// Fit a machine's errors to sessions; makes a candidate calibration.
struct IdentifyParams {
  MachineId machine;
  std::vector<SessionId> sessions;  // complete ones of that machine
  // Errors to fit: "EZ0T", or a term of errors.json without its amplitude ({"symbol": "EBB", "shape": "backlash"});
  // empty: those that the machine declares.
  std::vector<std::string> declared;
  std::string budget_json{};              // identify::ReadBudget; empty: the readings' noise alone
  std::optional<int> monte_carlo_runs{};  // 1 .. identify::kMaxMonteCarloRuns; nothing: no simulation
  uint64_t monte_carlo_seed = 1;
  std::optional<CalibrationId> held_calibration{};  // whose errors act at their values; or
  std::string held_errors_json{};                   // identify::ReadHeldErrors; empty and no calibration: none
};

// Find what a machine's declared model lacks; makes a candidate calibration.
struct CloseLoopParams {
  MachineId machine;
  std::vector<SessionId> fit, check;  // complete ones of that machine, none in both; check may be empty
  std::optional<int> max_effects;     // 1 .. kMaxEffects; nothing: the engine's default
  // Of the simulation alone, under the extended model; as in IdentifyParams.
  std::string budget_json{};
  std::optional<int> monte_carlo_runs{};
  uint64_t monte_carlo_seed = 1;
};
inline constexpr int kMaxEffects = 50;

// Evaluate a session of the laser tool setter; makes a report.
struct ToolSetterParams {
  MachineId machine;
  SessionId session;  // complete, of instrument tool-setter or tool-curve
  bool fit_yaw = false, fit_pitch = false;
};

// Rewrite a stored NC program for a machine's errors; makes a program.
struct CompensateParams {
  MachineId machine;
  ProgramId program;
  std::optional<CalibrationId> calibration;  // nothing: the machine's approved one. A candidate must be named.
  Eigen::Vector3d tool_tip_mm = Eigen::Vector3d::Zero();  // nominal tool point at home, machine frame
  nc::RewriteOptions options;                             // its `calibration` and `source_crc32` are set by the job
  nc::OpenOptions open{};        // of these what the machine's profile may say; lists that are empty, too
  bool without_profile = false;  // the machine's profile says nothing of what is open
  std::optional<double> time_s;  // when the program will run, of the sessions' clock
  std::optional<double> temperature_celsius;
  bool tables_are_off = false;  // of the control: those that were handed out of calibrations of this machine
};

using JobParams = std::variant<IdentifyParams, CompensateParams, CloseLoopParams, ToolSetterParams>;

inline constexpr char kIdentify[] = "identify";
inline constexpr char kCompensate[] = "compensate";
inline constexpr char kCloseLoop[] = "close_loop";
inline constexpr char kToolSetter[] = "tool_setter";
// JobRecord::kind of such a job.
std::string KindOf(const JobParams& params);
const MachineId& MachineOf(const JobParams& params);

}  // namespace axiscal::records

#endif  // AXISCAL_CORE_RECORDS_JOB_PARAMS_H_
