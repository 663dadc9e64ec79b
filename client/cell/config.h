// The configuration of axiscal-cell: one TOML file (docs/cell.md).
#ifndef AXISCAL_CLIENT_CELL_CONFIG_H_
#define AXISCAL_CLIENT_CELL_CONFIG_H_

#include <chrono>
#include <string>
#include <vector>

#include "client/options.h"
#include "client/spool/spool.h"

namespace axiscal::cell {

// One folder that is looked through.
struct Watch {
  std::string place;         // where it stands: "cell.toml:12"
  std::string folder;        // of this machine, or mounted from another one
  std::string files = "*";   // names that are meant, with * ? [..]
  std::string machine;       // whose logs; of session files empty: the header says it
  std::string log_template;  // a file, or the name of a known format; empty: these are session files
  std::string plan;          // a file; empty: none
  std::string end_line;      // a file whose last line this is is whole; empty: time alone tells
  bool removes = false;      // files that the server has
};

struct Config {
  std::string server;  // address as gRPC takes it
  client::Options client = {};
  spool::SpoolOptions spool = {};
  std::string name;  // by which the service knows it; the machine's host name where it is not set
  // The service raises an event when it has heard nothing for so long.
  std::chrono::minutes silent_after = std::chrono::minutes(15);
  std::string status_file;  // empty: "status.json" in the spool
  std::chrono::milliseconds look_every = std::chrono::seconds(10);
  // A file is whole when size and time have not changed for so long.
  std::chrono::milliseconds settle = std::chrono::seconds(10);
  // Waits between attempts: random, up to a limit that doubles from the first to the last.
  std::chrono::milliseconds first_wait = std::chrono::seconds(1), last_wait = std::chrono::minutes(5);
  std::vector<Watch> watches;
};

// INVALID_ARGUMENT that names place, key, value and rule. Relative files are looked for beside `path`.
absl::StatusOr<Config> ReadConfig(const std::string& text, const std::string& path);

// How a file is called on the server: its name without folders; bytes that are no UTF-8 (names in Latin-1, from old
// controls) and control characters as "%E9", so that two names stay two.
std::string NameOf(const std::string& path);

// What a log of this folder is sent with, as template and plan are now. Errors of reading them.
absl::StatusOr<spool::Item> ItemOf(const Watch& watch, const std::string& file);

}  // namespace axiscal::cell

#endif  // AXISCAL_CLIENT_CELL_CONFIG_H_
