#include "server/handlers/session_check.h"

#include <algorithm>
#include <cmath>
#include <optional>
#include <set>
#include <utility>

#include "core/base/error_detail.h"
#include "core/instruments/plausible.h"
#include "core/instruments/tracker/tracker_run.h"
#include "core/machine/machine_json.h"
#include "core/session/check_machine.h"
#include "core/session/header_rules.h"
#include "core/session/text.h"
#include "core/toolsetter/evaluate.h"

namespace axiscal::handlers {
namespace {

absl::Status Invalid(const absl::Status& status, const std::string& field) {
  if (status.ok()) return status;
  const std::string message(status.message());
  return base::Error(absl::StatusCode::kInvalidArgument, message,
                     {"SESSION_INVALID", {{"field", field}, {"rule", message}}});
}

session::Session WithoutReadings(const records::SessionSchema& schema) {
  session::Session session{schema.header, {}};
  for (const records::ColumnSpec& column : schema.columns) session.columns.push_back({column.name, {}, {}});
  return session;
}

// Whether nothing is wrong with any of them, told faster than what is wrong with which. Empty cells may look wrong.
bool AllFit(const session::ColumnRule& rule, const std::vector<double>& values, double earlier_s) {
  bool all_fit = !rule.IsSense();
  for (const double number : values) all_fit &= (number >= rule.min) & (number <= rule.max);
  if (rule.kind != session::ColumnKind::kTime || values.empty()) return all_fit;
  all_fit &= values[0] >= earlier_s;
  for (size_t i = 1; i < values.size(); ++i) all_fit &= values[i] >= values[i - 1];
  return all_fit;
}

std::vector<std::string> NamesOf(const std::vector<records::ColumnSpec>& columns) {
  std::vector<std::string> names;
  for (const records::ColumnSpec& column : columns) names.push_back(column.name);
  return names;
}

// What the headers of a tracker are held against: the first reading of each target, and the last of all. A session may
// have millions of readings, and a hostile one as many targets.
class Sights {
 public:
  void See(const std::vector<session::Column>& columns) {
    const session::Column *times = nullptr, *targets = nullptr;
    for (const session::Column& column : columns) {
      if (column.name == "t_s") times = &column;
      if (column.name == "target") targets = &column;
    }
    if (targets == nullptr || targets->texts.empty()) return;
    const std::vector<std::string>& names = targets->texts;
    const auto time_of = [times](size_t row) {
      return times == nullptr ? std::optional<double>() : times->values[row];
    };
    // Two more than headers may state: a session with so many is refused, whatever the others are.
    constexpr size_t kMost = tracker::kMostTargets + tracker::kMostReferences + 2;
    for (size_t row = 0; row < names.size(); ++row)
      if (seen_.size() < kMost && seen_.insert(names[row]).second) Add(names[row], time_of(row));
    last_ = {names.back(), time_of(names.size() - 1)};
  }

  // A session with these readings alone.
  session::Session Take(const std::vector<session::HeaderEntry>& header) {
    if (!seen_.empty()) Add(last_.first, last_.second);
    session::Session session{header, {{"target", {}, std::move(names_)}}};
    if (!times_s_.empty()) session.columns.push_back({"t_s", std::move(times_s_), {}});
    return session;
  }

 private:
  void Add(const std::string& name, std::optional<double> time_s) {
    names_.push_back(name);
    if (time_s) times_s_.push_back(*time_s);
  }

  std::set<std::string> seen_;
  std::vector<std::string> names_;
  std::vector<double> times_s_;
  std::pair<std::string, std::optional<double>> last_;
};

// Headers that speak of all readings, once those are there. Only a tracker's do, by the targets that it read.
absl::Status CheckWhole(Core& core, SessionId id, const records::SessionTotals& totals) {
  ASSIGN_OR_RETURN(const records::SessionRecord record, core.database.GetSession(id));
  const bool has_targets = std::any_of(record.columns.begin(), record.columns.end(),
                                       [](const records::ColumnSpec& column) { return column.name == "target"; });
  if (!has_targets || record.state != records::SessionState::kOpen || record.reading_count != totals.reading_count)
    return absl::OkStatus();
  Sights sights;
  RETURN_IF_ERROR(core.database.ReadChunks(id, 0, [&](const records::Chunk& chunk) {
    sights.See(chunk.columns());
    return absl::OkStatus();
  }));
  return Invalid(instruments::CheckWhole(sights.Take(record.header)), "schema.header");
}

// When it was measured, by its header `started` (ISO 8601; without a zone it is UTC); nothing when it does not say.
std::optional<base::UtcTime> StartedAt(const session::Session& session) {
  const std::optional<std::string> started = session::FindHeader(session, "started");
  if (!started) return std::nullopt;
  return session::ParseIso8601(*started);
}

}  // namespace

absl::StatusOr<machine::Machine> MachineOf(Core& core, const MachineId& id) {
  ASSIGN_OR_RETURN(const records::MachineRecord record, core.database.GetMachine(id));
  if (record.deleted_at) {
    return base::Error(absl::StatusCode::kFailedPrecondition, "machine " + id.text() + " is deleted",
                       {"MACHINE_DELETED", {}});
  }
  return machine::MachineFromJson(record.description_json);
}

absl::Status CheckSchema(Core& core, const MachineId& machine_id, const records::SessionSchema& schema) {
  ASSIGN_OR_RETURN(const machine::Machine machine, MachineOf(core, machine_id));
  RETURN_IF_ERROR(Invalid(session::ValidateHeader(schema.header), "schema.header"));
  const absl::StatusOr<std::vector<session::ColumnRule>> rules =
      session::ColumnRules(schema.header, NamesOf(schema.columns));
  RETURN_IF_ERROR(Invalid(rules.status(), "schema.columns"));
  for (size_t i = 0; i < rules->size(); ++i) {
    const bool is_text = (*rules)[i].kind == session::ColumnKind::kName;
    if (is_text == schema.columns[i].is_text) continue;
    return Invalid(absl::InvalidArgumentError(schema.columns[i].name + (is_text ? " holds texts" : " holds numbers")),
                   absl::StrCat("schema.columns[", i, "].kind"));
  }
  RETURN_IF_ERROR(Invalid(toolsetter::CheckHeader(WithoutReadings(schema)), "schema.header"));
  return Invalid(session::CheckAgainstMachine(WithoutReadings(schema), machine), "schema");
}

absl::StatusOr<ReadingCheck> ReadingCheck::Create(Core& core, const records::SessionRecord& session,
                                                  int64_t first_seq) {
  const std::vector<std::string> names = NamesOf(session.columns);
  ASSIGN_OR_RETURN(std::vector<session::ColumnRule> rules, session::ColumnRules(session.header, names));
  ASSIGN_OR_RETURN(machine::Machine machine, MachineOf(core, session.machine));
  ASSIGN_OR_RETURN(session::MachineCheck machine_check, session::MachineCheck::Create(session.header, names, machine));
  ReadingCheck check(session.header, std::move(rules), std::move(machine), std::move(machine_check));
  if (first_seq == 0) return check;
  // Resumed: the last reading that stands says how far time had run.
  int64_t tail_readings = 0;
  RETURN_IF_ERROR(core.database.ReadChunks(session.id, first_seq - 1, [&](const records::Chunk& chunk) {
    if (chunk.seq() >= first_seq) {
      tail_readings += chunk.reading_count();
    } else {
      check.SeeTime(chunk.columns());
    }
    return absl::OkStatus();
  }));
  check.first_reading_ = static_cast<size_t>(std::max<int64_t>(0, session.reading_count - tail_readings));
  return check;
}

absl::Status ReadingCheck::Check(const records::Chunk& chunk) {
  const std::vector<session::Column>& columns = chunk.columns();
  for (size_t i = 0; i < columns.size(); ++i) RETURN_IF_ERROR(Invalid(CheckColumn(columns[i], i), "chunk"));
  const absl::Status travel = machine_check_.Check(columns);
  if (!travel.ok()) {
    return Invalid(base::Within(absl::StrCat("readings from ", first_reading_ + 1, " on"), travel), "chunk");
  }
  part_.columns = columns;
  RETURN_IF_ERROR(Invalid(instruments::CheckPlausible(part_, machine_, first_reading_), "chunk"));
  SeeTime(columns);
  first_reading_ += static_cast<size_t>(chunk.reading_count());
  return absl::OkStatus();
}

void ReadingCheck::SeeTime(const std::vector<session::Column>& columns) {
  for (const session::Column& column : columns) {
    if (column.name == "t_s") last_time_s_ = column.values.back();
  }
}

absl::Status ReadingCheck::CheckColumn(const session::Column& column, size_t index) {
  const session::ColumnRule& rule = rules_[index];
  const auto place = [&](size_t i) {
    return session::Place(session::ReadingLine(part_.header.size(), first_reading_ + i), index, column.name);
  };
  for (size_t i = 0; i < column.texts.size(); ++i) {
    RETURN_IF_ERROR(base::Within(place(i), session::CheckName(rule, column.texts[i])));
  }
  double earlier_s = last_time_s_.value_or(-std::numeric_limits<double>::infinity());
  if (AllFit(rule, column.values, earlier_s)) return absl::OkStatus();
  for (size_t i = 0; i < column.values.size(); ++i) {
    const double number = column.values[i];
    if (!rule.Fits(number) && !(rule.may_be_empty && std::isnan(number))) {
      return absl::InvalidArgumentError(absl::StrFormat("%s: %g, expected %s", place(i), number, rule.expected));
    }
    if (rule.kind != session::ColumnKind::kTime) continue;
    if (number < earlier_s) {
      return absl::InvalidArgumentError(
          absl::StrFormat("%s: %.12g, expected at least %.12g: time never runs back", place(i), number, earlier_s));
    }
    earlier_s = number;
  }
  return absl::OkStatus();
}

absl::StatusOr<records::SessionRecord> FinishChecked(Core& core, SessionId id, const records::SessionTotals& totals) {
  if (totals.reading_count == 0) {
    return Invalid(absl::InvalidArgumentError("no readings, expected at least one"), "totals.readings");
  }
  RETURN_IF_ERROR(CheckWhole(core, id, totals));
  ASSIGN_OR_RETURN(records::SessionRecord record, core.database.FinishSession(id, totals));
  core.run_soon(record.machine);
  return record;
}

storage::NewSession NewSessionOf(const MachineId& machine, const records::SessionSchema& schema,
                                 const storage::Caller& caller) {
  const session::Session head{schema.header, {}};
  storage::NewSession session;
  session.machine = machine;
  session.name = session::FindHeader(head, "session").value_or("");
  session.instrument = session::FindHeader(head, "instrument").value_or("");
  session.header = schema.header;
  session.measured_at = StartedAt(head);
  session.columns = schema.columns;
  session.caller = caller;
  return session;
}

}  // namespace axiscal::handlers
