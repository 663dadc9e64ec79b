#include "core/session/read_session.h"

#include <sys/stat.h>

#include <algorithm>
#include <cerrno>
#include <cstring>
#include <fstream>
#include <sstream>

#include "core/session/column_rules.h"
#include "core/session/line_reader.h"
#include "core/session/row_parser.h"
#include "core/session/text.h"

namespace axiscal::session {
namespace {

absl::Status Refuse(size_t line, const std::string& what) {
  return absl::InvalidArgumentError(absl::StrCat("line ", line, ": ", what));
}

absl::Status ReadHeader(LineReader& reader, Session& session, Line& line) {
  ASSIGN_OR_RETURN(session.header, ReadHeaderLines(reader, &line));
  if (session.header.empty()) {
    return Refuse(1, absl::StrCat(Quoted(std::string(line.text)), ", expected header lines '# key: value' first"));
  }
  return ValidateHeader(session.header);
}

void LeaveOutReadings(Session& session) {
  const InstrumentFormat* const format = FindInstrumentFormat(*FindHeader(session, "instrument"));
  std::erase_if(session.columns, [&](const Column& column) {
    return std::any_of(format->columns.begin(), format->columns.end(), [&](const ReadingColumn& reading) {
      return reading.name == column.name && reading.source != ColumnSource::kPlan;
    });
  });
}

absl::StatusOr<Session> Read(std::istream& in, SessionKind kind) {
  LineReader reader(in);
  Session session;
  Line line;
  RETURN_IF_ERROR(ReadHeader(reader, session, line));
  const std::vector<std::string> names = SplitCells(line.text);
  ASSIGN_OR_RETURN(const std::vector<ColumnRule> rules, ColumnRules(session.header, names, kind));
  for (const std::string& name : names) session.columns.push_back({name, {}, {}});
  RowParser rows(rules, session.columns);
  size_t readings = 0;
  for (;; ++readings) {
    ASSIGN_OR_RETURN(const bool more, reader.Next(&line));
    if (!more) break;
    RETURN_IF_ERROR(CheckLineEnd(line));
    RETURN_IF_ERROR(rows.Add(line));
  }
  if (readings == 0) return Refuse(line.number, "no readings follow the column names, expected at least one");
  if (kind == SessionKind::kPlan) LeaveOutReadings(session);
  return session;
}

absl::StatusOr<Session> ReadNamed(std::istream& in, const std::string& name, SessionKind kind) {
  auto session = Read(in, kind);
  if (!session.ok()) return base::Within(name, session.status());
  return session;
}

absl::StatusOr<Session> ReadFile(const std::string& path, SessionKind kind) {
  struct stat info;
  if (stat(path.c_str(), &info) != 0) {
    const std::string what = absl::StrCat(path, ": ", std::strerror(errno));
    return errno == ENOENT ? absl::NotFoundError(what) : absl::InvalidArgumentError(what);
  }
  if (!S_ISREG(info.st_mode)) return absl::InvalidArgumentError(path + ": is not a file, expected a session file");
  if (static_cast<size_t>(info.st_size) > kMaxSessionBytes) {
    return absl::InvalidArgumentError(absl::StrCat(path, ": ", info.st_size, " bytes, a session file has at most ",
                                                   kMaxSessionBytes, " (", kMaxSessionBytes >> 20,
                                                   " MB): split the session"));
  }
  std::ifstream in(path, std::ios::binary);
  if (!in) return absl::InvalidArgumentError(absl::StrCat(path, ": ", std::strerror(errno)));
  return ReadNamed(in, path, kind);
}

}  // namespace

absl::StatusOr<Session> ReadSession(std::istream& in, const std::string& name) {
  return ReadNamed(in, name, SessionKind::kMeasured);
}

absl::StatusOr<Session> ReadSessionText(const std::string& text, const std::string& name) {
  std::istringstream in(text);
  return ReadSession(in, name);
}

absl::StatusOr<Session> ReadSessionFile(const std::string& path) { return ReadFile(path, SessionKind::kMeasured); }

absl::StatusOr<Session> ReadPlanText(const std::string& text, const std::string& name) {
  std::istringstream in(text);
  return ReadNamed(in, name, SessionKind::kPlan);
}

absl::StatusOr<Session> ReadPlanFile(const std::string& path) { return ReadFile(path, SessionKind::kPlan); }

}  // namespace axiscal::session
