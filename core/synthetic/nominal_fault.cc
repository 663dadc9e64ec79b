#include "core/synthetic/nominal_fault.h"

#include <algorithm>
#include <utility>

#include "core/session/text.h"
#include "core/synthetic/sampling.h"

namespace axiscal::synthetic {
namespace {

absl::Status MoveTip(const NominalFault& fault, session::Session* session) {
  for (session::HeaderEntry& entry : session->header) {
    std::vector<double> tip_mm;
    if (entry.key != "tool_tip_mm" || !session::ParseNumbers(entry.value, &tip_mm) || tip_mm.size() != 3) continue;
    entry.value = absl::StrFormat("%.10g %.10g %.10g", tip_mm[0] + fault.offset_mm.x(), tip_mm[1] + fault.offset_mm.y(),
                                  tip_mm[2] + fault.offset_mm.z());
    return absl::OkStatus();
  }
  return absl::InvalidArgumentError("the session states no tool_tip_mm");
}

absl::Status ChangeColumns(const NominalFault& fault, session::Session* session) {
  std::vector<session::Column*> columns;
  for (const std::string& name : fault.columns) {
    columns.push_back(ColumnIn(session, name));
    if (columns.back() == nullptr) {
      if (fault.sessions.empty()) return absl::OkStatus();
      return absl::InvalidArgumentError(absl::StrCat("the session has no column '", name, "'"));
    }
  }
  if (fault.kind == NominalKind::kSwapped) {
    std::swap(columns[0]->values, columns[1]->values);
  } else {
    for (double& value : columns[0]->values) value *= fault.factor;
  }
  return absl::OkStatus();
}

}  // namespace

const char* const* NominalWords() {
  static const char* const kWords[] = {"direction", "pivot", "tool-length", "swapped", "unit", nullptr};
  return kWords;
}

machine::Machine Misdescribe(const machine::Machine& machine, const std::vector<NominalFault>& faults) {
  machine::Machine described = machine;
  for (const NominalFault& fault : faults) {
    if (fault.kind == NominalKind::kDirection) {
      Eigen::Vector3d& direction = described.axes[fault.axis].direction;
      direction = fault.direction.value_or(-direction);
    } else if (fault.kind == NominalKind::kPivot) {
      described.axes[fault.axis].point_mm += fault.offset_mm;
    }
  }
  return described;
}

absl::Status Misstate(const std::vector<NominalFault>& faults, session::Session* session) {
  const std::string name = session::FindHeader(*session, "session").value_or("");
  for (size_t i = 0; i < faults.size(); ++i) {
    const NominalFault& fault = faults[i];
    const bool is_named = std::find(fault.sessions.begin(), fault.sessions.end(), name) != fault.sessions.end();
    if (!fault.sessions.empty() && !is_named) continue;
    absl::Status changed;
    if (fault.kind == NominalKind::kToolLength) changed = MoveTip(fault, session);
    if (fault.kind == NominalKind::kSwapped || fault.kind == NominalKind::kUnit)
      changed = ChangeColumns(fault, session);
    if (!changed.ok()) return base::Within(absl::StrCat("nominal[", i, "]: session '", name, "'"), changed);
  }
  return absl::OkStatus();
}

}  // namespace axiscal::synthetic
