// What a job is to do, as client and job runner see it. The store keeps it as the bytes of its message.
#ifndef AXISCAL_PROTO_CONVERT_JOB_PARAMS_H_
#define AXISCAL_PROTO_CONVERT_JOB_PARAMS_H_

#include <Eigen/Core>
#include <optional>
#include <string>
#include <variant>
#include <vector>

#include "axiscal/v1/job.pb.h"
#include "core/base/ids.h"
#include "core/base/status.h"
#include "core/nc/options.h"

namespace axiscal::convert {

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
  std::optional<double> time_s;                           // when the program will run, of the sessions' clock
  std::optional<double> temperature_celsius;
};

using JobParams = std::variant<IdentifyParams, CompensateParams, CloseLoopParams, ToolSetterParams>;

inline constexpr char kIdentify[] = "identify";
inline constexpr char kCompensate[] = "compensate";
inline constexpr char kCloseLoop[] = "close_loop";
inline constexpr char kToolSetter[] = "tool_setter";
// The store's name of the kind.
std::string KindOf(const JobParams& params);
const MachineId& MachineOf(const JobParams& params);

v1::JobParams ToProto(const JobParams& params);
// FIELD_INVALID: no kind, no machine, no session or one twice (also once to fit and once to check), a tool tip of other
// than three finite numbers, unknown choices. Symbols, dialects and the like are judged by the engine that uses them.
absl::StatusOr<JobParams> FromProto(const v1::JobParams& message);

v1::CompensateParams ToProto(const CompensateParams& params);
// Of a program that is stored (`needs_program`), or of one that comes with the call and has no id.
absl::StatusOr<CompensateParams> FromProto(const v1::CompensateParams& message, bool needs_program);

v1::RewriteOptions ToProto(const nc::RewriteOptions& options);
// Unset fields take the defaults of nc::RewriteOptions.
absl::StatusOr<nc::RewriteOptions> FromProto(const v1::RewriteOptions& message);

// The bytes that the store keeps, and back. Equal params have equal bytes.
std::string Serialize(const JobParams& params);
absl::StatusOr<JobParams> ParseJobParams(const std::string& bytes);

}  // namespace axiscal::convert

#endif  // AXISCAL_PROTO_CONVERT_JOB_PARAMS_H_
