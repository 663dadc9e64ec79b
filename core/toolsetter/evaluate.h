// What a stored or brought session of the tool setter says: the beam's reference from a `tool-setter` session, length
// and wear from a `tool-curve` session.
#ifndef AXISCAL_CORE_TOOLSETTER_EVALUATE_H_
#define AXISCAL_CORE_TOOLSETTER_EVALUATE_H_

#include <string>

#include "core/reports/tool_setter.h"
#include "core/session/session.h"
#include "core/toolsetter/reference.h"

namespace axiscal::toolsetter {

// True for the instruments that Evaluate knows.
bool IsToolSetter(const std::string& instrument);

// Of a session before its readings: INVALID_ARGUMENT naming key, value and rule where beam, rods or cutter cannot be
// what Evaluate could work with (a rod whose normal points up, inserts that do not reach the beam). OK for other
// instruments.
absl::Status CheckHeader(const session::Session& session);

// INVALID_ARGUMENT as ReadRodSession, FitReference, ReadCurveSession and FitWear; also for other instruments.
absl::StatusOr<reports::ToolSetter> Evaluate(const session::Session& session, const ReferenceOptions& options);

}  // namespace axiscal::toolsetter

#endif  // AXISCAL_CORE_TOOLSETTER_EVALUATE_H_
