// Who may read a database: its owner (FileLock makes the file so). SQLite gives "FILE-wal" and "FILE-shm" the rights of
// FILE.
#ifndef AXISCAL_SERVER_STORAGE_FILE_MODE_H_
#define AXISCAL_SERVER_STORAGE_FILE_MODE_H_

#include <string>
#include <vector>

namespace axiscal::storage {

// Of the database and what stands beside it, the files that everybody on the machine may read or write: "FILE (0644)".
std::vector<std::string> OpenToOthers(const std::string& path);

}  // namespace axiscal::storage

#endif  // AXISCAL_SERVER_STORAGE_FILE_MODE_H_
