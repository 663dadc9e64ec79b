#include "core/plan/survey.h"

#include <algorithm>
#include <cmath>
#include <set>

#include "core/identify/naming.h"
#include "core/identify/plausible_errors.h"
#include "core/identify/reduction.h"
#include "core/plan/passes.h"
#include "core/plan/planned_run.h"
#include "core/plan/state_setups.h"
#include "core/session/column_rules.h"

namespace axiscal::plan {
namespace {

constexpr int kPassesProposed[] = {2, 4, 8};  // beyond these the set-up, not the readings, limits what is reached

absl::StatusOr<SurveyedTest> Judge(const machine::Machine& machine, const machine::ErrorModel& model,
                                   const std::vector<identify::Estimate>& errors, PlannedSession planned) {
  ASSIGN_OR_RETURN(instruments::MeasuringRun run, PlannedRun(machine, planned.session));
  SurveyedTest out;
  out.session = run.session;
  out.readings = run.reading_count();
  out.seconds = run.time_s.back() - run.time_s.front();
  ASSIGN_OR_RETURN(out.tells, InformationOf(machine, model, std::move(run)));
  const information::NullSpace null_space = information::FindNullSpace(out.tells.identifying);
  out.rank = null_space.rank;
  for (Eigen::Index row = 0; row < null_space.directions.rows(); ++row)
    out.not_separable.push_back(identify::CombinationName(errors, null_space.directions.row(row)));
  for (const bool is_involved : null_space.involved) out.is_determined.push_back(!is_involved);
  out.planned = std::move(planned);
  return out;
}

// Of `symbols`, each once; of none: what the machine declares, or all location errors.
absl::StatusOr<machine::ErrorModel> ConstantErrors(const machine::Machine& machine,
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

// Whether two sessions command the same positions, in the same order or backwards, with one instrument.
bool IsSameMotion(const session::Session& one, const session::Session& other) {
  if (session::FindHeader(one, "instrument") != session::FindHeader(other, "instrument")) return false;
  if (one.reading_count() != other.reading_count()) return false;
  bool is_same = true, is_reversed = true;
  for (const session::Column& column : one.columns) {
    std::string axis;
    session::ColumnKind kind;
    const session::Column* const twin = session::FindColumn(other, column.name);
    if (!session::ParseAxisColumn(column.name, &axis, &kind)) continue;
    if (twin == nullptr) return false;
    constexpr double kSame = 2e-3;  // mm or deg
    const auto is_near = [](double a, double b) { return std::abs(a - b) < kSame; };
    is_same &= std::equal(column.values.begin(), column.values.end(), twin->values.begin(), is_near);
    is_reversed &= std::equal(column.values.begin(), column.values.end(), twin->values.rbegin(), is_near);
  }
  // Of sphere centres the rotary columns alone are there: the tool and the sphere make the motion.
  for (const char* key : {"tool_tip_mm", "table_ball_mm"}) {
    if (session::FindHeader(one, "instrument") == "centres" &&
        session::FindHeader(one, key) != session::FindHeader(other, key))
      return false;
  }
  return is_same || is_reversed;
}

// The search of ProposeTests.
class LeastTime {
 public:
  struct Verdict {
    information::Told told;
    int minutes = 0;
    bool tells_all = false;  // that all tests together tell
  };

  // `wanted`: per asked error the largest standard uncertainty; empty: what counts as measured.
  LeastTime(const Survey& survey, const std::vector<int>& asked, const std::vector<double>& wanted)
      : survey_(survey), asked_(asked) {
    for (size_t i = 0; i < asked.size(); ++i) {
      const double measured = identify::kMeasuredWithin * identify::kPlausible * survey.errors[asked[i]].factor;
      widest_.push_back(wanted.empty() ? measured : std::min(measured, wanted[i]));
    }
    std::vector<int> all;
    for (int i = 0; i < static_cast<int>(survey.tests.size()); ++i) {
      const auto is_same = [&](int other) {
        return IsSameMotion(survey.tests[i].planned.session, survey.tests[other].planned.session);
      };
      if (std::none_of(all.begin(), all.end(), is_same)) all.push_back(i);
    }
    candidates_ = std::move(all);
    told_by_all_ = TellOf(candidates_).told;
  }

  // None: nothing that was asked is told.
  std::vector<int> Find() {
    if (told_by_all_.determined_count == 0) return {};
    const int count = static_cast<int>(candidates_.size());
    for (int i = 0; i < count; ++i) Consider({candidates_[i]});
    for (int i = 0; i < count; ++i) {
      for (int j = i + 1; j < count; ++j) Consider({candidates_[i], candidates_[j]});
    }
    // Larger sets: all tests but those that can be left out, the longest first and, of equal length, the last.
    std::vector<int> longest_first = candidates_;
    std::stable_sort(longest_first.begin(), longest_first.end(),
                     [&](int a, int b) { return survey_.tests[a].seconds > survey_.tests[b].seconds; });
    std::vector<int> kept = longest_first;
    for (const int test : longest_first) TryWithout(test, &kept);
    Exchange(kept);
    if (!best_.empty()) Exchange(best_);
    std::sort(best_.begin(), best_.end());
    return best_;
  }

  Verdict TellOf(const std::vector<int>& set) const {
    Verdict verdict;
    verdict.told = {std::vector<bool>(asked_.size(), false), std::vector<double>(asked_.size(), NAN)};
    if (set.empty()) return verdict;
    verdict.told = ToldBy(set);
    for (size_t i = 0; i < asked_.size(); ++i) {
      if (!verdict.told.is_determined[i] || verdict.told.sigma[i] <= widest_[i]) continue;
      verdict.told.is_determined[i] = false;
      verdict.told.sigma[i] = NAN;
      --verdict.told.determined_count;
    }
    double seconds = 0.0;
    for (const int test : set) seconds += survey_.tests[test].seconds + kMountingSeconds;
    verdict.minutes = static_cast<int>(std::ceil(seconds / 60.0));
    verdict.tells_all = true;
    for (size_t i = 0; i < told_by_all_.is_determined.size(); ++i)
      verdict.tells_all &= verdict.told.is_determined[i] || !told_by_all_.is_determined[i];
    return verdict;
  }

  // Per asked error by all tests together, however uncertain.
  std::vector<double> Best() const {
    return candidates_.empty() ? std::vector<double>(asked_.size(), NAN) : ToldBy(candidates_).sigma;
  }

 private:
  information::Told ToldBy(const std::vector<int>& set) const {
    information::TestInformation together = survey_.tests[set[0]].tells;
    for (size_t i = 1; i < set.size(); ++i) together += survey_.tests[set[i]].tells;
    return information::Tell(together, asked_);
  }

  // Whether it is the best so far.
  bool Consider(const std::vector<int>& set) {
    Verdict verdict = TellOf(set);
    if (!verdict.tells_all) return false;
    constexpr double kRounding = 1e-9;
    const bool is_better = best_.empty() || verdict.minutes < of_best_.minutes ||
                           (verdict.minutes == of_best_.minutes &&
                            verdict.told.log_determinant < of_best_.told.log_determinant - kRounding);
    if (!is_better) return false;
    best_ = set;
    of_best_ = std::move(verdict);
    return true;
  }

  // Leaves `test` out of `set` where the others tell as much.
  bool TryWithout(int test, std::vector<int>* set) const {
    std::vector<int> fewer = *set;
    std::erase(fewer, test);
    if (fewer.empty() || !TellOf(fewer).tells_all) return false;
    *set = std::move(fewer);
    return true;
  }

  // One test for another, then without those that are no longer needed, as long as it pays.
  void Exchange(std::vector<int> set) {
    Consider(set);
    for (bool improves = true; improves;) {
      improves = false;
      for (size_t place = 0; place < set.size() && !improves; ++place) {
        for (const int test : candidates_) {
          if (std::find(set.begin(), set.end(), test) != set.end()) continue;
          std::vector<int> other = set;
          other[place] = test;
          if (!TellOf(other).tells_all) continue;
          const std::vector<int> whole = other;
          for (const int one : whole) {
            if (one != test) TryWithout(one, &other);
          }
          if (!Consider(other)) continue;
          set = other;
          improves = true;
          break;
        }
      }
    }
  }

  const Survey& survey_;
  const std::vector<int> asked_;
  std::vector<double> widest_;   // per asked error, mm or rad
  std::vector<int> candidates_;  // no two the same motion
  information::Told told_by_all_;
  std::vector<int> best_;
  Verdict of_best_;
};

}  // namespace

absl::StatusOr<machine::ErrorModel> ErrorsToJudge(const machine::Machine& machine,
                                                  const std::vector<std::string>& declared,
                                                  const std::vector<std::string>& asked) {
  std::vector<std::string> symbols = declared;
  if (symbols.empty()) {
    ASSIGN_OR_RETURN(const machine::ErrorModel model, ConstantErrors(machine, {}));
    for (const machine::ErrorTerm& term : model.terms) symbols.push_back(machine::SymbolOf(machine, term));
  }
  symbols.insert(symbols.end(), asked.begin(), asked.end());
  return ConstantErrors(machine, symbols);
}

absl::StatusOr<information::TestInformation> InformationOf(const machine::Machine& machine,
                                                           const machine::ErrorModel& model,
                                                           instruments::MeasuringRun run) {
  ASSIGN_OR_RETURN(const identify::Problem problem, identify::MakeProblem(machine, {std::move(run)}));
  const identify::Point point = identify::StartingPoint(problem, model);
  const identify::NormalEquations normal = identify::Assemble(problem, point, identify::ListParameters(model, false));
  return information::TestInformation{
      identify::InformationOf(identify::ReduceVisible(problem, point, normal)),
      identify::InformationOf(identify::Reduce(problem, point, normal, identify::Priors::kAll))};
}

absl::StatusOr<Survey> SurveyTests(const Situation& situation, const machine::ErrorModel& model,
                                   const std::vector<std::string>& setups) {
  Survey survey;
  survey.model = model;
  for (const identify::Parameter& parameter : identify::ListParameters(model, false))
    survey.errors.push_back(identify::NamedEstimate(*situation.machine, model, parameter));
  std::vector<std::pair<std::string, PlannedSession>> all;
  for (const auto* tests : {&Tests(), &FurtherTests()}) {
    for (const Test& test : *tests) {
      // "Farther than so far" means nothing on a machine that was never measured.
      if (situation.runs.empty() && test.name == "farther") continue;
      for (PlannedSession& planned : test.plan(situation)) {
        if (ReachOf(situation, planned.session).is_reachable) all.emplace_back(test.name, std::move(planned));
      }
    }
  }
  std::vector<session::Session*> sessions;
  for (auto& [test, planned] : all) sessions.push_back(&planned.session);
  RETURN_IF_ERROR(StateSetups(*situation.machine, setups, sessions));
  for (auto& [test, planned] : all) {
    ASSIGN_OR_RETURN(SurveyedTest surveyed, Judge(*situation.machine, model, survey.errors, std::move(planned)));
    surveyed.test = test;
    survey.tests.push_back(std::move(surveyed));
  }
  return survey;
}

absl::Status AddPasses(const Situation& situation, Survey* survey) {
  const size_t once = survey->tests.size();
  for (size_t i = 0; i < once; ++i) {
    for (const int passes : kPassesProposed) {
      ASSIGN_OR_RETURN(SurveyedTest surveyed, Judge(*situation.machine, survey->model, survey->errors,
                                                    InPasses(survey->tests[i].planned, passes)));
      surveyed.test = survey->tests[i].test;
      survey->tests.push_back(std::move(surveyed));
    }
  }
  return absl::OkStatus();
}

std::vector<const Test*> TestsWithoutSession(const Survey& survey) {
  std::vector<const Test*> without;
  for (const auto* tests : {&Tests(), &FurtherTests()}) {
    for (const Test& test : *tests) {
      const auto is_of_test = [&](const SurveyedTest& surveyed) { return surveyed.test == test.name; };
      if (std::none_of(survey.tests.begin(), survey.tests.end(), is_of_test)) without.push_back(&test);
    }
  }
  return without;
}

absl::StatusOr<std::vector<int>> IndicesOf(const Survey& survey, const std::vector<std::string>& symbols) {
  std::vector<int> indices;
  for (const std::string& text : symbols) {
    ASSIGN_OR_RETURN(const machine::ErrorSymbol symbol, machine::ParseErrorSymbol(text));
    for (size_t i = 0; i < survey.errors.size(); ++i) {
      if (survey.errors[i].name == machine::ToString(symbol)) indices.push_back(static_cast<int>(i));
    }
  }
  return indices;
}

Proposal ProposeTests(const Survey& survey, const std::vector<int>& asked, const std::vector<double>& wanted) {
  LeastTime search(survey, asked, wanted);
  Proposal proposal;
  proposal.best = search.Best();
  proposal.tests = search.Find();
  const information::Told told = search.TellOf(proposal.tests).told;
  proposal.undetermined = told.Undetermined();
  proposal.sigma = told.sigma;
  for (const int test : proposal.tests) proposal.seconds += survey.tests[test].seconds + kMountingSeconds;
  return proposal;
}

}  // namespace axiscal::plan
