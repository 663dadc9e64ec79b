#include "server/storage/seal.h"

#include "core/base/sha256.h"
#include "server/storage/audit.h"
#include "server/storage/calibrations.h"
#include "server/storage/jobs.h"
#include "server/storage/transaction.h"

namespace axiscal::storage {
namespace {

absl::Status SealRevisions(Connection& connection) {
  while (true) {
    int64_t machine_key, revision;
    std::string sha256;
    {
      ASSIGN_OR_RETURN(
          Statement row,
          connection.Ask("SELECT machine_id, revision, description_json FROM machine_revision WHERE sha256 = '' "
                         "ORDER BY machine_id, revision LIMIT 1"));
      ASSIGN_OR_RETURN(const bool found, row.Step());
      if (!found) return absl::OkStatus();
      machine_key = row.Int(0);
      revision = row.Int(1);
      sha256 = base::Sha256Hex(row.Text(2));
    }
    RETURN_IF_ERROR(connection.Run("UPDATE machine_revision SET sha256 = ?3 WHERE machine_id = ?1 AND revision = ?2",
                                   machine_key, revision, sha256));
  }
}

absl::Status SealCalibrations(Connection& connection) {
  while (true) {
    CalibrationId id;
    {
      ASSIGN_OR_RETURN(Statement row,
                       connection.Ask("SELECT id FROM calibration WHERE checksum = '' ORDER BY id LIMIT 1"));
      ASSIGN_OR_RETURN(const bool found, row.Step());
      if (!found) return absl::OkStatus();
      id = CalibrationId(row.Int(0));
    }
    RETURN_IF_ERROR(SealCalibration(connection, id));
  }
}

absl::Status SealJobs(Connection& connection) {
  while (true) {
    JobId id;
    std::string checksum;
    {
      ASSIGN_OR_RETURN(Statement row, connection.Ask("SELECT id, result FROM job INDEXED BY job_unsealed WHERE "
                                                     "state = 3 AND result_sha256 = '' ORDER BY id LIMIT 1"));
      ASSIGN_OR_RETURN(const bool found, row.Step());
      if (!found) return absl::OkStatus();
      id = JobId(row.Int(0));
      checksum = JobResultChecksum(id, row.Text(1));
    }
    RETURN_IF_ERROR(connection.Run("UPDATE job SET result_sha256 = ?2 WHERE id = ?1", id, checksum));
  }
}

}  // namespace

absl::Status SealOldRows(Connection& connection) {
  ASSIGN_OR_RETURN(Transaction transaction, Transaction::BeginWrite(connection));
  RETURN_IF_ERROR(SealRevisions(connection));
  RETURN_IF_ERROR(SealCalibrations(connection));
  RETURN_IF_ERROR(SealJobs(connection));
  RETURN_IF_ERROR(ChainOldAudit(connection));
  return transaction.Commit();
}

}  // namespace axiscal::storage
