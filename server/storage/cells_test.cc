#include "server/storage/cells.h"

#include <gtest/gtest.h>

#include "core/base/error_detail.h"
#include "server/storage/testing/temp_database.h"

namespace axiscal::storage {
namespace {

const MachineId kServed("mt");

CellReport Report(const std::string& name, int64_t waiting = 0, const std::string& problem = "") {
  CellReport report;
  report.machine = kServed;
  report.name = name;
  report.version = "0.1";
  report.problem = problem;
  report.waiting_files = waiting;
  report.waiting_bytes = 1000 * waiting;
  report.max_bytes = 1 << 30;
  return report;
}

class Cells : public testing::Test {
 protected:
  Cells() {
    DEMAND(database->CreateMachine(kServed, "{}", Cell("")).ok());
    DEMAND(database->CreateMachine(MachineId("other"), "{}", Cell("")).ok());
  }
  std::vector<CellRecord> List(const Visible& visible = {}) {
    const auto page = database->ListCells(std::nullopt, {}, visible);
    EXPECT_TRUE(page.ok()) << page.status();
    return page.ok() ? page->rows : std::vector<CellRecord>();
  }

  TempDatabase database;
};

TEST_F(Cells, TheNewestReportStandsAndSilenceGrows) {
  ASSERT_TRUE(database->ReportCell(Report("seven", 3, "full"), {"ann", ""}).ok());
  database.clock.Advance(std::chrono::minutes(14));
  EXPECT_FALSE(List().at(0).is_silent());
  database.clock.Advance(std::chrono::minutes(2));
  EXPECT_TRUE(List().at(0).is_silent());
  EXPECT_EQ(List().at(0).silence, std::chrono::minutes(16));
  const auto again = database->ReportCell(Report("seven", 2), {"bob", ""});
  ASSERT_TRUE(again.ok()) << again.status();
  ASSERT_EQ(List().size(), 1u);
  const CellRecord cell = List().at(0);
  EXPECT_FALSE(cell.is_silent());
  EXPECT_EQ(cell.reported_by, "bob");
  EXPECT_EQ(cell.report.problem, "");
  EXPECT_EQ(cell.report.waiting_bytes, 2000);
  EXPECT_EQ(cell.reported_at, database.clock.UtcNow());
}

// A server that was down for a weekend hears of no cell meanwhile, which is nobody's silence; nor does a clock that is
// set make one.
TEST_F(Cells, TheTimeWithoutAServerIsNoSilence) {
  ASSERT_TRUE(database->ReportCell(Report("seven"), Cell("")).ok());
  database.Close();
  database.clock.Advance(std::chrono::hours(60));
  database.Open();
  EXPECT_LT(List().at(0).silence, std::chrono::minutes(1));
  database.clock.Advance(std::chrono::minutes(16));
  EXPECT_TRUE(List().at(0).is_silent());
}

TEST_F(Cells, AreSummedOncePerSpool) {
  ASSERT_TRUE(database->ReportCell(Report("seven", 3, "full"), Cell("")).ok());
  CellReport of_other = Report("seven", 3, "full");
  of_other.machine = MachineId("other");
  ASSERT_TRUE(database->ReportCell(of_other, Cell("")).ok());
  database.clock.Advance(std::chrono::minutes(16));
  ASSERT_TRUE(database->ReportCell(Report("eight", 4), Cell("")).ok());
  const auto sums = database->SumCells();
  ASSERT_TRUE(sums.ok()) << sums.status();
  EXPECT_EQ(sums->well, 1);
  EXPECT_EQ(sums->silent, 1);
  EXPECT_EQ(sums->with_problem, 0) << "it is silent: its last word is old";
  EXPECT_EQ(sums->waiting_files, 7);
  EXPECT_EQ(sums->waiting_bytes, 7000);
}

TEST_F(Cells, AreShownToWhoMaySeeTheMachine) {
  ASSERT_TRUE(database->ReportCell(Report("seven"), Cell("")).ok());
  CellReport of_other = Report("eight");
  of_other.machine = MachineId("other");
  ASSERT_TRUE(database->ReportCell(of_other, Cell("")).ok());
  const auto seen = List({false, {{records::Scope::Kind::kMachine, "mt"}}, "ann"});
  ASSERT_EQ(seen.size(), 1u);
  EXPECT_EQ(seen[0].report.name, "seven");
  const auto first = database->ListCells(std::nullopt, {1, ""}, {});
  ASSERT_TRUE(first.ok()) << first.status();
  EXPECT_EQ(first->rows.at(0).report.name, "eight");
  const auto second = database->ListCells(std::nullopt, {1, first->next_token}, {});
  ASSERT_TRUE(second.ok()) << second.status();
  EXPECT_EQ(second->rows.at(0).report.name, "seven");
  EXPECT_EQ(second->next_token, "");
}

TEST_F(Cells, AreForgottenAndBounded) {
  EXPECT_EQ(base::ErrorReason(database->ForgetCell(kServed, "seven", Cell(""))), "CELL_NOT_FOUND");
  for (int i = 0; i < 16; ++i) ASSERT_TRUE(database->ReportCell(Report(absl::StrCat(i)), Cell("")).ok());
  EXPECT_EQ(base::ErrorReason(database->ReportCell(Report("seven"), Cell("")).status()), "TOO_MANY_CELLS");
  EXPECT_TRUE(database->ReportCell(Report("3"), Cell("")).ok()) << "which is there already";
  EXPECT_TRUE(database->ForgetCell(kServed, "3", Cell("")).ok());
  EXPECT_TRUE(database->ReportCell(Report("seven"), Cell("")).ok());
  EXPECT_EQ(database->ListAudit({})->rows[0].action, "cell.forget");
  CellReport unknown = Report("x");
  unknown.machine = MachineId("none");
  EXPECT_EQ(base::ErrorReason(database->ReportCell(unknown, Cell("")).status()), "MACHINE_NOT_FOUND");
}

}  // namespace
}  // namespace axiscal::storage
