#include "server/storage/handed_tables.h"

#include <gtest/gtest.h>

#include "server/storage/testing/temp_database.h"

namespace axiscal::storage {
namespace {

TEST(HandedTables, AreKnownByMachineOverARestart) {
  TempDatabase database;
  ASSERT_TRUE(database->CreateMachine(MachineId("mt"), "{}", Cell("")).ok());
  ASSERT_TRUE(database->CreateMachine(MachineId("other"), "{}", Cell("")).ok());
  const auto first = database->CreateCalibration(TestCalibration(database.clock.UtcNow(), -90.0));
  const auto second = database->CreateCalibration(TestCalibration(database.clock.UtcNow(), -80.0));
  ASSERT_TRUE(first.ok() && second.ok()) << first.status() << second.status();
  ASSERT_TRUE(database->NoteHandedTable(first->id, "siemens-cec", {"ann", ""}).ok());
  database.clock.Advance(std::chrono::hours(1));
  ASSERT_TRUE(database->NoteHandedTable(first->id, "siemens-cec", {"bob", ""}).ok());
  ASSERT_TRUE(database->NoteHandedTable(first->id, "general", {"ann", ""}).ok());
  ASSERT_TRUE(database->NoteHandedTable(second->id, "general", {"ann", ""}).ok());
  EXPECT_EQ(database->ListAudit({})->rows[0].action, "table.make");
  const base::UtcTime now = database.clock.UtcNow();
  database.Close();
  database.Open();
  const auto tables = database->ListHandedTables(MachineId("mt"));
  ASSERT_TRUE(tables.ok()) << tables.status();
  ASSERT_EQ(tables->size(), 3u);
  EXPECT_EQ(tables->at(0).calibration, first->id);
  EXPECT_EQ(tables->at(0).format, "general");
  EXPECT_EQ(tables->at(1).format, "siemens-cec");
  EXPECT_EQ(tables->at(1).handed_to, "bob");
  EXPECT_EQ(tables->at(1).handed_at, now);
  EXPECT_EQ(tables->at(2).calibration, second->id);
  EXPECT_TRUE(database->ListHandedTables(MachineId("other"))->empty());
  EXPECT_FALSE(database->ListHandedTables(MachineId("none")).ok());
  EXPECT_FALSE(database->NoteHandedTable(CalibrationId(77), "general", {"ann", ""}).ok());
}

}  // namespace
}  // namespace axiscal::storage
