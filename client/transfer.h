// Downloads of sessions and programs, and programs' upload: streams that are resumed or checked at the end. Internal to
// the client.
#ifndef AXISCAL_CLIENT_TRANSFER_H_
#define AXISCAL_CLIENT_TRANSFER_H_

#include "client/client.h"

namespace axiscal::client {

class Connection;

absl::StatusOr<session::Session> DownloadSession(const Connection& connection, SessionId id);

// Bytes from an offset on, at most so many; empty at the end.
using ReadAt = std::function<absl::StatusOr<std::string>(int64_t offset, int64_t bytes)>;
struct ProgramSource {
  std::string name;
  int64_t size = 0;  // bytes
  std::string sha256;
  ReadAt read_at;
};
absl::StatusOr<ProgramRecord> PutProgram(const Connection& connection, const ProgramSource& source,
                                         const ProgressCallback& progress);

absl::StatusOr<records::StoredLog> PutLog(const Connection& connection, const MachineId& machine,
                                          const std::string& name, const std::string& bytes,
                                          const records::LogForm& form);

using TakeBytes = std::function<absl::Status(const std::string& bytes)>;
absl::StatusOr<ProgramRecord> GetProgram(const Connection& connection, ProgramId id, const TakeBytes& take,
                                         const ProgressCallback& progress);

// Writes on a thread of its own, reads and takes on this one.
absl::StatusOr<std::string> RewriteProgram(const Connection& connection, const records::CompensateParams& params,
                                           const ProgramSource& source, const TakeBytes& take);

// Size, checksum and bytes of a file, without holding it. NOT_FOUND when it cannot be read.
absl::StatusOr<ProgramSource> FileSource(const std::string& path);

}  // namespace axiscal::client

#endif  // AXISCAL_CLIENT_TRANSFER_H_
