// What the worked examples ship is what the simulator gives; make_example_sessions writes it anew.
#include "tests/known_answers/example_sessions.h"

#include <gtest/gtest.h>

#include "core/base/testing/source_path.h"
#include "core/session/read_session.h"

namespace axiscal::known_answers {
namespace {

TEST(ExampleSessions, AreTheSimulators) {
  const auto made = ExampleSessions();
  ASSERT_TRUE(made.ok()) << made.status();
  ASSERT_FALSE(made->empty());
  for (const auto& [file, session] : *made) {
    const auto shipped = session::ReadSessionFile(base::SourcePath("/deploy/examples/") + file);
    ASSERT_TRUE(shipped.ok()) << shipped.status();
    EXPECT_EQ(shipped->header, session.header) << file;
    ASSERT_EQ(shipped->columns.size(), session.columns.size()) << file;
    for (size_t i = 0; i < session.columns.size(); ++i) {
      const session::Column &ours = session.columns[i], &theirs = shipped->columns[i];
      ASSERT_EQ(theirs.name, ours.name) << file;
      EXPECT_EQ(theirs.texts, ours.texts) << file;
      ASSERT_EQ(theirs.values.size(), ours.values.size()) << file;
      // One step of the rounding: another compiler may round a last bit otherwise.
      for (size_t k = 0; k < ours.values.size(); ++k)
        ASSERT_NEAR(theirs.values[k], ours.values[k], 1.01e-4) << file << ' ' << ours.name << ' ' << k;
    }
  }
}

}  // namespace
}  // namespace axiscal::known_answers
