#include "proto/convert/job_params.h"

#include <set>

#include "core/identify/monte_carlo.h"
#include "proto/convert/field.h"

namespace axiscal::convert {
namespace {

constexpr size_t kMostErrorBytes = 10'000;  // of one declared error: a map has many nodes
// Each is looked up before the call is answered: more than a machine gathers in years, and a second's work.
constexpr int kMostSessions = 10'000;
constexpr int kMostDeclaredErrors = 1000;  // each is parsed; a machine has some tens

// What both kinds that simulate say of it.
template <typename Params, typename Message>
void SimulationToProto(const Params& params, Message* message) {
  message->set_budget_json(params.budget_json);
  if (!params.monte_carlo_runs) return;
  message->set_monte_carlo_runs(*params.monte_carlo_runs);
  message->set_monte_carlo_seed(params.monte_carlo_seed);
}

template <typename Message, typename Params>
absl::Status SimulationFromProto(const Message& message, Params* params) {
  params->budget_json = message.budget_json();
  if (message.has_monte_carlo_runs()) {
    if (message.monte_carlo_runs() < 1 || message.monte_carlo_runs() > identify::kMaxMonteCarloRuns) {
      return FieldError("monte_carlo_runs",
                        absl::StrCat(message.monte_carlo_runs(), ", must be 1 to ", identify::kMaxMonteCarloRuns));
    }
    params->monte_carlo_runs = message.monte_carlo_runs();
  }
  if (message.has_monte_carlo_seed()) {
    if (!params->monte_carlo_runs) return FieldError("monte_carlo_seed", "must not be set without monte_carlo_runs");
    params->monte_carlo_seed = message.monte_carlo_seed();
  }
  return absl::OkStatus();
}

v1::IdentifyParams IdentifyToProto(const records::IdentifyParams& params) {
  v1::IdentifyParams message;
  message.set_machine_id(params.machine.text());
  for (const SessionId& id : params.sessions) message.add_session_ids(id.number());
  for (const std::string& symbol : params.declared) message.add_declared_errors(symbol);
  SimulationToProto(params, &message);
  if (params.held_calibration) message.set_held_calibration_id(params.held_calibration->number());
  message.set_held_errors_json(params.held_errors_json);
  return message;
}

// Appends the ids of a field; none may be in `seen`, which they join.
template <typename Ids>
absl::Status ReadSessions(const std::string& name, const Ids& ids, std::set<int64_t>& seen,
                          std::vector<SessionId>& sessions) {
  RETURN_IF_ERROR(RequireAtMost(name, ids.size(), kMostSessions));
  for (int i = 0; i < ids.size(); ++i) {
    const std::string field = absl::StrCat(name, "[", i, "]");
    RETURN_IF_ERROR(RequirePositive(field, ids[i]));
    if (!seen.insert(ids[i]).second) return FieldError(field, absl::StrCat(ids[i], " stands twice"));
    sessions.push_back(SessionId(ids[i]));
  }
  return absl::OkStatus();
}

absl::StatusOr<records::JobParams> IdentifyFromProto(const v1::IdentifyParams& message) {
  RETURN_IF_ERROR(RequireText("machine_id", message.machine_id(), 1, 255));
  RETURN_IF_ERROR(RequireMessage("session_ids", message.session_ids_size() > 0));
  records::IdentifyParams params;
  params.machine = MachineId(message.machine_id());
  std::set<int64_t> seen;
  RETURN_IF_ERROR(ReadSessions("session_ids", message.session_ids(), seen, params.sessions));
  RETURN_IF_ERROR(RequireAtMost("declared_errors", message.declared_errors_size(), kMostDeclaredErrors));
  for (int i = 0; i < message.declared_errors_size(); ++i) {
    RETURN_IF_ERROR(
        RequireText(absl::StrCat("declared_errors[", i, "]"), message.declared_errors(i), 1, kMostErrorBytes));
    params.declared.push_back(message.declared_errors(i));
  }
  RETURN_IF_ERROR(SimulationFromProto(message, &params));
  if (message.has_held_calibration_id()) {
    RETURN_IF_ERROR(RequirePositive("held_calibration_id", message.held_calibration_id()));
    if (!message.held_errors_json().empty()) {
      return FieldError("held_errors_json", "must not be set beside held_calibration_id");
    }
    params.held_calibration = CalibrationId(message.held_calibration_id());
  }
  params.held_errors_json = message.held_errors_json();
  return params;
}

v1::CloseLoopParams CloseLoopToProto(const records::CloseLoopParams& params) {
  v1::CloseLoopParams message;
  message.set_machine_id(params.machine.text());
  for (const SessionId& id : params.fit) message.add_fit_session_ids(id.number());
  for (const SessionId& id : params.check) message.add_check_session_ids(id.number());
  if (params.max_effects) message.set_max_effects(*params.max_effects);
  SimulationToProto(params, &message);
  return message;
}

absl::StatusOr<records::JobParams> CloseLoopFromProto(const v1::CloseLoopParams& message) {
  RETURN_IF_ERROR(RequireText("machine_id", message.machine_id(), 1, 255));
  RETURN_IF_ERROR(RequireMessage("fit_session_ids", message.fit_session_ids_size() > 0));
  records::CloseLoopParams params;
  params.machine = MachineId(message.machine_id());
  std::set<int64_t> seen;
  RETURN_IF_ERROR(ReadSessions("fit_session_ids", message.fit_session_ids(), seen, params.fit));
  for (int i = 0; i < message.check_session_ids_size(); ++i) {
    const int64_t id = message.check_session_ids(i);
    if (!seen.contains(id)) continue;
    return FieldError(absl::StrCat("check_session_ids[", i, "]"),
                      absl::StrCat(id, " stands in fit_session_ids: a session that was fitted proves nothing"));
  }
  RETURN_IF_ERROR(ReadSessions("check_session_ids", message.check_session_ids(), seen, params.check));
  if (message.has_max_effects()) {
    if (message.max_effects() < 1 || message.max_effects() > records::kMaxEffects) {
      return FieldError("max_effects", absl::StrCat(message.max_effects(), ", must be 1 to ", records::kMaxEffects));
    }
    params.max_effects = message.max_effects();
  }
  RETURN_IF_ERROR(SimulationFromProto(message, &params));
  if (!params.budget_json.empty() && !params.monte_carlo_runs)
    return FieldError("budget_json", "must not be set without monte_carlo_runs");
  return params;
}

v1::ToolSetterParams ToolSetterToProto(const records::ToolSetterParams& params) {
  v1::ToolSetterParams message;
  message.set_machine_id(params.machine.text());
  message.set_session_id(params.session.number());
  message.set_fit_yaw(params.fit_yaw);
  message.set_fit_pitch(params.fit_pitch);
  return message;
}

absl::StatusOr<records::JobParams> ToolSetterFromProto(const v1::ToolSetterParams& message) {
  RETURN_IF_ERROR(RequireText("machine_id", message.machine_id(), 1, 255));
  RETURN_IF_ERROR(RequirePositive("session_id", message.session_id()));
  return records::ToolSetterParams{MachineId(message.machine_id()), SessionId(message.session_id()), message.fit_yaw(),
                                   message.fit_pitch()};
}

// What a message leaves to the machine's profile, and the other way round.
nc::OpenOptions OpenOf(const v1::CompensateParams& message) {
  const v1::RewriteOptions& options = message.options();
  nc::OpenOptions open;
  open.tool_tip = message.tool_tip_mm_size() == 0;
  open.dialect = !options.has_dialect();
  open.integer_words = options.integer_words() == v1::INTEGER_WORDS_UNSPECIFIED;
  open.decimals = !options.has_decimals_mm() && !options.has_decimals_inch();
  open.block_delete = options.block_delete() == v1::BLOCK_DELETE_UNSPECIFIED;
  return open;
}

void LeaveOpen(const nc::OpenOptions& open, v1::RewriteOptions* options) {
  if (open.dialect) options->clear_dialect();
  if (open.integer_words) options->clear_integer_words();
  if (open.decimals) {
    options->clear_decimals_mm();
    options->clear_decimals_inch();
  }
  if (open.block_delete) options->clear_block_delete();
}

}  // namespace

v1::CompensateParams ToProto(const records::CompensateParams& params) {
  v1::CompensateParams message;
  message.set_machine_id(params.machine.text());
  if (params.program.number() > 0) message.set_program_id(params.program.number());
  if (params.calibration) message.set_calibration_id(params.calibration->number());
  *message.mutable_options() = ToProto(params.options);
  if (!params.open.tool_tip)
    for (const double value_mm : params.tool_tip_mm) message.add_tool_tip_mm(value_mm);
  LeaveOpen(params.open, message.mutable_options());
  message.set_without_profile(params.without_profile);
  if (params.time_s) message.set_time_s(*params.time_s);
  if (params.temperature_celsius) message.set_temperature_celsius(*params.temperature_celsius);
  message.set_tables_are_off(params.tables_are_off);
  return message;
}

absl::StatusOr<records::CompensateParams> FromProto(const v1::CompensateParams& message, bool needs_program) {
  RETURN_IF_ERROR(RequireText("machine_id", message.machine_id(), 1, 255));
  if (needs_program) RETURN_IF_ERROR(RequirePositive("program_id", message.program_id()));
  if (!needs_program && message.program_id() != 0) return FieldError("program_id", "the program comes with the call");
  records::CompensateParams params;
  params.machine = MachineId(message.machine_id());
  params.program = ProgramId(message.program_id());
  if (message.has_calibration_id()) {
    RETURN_IF_ERROR(RequirePositive("calibration_id", message.calibration_id()));
    params.calibration = CalibrationId(message.calibration_id());
  }
  params.without_profile = message.without_profile();
  params.open = OpenOf(message);
  if (message.tool_tip_mm_size() != 3 && (!params.open.tool_tip || params.without_profile)) {
    return FieldError("tool_tip_mm", absl::StrCat(message.tool_tip_mm_size(), " numbers, must be 3"));
  }
  for (int i = 0; i < message.tool_tip_mm_size(); ++i) {
    RETURN_IF_ERROR(RequireFinite(absl::StrCat("tool_tip_mm[", i, "]"), message.tool_tip_mm(i)));
    params.tool_tip_mm[i] = message.tool_tip_mm(i);
  }
  absl::StatusOr<nc::RewriteOptions> options = FromProto(message.options());
  if (!options.ok()) return InField("options", options.status());
  params.options = *std::move(options);
  if (message.has_time_s()) {
    RETURN_IF_ERROR(RequireFinite("time_s", message.time_s()));
    params.time_s = message.time_s();
  }
  if (message.has_temperature_celsius()) {
    RETURN_IF_ERROR(RequireFinite("temperature_celsius", message.temperature_celsius()));
    params.temperature_celsius = message.temperature_celsius();
  }
  params.tables_are_off = message.tables_are_off();
  return params;
}

v1::JobParams ToProto(const records::JobParams& params) {
  v1::JobParams message;
  if (const auto* identify = std::get_if<records::IdentifyParams>(&params)) {
    *message.mutable_identify() = IdentifyToProto(*identify);
  } else if (const auto* close_loop = std::get_if<records::CloseLoopParams>(&params)) {
    *message.mutable_close_loop() = CloseLoopToProto(*close_loop);
  } else if (const auto* tool_setter = std::get_if<records::ToolSetterParams>(&params)) {
    *message.mutable_tool_setter() = ToolSetterToProto(*tool_setter);
  } else {
    *message.mutable_compensate() = ToProto(std::get<records::CompensateParams>(params));
  }
  return message;
}

absl::StatusOr<records::JobParams> FromProto(const v1::IdentifyParams& message) { return IdentifyFromProto(message); }

absl::StatusOr<records::JobParams> FromProto(const v1::CloseLoopParams& message) { return CloseLoopFromProto(message); }

absl::StatusOr<records::JobParams> FromProto(const v1::JobParams& message) {
  switch (message.kind_case()) {
    case v1::JobParams::kIdentify: {
      absl::StatusOr<records::JobParams> params = IdentifyFromProto(message.identify());
      return params.ok() ? params : InField("identify", params.status());
    }
    case v1::JobParams::kCompensate: {
      absl::StatusOr<records::CompensateParams> params = FromProto(message.compensate(), true);
      if (!params.ok()) return InField("compensate", params.status());
      return records::JobParams(*std::move(params));
    }
    case v1::JobParams::kCloseLoop: {
      absl::StatusOr<records::JobParams> params = CloseLoopFromProto(message.close_loop());
      return params.ok() ? params : InField("close_loop", params.status());
    }
    case v1::JobParams::kToolSetter: {
      absl::StatusOr<records::JobParams> params = ToolSetterFromProto(message.tool_setter());
      return params.ok() ? params : InField("tool_setter", params.status());
    }
    default:
      return FieldError("kind", "must be one of identify, compensate, close_loop, tool_setter");
  }
}

std::string Serialize(const records::JobParams& params) { return ToProto(params).SerializeAsString(); }

absl::StatusOr<records::JobParams> ParseJobParams(const std::string& bytes) {
  v1::JobParams message;
  if (!message.ParseFromString(bytes)) return absl::DataLossError("the job's params are no message");
  return FromProto(message);
}

}  // namespace axiscal::convert
