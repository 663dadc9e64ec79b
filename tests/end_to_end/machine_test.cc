// Machines, paging, etags, and the server's own answers.
#include "axiscal/v1/machines_service.grpc.pb.h"
#include "core/base/error_detail.h"
#include "tests/end_to_end/testing/fixture.h"
#include "tests/end_to_end/testing/raw_upload.h"

namespace axiscal {
namespace {

using testing::MachineJson;
using Machine = testing::EndToEnd;

TEST_F(Machine, IsStoredAsItWasDescribed) {
  const auto created = client().CreateMachine(MachineJson("mt"));
  ASSERT_OK(created);
  EXPECT_EQ(created->revision, 1);
  const auto read = client().GetMachine(MachineId("mt"));
  ASSERT_OK(read);
  EXPECT_EQ(read->description_json, MachineJson("mt"));
  ASSERT_OK(client().CreateMachine(MachineJson("mt")));
}

TEST_F(Machine, ABadDescriptionIsRefusedWithItsField) {
  std::string json = MachineJson("mt");
  json.replace(json.find("[1, 0, 0]"), 9, "[1, 1, 0]");
  const auto created = client().CreateMachine(json);
  EXPECT_EQ(created.status().code(), absl::StatusCode::kInvalidArgument);
  const auto detail = base::GetErrorDetail(created.status());
  ASSERT_TRUE(detail.has_value());
  EXPECT_EQ(detail->reason, "MACHINE_INVALID");
  EXPECT_EQ(detail->facts.at("field"), "description_json");
  EXPECT_NE(created.status().message().find("X"), std::string::npos) << created.status();
}

TEST_F(Machine, AStaleEtagIsRefusedAndOldRevisionsStayReadable) {
  ASSERT_OK(client().CreateMachine(MachineJson("mt")));
  std::string edited = MachineJson("mt");
  edited.replace(edited.find("\"EY0C\""), 6, "\"EZ0T\"");
  const auto updated = client().UpdateMachine(edited, 1);
  ASSERT_OK(updated);
  EXPECT_EQ(updated->revision, 2);
  const auto stale = client().UpdateMachine(MachineJson("mt"), 1);
  EXPECT_EQ(stale.status().code(), absl::StatusCode::kAborted);
  EXPECT_EQ(base::ErrorReason(stale.status()), "ETAG_MISMATCH");
  const auto first = client().GetMachineRevision(MachineId("mt"), 1);
  ASSERT_OK(first);
  EXPECT_EQ(first->description_json, MachineJson("mt"));
}

TEST_F(Machine, PagesAreInOrderOfTheId) {
  for (const char* id : {"c", "a", "e", "b", "d"}) ASSERT_OK(client().CreateMachine(MachineJson(id)));
  const auto first = client().ListMachines({2, ""});
  ASSERT_OK(first);
  ASSERT_EQ(first->rows.size(), 2u);
  EXPECT_EQ(first->rows[0].id.text(), "a");
  ASSERT_OK(client().CreateMachine(MachineJson("aa")));  // before the page's end: not seen again
  const auto second = client().ListMachines({10, first->next_token});
  ASSERT_OK(second);
  ASSERT_EQ(second->rows.size(), 3u);
  EXPECT_EQ(second->rows[0].id.text(), "c");
  EXPECT_TRUE(second->next_token.empty());
}

TEST_F(Machine, BadPagesAreRefused) {
  EXPECT_EQ(base::ErrorReason(client().ListMachines({-1, ""}).status()), "PAGE_INVALID");
  EXPECT_EQ(base::ErrorReason(client().ListMachines({1, "not a token"}).status()), "PAGE_INVALID");
}

TEST_F(Machine, ADeletedMachineTakesNoSessions) {
  ASSERT_OK(client().CreateMachine(MachineJson("mt")));
  ASSERT_OK(client().DeleteMachine(MachineId("mt"), 1));
  const auto upload = client().Upload(MachineId("mt"), testing::BallbarSession("mt", "BX", 10));
  EXPECT_EQ(base::ErrorReason(upload.status()), "MACHINE_DELETED");
  const auto machines = client().ListMachines();
  ASSERT_OK(machines);
  EXPECT_TRUE(machines->rows.empty());
}

TEST_F(Machine, TheServerSaysHowItIs) {
  EXPECT_TRUE(client().CheckHealth().ok());
  const auto info = client().GetServerInfo();
  ASSERT_OK(info);
  EXPECT_FALSE(info->software_version.empty());
  EXPECT_GT(info->schema_version, 0);
  EXPECT_GT(info->workers, 0);
  EXPECT_FALSE(info->draining);
}

TEST_F(Machine, AMalformedUnaryCallIsInternalAndChangesNothing) {
  const grpc::Status status =
      testing::SendBytes(channel(), "/axiscal.v1.Machines/CreateMachine", {"\x0a\xff\xff\xff\xff"});
  EXPECT_FALSE(status.ok());
  const auto machines = client().ListMachines();
  ASSERT_OK(machines);
  EXPECT_TRUE(machines->rows.empty());
}

}  // namespace
}  // namespace axiscal
