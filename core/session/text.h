// Small text helpers of the session readers.
#ifndef AXISCAL_CORE_SESSION_TEXT_H_
#define AXISCAL_CORE_SESSION_TEXT_H_

#include <optional>
#include <string>
#include <vector>

#include "core/base/clock.h"

namespace axiscal::session {

// Numbers separated by blanks; false when `text` is anything else.
bool ParseNumbers(const std::string& text, std::vector<double>* numbers);

// Well-formed UTF-8 without control characters.
bool IsPlainText(const std::string& text);

// `text` cut after 40 bytes, with control characters and bytes beyond ASCII as \xNN, bare or in quotes: for messages.
std::string Printable(const std::string& text);
std::string Quoted(const std::string& text);

// A date of ISO 8601 with or without a time ("2026-05-31", "2026-05-31T14:03:07.5+02:00", or a blank for T); without a
// zone it is UTC. Nothing when `text` is anything else, or no day of the calendar.
std::optional<base::UtcTime> ParseIso8601(const std::string& text);

}  // namespace axiscal::session

#endif  // AXISCAL_CORE_SESSION_TEXT_H_
