#include "core/session/write_session.h"

#include <charconv>
#include <cmath>

#include "core/base/files.h"
#include "core/session/validate.h"

namespace axiscal::session {
namespace {

void AppendNumber(double number, std::string& text) {
  if (std::isnan(number)) return;  // an empty cell
  char digits[32];
  const auto [end, error] = std::to_chars(digits, digits + sizeof(digits), number);
  text.append(digits, end);
}

}  // namespace

absl::StatusOr<std::string> WriteSession(const Session& session) {
  RETURN_IF_ERROR(Validate(session));
  std::string text;
  for (const HeaderEntry& entry : session.header) absl::StrAppend(&text, "# ", entry.key, ": ", entry.value, "\n");
  for (size_t i = 0; i < session.columns.size(); ++i) {
    absl::StrAppend(&text, i == 0 ? "" : ",", session.columns[i].name);
  }
  text += '\n';
  const size_t readings = session.reading_count();
  for (size_t row = 0; row < readings; ++row) {
    for (size_t i = 0; i < session.columns.size(); ++i) {
      const Column& column = session.columns[i];
      if (i > 0) text += ',';
      if (column.texts.empty()) {
        AppendNumber(column.values[row], text);
      } else {
        text += column.texts[row];
      }
    }
    text += '\n';
  }
  return text;
}

absl::Status WriteSessionFile(const Session& session, const std::string& path) {
  ASSIGN_OR_RETURN(const std::string text, WriteSession(session));
  return base::WriteFileAtomically(path, text);
}

}  // namespace axiscal::session
