// The fifteen cases of another simulator (tests/data/loop) and what went into them (truth.json).
#ifndef AXISCAL_TESTS_KNOWN_ANSWERS_LOOP_TRUTH_H_
#define AXISCAL_TESTS_KNOWN_ANSWERS_LOOP_TRUTH_H_

#include <gtest/gtest.h>

#include <nlohmann/json.hpp>
#include <optional>
#include <string>
#include <vector>

#include "core/machine/error_model.h"
#include "core/session/case.h"

namespace axiscal::known_answers::loop_truth {

std::vector<std::string> CaseNames();
// "case_003", as test names allow.
std::string NameOf(const testing::TestParamInfo<std::string>& param);
session::Case ReadCase(const std::string& name);
nlohmann::json ReadTruth(const std::string& name);

// Bad readings (one in a hundred), correlated noise and a wrong stated sigma: 012 and later. Bad readings stay in the
// oracle's figures; how far a fit leans towards them is its own choice.
bool IsDirty(const nlohmann::json& truth);

// An effect of a truth file, with start values of its own for what is not linear; nothing for `bump` and `step`, which
// are no shapes of error terms.
std::optional<machine::ErrorTerm> TermOf(const nlohmann::json& effect, const machine::Machine& machine);

}  // namespace axiscal::known_answers::loop_truth

#endif  // AXISCAL_TESTS_KNOWN_ANSWERS_LOOP_TRUTH_H_
