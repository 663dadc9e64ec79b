// A controller's log reduced to a session file's content: what a touch probe's program printed (Fanuc's DPRNT) or a
// control recorded (LinuxCNC's PROBEOPEN log), with what a template or a planned session says about it.
#ifndef AXISCAL_CORE_LOGS_REDUCE_H_
#define AXISCAL_CORE_LOGS_REDUCE_H_

#include <functional>
#include <istream>
#include <optional>
#include <string>
#include <vector>

#include "core/logs/log_reader.h"
#include "core/machine/machine.h"
#include "core/session/session.h"

namespace axiscal::logs {

struct ReduceOptions {
  // Checks axes and gates touches; needed for `approach: feature` and for centres from touches.
  const machine::Machine* machine = nullptr;
  // The session that was planned and run (session::ReadPlanFile): brings header and planned columns; reading k is its
  // line k, latched within kMaxOffPlanMm (linear axes) and kMaxOffPlanDeg of it and of its names. Of `centres` line k
  // is a pose, and the log may hold the touches at it.
  const session::Session* plan = nullptr;
  std::string session = "";                      // its name, in place of the template's or the plan's
  std::optional<double> start_s = std::nullopt;  // t_s of the first reading where the log has no times
  std::function<bool()> cancelled = nullptr;     // asked now and then while lines are read: then CANCELLED
};

// Mounting and errors move the contact off the plan, by far less than the distance to another feature: a touch farther
// off the plan than this is of something else.
inline constexpr double kMaxOffPlanMm = 25.0, kMaxOffPlanDeg = 0.1;

// Of a session of which a service keeps the log as well: header keys `log` (its name), `log_sha256`, and of what was
// stored the programs' numbers: `log_program`, `log_template` (or a known format's name), `log_plan`. A plan's own are
// no part of what is measured.
struct Reduced {
  session::Session session;   // valid; header key `cut_line` where the log's last line was cut
  std::vector<size_t> lines;  // of the log, by reading; of a centre the first of its touches
  std::optional<CutLine> cut;
  std::vector<std::string> notes;  // for people: what is missing, what was filled in
};

// A column is filled by its session::ColumnSource: what is planned from the log, else the plan or the template;
// commanded positions from the log, else the plan, latched ones (touch) from the log alone; readings from the log
// alone; centres from the log, else fitted to its touches (sphere_centres.h; needs `machine`), with header
// `centre_sigma_um`. Where neither positions nor names of the log stand in the plan too, it must hold as many readings
// as the plan. INVALID_ARGUMENT naming log or template, line, column and the rule, as WrongAt() where a line of the log
// is wrong; nothing is made up for what the log does not say.
absl::StatusOr<Reduced> Reduce(std::istream& log, const std::string& log_name, const LogTemplate& log_template,
                               const ReduceOptions& options);

}  // namespace axiscal::logs

#endif  // AXISCAL_CORE_LOGS_REDUCE_H_
