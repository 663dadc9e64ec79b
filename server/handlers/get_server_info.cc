#include "server/handlers/get_server_info.h"

#include "proto/convert/session.h"

namespace axiscal::handlers {

absl::StatusOr<v1::GetServerInfoResponse> GetServerInfo(Core& core, const Call& call,
                                                        const v1::GetServerInfoRequest& request) {
  v1::GetServerInfoResponse response;
  response.set_software_version(AXISCAL_VERSION);
  response.set_schema_version(core.database.schema_version());
  response.set_max_chunk_readings(records::kMaxChunkReadings);
  response.set_max_message_bytes(kMaxMessageBytes);
  response.set_window_chunks(core.limits.window_chunks);
  response.set_open_uploads(core.held.count(HeldKind::kUpload));
  response.set_max_uploads(core.limits.held.max_uploads);
  response.set_workers(core.workers);
  response.set_draining(core.draining);
  return response;
}

}  // namespace axiscal::handlers
