#include <gtest/gtest.h>

#include "core/base/error_detail.h"
#include "server/storage/page_token.h"
#include "server/storage/testing/temp_database.h"

namespace axiscal::storage {
namespace {

TEST(Machines, AreKeptWithEveryRevision) {
  TempDatabase database;
  const MachineId id("mt");
  const auto created = database->CreateMachine(id, "{\"a\":1}", Cell(""));
  ASSERT_TRUE(created.ok()) << created.status();
  EXPECT_EQ(created->revision, 1);
  database.clock.Advance(std::chrono::seconds(5));
  const auto updated = database->UpdateMachine(id, 1, "{\"a\":2}", Cell(""));
  ASSERT_TRUE(updated.ok()) << updated.status();
  EXPECT_EQ(updated->revision, 2);
  EXPECT_EQ(updated->updated_at - updated->created_at, std::chrono::seconds(5));
  EXPECT_EQ(database->GetMachine(id)->description_json, "{\"a\":2}");
  EXPECT_EQ(database->GetMachineRevision(id, 1)->description_json, "{\"a\":1}");
  EXPECT_EQ(base::ErrorReason(database->GetMachineRevision(id, 3).status()), "MACHINE_NOT_FOUND");
}

TEST(Machines, CreateTwiceIsOneMachineUnlessItDiffers) {
  TempDatabase database;
  ASSERT_TRUE(database->CreateMachine(MachineId("mt"), "{}", Cell("")).ok());
  EXPECT_TRUE(database->CreateMachine(MachineId("mt"), "{}", Cell("")).ok());
  const absl::Status other = database->CreateMachine(MachineId("mt"), "{\"a\":1}", Cell("")).status();
  EXPECT_TRUE(absl::IsAlreadyExists(other)) << other;
  EXPECT_EQ(base::ErrorReason(other), "MACHINE_EXISTS");
}

TEST(Machines, UpdateOfAnOldRevisionIsRefused) {
  TempDatabase database;
  ASSERT_TRUE(database->CreateMachine(MachineId("mt"), "{}", Cell("")).ok());
  ASSERT_TRUE(database->UpdateMachine(MachineId("mt"), 1, "{\"a\":1}", Cell("")).ok());
  const absl::Status late = database->UpdateMachine(MachineId("mt"), 1, "{\"b\":1}", Cell("")).status();
  EXPECT_TRUE(absl::IsAborted(late)) << late;
  EXPECT_EQ(base::GetErrorDetail(late)->facts.at("etag"), "2");
  EXPECT_EQ(database->GetMachine(MachineId("mt"))->description_json, "{\"a\":1}");
}

TEST(Machines, DeletedOnesAreHiddenButReadable) {
  TempDatabase database;
  ASSERT_TRUE(database->CreateMachine(MachineId("mt"), "{}", Cell("")).ok());
  ASSERT_TRUE(database->DeleteMachine(MachineId("mt"), 0, Cell("")).ok());
  EXPECT_TRUE(database->DeleteMachine(MachineId("mt"), 0, Cell("")).ok());
  EXPECT_TRUE(database->ListMachines({})->rows.empty());
  EXPECT_TRUE(database->GetMachine(MachineId("mt"))->deleted_at.has_value());
  EXPECT_EQ(base::ErrorReason(database->CreateSession(TestSession("")).status()), "MACHINE_DELETED");
}

TEST(Machines, PagesStayStableWhileMachinesAreAdded) {
  TempDatabase database;
  for (const char* name : {"d", "b", "f", "h"})
    ASSERT_TRUE(database->CreateMachine(MachineId(name), "{}", Cell("")).ok());
  const auto first = database->ListMachines({2, ""});
  ASSERT_EQ(first->rows.size(), 2u);
  EXPECT_EQ(first->rows[1].id.text(), "d");
  ASSERT_TRUE(database->CreateMachine(MachineId("a"), "{}", Cell("")).ok());
  const auto second = database->ListMachines({2, first->next_token});
  ASSERT_EQ(second->rows.size(), 2u);
  EXPECT_EQ(second->rows[0].id.text(), "f");
  EXPECT_EQ(second->next_token, "");
}

TEST(Machines, BadPagesAreRefused) {
  TempDatabase database;
  for (const char* name : {"a", "b"}) ASSERT_TRUE(database->CreateMachine(MachineId(name), "{}", Cell("")).ok());
  const std::string token = database->ListMachines({1, ""})->next_token;
  EXPECT_EQ(base::ErrorReason(database->ListMachines({-1, ""}).status()), "PAGE_INVALID");
  EXPECT_EQ(base::ErrorReason(database->ListMachines({1, token + "x"}).status()), "PAGE_INVALID");
  EXPECT_EQ(base::ErrorReason(database->ListMachines({1, "%"}).status()), "PAGE_INVALID");
  EXPECT_EQ(base::ErrorReason(database->LatestFleet({}, {1, token}).status()), "PAGE_INVALID");
  // With a right checksum too, a key must be one that a list gives.
  for (const std::string key : {"", "x", "12x", " 1", "-1", "99999999999999999999"}) {
    const PageStart start = {"sessions||0", 1, {}};
    const absl::Status forged = database->ListSessions({}, {1, MakePageToken(start, key)}).status();
    EXPECT_EQ(base::ErrorReason(forged), "PAGE_INVALID") << key << ": " << forged;
    EXPECT_EQ(base::GetErrorDetail(forged)->facts["field"], "page_token");
  }
}

TEST(Machines, ChangesAreAudited) {
  TempDatabase database;
  ASSERT_TRUE(database->CreateMachine(MachineId("mt"), "{}", Cell("r1")).ok());
  ASSERT_TRUE(database->DeleteMachine(MachineId("mt"), 0, Cell("r2")).ok());
  const auto audit = database->ListAudit({});
  ASSERT_EQ(audit->rows.size(), 2u);
  EXPECT_EQ(audit->rows[0].action, "machine.delete");
  EXPECT_EQ(audit->rows[1].resource, "machines/mt");
  EXPECT_EQ(audit->rows[1].principal, "cell");
  EXPECT_EQ(audit->rows[1].detail, "request_id r1");
}

}  // namespace
}  // namespace axiscal::storage
