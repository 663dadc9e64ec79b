// How a session was measured, from its header, in words.
#ifndef AXISCAL_CORE_SHEET_SETUP_WORDS_H_
#define AXISCAL_CORE_SHEET_SETUP_WORDS_H_

#include <string>
#include <vector>

#include "core/records/session.h"
#include "core/sheet/sheet.h"

namespace axiscal::sheet {

// "touch probe (sphere centres)", "length from an anchor"; an instrument that is not known by its own name.
std::string InstrumentWords(const records::SessionRecord& session, Language language);

// "(0; 0; -350) mm", of `tool_tip_mm`; empty where it is not stated.
std::string ToolPointText(const std::vector<session::HeaderEntry>& header, Language language);

// What headers state of set-ups, a line for sessions of which the same is said, with the tool point where it is not the
// same in all: "BX, CR: table ball at (50; 0; 65) mm, bar 100 mm", "T: tracker knocked at t = 900 s".
std::vector<std::string> SetupLines(const std::vector<const records::SessionRecord*>& sessions, Language language);
// "BX: certificate 4711 of bar_length, valid until 2027-01-31", likewise.
std::vector<std::string> CertificateLines(const std::vector<const records::SessionRecord*>& sessions,
                                          Language language);

// The words of a fact that a fit's report names, as "thermometer of temp_C, +- 0.1 K", where the header states it: else
// as it is.
std::string StatedFactText(const std::string& fact, const std::vector<records::SessionRecord>& sessions,
                           Language language);

}  // namespace axiscal::sheet

#endif  // AXISCAL_CORE_SHEET_SETUP_WORDS_H_
