#include "core/instruments/plausible.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <random>

#include "core/base/testing/source_path.h"
#include "core/instruments/evaluation.h"
#include "core/session/case.h"
#include "core/session/column_rules.h"

namespace axiscal::instruments {
namespace {

using ::testing::HasSubstr;
using ::testing::StartsWith;

session::Case Load(const std::string& name) {
  auto read = session::ReadCase(absl::StrCat(base::SourcePath(""), "/tests/data/loop/", name));
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

// The first reading, from 1, that disagrees with the nominal machine, found by predicting every one; 0: none.
int FirstDisagreeing(const session::Session& session, const machine::Machine& machine) {
  const MeasuringRun run = BindSession(session, machine).value();
  const double no_setup[kMaxSetupParameters] = {};
  for (int k = 0; k < run.reading_count(); ++k) {
    double predicted_mm[kMaxRows];
    Predict(machine, run, k, {}, no_setup, predicted_mm);
    for (int row = 0; row < run.row_count; ++row) {
      if (std::abs(predicted_mm[row] - run.measured_mm(row, k)) > kMaxDisagreementMm) return k + 1;
    }
  }
  return 0;
}

TEST(Plausible, ADenseSeriesIsRefusedAtTheReadingThatPredictingEveryOneFinds) {
  std::mt19937 random(1);
  std::uniform_real_distribution<double> slope(0.05, 2.0);
  int refused = 0;
  for (const char* name : {"case-000", "case-001", "case-012"}) {
    const session::Case loaded = Load(name);
    for (const session::Session& measured : loaded.fit) {
      for (const char* moved : {"X_mm", "Z_mm", "B_deg", "C_deg"}) {
        if (session::FindColumn(measured, moved) == nullptr) continue;
        session::Session session = measured;
        const double per_reading = slope(random);
        double drift = 0.0;
        for (double& value : Values(session, moved)) value += drift += per_reading;
        const int first = FirstDisagreeing(session, loaded.machine);
        const absl::Status status = CheckPlausible(session, loaded.machine);
        EXPECT_EQ(status.ok(), first == 0) << name << " " << moved << ": " << status;
        refused += first > 0;
        const std::string place = first > 0 ? absl::StrCat(": reading ", first, " of session") : "";
        EXPECT_THAT(std::string(status.message()), HasSubstr(place));
      }
    }
  }
  EXPECT_GT(refused, 10);
}

// Sticks at reading 101, for so many readings.
session::Session Stuck(session::Session session, int readings) {
  std::vector<double>& values = Values(session, "dL_mm");
  std::fill_n(values.begin() + 100, readings, values[100]);
  return session;
}

TEST(Alive, AnInstrumentThatReadsOneValueIsRefused) {
  const session::Case loaded = Load("case-000");
  session::Session session = loaded.fit[0];
  Values(session, "dL_mm").assign(session.reading_count(), 0.0123);
  EXPECT_THAT(std::string(CheckPlausible(session, loaded.machine).message()),
              StartsWith(absl::StrCat("line 9: readings 1 to ", session.reading_count(), " of session '",
                                      *session::FindHeader(session, "session"),
                                      "': dL_mm = 0.0123 mm in all of them while the machine moves")));
}

TEST(Alive, AStretchOfMoreThanTwentyMovesIsRefused) {
  const session::Case loaded = Load("case-000");
  EXPECT_TRUE(CheckPlausible(Stuck(loaded.fit[0], 15), loaded.machine).ok());
  EXPECT_THAT(std::string(CheckPlausible(Stuck(loaded.fit[0], 25), loaded.machine).message()),
              HasSubstr("readings 101 to 125 of session"));
}

TEST(Alive, APartOfASessionIsJudgedByWhatElseIsInIt) {
  const session::Case loaded = Load("case-000");
  EXPECT_THAT(std::string(CheckPlausible(Stuck(loaded.fit[0], 25), loaded.machine, 1000).message()),
              HasSubstr("readings 1101 to 1125 of session"));
  session::Session part = loaded.fit[0];
  Values(part, "dL_mm").assign(part.reading_count(), 0.0123);  // the whole may have a coarse display
  EXPECT_TRUE(CheckPlausible(part, loaded.machine, 1000).ok());
}

TEST(Alive, AMachineAtRestMayReadTheSame) {
  const session::Case loaded = Load("case-000");
  session::Session session = Stuck(loaded.fit[0], 200);
  for (session::Column& column : session.columns) {
    if (column.name != "t_s" && column.name != "dL_mm")
      std::fill_n(column.values.begin() + 100, 200, column.values[100]);
  }
  EXPECT_TRUE(CheckPlausible(session, loaded.machine).ok());
}

TEST(Alive, ACoarseDisplayOrASignalWithoutNoiseMayStandStill) {
  const session::Case loaded = Load("case-000");
  session::Session coarse = loaded.fit[0], smooth = loaded.fit[0];
  std::vector<double>&displayed = Values(coarse, "dL_mm"), &exact = Values(smooth, "dL_mm");
  for (double& value : displayed) value = 0.02 * std::round(value / 0.02);
  for (size_t k = 0; k < exact.size(); ++k) exact[k] = 1e-4 * std::round(50.0 * std::sin(0.005 * k));
  const auto longest = [](const std::vector<double>& values) {
    int most = 0;
    for (size_t k = 1, now = 0; k < values.size(); ++k) {
      now = values[k] == values[k - 1] ? now + 1 : 0;
      most = std::max(most, static_cast<int>(now));
    }
    return most;
  };
  EXPECT_GT(longest(displayed), 2 * kDeadMoves);
  EXPECT_GT(longest(exact), 2 * kDeadMoves);
  EXPECT_TRUE(CheckPlausible(coarse, loaded.machine).ok());
  EXPECT_TRUE(CheckPlausible(smooth, loaded.machine).ok());
}

}  // namespace
}  // namespace axiscal::instruments
