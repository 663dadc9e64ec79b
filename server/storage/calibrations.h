// Rows of `calibration` and `calibration_session`. What each function returns: database.h.
#ifndef AXISCAL_SERVER_STORAGE_CALIBRATIONS_H_
#define AXISCAL_SERVER_STORAGE_CALIBRATIONS_H_

#include <optional>

#include "server/storage/connection.h"
#include "server/storage/records.h"

namespace axiscal::storage {

// Writes the checksum of the row as it stands.
absl::Status SealCalibration(Connection& connection, CalibrationId id);
absl::StatusOr<CalibrationRecord> CreateCalibration(Connection& connection, UtcTime now,
                                                    const NewCalibration& calibration, std::optional<JobId> job);
absl::StatusOr<CalibrationRecord> GetCalibration(Connection& connection, CalibrationId id);
absl::StatusOr<std::vector<records::Decision>> ListDecisions(Connection& connection, CalibrationId id, int limit);
absl::StatusOr<CalibrationRecord> GetApprovedCalibration(Connection& connection, const MachineId& machine);
absl::StatusOr<CalibrationRecord> GetApprovedByPerson(Connection& connection, const MachineId& machine);
absl::StatusOr<std::optional<CalibrationId>> GetFormerOf(Connection& connection, CalibrationId id);
absl::StatusOr<Page<CalibrationRecord>> ListCalibrations(Connection& connection, const CalibrationFilter& filter,
                                                         const PageRequest& request, const Visible& visible);
absl::StatusOr<CalibrationRecord> ApproveCalibration(Connection& connection, UtcTime now, CalibrationId id,
                                                     int64_t expected_etag, std::optional<CalibrationId> in_use,
                                                     const Caller& caller);
absl::StatusOr<CalibrationRecord> RetireCalibration(Connection& connection, UtcTime now, CalibrationId id,
                                                    int64_t expected_etag, const Caller& caller);

}  // namespace axiscal::storage

#endif  // AXISCAL_SERVER_STORAGE_CALIBRATIONS_H_
