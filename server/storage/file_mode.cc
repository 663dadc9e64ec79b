#include "server/storage/file_mode.h"

#include <sys/stat.h>

#include <filesystem>

#include "absl/strings/str_format.h"

namespace axiscal::storage {

std::vector<std::string> OpenToOthers(const std::string& path) {
  // What SQLite makes stands beside the file itself, not beside a symbolic link to it.
  std::error_code unknown;
  const std::filesystem::path file_itself = std::filesystem::canonical(path, unknown);
  std::vector<std::string> open_files;
  for (const char* suffix : {"", "-wal", "-shm"}) {
    struct stat info;
    const std::string file = (unknown ? path : file_itself.string()) + suffix;
    if (stat(file.c_str(), &info) != 0 || (info.st_mode & (S_IROTH | S_IWOTH)) == 0) continue;
    open_files.push_back(absl::StrFormat("%s (%04o)", file, info.st_mode & 07777u));
  }
  return open_files;
}

}  // namespace axiscal::storage
