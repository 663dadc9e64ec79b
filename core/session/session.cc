#include "core/session/session.h"

namespace axiscal::session {

std::optional<std::string> FindHeader(const Session& session, const std::string& key) {
  for (const HeaderEntry& entry : session.header) {
    if (entry.key == key) return entry.value;
  }
  return std::nullopt;
}

const Column* FindColumn(const Session& session, const std::string& name) {
  for (const Column& column : session.columns) {
    if (column.name == name) return &column;
  }
  return nullptr;
}

}  // namespace axiscal::session
