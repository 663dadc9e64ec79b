// What a publication's own closed formulas make of a user's sessions, beside what the one engine makes of them. For
// comparison only: no number from here reaches a calibration, a table or a program.
#ifndef AXISCAL_CORE_PUBLISHED_COMPARISON_H_
#define AXISCAL_CORE_PUBLISHED_COMPARISON_H_

#include <Eigen/Core>
#include <limits>
#include <string>
#include <vector>

#include "core/base/status.h"
#include "core/identify/held.h"
#include "core/machine/machine.h"
#include "core/nc/poses.h"
#include "core/session/session.h"

namespace axiscal::published {

// One published quantity. Numbers are NaN where the sessions do not give them; `note` says why.
struct Row {
  std::string quantity;                                         // as published: "dxCZ - dxBT"
  std::string unit;                                             // of all numbers: "um", "arcsec"
  double published = std::numeric_limits<double>::quiet_NaN();  // by the formula as printed
  double corrected = std::numeric_limits<double>::quiet_NaN();  // with the errata, or what it leaves out, put right
  std::string symbol;                                           // what it is in our terms: "EX0C - EX0T"
  double exact = std::numeric_limits<double>::quiet_NaN();      // by the engine, from all sessions together
  double sigma = std::numeric_limits<double>::quiet_NaN();      // standard uncertainty of `exact`
  std::string formula;                                          // as printed
  std::string note;                                             // the erratum, or what is missing
  // Standard uncertainty of `published` by what the readings, or the errors, state: linear.
  double published_sigma = std::numeric_limits<double>::quiet_NaN();
};

struct Comparison {
  std::vector<Row> rows;
  std::vector<std::string> notes;  // on the sessions as a whole
};

// What a published compensation is about: where a program goes with a tool, and the machine's errors.
struct Program {
  identify::HeldErrors errors;                            // with their uncertainties where those are known
  Eigen::Vector3d tool_tip_mm = Eigen::Vector3d::Zero();  // at home, machine frame
  std::vector<nc::ProgramPose> poses;
};
inline constexpr size_t kMostPoses = 1000;  // a table is made of them

struct Source {
  std::string name;      // "yao-table-4.5"
  std::string citation;  // where it is printed
  std::string needs;     // which sessions or program, for people
  // One of the two is set, the other null. FAILED_PRECONDITION or INVALID_ARGUMENT, with what was expected, where the
  // formulas are about another machine or other sessions; else the errors of the fit.
  absl::StatusOr<Comparison> (*compare)(const machine::Machine&, const std::vector<session::Session>&);
  absl::StatusOr<Comparison> (*compare_program)(const machine::Machine&, const Program&) = nullptr;
};
const std::vector<Source>& Sources();
// INVALID_ARGUMENT listing the known ones.
absl::StatusOr<const Source*> FindSource(const std::string& name);

}  // namespace axiscal::published

#endif  // AXISCAL_CORE_PUBLISHED_COMPARISON_H_
