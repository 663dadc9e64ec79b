// Whole files in and out.
#ifndef AXISCAL_CORE_BASE_FILES_H_
#define AXISCAL_CORE_BASE_FILES_H_

#include <string>

#include "core/base/status.h"

namespace axiscal::base {

// The file's bytes. NOT_FOUND when there is none; INVALID_ARGUMENT when it is no file or has more than `max_bytes`
// (refused before reading).
absl::StatusOr<std::string> ReadFile(const std::string& path, size_t max_bytes);

// Writes a new file beside `path`, syncs it and renames it over `path`: a reader sees the old bytes or the new ones,
// never half of them, and after an error or a crash `path` is what it was. INVALID_ARGUMENT when the folder cannot be
// written, RESOURCE_EXHAUSTED on a full disk.
absl::Status WriteFileAtomically(const std::string& path, const std::string& bytes);

}  // namespace axiscal::base

#endif  // AXISCAL_CORE_BASE_FILES_H_
