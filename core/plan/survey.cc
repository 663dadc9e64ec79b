#include "core/plan/survey.h"

#include <algorithm>
#include <cmath>
#include <set>

#include "core/identify/naming.h"
#include "core/identify/reduction.h"
#include "core/plan/planned_run.h"

namespace axiscal::plan {
namespace {

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
  const identify::NormalEquations normal =
      identify::Assemble(problem, point, identify::ListParameters(model, false));
  return information::TestInformation{
      identify::InformationOf(identify::ReduceVisible(problem, point, normal)),
      identify::InformationOf(identify::Reduce(problem, point, normal, identify::Priors::kAll))};
}

absl::StatusOr<Survey> SurveyTests(const Situation& situation, const machine::ErrorModel& model) {
  Survey survey;
  survey.model = model;
  for (const identify::Parameter& parameter : identify::ListParameters(model, false))
    survey.errors.push_back(identify::NamedEstimate(*situation.machine, model, parameter));
  for (const auto* tests : {&Tests(), &FurtherTests()}) {
    for (const Test& test : *tests) {
      // "Farther than so far" means nothing on a machine that was never measured.
      if (situation.runs.empty() && test.name == "farther") continue;
      for (PlannedSession& planned : test.plan(situation)) {
        if (!ReachOf(situation, planned.session).is_reachable) continue;
        ASSIGN_OR_RETURN(SurveyedTest surveyed, Judge(*situation.machine, model, survey.errors, std::move(planned)));
        surveyed.test = test.name;
        survey.tests.push_back(std::move(surveyed));
      }
    }
  }
  return survey;
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

Proposal ProposeTests(const Survey& survey, const std::vector<int>& asked) {
  std::vector<information::TestInformation> tests;
  for (const SurveyedTest& test : survey.tests) tests.push_back(test.tells);
  information::Choice choice = information::ChooseTests(tests, asked);
  Proposal proposal;
  proposal.undetermined = choice.told.Undetermined();
  proposal.tests = std::move(choice.tests);
  proposal.sigma = std::move(choice.told.sigma);
  for (const int test : proposal.tests) proposal.seconds += survey.tests[test].seconds + kMountingSeconds;
  return proposal;
}

}  // namespace axiscal::plan
