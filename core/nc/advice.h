// What to add to a command line so that what was refused can be corrected.
#ifndef AXISCAL_CORE_NC_ADVICE_H_
#define AXISCAL_CORE_NC_ADVICE_H_

#include <cstddef>
#include <string>
#include <vector>

#include "core/machine/machine.h"

namespace axiscal::nc {

inline constexpr size_t kMaxAdvice = 50;
inline constexpr char kUnitAdvice[] = "--unit mm (or inch)";

// The options that the reason of a refusal asks for, in the words to type: "..." stands for a value that only the shop
// knows. None where no option helps.
std::vector<std::string> MissingOptions(const std::string& reason, const machine::Machine& machine);

// The machine's axes in the order in which programs write their words: X, Y, Z, A, B, C ...
std::vector<int> InWordOrder(const machine::Machine& machine);

// Makes one option of those for single M codes: --harmless-m 47,120.
void MergeHarmless(std::vector<std::string>* options);

}  // namespace axiscal::nc

#endif  // AXISCAL_CORE_NC_ADVICE_H_
