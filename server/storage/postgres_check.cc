#include "server/storage/postgres_check.h"

#include <map>
#include <regex>
#include <utility>
#include <vector>

#include "absl/strings/match.h"
#include "absl/strings/str_cat.h"

namespace axiscal::storage {
namespace {

// "table job", "index job_running" and the table they belong to.
using Objects = std::map<std::string, std::string>;

void Forget(Objects& objects, const std::string& table) {
  std::erase_if(objects, [&](const auto& object) { return object.second == table; });
}

void Rename(Objects& objects, const std::string& from, const std::string& to) {
  objects.erase("table " + from);
  objects["table " + to] = to;
  for (auto& [name, table] : objects) {
    if (table == from) table = to;
  }
}

// What the migrations have made and left, told by their own statements.
Objects ObjectsOf(const std::vector<Migration>& migrations) {
  static const auto& statement = *new std::regex(
      "CREATE TABLE (\\w+)|CREATE (?:UNIQUE )?INDEX (\\w+)\\s+ON (\\w+)|CREATE TRIGGER (\\w+)\\s[^;]*?\\sON (\\w+)|"
      "CREATE FUNCTION (\\w+)|DROP TABLE (\\w+)|ALTER TABLE (\\w+) RENAME TO (\\w+)|DROP INDEX (\\w+)|"
      "DROP TRIGGER (\\w+)");
  Objects objects;
  for (const Migration& migration : migrations) {
    for (std::sregex_iterator found(migration.sql.begin(), migration.sql.end(), statement), end; found != end;
         ++found) {
      const std::smatch& m = *found;
      if (m[1].matched) objects["table " + m.str(1)] = m.str(1);
      if (m[2].matched) objects["index " + m.str(2)] = m.str(3);
      if (m[4].matched) objects["trigger " + m.str(4)] = m.str(5);
      if (m[6].matched) objects["function " + m.str(6)] = "";
      if (m[7].matched) Forget(objects, m.str(7));
      if (m[8].matched) Rename(objects, m.str(8), m.str(9));
      if (m[10].matched) objects.erase("index " + m.str(10));
      if (m[11].matched) objects.erase("trigger " + m.str(11));
    }
  }
  return objects;
}

// name, table, whether it works; of what no constraint and no extension has made. Of the tables of chunk's ranges,
// which the server makes as sessions come (migration 0024), and of those that were detached, only what does not work.
constexpr char kObjects[] = R"(WITH own AS (SELECT c.oid, CAST(c.relname AS TEXT) AS name, c.relkind,
  c.relispartition OR c.relname ~ '^chunk_range_[0-9]+$' AS is_range
FROM pg_class AS c WHERE c.relnamespace = CAST(current_schema() AS regnamespace))
SELECT 'table ' || name, name, true FROM own WHERE relkind IN ('r', 'p', 'f', 'v', 'm') AND NOT is_range
UNION ALL SELECT 'index ' || c.name, t.name, i.indisvalid AND i.indisready
FROM pg_index AS i JOIN own AS c ON c.oid = i.indexrelid JOIN own AS t ON t.oid = i.indrelid
WHERE NOT i.indisvalid OR NOT (t.is_range OR EXISTS (SELECT 1 FROM pg_constraint WHERE conindid = c.oid))
UNION ALL SELECT CAST('trigger ' || g.tgname AS TEXT), t.name, g.tgenabled IN ('O', 'A')
FROM pg_trigger AS g JOIN own AS t ON t.oid = g.tgrelid
WHERE g.tgenabled NOT IN ('O', 'A') OR NOT (t.is_range OR g.tgisinternal)
UNION ALL SELECT CAST('constraint ' || n.conname AS TEXT), CAST(t.relname AS TEXT), false
FROM pg_constraint AS n JOIN pg_class AS t ON t.oid = n.conrelid
WHERE n.connamespace = CAST(current_schema() AS regnamespace) AND NOT n.convalidated
ORDER BY 1)";

absl::Status CheckFunctions(Connection& connection, const std::vector<Migration>& migrations, Objects& expected,
                            const NoteDamage& tell) {
  std::string texts;
  for (const Migration& migration : migrations) texts += migration.sql;
  ASSIGN_OR_RETURN(Statement row,
                   connection.Ask("SELECT CAST(proname AS TEXT), CAST(prosrc AS TEXT) FROM pg_proc WHERE "
                                  "pronamespace = CAST(current_schema() AS regnamespace) ORDER BY 1"));
  Objects found;
  while (true) {
    ASSIGN_OR_RETURN(const bool more, row.Step());
    if (!more) break;
    const std::string name = "function " + row.Text(0);
    found[name] = "";
    if (!expected.contains(name)) {
      tell("schema", name + " is none of the migrations'");
    } else if (!absl::StrContains(texts, row.Text(1))) {
      tell("schema", name + " is not what the migrations made");
    }
  }
  for (const auto& [name, table] : expected) {
    if (absl::StartsWith(name, "function ") && !found.contains(name)) tell("schema", name + " is not there");
  }
  return absl::OkStatus();
}

// Of one foreign key: the statement that finds rows which name nothing.
struct Reference {
  std::string table, target, orphans;
};

absl::StatusOr<std::vector<Reference>> ListReferences(Connection& connection) {
  ASSIGN_OR_RETURN(Statement row, connection.Ask(R"(SELECT CAST(c.relname AS TEXT), CAST(t.relname AS TEXT),
  'SELECT count(*) FROM ' || quote_ident(c.relname) || ' AS c WHERE ' ||
  string_agg('c.' || quote_ident(a.attname) || ' IS NOT NULL', ' AND ' ORDER BY k.place) ||
  ' AND NOT EXISTS (SELECT 1 FROM ' || quote_ident(t.relname) || ' AS t WHERE ' ||
  string_agg('t.' || quote_ident(b.attname) || ' = c.' || quote_ident(a.attname), ' AND ' ORDER BY k.place) || ')'
FROM pg_constraint AS n JOIN pg_class AS c ON c.oid = n.conrelid JOIN pg_class AS t ON t.oid = n.confrelid
JOIN LATERAL unnest(n.conkey, n.confkey) WITH ORDINALITY AS k (from_key, to_key, place) ON true
JOIN pg_attribute AS a ON a.attrelid = n.conrelid AND a.attnum = k.from_key
JOIN pg_attribute AS b ON b.attrelid = n.confrelid AND b.attnum = k.to_key
WHERE n.contype = 'f' AND n.conparentid = 0 AND n.connamespace = CAST(current_schema() AS regnamespace)
GROUP BY n.oid, n.conname, c.relname, t.relname ORDER BY c.relname, n.conname)"));
  std::vector<Reference> references;
  while (true) {
    ASSIGN_OR_RETURN(const bool more, row.Step());
    if (!more) return references;
    references.push_back({row.Text(0), row.Text(1), row.Text(2)});
  }
}

}  // namespace

absl::Status CheckPostgresObjects(Connection& connection, const std::vector<Migration>& migrations,
                                  const NoteDamage& tell) {
  Objects expected = ObjectsOf(migrations);
  RETURN_IF_ERROR(CheckFunctions(connection, migrations, expected, tell));
  std::erase_if(expected, [](const auto& object) { return absl::StartsWith(object.first, "function "); });
  ASSIGN_OR_RETURN(Statement row, connection.Ask(kObjects));
  while (true) {
    ASSIGN_OR_RETURN(const bool more, row.Step());
    if (!more) break;
    const std::string name = row.Text(0), table = row.Text(1);
    const auto at = expected.find(name);
    const std::string place = absl::StrCat(name, table.empty() || name == "table " + table ? "" : " of table " + table);
    if (!row.Bool(2)) {
      tell("schema", place + " is switched off or not valid");
    } else if (at == expected.end()) {
      tell("schema", place + " is none of the migrations'");
    } else if (at->second != table) {
      tell("schema", absl::StrCat(place, " belongs to table ", at->second));
    }
    // One of a range that is switched off has the name of the one that stands for all ranges.
    if (at != expected.end() && (row.Bool(2) || at->second == table)) expected.erase(at);
  }
  for (const auto& [name, table] : expected) tell("schema", name + " is not there");
  return absl::OkStatus();
}

absl::Status CheckPostgresReferences(Connection& connection, const NoteDamage& tell) {
  ASSIGN_OR_RETURN(const std::vector<Reference> references, ListReferences(connection));
  for (const Reference& reference : references) {
    ASSIGN_OR_RETURN(Statement row, connection.Ask(reference.orphans));
    RETURN_IF_ERROR(row.Step().status());
    if (row.Int(0) == 0) continue;
    tell("file", absl::StrCat("table ", reference.table, ": ", row.Int(0), " rows name a row of ", reference.target,
                              " that is not there"));
  }
  return absl::OkStatus();
}

}  // namespace axiscal::storage
