#include "server/routines/judge.h"

#include <algorithm>
#include <cmath>

#include "absl/strings/str_join.h"
#include "core/base/units.h"
#include "server/inputs/compared.h"
#include "server/inputs/tolerance.h"

namespace axiscal::routines {
namespace {

// Two calibrations of a machine that did not change disagree more than this in 5 of 100 cases.
constexpr double kLeastProbability = 0.05;
constexpr size_t kNamed = 5;  // of errors that differ, the clearest; more are counted

absl::StatusOr<compare::Comparison> CompareStored(storage::Database& database, const records::CalibrationRecord& in_use,
                                                  const records::CalibrationRecord& candidate) {
  ASSIGN_OR_RETURN(const inputs::Compared compared, inputs::SidesOf(database, in_use, candidate));
  return compare::Compare(compared.machine, compared.first, compared.second, compared.workspace);
}

bool Differs(const compare::Difference& one) {
  return one.verdict == compare::Verdict::kDiffers || one.verdict == compare::Verdict::kOnlyOne;
}

std::string TextOf(const compare::Difference& one) {
  if (one.verdict == compare::Verdict::kOnlyOne) return one.name + " is in one of the two models only";
  return absl::StrFormat("%s %+.4g +- %.2g %s", one.name, one.difference, one.sigma, one.unit);
}

// The clearest first.
std::string TextOf(std::vector<compare::Difference> differences) {
  std::stable_sort(differences.begin(), differences.end(), [](const auto& a, const auto& b) {
    const auto clear = [](const compare::Difference& one) {
      return one.sigma > 0.0 ? std::abs(one.difference) / one.sigma : 0.0;
    };
    return clear(a) > clear(b);
  });
  std::vector<std::string> texts;
  for (const compare::Difference& one : differences)
    if (texts.size() < kNamed) texts.push_back(TextOf(one));
  const size_t more = differences.size() - texts.size();
  return absl::StrJoin(texts, ", ") + (more > 0 ? absl::StrCat(" and ", more, " more") : "");
}

}  // namespace

bool MayPass(const absl::Status& status) {
  return absl::IsUnavailable(status) || absl::IsResourceExhausted(status) || absl::IsAborted(status) ||
         absl::IsCancelled(status) || absl::IsDeadlineExceeded(status);
}

Judgement JudgeComparison(const std::optional<compare::Comparison>& comparison,
                          const std::optional<CalibrationId>& in_use) {
  Judgement judgement;
  judgement.in_use = in_use;
  if (!comparison) {
    judgement.text = "no calibration is in use to compare it with";
    judgement.doubts = {"the first calibration is put in use by a person"};
    return judgement;
  }
  std::vector<compare::Difference> different;
  bool is_certain = true, has_only_one = false;
  for (const auto* const list : {&comparison->errors, &comparison->combinations}) {
    for (const compare::Difference& one : *list) {
      if (Differs(one)) different.push_back(one);
      has_only_one |= one.verdict == compare::Verdict::kOnlyOne;
      is_certain &= one.verdict != compare::Verdict::kNoUncertainty;
    }
  }
  const std::string other = in_use ? absl::StrCat("calibration ", in_use->number()) : "the calibration in use";
  const bool is_joint = comparison->joint.degrees_of_freedom > 0;
  judgement.agrees = different.empty() && is_certain && is_joint && comparison->joint.probability >= kLeastProbability;
  if (judgement.agrees) {
    judgement.text = absl::StrFormat("it agrees with %s within the uncertainties of both (probability %.2f)", other,
                                     comparison->joint.probability);
  } else if (!different.empty()) {
    judgement.text = absl::StrCat("against ", other, ": ", TextOf(different));
  } else if (is_joint && is_certain) {
    judgement.text = absl::StrFormat(
        "against %s no single error differs beyond the uncertainties, all together do (probability %.2g)", other,
        comparison->joint.probability);
  } else {
    judgement.text = absl::StrCat("whether it differs from ", other, " is not known: an uncertainty is missing");
  }
  if (has_only_one) judgement.doubts.push_back("the two models do not have the same errors");
  if (!is_certain) judgement.doubts.push_back("an uncertainty is missing");
  if (!comparison->tool_point) {
    judgement.doubts.push_back("what it changes at the tool point is not known: no readings with positions are left");
    return judgement;
  }
  const compare::Size& size = comparison->tool_point->as_programmed;
  judgement.largest_change_um = size.max_mm * base::kUmPerMm;
  absl::StrAppendFormat(&judgement.text,
                        "; over the measured positions the tool point moves by up to %.3g um (%.3g um rms)",
                        *judgement.largest_change_um, size.rms_mm * base::kUmPerMm);
  if (!comparison->tool_point->unknown.empty()) {
    judgement.doubts.push_back("how far the tool point moves is not known along " +
                               absl::StrJoin(comparison->tool_point->unknown, "; "));
  }
  return judgement;
}

std::vector<std::string> DoubtsOf(const records::CalibrationRecord& candidate,
                                  const std::optional<reports::CalibrationReport>& report,
                                  const std::vector<records::DriftLimit>& tolerances) {
  std::vector<std::string> doubts;
  if (!report) {
    doubts.push_back("its report cannot be read");
  } else {
    for (const reports::Warning& warning : reports::FittedOf(*report).warnings) doubts.push_back(warning.text);
    const auto* const loop = std::get_if<reports::Loop>(&*report);
    if (loop != nullptr && loop->verdict == reports::Verdict::kUnexplained)
      doubts.push_back("the loop leaves structure in the readings that it cannot name");
  }
  for (const records::DriftLimit& limit : tolerances) {
    const auto estimate = std::find_if(candidate.content.estimates.begin(), candidate.content.estimates.end(),
                                       [&](const records::Estimate& one) { return one.symbol == limit.symbol; });
    if (estimate == candidate.content.estimates.end() || !estimate->identifiable || !estimate->value ||
        !estimate->sigma) {
      doubts.push_back(absl::StrCat(limit.symbol, " has a tolerance and no number here"));
      continue;
    }
    const double outside = inputs::ProbabilityOutside(limit, *estimate);
    if (outside < inputs::kProvenInside) continue;
    doubts.push_back(absl::StrFormat(
        "%s is %.4g +- %.2g, %s its tolerance %g .. %g", limit.symbol, *estimate->value, *estimate->sigma,
        outside >= inputs::kProvenOutside ? "out of" : "not certainly within", limit.low, limit.high));
  }
  return doubts;
}

namespace {

// What routines have moved step by step since a person looked counts together.
absl::Status JudgeSincePerson(storage::Database& database, const records::CalibrationRecord& candidate,
                              Judgement* judgement) {
  const absl::StatusOr<records::CalibrationRecord> by_person = database.GetApprovedByPerson(candidate.content.machine);
  if (MayPass(by_person.status())) return by_person.status();
  if (by_person.ok() && by_person->id == judgement->in_use) return absl::OkStatus();
  const absl::StatusOr<compare::Comparison> comparison =
      by_person.ok() ? CompareStored(database, *by_person, candidate) : by_person.status();
  if (MayPass(comparison.status())) return comparison.status();
  if (!comparison.ok() || !comparison->tool_point) {
    judgement->doubts.push_back("how far routines have moved it since a person approved one is not known");
    return absl::OkStatus();
  }
  judgement->largest_change_since_person_um = comparison->tool_point->as_programmed.max_mm * base::kUmPerMm;
  absl::StrAppendFormat(&judgement->text, "; since calibration %d, which a person put in use, by up to %.3g um",
                        by_person->id.number(), *judgement->largest_change_since_person_um);
  return absl::OkStatus();
}

}  // namespace

absl::StatusOr<Judgement> Judge(storage::Database& database, const records::CalibrationRecord& candidate) {
  const MachineId& machine = candidate.content.machine;
  const absl::StatusOr<records::CalibrationRecord> in_use = database.GetApprovedCalibration(machine);
  Judgement judgement;
  if (in_use.ok()) {
    const absl::StatusOr<compare::Comparison> comparison = CompareStored(database, *in_use, candidate);
    if (comparison.ok()) {
      judgement = JudgeComparison(*comparison, in_use->id);
      RETURN_IF_ERROR(JudgeSincePerson(database, candidate, &judgement));
    } else if (MayPass(comparison.status())) {
      return comparison.status();
    } else {
      judgement.text = absl::StrCat("it cannot be compared with calibration ", in_use->id.number(), ": ",
                                    std::string(comparison.status().message()));
      judgement.doubts = {"it was not compared with what is in use"};
    }
  } else if (MayPass(in_use.status())) {
    return in_use.status();
  } else if (absl::IsNotFound(in_use.status())) {
    judgement = JudgeComparison(std::nullopt, std::nullopt);
  } else {
    judgement.text = absl::StrCat("the calibration in use cannot be read: ", std::string(in_use.status().message()));
    judgement.doubts = {"it was not compared with what is in use"};
  }
  ASSIGN_OR_RETURN(const records::ExpectationsRecord expected, database.GetExpectations(machine));
  std::optional<reports::CalibrationReport> report;
  absl::StatusOr<reports::CalibrationReport> read = reports::ReadCalibrationReport(candidate.content.report_json);
  if (read.ok()) report = *std::move(read);
  for (std::string& doubt : DoubtsOf(candidate, report, expected.content.tolerances))
    judgement.doubts.push_back(std::move(doubt));
  return judgement;
}

}  // namespace axiscal::routines
