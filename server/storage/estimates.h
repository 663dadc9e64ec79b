// Rows of `estimate` and `estimate_week`: what each calibration found for each error symbol.
#ifndef AXISCAL_SERVER_STORAGE_ESTIMATES_H_
#define AXISCAL_SERVER_STORAGE_ESTIMATES_H_

#include <functional>
#include <string>
#include <vector>

#include "server/storage/connection.h"
#include "server/storage/records.h"

namespace axiscal::storage {

inline constexpr int64_t kWeekUs = 7LL * 24 * 3600 * 1'000'000;
// SQL of an estimate whose calibration is c: it was rejected (a candidate that was retired without ever having been
// approved), or not.
inline constexpr char kIsRejected[] = "(c.state = 3 AND c.approved_at_utc_us IS NULL)";
inline constexpr char kIsPoint[] = "NOT (c.state = 3 AND c.approved_at_utc_us IS NULL)";
// SQL that is true where a row of `estimate` (e), and whether its calibration (c) was rejected, are what was stored
// (server/storage/row_checksum.h). Of most calibrations it reads no more than the state, which stands before their
// long texts.
inline constexpr char kIsIntactEstimate[] =
    "(e.crc32c IS NOT DISTINCT FROM row_crc32c(e.machine_id, e.symbol, e.measured_at_utc_us, e.calibration_id, "
    "e.position, e.unit, "
    "e.identifiable, e.estimated_um_urad, e.sigma_um_urad, CASE WHEN c.state = 3 AND c.approved_at_utc_us IS NULL THEN "
    "1 ELSE 0 END))";
// For WITH RECURSIVE: `known`, the symbols of machine ?1 in their order, and a NULL behind them. It skips from one to
// the next instead of reading every row for DISTINCT.
inline constexpr char kSymbolsOfMachine[] =
    "known (symbol) AS (SELECT (SELECT symbol FROM estimate_week WHERE machine_id = ?1 AND symbol > '' ORDER BY symbol "
    "LIMIT 1) UNION ALL SELECT (SELECT symbol FROM estimate_week WHERE machine_id = ?1 AND symbol > known.symbol ORDER "
    "BY symbol LIMIT 1) FROM known WHERE known.symbol IS NOT NULL)";
// As kIsIntactEstimate, of a row of `estimate_week` (w).
inline constexpr char kIsIntactWeek[] =
    "(w.crc32c IS NOT DISTINCT FROM row_crc32c(w.machine_id, w.symbol, w.week, w.unit, w.estimate_count, "
    "w.not_identifiable_count, "
    "w.min_um_urad, w.max_um_urad, w.sum_um_urad, w.first_at_utc_us, w.last_at_utc_us, w.last_sigma_um_urad, "
    "w.last_calibration_id))";

// INVALID_ARGUMENT CALIBRATION_INVALID: a symbol twice or empty, a value that is not finite or belongs to an error that
// was not identifiable.
absl::Status CheckEstimates(const std::vector<Estimate>& estimates);
absl::Status InsertEstimates(Connection& connection, int64_t machine_key, UtcTime measured_at, CalibrationId id,
                             const std::vector<Estimate>& estimates);
// After the calibration of that moment was rejected (retired without ever having been approved), or is no longer: what
// is rejected is no part of the sums over weeks. What was damaged before stays so.
absl::Status NoteRejection(Connection& connection, int64_t machine_key, UtcTime measured_at, CalibrationId id,
                           bool is_rejected);
// Told of each row that is not what was stored ("EX0C, calibration 12"; "EX0C, week 2812"), and of each week of which
// the sums are not those of its estimates. Sums of numbers that were added in another order may differ in their last
// digits.
absl::Status CheckHistory(Connection& connection, int64_t machine_key,
                          const std::function<void(const std::string& place, const std::string& what)>& tell);
// Rows that are not what was stored, of all machines.
absl::StatusOr<int64_t> CountDamagedEstimates(Connection& connection);
// Each row is what was stored from now on: of rows that came from another engine, whose checksums are made in another
// way (migrations/postgresql), and that were whole there.
absl::Status SealEstimatesAnew(Connection& connection);
// The estimates of one calibration, in the order in which they were given.
absl::StatusOr<std::vector<Estimate>> ReadEstimates(Connection& connection, int64_t machine_key, UtcTime measured_at,
                                                    CalibrationId id);
// In order.
absl::StatusOr<std::vector<std::string>> MachineSymbols(Connection& connection, int64_t machine_key);

}  // namespace axiscal::storage

#endif  // AXISCAL_SERVER_STORAGE_ESTIMATES_H_
