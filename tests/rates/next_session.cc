#include "tests/rates/next_session.h"

#include <algorithm>
#include <chrono>
#include <limits>

#include "core/decide/close_loop.h"
#include "core/loop/same_always.h"
#include "core/synthetic/simulate.h"
#include "tests/rates/score.h"

namespace axiscal::rates {
namespace {

using machine::ErrorTerm;

// The class of the reported effect that holds the truth; names of one effect count once, the truth's is the first.
// Empty where no class holds it.
std::vector<ErrorTerm> ClassOfTruth(const SimulatedCase& simulated, const loop::Report& report) {
  const ErrorTerm& truth = simulated.effects.terms[0];
  for (const loop::Effect& effect : report.effects) {
    std::vector<ErrorTerm> terms = {truth, effect.term};
    terms.insert(terms.end(), effect.equivalent.begin(), effect.equivalent.end());
    const std::vector<int> first = loop::FirstOfTheSame(simulated.machine, simulated.fit.front().tip_mm, terms);
    std::vector<ErrorTerm> members = {truth};
    bool has_truth = false;
    for (size_t i = 1; i < terms.size(); ++i) {
      const auto is_it = [&](const ErrorTerm& one) { return IsSame(one, terms[i]); };
      if (first[i] == 0 || is_it(truth)) {
        has_truth = true;
      } else if (first[i] == static_cast<int>(i) && std::none_of(members.begin(), members.end(), is_it)) {
        members.push_back(terms[i]);
      }
    }
    if (has_truth) return members;
  }
  return {};
}

std::string NamesOf(const machine::Machine& machine, const std::vector<ErrorTerm>& terms) {
  std::string names;
  for (const ErrorTerm& term : terms) names += (names.empty() ? "" : " ") + machine::NameOf(machine, term);
  return "{" + names + "}";
}

std::string ReportedIn(const machine::Machine& machine, const loop::Report& report) {
  std::string text;
  for (const loop::Effect& effect : report.effects) {
    std::vector<ErrorTerm> members = {effect.term};
    members.insert(members.end(), effect.equivalent.begin(), effect.equivalent.end());
    text += " " + NamesOf(machine, members);
  }
  return text;
}

// Moves a session to begin after `end_s`, as a machine is measured once at a time: a proposal says when it could start
// alone. Its end.
double StartAfter(double end_s, session::Session* session) {
  constexpr double kMountingS = 600.0;
  for (session::Column& column : session->columns) {
    if (column.name != "t_s") continue;
    const double later_s = std::max(0.0, end_s + kMountingS - column.values.front());
    for (double& time_s : column.values) time_s += later_s;
    return column.values.back();
  }
  return end_s;
}

}  // namespace

NextScore JudgeNext(uint64_t seed) {
  SimulatedCase simulated = Draw(Kind::kOne, seed);
  const machine::Machine& machine = simulated.machine;
  NextScore score;
  score.text = absl::StrFormat("%s in %s (%.1f)", machine.id, machine::NameOf(machine, simulated.effects.terms[0]),
                               simulated.signal_to_noise[0]);
  const auto start = std::chrono::steady_clock::now();
  const absl::StatusOr<loop::Report> before = decide::CloseLoop(machine, simulated.fit, simulated.check);
  score.seconds = std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
  if (!before.ok()) {
    score.text += " " + std::string(before.status().message());
    return score;
  }
  const std::vector<ErrorTerm> members = ClassOfTruth(simulated, *before);
  score.held_others = members.size() > 1;
  score.text += " before" + ReportedIn(machine, *before);
  score.is_alone = members.size() == 1;
  if (!score.held_others) return score;

  machine::ErrorModel truth = simulated.declared;
  truth.terms.push_back(simulated.effects.terms[0]);
  std::vector<session::Session> measured;
  double end_s = -std::numeric_limits<double>::infinity();  // of the session before
  for (const loop::Proposal& proposal : before->next_measurement) {
    if (proposal.test.empty()) {
      score.text += " no test for " + NamesOf(machine, proposal.remaining);
      continue;
    }
    score.text += absl::StrFormat(" [%s r %.3f chi2 %.0f]", *session::FindHeader(proposal.session, "session"),
                                  proposal.correlation_after, proposal.expected_chi2);
    if (!proposal.remaining.empty()) score.text += " leaves " + NamesOf(machine, proposal.remaining);
    synthetic::NoiseOptions noise;
    noise.sigma_scale = simulated.sigma_scale;
    noise.resolution_mm = 1e-4;
    noise.seed = 1000 * seed + measured.size();
    session::Session session = proposal.session;
    end_s = StartAfter(end_s, &session);
    measured.push_back(synthetic::Simulate(machine, truth, session, noise).value());
  }
  if (measured.empty()) return score;
  std::vector<instruments::MeasuringRun> runs = identify::BindSessions(machine, measured).value();
  for (instruments::MeasuringRun& run : runs) simulated.fit.push_back(std::move(run));
  const absl::StatusOr<loop::Report> after = decide::CloseLoop(machine, simulated.fit, simulated.check);
  if (!after.ok()) {
    score.text += " " + std::string(after.status().message());
    return score;
  }
  score.is_alone = ClassOfTruth(simulated, *after).size() == 1;
  score.text += std::string(score.is_alone ? " after" : " MISSED after") + ReportedIn(machine, *after);
  return score;
}

}  // namespace axiscal::rates
