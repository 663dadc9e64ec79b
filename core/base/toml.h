// The values of a TOML file with their places, as the library toml++ reads them; who reads a configuration says which
// keys there are.
#ifndef AXISCAL_CORE_BASE_TOML_H_
#define AXISCAL_CORE_BASE_TOML_H_

#include <cstdint>
#include <string>
#include <variant>
#include <vector>

#include "core/base/status.h"

namespace axiscal::base {

struct TomlTable {};   // its keys follow
struct TomlTables {};  // [[NAME]]: a TomlTable "NAME[0]" follows, with its keys, and so on
struct TomlOther {};   // a list, a time, a number with a point

struct TomlValue {
  std::string key;    // with its tables: "server.listen", "watch[1].folder"
  std::string place;  // "axiscald.toml:4"
  std::variant<std::string, int64_t, bool, TomlTable, TomlTables, TomlOther> value;
};

// In the order of tables and names. INVALID_ARGUMENT "PATH:LINE: ..." for what is no TOML.
absl::StatusOr<std::vector<TomlValue>> ReadTomlValues(const std::string& text, const std::string& path);

}  // namespace axiscal::base

#endif  // AXISCAL_CORE_BASE_TOML_H_
