// An error budget: named sources of error beside those that are identified, each with its range and how often it is
// drawn anew. It says how the readings of a test scatter, for weights and for Monte Carlo (JCGM 101).
#ifndef AXISCAL_CORE_IDENTIFY_BUDGET_H_
#define AXISCAL_CORE_IDENTIFY_BUDGET_H_

#include <cstdint>
#include <string>
#include <vector>

#include "core/base/status.h"
#include "core/machine/error_model.h"

namespace axiscal::identify {

enum class Distribution { kUniform, kNormal };

// How long one draw stands.
enum class DrawnPer {
  kReading,  // a positioning error of every pose
  kSession,  // an error of each mounting
  kRun       // a squareness that nobody identifies: one draw for all sessions
};

// An error of the machine: what it does to a reading follows from the one chain. Readings' own scatter is the term's
// alternative.
struct Source {
  std::string name;
  bool is_reading = false;  // acts on the readings themselves, not through `term`
  machine::ErrorTerm term;  // amplitudes are those of the draw; both of a harmonic are drawn
  Distribution distribution = Distribution::kNormal;
  double scale = 0.0;  // half width of a uniform one, standard deviation of a normal one; mm or rad per reference
  DrawnPer drawn_per = DrawnPer::kReading;
  std::vector<std::string> sessions;  // it acts in these; in all where empty

  // Standard deviation of a draw.
  double sigma() const;
  bool ActsIn(const std::string& session) const;
};

struct Budget {
  // Besides the sources every reading scatters as the fit judged it: the session's stated repeatability, or more where
  // the residuals show more.
  bool with_reading_noise = true;
  std::vector<Source> sources;
};

inline constexpr size_t kMaxSources = 100;

// {"axiscal": "budget/1", "reading_noise": true, "sources": [
//   {"name": "C angle", "symbol": "EC0C", "half_width": 70, "drawn": "reading", "sessions": ["I"]}, ...]}
// docs/formats.md, "Error budget". INVALID_ARGUMENT naming the entry, its value and the rule.
absl::StatusOr<Budget> ReadBudget(const std::string& text, const machine::Machine& machine);

// INVALID_ARGUMENT for a source of a session that is not among `sessions`.
absl::Status CheckSessions(const Budget& budget, const std::vector<std::string>& sessions);

}  // namespace axiscal::identify

#endif  // AXISCAL_CORE_IDENTIFY_BUDGET_H_
