// How a session is brought to the server: in chunks, resumed where the server stands. Internal to the client.
#ifndef AXISCAL_CLIENT_UPLOAD_H_
#define AXISCAL_CLIENT_UPLOAD_H_

#include "client/client.h"

namespace axiscal::client {

class Connection;

absl::StatusOr<UploadResult> UploadSession(const Connection& connection, const MachineId& machine,
                                           const session::Session& session, const ProgressCallback& progress);

}  // namespace axiscal::client

#endif  // AXISCAL_CLIENT_UPLOAD_H_
