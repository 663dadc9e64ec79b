// Rows of `program` and `program_part`: byte strings of any size, stored in parts and named by their content. What each
// function returns: database.h.
#ifndef AXISCAL_SERVER_STORAGE_PROGRAMS_H_
#define AXISCAL_SERVER_STORAGE_PROGRAMS_H_

#include <optional>
#include <string>
#include <vector>

#include "server/storage/connection.h"
#include "server/storage/records.h"

namespace axiscal::storage {

inline constexpr size_t kMaxPartBytes = 4 << 20;

struct EncodedPart {
  int64_t first_byte = 0;
  int64_t byte_count = 0;
  uint32_t crc32c = 0;  // of the bytes
  std::string content;  // the bytes, zstd
};

// What can be done before the writer's turn.
absl::StatusOr<EncodedPart> PreparePart(int64_t offset, const std::string& bytes);

// `damaged`: programs of that request that do not count.
absl::StatusOr<ProgramRecord> BeginProgram(Connection& connection, const Moment& now, const NewProgram& program,
                                           const std::vector<ProgramId>& damaged);
absl::StatusOr<ProgramRecord> AppendProgram(Connection& connection, const Moment& now, ProgramId id,
                                            const EncodedPart& part);
// The complete program of that content, if there is one.
absl::StatusOr<std::optional<ProgramId>> FindContent(Connection& connection, const std::string& sha256,
                                                     const std::string& kind);
// `sha256`: of the first `byte_count` bytes, as the caller has computed it from the parts. `damaged`: the program of
// this content, where it was found to have other bytes by now: it gets these parts.
absl::StatusOr<ProgramRecord> FinishProgram(Connection& connection, ProgramId id, int64_t byte_count,
                                            const std::string& sha256, std::optional<ProgramId> damaged);
absl::StatusOr<ProgramRecord> GetProgram(Connection& connection, ProgramId id);
absl::StatusOr<Page<ProgramRecord>> ListPrograms(Connection& connection, const ProgramFilter& filter,
                                                 const PageRequest& request, const Visible& visible);
absl::StatusOr<int> ExpirePrograms(Connection& connection, const Moment& now, std::chrono::microseconds idle);

// The part that holds byte `offset`, from that byte on; nothing at the end.
absl::StatusOr<std::optional<std::string>> ReadPart(Connection& connection, const ProgramRecord& program,
                                                    int64_t offset);

}  // namespace axiscal::storage

#endif  // AXISCAL_SERVER_STORAGE_PROGRAMS_H_
