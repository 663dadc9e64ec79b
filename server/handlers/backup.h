// Admin.Backup: a copy of the database, left in the server's folder for backups or sent to the caller.
#ifndef AXISCAL_SERVER_HANDLERS_BACKUP_H_
#define AXISCAL_SERVER_HANDLERS_BACKUP_H_

#include "axiscal/v1/admin_service.pb.h"
#include "server/handlers/core.h"

namespace axiscal::handlers {

// `send` returns false when the caller has left. One at a time: RESOURCE_EXHAUSTED BACKUP_RUNNING. FAILED_PRECONDITION
// BACKUP_FOLDER_MISSING where it is to be left on a server without such a folder.
absl::Status Backup(Core& core, const Call& call, const v1::BackupRequest& request,
                    const std::function<bool(const v1::BackupResponse&)>& send);

}  // namespace axiscal::handlers

#endif  // AXISCAL_SERVER_HANDLERS_BACKUP_H_
