#include <gtest/gtest.h>

#include "server/handlers/create_machine.h"
#include "server/handlers/delete_machine.h"
#include "server/handlers/get_machine.h"
#include "server/handlers/list_machines.h"
#include "server/handlers/testing/test_core.h"
#include "server/handlers/update_machine.h"

namespace axiscal::handlers {
namespace {

class Machines : public ::testing::Test, protected TestCore {
 protected:
  absl::StatusOr<v1::CreateMachineResponse> Create(const std::string& json) {
    v1::CreateMachineRequest request;
    request.set_description_json(json);
    return CreateMachine(core, call, request);
  }
};

TEST_F(Machines, AreCreatedReadUpdatedAndDeleted) {
  ASSERT_TRUE(Create(kMachineJson).ok());
  const auto read = GetMachine(core, call, Parse<v1::GetMachineRequest>(R"(machine_id: "mt")"));
  ASSERT_TRUE(read.ok()) << read.status();
  EXPECT_EQ(read->machine().description_json(), kMachineJson);
  EXPECT_EQ(read->machine().etag(), 1);

  v1::UpdateMachineRequest update;
  update.set_description_json(absl::StrCat(kMachineJson, "\n"));
  EXPECT_EQ(FieldOf(UpdateMachine(core, call, update).status()), "etag");
  update.set_etag(1);
  EXPECT_EQ(UpdateMachine(core, call, update)->machine().etag(), 2);
  EXPECT_EQ(base::ErrorReason(UpdateMachine(core, call, update).status()), "ETAG_MISMATCH");

  const auto gone = DeleteMachine(core, call, Parse<v1::DeleteMachineRequest>(R"(machine_id: "mt" etag: 2)"));
  ASSERT_TRUE(gone.ok()) << gone.status();
  EXPECT_TRUE(gone->machine().has_deleted_utc_us());
  EXPECT_EQ(ListMachines(core, call, {})->machines_size(), 0);
}

TEST_F(Machines, ABadDescriptionChangesNothing) {
  const absl::Status status = Create(R"({"id": "mt"})").status();
  EXPECT_EQ(status.code(), absl::StatusCode::kInvalidArgument);
  EXPECT_EQ(base::ErrorReason(status), "MACHINE_INVALID");
  EXPECT_EQ(FieldOf(status), "description_json");
  EXPECT_EQ(ListMachines(core, call, {})->machines_size(), 0);
}

TEST_F(Machines, PagesAreBounded) {
  const auto refused = ListMachines(core, call, Parse<v1::ListMachinesRequest>("page_size: -1"));
  EXPECT_EQ(base::ErrorReason(refused.status()), "PAGE_INVALID");
}

}  // namespace
}  // namespace axiscal::handlers
