// Who may do what, as rows: principals, tokens, roles, groups of machines; to which machines a row belongs.
#ifndef AXISCAL_SERVER_STORAGE_ACCESS_H_
#define AXISCAL_SERVER_STORAGE_ACCESS_H_

#include <optional>
#include <string>
#include <vector>

#include "server/storage/connection.h"
#include "server/storage/records.h"

namespace axiscal::storage {

absl::StatusOr<PrincipalRecord> CreatePrincipal(Connection& connection, UtcTime now, const std::string& name,
                                                const std::string& note, const Caller& caller);
absl::StatusOr<PrincipalRecord> GetPrincipal(Connection& connection, const std::string& name);
absl::StatusOr<PrincipalRecord> RevokePrincipal(Connection& connection, UtcTime now, const std::string& name,
                                                const Caller& caller);
absl::StatusOr<Page<PrincipalRecord>> ListPrincipals(Connection& connection, const PageRequest& request);
absl::StatusOr<TokenRecord> CreateToken(Connection& connection, UtcTime now, const NewToken& token,
                                        const Caller& caller);
absl::StatusOr<TokenRecord> RevokeToken(Connection& connection, UtcTime now, int64_t id, const Caller& caller);
absl::Status TouchToken(Connection& connection, UtcTime now, int64_t id);
absl::StatusOr<PrincipalRecord> ChangeRole(Connection& connection, UtcTime now, const std::string& name,
                                           const Grant& grant, bool holds, const Caller& caller);
// That a machine is in, in order.
absl::StatusOr<std::vector<std::string>> GroupsOf(Connection& connection, int64_t machine_key);
absl::StatusOr<MachineAccess> ChangeGroup(Connection& connection, UtcTime now, const std::string& group,
                                          const MachineId& machine, bool belongs, const Caller& caller);
absl::StatusOr<MachineAccess> SetFourEyes(Connection& connection, UtcTime now, const MachineId& machine, bool four_eyes,
                                          const Caller& caller);
absl::StatusOr<Page<MachineAccess>> ListMachineAccess(Connection& connection, const PageRequest& request);

absl::StatusOr<std::optional<Holder>> FindHolderOfToken(Connection& connection, const std::string& sha256);
absl::StatusOr<std::optional<Holder>> FindHolderOfName(Connection& connection, const std::string& name);
absl::StatusOr<Belonging> WhereBelongs(Connection& connection, const Resource& resource, const std::string& principal);

// Keys of the machines in these scopes, each once.
absl::StatusOr<std::vector<int64_t>> MachinesIn(Connection& connection, const std::vector<records::Scope>& scopes);

// The newest ids of a list that shows rows of some keys only, as "[12,7,3]" for json_each: at most `limit` below
// `before`. `sql` asks for those of one key: ?1 the key, ?2 below which, ?3 above which, ?4 how many at most, ?5 more.
// Costs about a seek for each key, however many rows there are.
template <typename Key, typename More>
absl::StatusOr<std::vector<int64_t>> NewestIds(Connection& connection, const std::string& sql,
                                               const std::vector<Key>& keys, int64_t before, int64_t limit,
                                               const More& more, std::vector<int64_t> found = {}) {
  for (const Key& key : keys) {
    const int64_t above = static_cast<int64_t>(found.size()) < limit ? 0 : found.back();
    ASSIGN_OR_RETURN(Statement row, connection.Ask(sql, key, before, above, limit, more));
    while (true) {
      ASSIGN_OR_RETURN(const bool is_there, row.Step());
      if (!is_there) break;
      found.push_back(row.Int(0));
    }
    std::sort(found.begin(), found.end(), std::greater<>());
    found.erase(std::unique(found.begin(), found.end()), found.end());
    if (static_cast<int64_t>(found.size()) > limit) found.resize(static_cast<size_t>(limit));
  }
  return found;
}

std::string JsonOf(const std::vector<int64_t>& ids);

// The same of a table whose rows have a machine and a state (0: any): of the machines in these scopes.
absl::StatusOr<std::string> NewestOfMachines(Connection& connection, const std::string& table,
                                             const std::vector<records::Scope>& scopes, int state, int64_t before,
                                             int64_t limit);

// Rows that a page of a narrow list looks at.
inline constexpr int64_t kMostLookedAt = 1000;

// What else than machine and state a list of a table is held to.
struct Narrowing {
  // Rows whose `column` is `text`: indices TABLE_with_COLUMN and TABLE_of_machine_with_COLUMN.
  struct Text {
    std::string column, text;
  };
  std::vector<Text> texts = {};
  // Rows whose `time`, as the indices TABLE_at and TABLE_of_machine_at have it behind blocks of numbers, lies in the
  // span.
  std::string time = {};
  TimeSpan span = {};
  // Rows that another table names: NewestIds() of it, with the limit kMostLookedAt.
  std::optional<std::vector<int64_t>> linked = {};
};

// The rows that a page of such a list looks at, the newest below `before` by whichever index leaves the fewest of them:
// of the machine and state (0: any), of a text, of the time, of those that are linked. The page holds each row to all
// else. Where one of them fits few rows, the page ends the list, however many fit none; else it looks at so many at
// most (of a time, at so many blocks of numbers too), and the next one goes on.
struct LookedAt {
  std::string ids = {};              // JSON
  std::string machines = {};         // JSON: the keys that rows must have; empty: any
  std::optional<int64_t> last = {};  // there may be more below this number
};
// Of that machine (its key), else of all that may be seen.
absl::StatusOr<LookedAt> LookAtNarrowest(Connection& connection, const std::string& table,
                                         const std::optional<int64_t>& machine, const Visible& visible, int state,
                                         int64_t before, const Narrowing& narrowing);
// What the page holds each of its rows to beside texts and links, of a table called `alias`: "WHERE ...", with the
// parameters ?2 (machine), ?3 (state), ?5 (LookedAt::ids), ?6 and ?7 (span, of `time`), ?8 (LookedAt::machines).
std::string HeldTo(const std::string& alias, const LookedAt& looked, bool has_machine, int state,
                   const std::string& time, const TimeSpan& span);
// For the name of a list in its page token.
std::string TokenOf(const TimeSpan& span);

}  // namespace axiscal::storage

#endif  // AXISCAL_SERVER_STORAGE_ACCESS_H_
