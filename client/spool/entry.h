// One file on its way to the server, as it stands in a spool: a folder with the file's bytes and what is to be done
// with them.
#ifndef AXISCAL_CLIENT_SPOOL_ENTRY_H_
#define AXISCAL_CLIENT_SPOOL_ENTRY_H_

#include <cstdint>
#include <map>
#include <string>

#include "core/base/status.h"
#include "core/records/log.h"

namespace axiscal::spool {

// What is to be sent, without its bytes.
struct Item {
  bool is_log = false;          // a controller's log; else a session file
  std::string machine;          // empty, of a session file: the one that its header names
  std::string name;             // the file's, without folders
  std::string source = {};      // where it was found; empty: nowhere
  bool removes_source = false;  // once the server has it, unless it is another file by then
  records::LogForm form = {};   // of a log: how it is read

  bool operator==(const Item&) const = default;
};

struct Entry {
  int64_t number = 0;  // counts: entries are sent in this order, whatever the clock says
  std::string id;      // 64 hexadecimal digits of item and bytes: the same is one entry
  Item item;
  std::string sha256;  // of the bytes
  int64_t size_bytes = 0;
};

// The same for the same item and bytes; where it was found does not count.
std::string EntryId(const Item& item, const std::string& sha256);

// All but template and plan, which stand in files of their own. INVALID_ARGUMENT.
std::string WriteEntry(const Entry& entry);
absl::StatusOr<Entry> ReadEntry(const std::string& json);

// Why the server did not take it, or that it did: facts by name, texts.
using Note = std::map<std::string, std::string>;
std::string WriteNote(const Note& note);
absl::StatusOr<Note> ReadNote(const std::string& json);

}  // namespace axiscal::spool

#endif  // AXISCAL_CLIENT_SPOOL_ENTRY_H_
