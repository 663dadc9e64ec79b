// The tables of dialect.h: which code means what, by controller family. Later tables of a dialect override earlier
// ones.
#ifndef AXISCAL_CORE_NC_DIALECT_TABLES_H_
#define AXISCAL_CORE_NC_DIALECT_TABLES_H_

#include <vector>

#include "core/nc/dialect.h"

namespace axiscal::nc {

std::vector<CodeEntry> IsoCodes();       // on which Fanuc, Haas, LinuxCNC and Sinumerik agree
std::vector<CodeEntry> FanucCodes();     // Fanuc milling and Mazak EIA
std::vector<CodeEntry> HaasCodes();      // over FanucCodes
std::vector<CodeEntry> LinuxCncCodes();  // over IsoCodes
std::vector<CodeEntry> SinumerikCodes();
std::vector<CodeEntry> KlartextCodes();  // M functions only
// M codes that start nothing and move no axis, and those of the same manuals that do.
std::vector<CodeEntry> FanucM();
std::vector<CodeEntry> HaasM();
std::vector<CodeEntry> LinuxCncM();
std::vector<CodeEntry> SinumerikM();
std::vector<CodeEntry> KlartextM();
std::vector<Keyword> MacroKeywords();    // custom macro B
std::vector<Keyword> FanucCorners();     // Fanuc, Mazak and Haas
std::vector<Keyword> LinuxCncKeywords();
std::vector<Keyword> SinumerikKeywords();
std::vector<Keyword> KlartextKeywords();
std::vector<DistanceName> SinumerikDistances();

}  // namespace axiscal::nc

#endif  // AXISCAL_CORE_NC_DIALECT_TABLES_H_
