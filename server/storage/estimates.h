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
// SQL of an estimate whose calibration is c: it was not rejected (a candidate that was retired without ever having been
// approved).
inline constexpr char kIsPoint[] = "NOT (c.state = 3 AND c.approved_at_utc_us IS NULL)";

// INVALID_ARGUMENT CALIBRATION_INVALID: a symbol twice or empty, a value that is not finite or belongs to an error that
// was not identifiable.
absl::Status CheckEstimates(const std::vector<Estimate>& estimates);
absl::Status InsertEstimates(Connection& connection, int64_t machine_key, UtcTime measured_at, CalibrationId id,
                             const std::vector<Estimate>& estimates);
// After a calibration of that moment was rejected (retired without ever having been approved), or is no longer: what is
// rejected is no part of the sums over weeks.
absl::Status SumWeekAgain(Connection& connection, int64_t machine_key, UtcTime measured_at);
// Told of each week of which the sums are not those of its estimates ("EX0C, week 2812"). Sums of numbers that were
// added in another order may differ in their last digits.
absl::Status CheckWeeks(Connection& connection, int64_t machine_key,
                        const std::function<void(const std::string& week)>& tell);
// The estimates of one calibration, in the order in which they were given.
absl::StatusOr<std::vector<Estimate>> ReadEstimates(Connection& connection, int64_t machine_key, UtcTime measured_at,
                                                    CalibrationId id);
// In order.
absl::StatusOr<std::vector<std::string>> MachineSymbols(Connection& connection, int64_t machine_key);

}  // namespace axiscal::storage

#endif  // AXISCAL_SERVER_STORAGE_ESTIMATES_H_
