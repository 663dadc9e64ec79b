// One measuring session as its file holds it (docs/formats.md, "Measuring session"): header entries, then named columns
// of equal length in time order. This is also the form in which sessions travel and are stored; instruments give the
// columns their meaning.
#ifndef AXISCAL_CORE_SESSION_SESSION_H_
#define AXISCAL_CORE_SESSION_SESSION_H_

#include <algorithm>
#include <optional>
#include <string>
#include <vector>

#include "core/base/status.h"

namespace axiscal::session {

// `# key: value`; order and unknown keys are kept. A key may repeat (`# plane NAME: ...` has the key "plane NAME").
struct HeaderEntry {
  std::string key;
  std::string value;

  bool operator==(const HeaderEntry&) const = default;
};

// One column in the file's own unit (the suffix of its name says which: _mm _deg _s _C _um). A text column (`feature`,
// `rod`) has `texts` instead of `values`. An empty cell, where the instrument allows one, is NaN.
struct Column {
  std::string name;
  std::vector<double> values;
  std::vector<std::string> texts;

  bool operator==(const Column&) const = default;
};

struct Session {
  std::vector<HeaderEntry> header;
  std::vector<Column> columns;

  size_t reading_count() const {
    return columns.empty() ? 0 : std::max(columns[0].values.size(), columns[0].texts.size());
  }
  bool operator==(const Session&) const = default;
};

// The value of the first entry with `key`, or nothing.
std::optional<std::string> FindHeader(const Session& session, const std::string& key);
// The column, or nullptr.
const Column* FindColumn(const Session& session, const std::string& name);

}  // namespace axiscal::session

#endif  // AXISCAL_CORE_SESSION_SESSION_H_
