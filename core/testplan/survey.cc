#include "core/testplan/survey.h"

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>
#include <set>

#include "core/identify/naming.h"
#include "core/instruments/registry.h"

namespace axiscal::testplan {
namespace {

using identify::Reduced;

absl::StatusOr<SurveyedTest> Judge(const machine::Machine& machine, const machine::ErrorModel& model,
                                   const std::vector<identify::Estimate>& errors, plan::PlannedSession planned) {
  session::Session empty = planned.session;
  const instruments::Instrument* const instrument =
      instruments::FindInstrument(session::FindHeader(empty, "instrument").value_or(""));
  if (instrument == nullptr) return absl::InvalidArgumentError("the planned session's instrument is not evaluated");
  for (const std::string& name : instrument->reading_columns)
    empty.columns.push_back({name, std::vector<double>(empty.reading_count(), 0.0), {}});
  ASSIGN_OR_RETURN(instruments::MeasuringRun run, instruments::BindSession(empty, machine));
  SurveyedTest out;
  out.session = run.session;
  out.readings = run.reading_count();
  out.seconds = run.time_s.back() - run.time_s.front();
  ASSIGN_OR_RETURN(const identify::Problem problem, identify::MakeProblem(machine, {std::move(run)}));
  const identify::Point point = identify::StartingPoint(problem, model);
  const auto parameters = identify::ListParameters(model, false);
  const identify::NormalEquations normal = identify::Assemble(problem, point, parameters);
  out.identifying = identify::ReduceVisible(problem, point, normal);
  out.informing = identify::Reduce(problem, point, normal, identify::Priors::kAll);
  const identify::NullSpace null_space = identify::FindNullSpace(out.identifying);
  out.rank = null_space.rank;
  for (Eigen::Index row = 0; row < null_space.directions.rows(); ++row)
    out.not_separable.push_back(identify::CombinationName(errors, null_space.directions.row(row)));
  for (const bool is_involved : null_space.involved) out.is_determined.push_back(!is_involved);
  out.planned = std::move(planned);
  return out;
}

Reduced Sum(const Reduced& a, const Reduced& b) {
  return {a.information + b.information, a.gradient + b.gradient,
          (a.column_norm.cwiseAbs2() + b.column_norm.cwiseAbs2()).cwiseSqrt()};
}

// What a set of tests says of the asked errors.
struct Verdict {
  int determined = 0;       // of the asked
  double log_volume = 0.0;  // log determinant of their covariance, each in um or urad; of the determined ones
  std::vector<bool> is_determined;
  std::vector<double> sigma;
};

Verdict VerdictOf(const Survey& survey, const std::vector<int>& tests, const std::vector<int>& asked) {
  Reduced identifying = survey.tests[tests[0]].identifying, informing = survey.tests[tests[0]].informing;
  for (size_t i = 1; i < tests.size(); ++i) {
    identifying = Sum(identifying, survey.tests[tests[i]].identifying);
    informing = Sum(informing, survey.tests[tests[i]].informing);
  }
  const identify::NullSpace null_space = identify::FindNullSpace(identifying);
  std::vector<int> free;
  for (int i = 0; i < static_cast<int>(survey.errors.size()); ++i) {
    if (std::find(null_space.fixed.begin(), null_space.fixed.end(), i) == null_space.fixed.end()) free.push_back(i);
  }
  Verdict verdict;
  verdict.is_determined.assign(asked.size(), false);
  verdict.sigma.assign(asked.size(), NAN);
  if (free.empty()) return verdict;
  // Scaled to unit diagonal: errors in mm and rad differ by their levers.
  Eigen::VectorXd scale(free.size());
  for (size_t i = 0; i < free.size(); ++i)
    scale[i] = 1.0 / std::sqrt(std::max(informing.information(free[i], free[i]), 1e-300));
  const Eigen::MatrixXd scaled = scale.asDiagonal() * informing.information(free, free) * scale.asDiagonal();
  Eigen::MatrixXd covariance = scaled.ldlt().solve(Eigen::MatrixXd::Identity(scale.size(), scale.size()));
  covariance = scale.asDiagonal() * covariance * scale.asDiagonal();
  std::vector<int> seen;
  for (size_t i = 0; i < asked.size(); ++i) {
    const auto place = std::find(free.begin(), free.end(), asked[i]);
    if (null_space.involved[asked[i]] || place == free.end()) continue;
    verdict.is_determined[i] = true;
    ++verdict.determined;
    seen.push_back(static_cast<int>(place - free.begin()));
    verdict.sigma[i] = std::sqrt(std::max(0.0, covariance(seen.back(), seen.back())));
  }
  if (seen.empty()) return verdict;
  Eigen::MatrixXd block = covariance(seen, seen) * 1e6;  // um and urad
  const Eigen::VectorXd pivots = block.ldlt().vectorD();
  for (Eigen::Index i = 0; i < pivots.size(); ++i) verdict.log_volume += std::log(std::max(pivots[i], 1e-300));
  return verdict;
}

bool IsBetter(const Verdict& a, const Verdict& b) {
  if (a.determined != b.determined) return a.determined > b.determined;
  return a.log_volume < b.log_volume - 1e-9;
}

}  // namespace

absl::StatusOr<machine::ErrorModel> ErrorsToJudge(const machine::Machine& machine,
                                                  const std::vector<std::string>& symbols) {
  machine::ErrorModel model = symbols.empty() ? machine::DeclaredModel(machine) : machine::ErrorModel{};
  std::set<std::string> names;
  const auto add = [&](const machine::ErrorSymbol& symbol) {
    if (names.insert(machine::ToString(symbol)).second) model.terms.push_back(machine::ConstantTerm(machine, symbol));
  };
  for (const std::string& text : symbols) {
    ASSIGN_OR_RETURN(const machine::ErrorSymbol symbol, machine::ParseErrorSymbol(text));
    if (!symbol.is_constant) {
      return absl::InvalidArgumentError(text +
                                        ": varies along its axis, expected a constant error such as EX0C: tests are "
                                        "proposed for constant errors");
    }
    if (machine::FindJoint(machine, symbol.axis) < 0)
      return absl::InvalidArgumentError(text + ": machine " + machine.id + " has no axis " + symbol.axis);
    add(symbol);
  }
  if (!model.terms.empty()) return model;
  for (const machine::Axis& axis : machine.axes) {
    for (int c = 0; c < machine::kComponents; ++c) {
      const auto component = static_cast<machine::Component>(c);
      // Location errors: two offsets and two tilts of a rotary axis, the tilts of a linear one; along or about the axis
      // itself lies its zero.
      const int along = c % 3;
      if (std::abs(axis.direction[along]) > 0.9) continue;
      if (axis.kind == machine::AxisKind::kLinear && !machine::IsAngle(component)) continue;
      add({component, axis.name, true});
    }
  }
  return model;
}

absl::StatusOr<Survey> SurveyTests(const plan::Situation& situation, const machine::ErrorModel& model) {
  Survey survey;
  survey.model = model;
  for (const identify::Parameter& parameter : identify::ListParameters(model, false))
    survey.errors.push_back(identify::NamedEstimate(*situation.machine, model, parameter));
  for (const auto* tests : {&plan::Tests(), &plan::FurtherTests()}) {
    for (const plan::Test& test : *tests) {
      // "Farther than so far" means nothing on a machine that was never measured.
      if (situation.runs.empty() && test.name == "farther") continue;
      for (plan::PlannedSession& planned : test.plan(situation)) {
        if (!plan::ReachOf(situation, planned.session).is_reachable) continue;
        ASSIGN_OR_RETURN(SurveyedTest surveyed, Judge(*situation.machine, model, survey.errors, std::move(planned)));
        surveyed.test = test.name;
        survey.tests.push_back(std::move(surveyed));
      }
    }
  }
  return survey;
}

Proposal ProposeTests(const Survey& survey, const std::vector<int>& asked) {
  Proposal proposal;
  const int count = static_cast<int>(survey.tests.size());
  if (count == 0) {
    for (size_t i = 0; i < asked.size(); ++i) proposal.undetermined.push_back(static_cast<int>(i));
    proposal.sigma.assign(asked.size(), NAN);
    return proposal;
  }
  std::vector<int> all(count);
  for (int i = 0; i < count; ++i) all[i] = i;
  const int reachable = VerdictOf(survey, all, asked).determined;
  std::vector<int> best;
  Verdict best_verdict;
  const auto consider = [&](std::vector<int> tests) {
    Verdict verdict = VerdictOf(survey, tests, asked);
    if (!best.empty() && !IsBetter(verdict, best_verdict)) return;
    best = std::move(tests);
    best_verdict = std::move(verdict);
  };
  for (int i = 0; i < count; ++i) consider({i});
  if (best_verdict.determined < reachable) {
    for (int i = 0; i < count; ++i) {
      for (int j = i + 1; j < count; ++j) consider({i, j});
    }
  }
  // Larger sets: the best addition, then exchanges of one test at a time until none helps.
  while (best_verdict.determined < reachable && static_cast<int>(best.size()) < count) {
    const std::vector<int> smaller = best;
    best.clear();
    for (int i = 0; i < count; ++i) {
      if (std::find(smaller.begin(), smaller.end(), i) != smaller.end()) continue;
      std::vector<int> larger = smaller;
      larger.push_back(i);
      consider(larger);
    }
    for (bool improves = true; improves;) {
      const std::vector<int> before = best;
      for (size_t place = 0; place < before.size(); ++place) {
        for (int i = 0; i < count; ++i) {
          if (std::find(before.begin(), before.end(), i) != before.end()) continue;
          std::vector<int> other = before;
          other[place] = i;
          consider(other);
        }
      }
      improves = best != before;
    }
  }
  if (best_verdict.determined == 0) best.clear();  // nobody runs a test that tells nothing of what was asked
  proposal.tests = best;
  proposal.sigma = best_verdict.sigma;
  for (const int test : best) proposal.seconds += survey.tests[test].seconds + kMountingSeconds;
  for (size_t i = 0; i < asked.size(); ++i) {
    if (!best_verdict.is_determined[i]) proposal.undetermined.push_back(static_cast<int>(i));
  }
  return proposal;
}

}  // namespace axiscal::testplan
