// The sessions of the worked examples that no paper prints (deploy/examples): made by the product's own simulator from
// the errors of each example's truth.json.
#ifndef AXISCAL_TESTS_KNOWN_ANSWERS_EXAMPLE_SESSIONS_H_
#define AXISCAL_TESTS_KNOWN_ANSWERS_EXAMPLE_SESSIONS_H_

#include <string>
#include <vector>

#include "core/base/status.h"
#include "core/session/session.h"

namespace axiscal::known_answers {

struct ExampleSession {
  std::string file;  // below deploy/examples
  session::Session session;
};

// With noise of the stated sigma, positions and readings to 0.1 um as controls report them.
absl::StatusOr<std::vector<ExampleSession>> ExampleSessions();

}  // namespace axiscal::known_answers

#endif  // AXISCAL_TESTS_KNOWN_ANSWERS_EXAMPLE_SESSIONS_H_
