#include "core/instruments/plausible.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "core/session/case.h"
#include "core/session/column_rules.h"

namespace axiscal::instruments {
namespace {

using ::testing::HasSubstr;
using ::testing::StartsWith;

session::Case Load(const std::string& name) {
  auto read = session::ReadCase(absl::StrCat(AXISCAL_SOURCE_DIR, "/tests/data/loop/", name));
  EXPECT_TRUE(read.ok()) << read.status();
  return *std::move(read);
}

std::vector<double>& Values(session::Session& session, const std::string& name) {
  for (session::Column& column : session.columns) {
    if (column.name == name) return column.values;
  }
  ADD_FAILURE() << name;
  return session.columns[0].values;
}

TEST(Plausible, EverySessionOfTheLoopCasesIs) {
  for (const char* name : {"case-000", "case-001", "case-002", "case-012", "case-013", "case-014"}) {
    const session::Case loaded = Load(name);
    for (const auto* sessions : {&loaded.fit, &loaded.check}) {
      for (const session::Session& session : *sessions) {
        const absl::Status status = CheckPlausible(session, loaded.machine);
        EXPECT_TRUE(status.ok()) << name << ": " << status;
      }
    }
  }
}

TEST(Plausible, MetresAreNot) {
  const session::Case loaded = Load("case-000");
  session::Session session = loaded.fit[0];
  for (const char* axis : {"X_mm", "Y_mm", "Z_mm"}) {
    for (double& value : Values(session, axis)) value /= 1000;
  }
  EXPECT_THAT(std::string(CheckPlausible(session, loaded.machine).message()),
              StartsWith(absl::StrCat("line 9: reading 1 of session '", *session::FindHeader(session, "session"),
                                      "': dL_mm = 0.0179 mm, but at these positions")));
}

TEST(Plausible, APartOfASessionSaysItsPlaceInTheWhole) {
  const session::Case loaded = Load("case-000");
  session::Session part = loaded.fit[0];
  Values(part, "Z_mm")[2] += 500;
  EXPECT_THAT(std::string(CheckPlausible(part, loaded.machine, 1000).message()),
              StartsWith(absl::StrCat("line ", session::ReadingLine(part.header.size(), 1002), ": reading 1003 of")));
}

TEST(Plausible, DegreesWhereMillimetresBelongAreNot) {
  const session::Case loaded = Load("case-000");
  session::Session session = loaded.fit[0];
  std::swap(Values(session, "X_mm"), Values(session, "B_deg"));
  EXPECT_THAT(std::string(CheckPlausible(session, loaded.machine).message()), HasSubstr("are the units (mm, deg)"));
}

TEST(Plausible, AWrongSignOfAnAxisIsNot) {
  session::Case loaded = Load("case-001");
  loaded.machine.axes[machine::FindAxis(loaded.machine, "Y")].direction *= -1;
  EXPECT_EQ(CheckPlausible(loaded.fit[0], loaded.machine).code(), absl::StatusCode::kInvalidArgument);
}

}  // namespace
}  // namespace axiscal::instruments
