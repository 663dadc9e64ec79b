#include "core/identify/budget.h"

#include <algorithm>
#include <cmath>

namespace axiscal::identify {

double Source::sigma() const { return distribution == Distribution::kUniform ? scale / std::sqrt(3.0) : scale; }

bool Source::ActsIn(const std::string& session) const {
  return sessions.empty() || std::find(sessions.begin(), sessions.end(), session) != sessions.end();
}

absl::Status CheckSessions(const Budget& budget, const std::vector<std::string>& sessions) {
  for (const Source& source : budget.sources) {
    for (const std::string& name : source.sessions) {
      if (std::find(sessions.begin(), sessions.end(), name) != sessions.end()) continue;
      return absl::InvalidArgumentError(
          absl::StrCat("budget: source '", source.name, "': session '", name, "' is not among those to identify from"));
    }
  }
  return absl::OkStatus();
}

}  // namespace axiscal::identify
