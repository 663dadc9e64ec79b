#include "server/storage/estimates.h"

#include <cmath>
#include <map>
#include <set>

#include "absl/strings/str_cat.h"
#include "absl/strings/substitute.h"
#include "server/storage/refusal.h"
#include "server/storage/transaction.h"

namespace axiscal::storage {
namespace {

constexpr char kAddToWeek[] =
    "INSERT INTO estimate_week (machine_id, symbol, week, unit, estimate_count, not_identifiable_count, min_um_urad, "
    "max_um_urad, "
    "sum_um_urad, first_at_utc_us, last_at_utc_us, last_sigma_um_urad, last_calibration_id) "
    "VALUES (?1, ?2, ?3, ?4, 1, 0, ?5, ?5, ?5, ?6, ?6, ?7, ?8) "
    "ON CONFLICT (machine_id, symbol, week) DO UPDATE SET estimate_count = estimate_week.estimate_count + 1, "
    "min_um_urad = CASE WHEN estimate_week.min_um_urad < ?5 THEN estimate_week.min_um_urad ELSE ?5 END, "
    "max_um_urad = CASE WHEN estimate_week.max_um_urad > ?5 THEN estimate_week.max_um_urad ELSE ?5 END, "
    "sum_um_urad = coalesce(estimate_week.sum_um_urad, 0.0) + ?5, first_at_utc_us = CASE WHEN "
    "estimate_week.first_at_utc_us < ?6 THEN estimate_week.first_at_utc_us ELSE ?6 END, "
    "last_sigma_um_urad = CASE WHEN estimate_week.last_at_utc_us > ?6 THEN estimate_week.last_sigma_um_urad ELSE ?7 "
    "END, last_calibration_id = CASE WHEN estimate_week.last_at_utc_us > ?6 THEN estimate_week.last_calibration_id "
    "ELSE ?8 END, last_at_utc_us = CASE WHEN estimate_week.last_at_utc_us > ?6 THEN estimate_week.last_at_utc_us "
    "ELSE ?6 END";
constexpr char kAddUnknownToWeek[] =
    "INSERT INTO estimate_week (machine_id, symbol, week, unit, estimate_count, not_identifiable_count) VALUES (?1, "
    "?2, ?3, ?4, 0, 1) "
    "ON CONFLICT (machine_id, symbol, week) DO UPDATE SET not_identifiable_count = "
    "estimate_week.not_identifiable_count + 1";

constexpr char kSealWeeks[] =
    "UPDATE estimate_week SET crc32c = row_crc32c(machine_id, symbol, week, unit, estimate_count, "
    "not_identifiable_count, min_um_urad, max_um_urad, sum_um_urad, first_at_utc_us, last_at_utc_us, "
    "last_sigma_um_urad, last_calibration_id)";
constexpr char kOfWeek[] = " WHERE machine_id = ?1 AND symbol = ?2 AND week = ?3";
// Where it was intact while its calibration was rejected (?5) it is so while that is ?6.
constexpr char kSealEstimateAgain[] =
    "UPDATE estimate SET crc32c = row_crc32c(machine_id, symbol, measured_at_utc_us, calibration_id, position, unit, "
    "identifiable, estimated_um_urad, sigma_um_urad, ?6) WHERE machine_id = ?1 AND symbol = ?2 AND "
    "measured_at_utc_us = ?3 AND calibration_id = ?4 AND crc32c IS NOT DISTINCT FROM row_crc32c(machine_id, symbol, "
    "measured_at_utc_us, "
    "calibration_id, position, unit, identifiable, estimated_um_urad, sigma_um_urad, ?5)";

// The sums of a machine's week ?2 (of ?3 us) of symbol ?4 over all that counts now. Rows stay where nothing is left:
// they say which symbols the machine has.
const std::string& SumWeekAgainSql() {
  static const std::string& sql =
      *new std::string(absl::Substitute(R"(UPDATE estimate_week AS w SET
  unit = coalesce((SELECT e.unit FROM estimate AS e CROSS JOIN calibration AS c ON c.id = e.calibration_id
    WHERE $0 AND $1 LIMIT 1), unit),
  (estimate_count, not_identifiable_count, min_um_urad, max_um_urad, sum_um_urad, first_at_utc_us, last_at_utc_us) =
    (SELECT count(e.estimated_um_urad), count(*) - count(e.estimated_um_urad), min(e.estimated_um_urad),
       max(e.estimated_um_urad), sum(e.estimated_um_urad),
       min(CASE WHEN e.estimated_um_urad IS NULL THEN NULL ELSE e.measured_at_utc_us END),
       max(CASE WHEN e.estimated_um_urad IS NULL THEN NULL ELSE e.measured_at_utc_us END)
     FROM estimate AS e CROSS JOIN calibration AS c ON c.id = e.calibration_id
     WHERE $0 AND $1),
  (last_sigma_um_urad, last_calibration_id) =
    (SELECT e.sigma_um_urad, e.calibration_id
     FROM estimate AS e CROSS JOIN calibration AS c ON c.id = e.calibration_id
     WHERE $0 AND e.estimated_um_urad IS NOT NULL AND $1
     ORDER BY e.measured_at_utc_us DESC, e.calibration_id DESC LIMIT 1)
WHERE w.machine_id = ?1 AND w.symbol = ?4 AND w.week = ?2)",
                                        "e.machine_id = w.machine_id AND e.symbol = "
                                        "w.symbol AND e.measured_at_utc_us >= w.week * ?3 "
                                        "AND e.measured_at_utc_us < (w.week + 1) * ?3",
                                        absl::StrCat(kIsPoint, " AND ", kIsIntactEstimate)));
  return sql;
}

absl::Status SumWeekAgain(Connection& connection, int64_t machine_key, int64_t week) {
  ASSIGN_OR_RETURN(const std::vector<std::string> symbols, MachineSymbols(connection, machine_key));
  for (const std::string& symbol : symbols) {
    RETURN_IF_ERROR(connection.Run(SumWeekAgainSql(), machine_key, week, kWeekUs, symbol));
    RETURN_IF_ERROR(connection.Run(absl::StrCat(kSealWeeks, kOfWeek), machine_key, symbol, week));
  }
  return absl::OkStatus();
}

// True also where there is none.
absl::StatusOr<bool> IsIntactWeek(Connection& connection, int64_t machine_key, const std::string& symbol,
                                  int64_t week) {
  ASSIGN_OR_RETURN(Statement row, connection.Ask(absl::StrCat("SELECT ", kIsIntactWeek,
                                                              " FROM estimate_week AS w WHERE machine_id = "
                                                              "?1 AND symbol = ?2 AND week = ?3"),
                                                 machine_key, symbol, week));
  ASSIGN_OR_RETURN(const bool found, row.Step());
  return !found || row.Bool(0);
}

absl::Status Invalid(const std::string& symbol, const std::string& rule) {
  return InvalidArgument("estimate " + symbol + ": " + rule, "CALIBRATION_INVALID");
}

absl::Status InsertOne(Connection& connection, int64_t machine_key, UtcTime measured_at, CalibrationId id,
                       int64_t position, const Estimate& estimate) {
  const int unit = static_cast<int>(estimate.unit);
  RETURN_IF_ERROR(
      connection.Run("INSERT INTO estimate (machine_id, symbol, measured_at_utc_us, calibration_id, position, unit, "
                     "identifiable, estimated_um_urad, sigma_um_urad, crc32c) VALUES (?1, ?2, ?3, ?4, ?5, ?6, ?7, ?8, "
                     "?9, row_crc32c(?1, ?2, ?3, ?4, ?5, ?6, ?7, ?8, ?9, 0))",
                     machine_key, estimate.symbol, measured_at, id, position, unit, estimate.identifiable,
                     estimate.value, estimate.sigma));
  const int64_t week = base::ToUtcUs(measured_at) / kWeekUs;
  ASSIGN_OR_RETURN(const bool is_intact, IsIntactWeek(connection, machine_key, estimate.symbol, week));
  if (!is_intact) return SumWeekAgain(connection, machine_key, week);
  RETURN_IF_ERROR(estimate.identifiable ? connection.Run(kAddToWeek, machine_key, estimate.symbol, week, unit,
                                                         estimate.value, measured_at, estimate.sigma, id)
                                        : connection.Run(kAddUnknownToWeek, machine_key, estimate.symbol, week, unit));
  return connection.Run(absl::StrCat(kSealWeeks, kOfWeek), machine_key, estimate.symbol, week);
}

}  // namespace

absl::Status CheckEstimates(const std::vector<Estimate>& estimates) {
  std::set<std::string> symbols;
  for (const Estimate& estimate : estimates) {
    if (estimate.symbol.empty()) return Invalid("without a symbol", "not allowed");
    if (!symbols.insert(estimate.symbol).second) return Invalid(estimate.symbol, "twice");
    if (estimate.identifiable != estimate.value.has_value()) {
      return Invalid(estimate.symbol, "has a value if and only if it is identifiable");
    }
    if (!estimate.identifiable && estimate.sigma.has_value())
      return Invalid(estimate.symbol, "not identifiable, but has a sigma");
    if (!std::isfinite(estimate.value.value_or(0.0))) return Invalid(estimate.symbol, "value is not finite");
    if (!std::isfinite(estimate.sigma.value_or(0.0)) || estimate.sigma.value_or(0.0) < 0.0) {
      return Invalid(estimate.symbol, "sigma must be finite and >= 0");
    }
  }
  return absl::OkStatus();
}

absl::Status InsertEstimates(Connection& connection, int64_t machine_key, UtcTime measured_at, CalibrationId id,
                             const std::vector<Estimate>& estimates) {
  for (size_t i = 0; i < estimates.size(); ++i) {
    RETURN_IF_ERROR(InsertOne(connection, machine_key, measured_at, id, static_cast<int64_t>(i), estimates[i]));
  }
  return absl::OkStatus();
}

absl::Status NoteRejection(Connection& connection, int64_t machine_key, UtcTime measured_at, CalibrationId id,
                           bool is_rejected) {
  ASSIGN_OR_RETURN(const std::vector<std::string> symbols, MachineSymbols(connection, machine_key));
  for (const std::string& symbol : symbols) {
    RETURN_IF_ERROR(
        connection.Run(kSealEstimateAgain, machine_key, symbol, measured_at, id, !is_rejected, is_rejected));
  }
  return SumWeekAgain(connection, machine_key, base::ToUtcUs(measured_at) / kWeekUs);
}

namespace {

using TellDamage = std::function<void(const std::string& place, const std::string& what)>;

absl::Status CheckRows(Connection& connection, int64_t machine_key, const TellDamage& tell) {
  {
    ASSIGN_OR_RETURN(Statement row,
                     connection.Ask(absl::StrCat("SELECT e.symbol, e.calibration_id FROM estimate AS e CROSS JOIN "
                                                 "calibration AS c ON c.id = e.calibration_id WHERE e.machine_id = ?1 "
                                                 "AND NOT ",
                                                 kIsIntactEstimate),
                                    machine_key));
    while (true) {
      ASSIGN_OR_RETURN(const bool more, row.Step());
      if (!more) break;
      tell(absl::StrCat(row.Text(0), ", calibration ", row.Int(1)),
           "the row is not what was stored: histories leave it out");
    }
  }
  ASSIGN_OR_RETURN(Statement row, connection.Ask(absl::StrCat("SELECT w.symbol, w.week FROM estimate_week AS w WHERE "
                                                              "w.machine_id = ?1 AND NOT ",
                                                              kIsIntactWeek),
                                                 machine_key));
  while (true) {
    ASSIGN_OR_RETURN(const bool more, row.Step());
    if (!more) return absl::OkStatus();
    tell(absl::StrCat(row.Text(0), ", week ", row.Int(1)),
         "the row is not what was stored: histories are drawn from its estimates");
  }
}

}  // namespace

absl::Status CheckHistory(Connection& connection, int64_t machine_key, const TellDamage& tell) {
  RETURN_IF_ERROR(CheckRows(connection, machine_key, tell));
  // Both ways, so that a week without its row is found too. Rows that are named already are not named again.
  ASSIGN_OR_RETURN(Statement row, connection.Ask(absl::Substitute(R"(WITH counted AS (
  SELECT e.symbol, e.measured_at_utc_us / ?2 AS week, count(e.estimated_um_urad) AS known, count(*) AS rows,
    min(e.estimated_um_urad) AS low, max(e.estimated_um_urad) AS high, sum(e.estimated_um_urad) AS total,
    coalesce(sum(abs(e.estimated_um_urad)), 0.0) AS size,
    min(CASE WHEN e.estimated_um_urad IS NULL THEN NULL ELSE e.measured_at_utc_us END) AS first,
    max(CASE WHEN e.estimated_um_urad IS NULL THEN NULL ELSE e.measured_at_utc_us END) AS last
  FROM estimate AS e CROSS JOIN calibration AS c ON c.id = e.calibration_id
  WHERE e.machine_id = ?1 AND $0 GROUP BY e.symbol, week)
SELECT w.symbol, w.week FROM estimate_week AS w LEFT JOIN counted AS n ON n.symbol = w.symbol AND n.week = w.week
WHERE w.machine_id = ?1 AND $1 AND (w.estimate_count <> coalesce(n.known, 0)
  OR w.not_identifiable_count <> coalesce(n.rows - n.known, 0) OR w.min_um_urad IS DISTINCT FROM n.low
  OR w.max_um_urad IS DISTINCT FROM n.high OR w.first_at_utc_us IS DISTINCT FROM n.first
  OR w.last_at_utc_us IS DISTINCT FROM n.last
  OR abs(coalesce(w.sum_um_urad, 0.0) - coalesce(n.total, 0.0)) > 1e-9 * coalesce(n.size, 0.0)
  OR (w.last_calibration_id IS NOT NULL AND NOT EXISTS (SELECT 1 FROM estimate AS e WHERE e.machine_id = ?1
    AND e.symbol = w.symbol AND e.measured_at_utc_us = w.last_at_utc_us AND e.calibration_id = w.last_calibration_id
    AND e.sigma_um_urad IS NOT DISTINCT FROM w.last_sigma_um_urad AND e.unit = w.unit)))
UNION SELECT n.symbol, n.week FROM counted AS n WHERE NOT EXISTS (SELECT 1 FROM estimate_week AS w
  WHERE w.machine_id = ?1 AND w.symbol = n.symbol AND w.week = n.week) ORDER BY 1, 2)",
                                                                  kIsPoint, kIsIntactWeek),
                                                 machine_key, kWeekUs));
  while (true) {
    ASSIGN_OR_RETURN(const bool more, row.Step());
    if (!more) return absl::OkStatus();
    tell(absl::StrCat(row.Text(0), ", week ", row.Int(1)), "its sums are not those of its estimates");
  }
}

absl::StatusOr<std::vector<Estimate>> ReadEstimates(Connection& connection, int64_t machine_key, UtcTime measured_at,
                                                    CalibrationId id) {
  // By whole keys of the clustered table, a symbol at a time: an index by calibration would grow the history by half
  // for this one use.
  ASSIGN_OR_RETURN(const std::vector<std::string> symbols, MachineSymbols(connection, machine_key));
  std::map<int64_t, Estimate> by_position;
  for (const std::string& symbol : symbols) {
    ASSIGN_OR_RETURN(
        Statement row,
        connection.Ask("SELECT position, unit, identifiable, estimated_um_urad, sigma_um_urad FROM estimate "
                       "WHERE machine_id = ?1 AND symbol = ?2 AND measured_at_utc_us = ?3 AND "
                       "calibration_id = ?4",
                       machine_key, symbol, measured_at, id));
    ASSIGN_OR_RETURN(const bool found, row.Step());
    if (!found) continue;
    by_position[row.Int(0)] = {symbol, row.As<EstimateUnit>(1), row.Bool(2), row.OptionalReal(3), row.OptionalReal(4)};
  }
  std::vector<Estimate> estimates;
  for (auto& [position, estimate] : by_position) estimates.push_back(std::move(estimate));
  return estimates;
}

absl::StatusOr<std::vector<std::string>> MachineSymbols(Connection& connection, int64_t machine_key) {
  ASSIGN_OR_RETURN(Statement row, connection.Ask(absl::StrCat("WITH RECURSIVE ", kSymbolsOfMachine,
                                                              " SELECT symbol FROM known WHERE symbol IS NOT NULL"),
                                                 machine_key));
  std::vector<std::string> symbols;
  while (true) {
    ASSIGN_OR_RETURN(const bool more, row.Step());
    if (!more) return symbols;
    symbols.push_back(row.Text(0));
  }
}

absl::StatusOr<int64_t> CountDamagedEstimates(Connection& connection) {
  int64_t count = 0;
  for (const std::string& sql :
       {absl::StrCat("SELECT count(*) FROM estimate AS e JOIN calibration AS c ON c.id = e.calibration_id WHERE NOT ",
                     kIsIntactEstimate),
        absl::StrCat("SELECT count(*) FROM estimate_week AS w WHERE NOT ", kIsIntactWeek)}) {
    ASSIGN_OR_RETURN(Statement row, connection.Ask(sql));
    RETURN_IF_ERROR(row.Step().status());
    count += row.Int(0);
  }
  return count;
}

absl::Status SealEstimatesAnew(Connection& connection) {
  ASSIGN_OR_RETURN(Transaction transaction, Transaction::BeginWrite(connection));
  RETURN_IF_ERROR(connection.Run(absl::StrCat(
      "UPDATE estimate SET crc32c = row_crc32c(machine_id, symbol, measured_at_utc_us, calibration_id, position, unit, "
      "identifiable, estimated_um_urad, sigma_um_urad, (SELECT CASE WHEN ",
      kIsRejected, " THEN 1 ELSE 0 END FROM calibration AS c WHERE c.id = estimate.calibration_id))")));
  RETURN_IF_ERROR(connection.Run(kSealWeeks));
  return transaction.Commit();
}

}  // namespace axiscal::storage
