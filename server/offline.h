// What axiscald does with a database that no server has: `axiscald check | restore | compact | copy`. Each prints what
// it found and returns the exit code of the process: 0, 1 where it could not be done, kDamaged where something is
// damaged.
#ifndef AXISCAL_SERVER_OFFLINE_H_
#define AXISCAL_SERVER_OFFLINE_H_

#include <string>

namespace axiscal::server {

inline constexpr int kDamaged = 2;

int CheckOffline(const std::string& path);
// `take_damaged`: also a backup in which something is damaged.
int RestoreOffline(const std::string& backup, const std::string& path, bool take_damaged);
int CompactOffline(const std::string& path);
// storage::CopyStoreTo(), which goes on where it was broken off.
int CopyOffline(const std::string& from, const std::string& to);

}  // namespace axiscal::server

#endif  // AXISCAL_SERVER_OFFLINE_H_
