#include "server/storage/access.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "core/base/error_detail.h"
#include "server/storage/testing/temp_database.h"

namespace axiscal::storage {
namespace {

using records::Role;
using records::Scope;
using ::testing::ElementsAre;
using ::testing::IsEmpty;

const Caller kAdmin = {"root", ""};

TEST(AccessRows, NamesThatAreNoneAreRefused) {
  TempDatabase database;
  const std::vector<std::string> wrong = {"", "a b", "local:ann", "-a", "a.", "\xC3\xA4", std::string(65, 'a')};
  for (const std::string& name : wrong) {
    EXPECT_EQ(base::ErrorReason(database->CreatePrincipal(name, "", kAdmin).status()), "NAME_INVALID") << name;
  }
  EXPECT_TRUE(database->CreatePrincipal("a", "", kAdmin).ok());
  EXPECT_TRUE(database->CreatePrincipal("ann.b_c-d@shop", "", kAdmin).ok());
}

TEST(AccessRows, RolesAreGivenAndTakenAndWrittenDown) {
  TempDatabase database;
  StoreSession(*database, 1);
  ASSERT_TRUE(database->CreatePrincipal("ann", "turning shop", kAdmin).ok());
  const Grant one = {Role::kCell, {Scope::Kind::kMachine, "mt"}}, two = {Role::kViewer, {}};
  for (const Grant& grant : {one, two, one}) ASSERT_TRUE(database->ChangeRole("ann", grant, true, kAdmin).ok());
  EXPECT_THAT(database->ChangeRole("ann", two, true, kAdmin)->grants, ElementsAre(two, one));
  EXPECT_THAT(database->ChangeRole("ann", two, false, kAdmin)->grants, ElementsAre(one));
  EXPECT_EQ(base::ErrorReason(
                database->ChangeRole("ann", {Role::kCell, {Scope::Kind::kMachine, "none"}}, true, kAdmin).status()),
            "MACHINE_NOT_FOUND");
  EXPECT_EQ(base::ErrorReason(database->ChangeRole("bob", two, true, kAdmin).status()), "PRINCIPAL_NOT_FOUND");
  std::vector<std::string> actions;
  const auto audit = database->ListAudit({});
  ASSERT_TRUE(audit.ok());
  for (const AuditEntry& entry : audit->rows) {
    if (entry.principal == "root") actions.push_back(absl::StrCat(entry.action, ": ", entry.was, " > ", entry.became));
  }
  EXPECT_THAT(actions, ElementsAre("role.take: viewer of all machines; cell of machine mt > cell of machine mt",
                                   "role.grant: cell of machine mt > viewer of all machines; cell of machine mt",
                                   "role.grant: no role > cell of machine mt", "principal.create:  > no role"));
}

TEST(AccessRows, AFileKeepsThem) {
  TempDatabase database;
  StoreSession(*database, 1);
  ASSERT_TRUE(database->CreatePrincipal("ann", "", kAdmin).ok());
  ASSERT_TRUE(database->CreateToken({"ann", "hash", "desk", database.clock.UtcNow()}, kAdmin).ok());
  ASSERT_TRUE(database->ChangeGroup("turning", MachineId("mt"), true, kAdmin).ok());
  ASSERT_TRUE(database->SetFourEyes(MachineId("mt"), true, kAdmin).ok());
  database.Close();
  database.Open();
  const auto holder = database->FindHolderOfToken("hash");
  ASSERT_TRUE(holder.ok() && holder->has_value());
  EXPECT_EQ((*holder)->principal, "ann");
  EXPECT_EQ((*holder)->token_expires_at, database.clock.UtcNow());
  EXPECT_FALSE(database->FindHolderOfToken("other")->has_value());
  const auto machines = database->ListMachineAccess({});
  ASSERT_EQ(machines->rows.size(), 1u);
  EXPECT_THAT(machines->rows[0].groups, ElementsAre("turning"));
  EXPECT_TRUE(machines->rows[0].four_eyes);
}

// Rows of three machines in turn; pages of one show those of two of them, each once, in the list's order.
class VisibleRows : public testing::Test {
 protected:
  void SetUp() override {
    for (const std::string machine : {"a", "b", "c"}) {
      ASSERT_TRUE(database_->CreateMachine(MachineId(machine), "{}", kAdmin).ok());
    }
    for (int i = 0; i < 12; ++i) {
      const MachineId machine(std::string(1, static_cast<char>('a' + i % 3)));
      NewSession session = TestSession("");
      session.machine = machine;
      ASSERT_TRUE(database_->CreateSession(session).ok());
      NewJob job;
      job.kind = "identify";
      job.machine = machine;
      ASSERT_TRUE(database_->CreateJob(job, 100).ok());
      NewCalibration calibration = TestCalibration(database_.clock.UtcNow(), i);
      calibration.machine = machine;
      ASSERT_TRUE(database_->CreateCalibration(calibration).ok());
      const std::string sender = i % 2 == 0 ? "ann" : "bob", text = "G01 X" + std::to_string(i);
      const ProgramId program = database_->BeginProgram({"nc", "O1", {sender, std::to_string(i)}})->id;
      ASSERT_TRUE(database_->AppendProgram(program, 0, text).ok());
      ASSERT_TRUE(database_->FinishProgram(program, static_cast<int64_t>(text.size()), "").ok());
      job.program = program;
      if (i < 6) continue;
      ASSERT_TRUE(database_->CreateJob(job, 100).ok());
    }
    ASSERT_TRUE(database_->ChangeGroup("turning", MachineId("c"), true, kAdmin).ok());
  }
  template <typename List, typename Key>
  static std::vector<std::string> All(const List& list, const Key& key) {
    std::vector<std::string> keys;
    PageRequest page{1, ""};
    do {
      const auto rows = list(page);
      EXPECT_TRUE(rows.ok()) << rows.status();
      if (!rows.ok()) break;
      for (const auto& row : rows->rows) keys.push_back(key(row));
      page.token = rows->next_token;
    } while (!page.token.empty());
    return keys;
  }

  TempDatabase database_;
  const Visible some_{
      false, {{Scope::Kind::kMachine, "a"}, {Scope::Kind::kGroup, "turning"}, {Scope::Kind::kMachine, "a"}}, "ann"};
  const Visible none_{false, {}, "nobody"};
};

TEST_F(VisibleRows, PagesHoldThemAloneAndEachOnce) {
  const std::vector<std::string> in_turn = {"c", "a", "c", "a", "c", "a", "c", "a"};
  EXPECT_EQ(All([&](const PageRequest& page) { return database_->ListSessions({}, page, some_); },
                [](const SessionRecord& row) { return row.machine.text(); }),
            in_turn);
  EXPECT_EQ(All(
                [&](const PageRequest& page) {
                  return database_->ListSessions({{}, SessionState::kOpen}, page, some_);
                },
                [](const SessionRecord& row) { return row.machine.text(); }),
            in_turn);
  EXPECT_EQ(All(
                [&](const PageRequest& page) {
                  return database_->ListSessions({{}, {}, {}, "touch"}, page, some_);
                },
                [](const SessionRecord& row) { return row.machine.text(); }),
            in_turn);
  EXPECT_EQ(All([&](const PageRequest& page) { return database_->ListCalibrations({}, page, some_); },
                [](const CalibrationRecord& row) { return row.content.machine.text(); }),
            in_turn);
  const auto jobs = All([&](const PageRequest& page) { return database_->ListJobs({}, page, some_); },
                        [](const JobRecord& row) { return row.machine->text(); });
  EXPECT_EQ(jobs, (std::vector<std::string>{"c", "c", "a", "a", "c", "c", "a", "a", "c", "a", "c", "a"}));
  EXPECT_THAT(All([&](const PageRequest& page) { return database_->ListMachines(page, some_); },
                  [](const MachineRecord& row) { return row.id.text(); }),
              ElementsAre("a", "c"));
  EXPECT_THAT(All([&](const PageRequest& page) { return database_->LatestFleet({}, page, some_); },
                  [](const FleetRow& row) { return row.machine.text(); }),
              ElementsAre("a", "c"));
  // What ann sent (0, 2, 4 ...), and what was rewritten for a and c (of 6 to 11: 6, 8, 9, 11).
  EXPECT_THAT(All([&](const PageRequest& page) { return database_->ListPrograms({}, page, some_); },
                  [](const ProgramRecord& row) { return std::to_string(row.id.number() - 1); }),
              ElementsAre("11", "10", "9", "8", "6", "4", "2", "0"));
}

TEST_F(VisibleRows, WhoSeesNothingGetsEmptyLists) {
  EXPECT_THAT(database_->ListSessions({}, {}, none_)->rows, IsEmpty());
  EXPECT_THAT(database_->ListJobs({}, {}, none_)->rows, IsEmpty());
  EXPECT_THAT(database_->ListCalibrations({}, {}, none_)->rows, IsEmpty());
  EXPECT_THAT(database_->ListMachines({}, none_)->rows, IsEmpty());
  EXPECT_THAT(database_->LatestFleet({}, {}, none_)->rows, IsEmpty());
  EXPECT_THAT(database_->ListPrograms({}, {}, none_)->rows, IsEmpty());
}

// Equal content is stored once: whoever sent it has it.
TEST(AccessRows, AProgramThatWasMergedIsItsSendersToo) {
  TempDatabase database;
  ProgramId first, second;
  for (const std::string sender : {"ann", "bob"}) {
    const ProgramId id = database->BeginProgram({"nc", "O1", {sender, "r"}})->id;
    ASSERT_TRUE(database->AppendProgram(id, 0, "G01 X1\n").ok());
    second = database->FinishProgram(id, 7, "")->id;
    if (sender == "ann") first = second;
  }
  EXPECT_EQ(first, second);
  for (const std::string sender : {"ann", "bob"}) {
    EXPECT_TRUE(database->WhereBelongs({ResourceKind::kProgram, "", first.number()}, sender)->is_own) << sender;
    EXPECT_EQ(database->ListPrograms({}, {}, {false, {}, sender})->rows.size(), 1u) << sender;
  }
  EXPECT_FALSE(database->WhereBelongs({ResourceKind::kProgram, "", first.number()}, "eve")->is_own);
}

}  // namespace
}  // namespace axiscal::storage
