#include "server/storage/care.h"

#include "server/storage/access.h"
#include "server/storage/page_token.h"

namespace axiscal::storage {
namespace {

// The calibration in use, and how many candidates were measured later.
absl::Status ReadCalibrations(Connection& connection, int64_t machine_key, MachineCare& care) {
  ASSIGN_OR_RETURN(Statement row,
                   connection.Ask("SELECT state, id, version, measured_at_utc_us, rms_before_um, rms_after_um FROM "
                                  "calibration INDEXED BY calibration_in_use WHERE machine_id = ?1 AND state <> 3 "
                                  "ORDER BY measured_at_utc_us DESC",
                                  machine_key));
  std::vector<UtcTime> candidates;
  while (true) {
    ASSIGN_OR_RETURN(const bool more, row.Step());
    if (!more) break;
    if (row.As<CalibrationState>(0) == CalibrationState::kApproved) {
      care.in_use = {CalibrationId(row.Int(1)), row.Int(2), row.Time(3), row.OptionalReal(4), row.OptionalReal(5)};
    } else {
      candidates.push_back(row.Time(3));
    }
  }
  for (const UtcTime measured_at : candidates) {
    if (!care.in_use || measured_at > care.in_use->measured_at) ++care.waiting;
  }
  return absl::OkStatus();
}

absl::Status ReadNewEvents(Connection& connection, UtcTime now, int64_t machine_key, MachineCare& care) {
  ASSIGN_OR_RETURN(Statement row,
                   connection.Ask("SELECT text FROM event INDEXED BY event_open_of_machine WHERE machine_id = ?1 AND "
                                  "cleared_at_utc_us IS NULL AND acknowledged_at_utc_us IS NULL AND "
                                  "(shelved_until_utc_us IS NULL OR shelved_until_utc_us <= ?2) ORDER BY id DESC",
                                  machine_key, now));
  while (true) {
    ASSIGN_OR_RETURN(const bool more, row.Step());
    if (!more) return absl::OkStatus();
    if (care.new_events++ == 0) care.newest_event = row.Text(0);
  }
}

absl::Status ReadFindings(Connection& connection, int64_t machine_key, MachineCare& care) {
  ASSIGN_OR_RETURN(Statement row, connection.Ask("SELECT kind, at_utc_us, text FROM standing_finding WHERE "
                                                 "machine_id = ?1 ORDER BY position",
                                                 machine_key));
  while (true) {
    ASSIGN_OR_RETURN(const bool more, row.Step());
    if (!more) return absl::OkStatus();
    care.findings.push_back({row.As<DriftKind>(0), row.Time(1), row.Text(2)});
  }
}

}  // namespace

absl::StatusOr<Page<MachineCare>> ListCare(Connection& connection, UtcTime now, const PageRequest& request,
                                           const Visible& visible) {
  ASSIGN_OR_RETURN(const PageStart start, StartPage(request, "care"));
  ASSIGN_OR_RETURN(const std::vector<int64_t> machines, MachinesIn(connection, visible.scopes));
  const std::string seen = visible.everything ? "" : "AND +m.id IN (SELECT value FROM json_each(?3)) ";
  ASSIGN_OR_RETURN(Statement row,
                   connection.Ask("SELECT m.id, m.name, CASE WHEN l.changes <> l.looked_at THEN 0 ELSE 1 END FROM "
                                  "machine AS m LEFT JOIN event_look AS l ON l.machine_id = m.id WHERE m.name > ?1 "
                                  "AND m.deleted_at_utc_us IS NULL " +
                                      seen + "ORDER BY m.name LIMIT ?2",
                                  start.after.value_or(""), start.row_limit(), JsonOf(machines)));
  Page<MachineCare> page;
  while (true) {
    ASSIGN_OR_RETURN(const bool more, row.Step());
    if (!more) break;
    MachineCare& care = page.rows.emplace_back();
    care.machine = MachineId(row.Text(1));
    care.is_followed = row.Bool(2);
    if (page.rows.size() > static_cast<size_t>(start.size)) break;  // tells only that another page follows
    RETURN_IF_ERROR(ReadCalibrations(connection, row.Int(0), care));
    RETURN_IF_ERROR(ReadNewEvents(connection, now, row.Int(0), care));
    RETURN_IF_ERROR(ReadFindings(connection, row.Int(0), care));
    ASSIGN_OR_RETURN(care.groups, GroupsOf(connection, row.Int(0)));
    care.care = CareOf(care);
  }
  EndPage(
      start, [](const MachineCare& care) { return care.machine.text(); },
      [](const MachineCare& care) {
        size_t bytes = care.machine.text().size() + care.newest_event.size() + 100;
        for (const StandingFinding& finding : care.findings) bytes += finding.text.size() + 20;
        for (const std::string& group : care.groups) bytes += group.size() + 2;
        return bytes;
      },
      page);
  return page;
}

}  // namespace axiscal::storage
