#include "core/toolsetter/evaluate.h"

#include "core/toolsetter/cutter_keys.h"
#include "core/toolsetter/length_curve.h"
#include "core/toolsetter/wear.h"

namespace axiscal::toolsetter {
namespace {

constexpr char kRods[] = "tool-setter", kCurve[] = "tool-curve";

}  // namespace

bool IsToolSetter(const std::string& instrument) { return instrument == kRods || instrument == kCurve; }

absl::Status CheckHeader(const session::Session& session) {
  const std::string instrument = session::FindHeader(session, "instrument").value_or("");
  if (instrument == kRods) return ReadRodSession(session).status();
  if (instrument != kCurve) return absl::OkStatus();
  ASSIGN_OR_RETURN(const CutterDescription description, ReadCutterKeys(session));
  ASSIGN_OR_RETURN(const InsertHeights heights, HeightsOf(description.cutter, description.run));
  ASSIGN_OR_RETURN(const double sigma_mm, CurveSigmaMm(session));
  return CheckInsertsApart(heights, description.cutter, description.run, sigma_mm);
}

absl::StatusOr<reports::ToolSetter> Evaluate(const session::Session& session, const ReferenceOptions& options) {
  const std::string instrument = session::FindHeader(session, "instrument").value_or("");
  if (instrument == kRods) {
    ASSIGN_OR_RETURN(const RodSession rods, ReadRodSession(session));
    ASSIGN_OR_RETURN(const Reference reference, FitReference(rods, options));
    return ReportOf(rods, reference);
  }
  if (instrument == kCurve) {
    ASSIGN_OR_RETURN(const CurveSession curve, ReadCurveSession(session));
    ASSIGN_OR_RETURN(const WearReport report, FitWear(curve));
    return ReportOf(curve, report);
  }
  return absl::InvalidArgumentError(absl::StrCat("session ", session::FindHeader(session, "session").value_or("?"),
                                                 ": instrument '", instrument, "', expected ", kRods, " or ", kCurve));
}

}  // namespace axiscal::toolsetter
