#include "server/storage/marks.h"

#include <gtest/gtest.h>

#include "core/base/error_detail.h"
#include "server/storage/testing/temp_database.h"

namespace axiscal::storage {
namespace {

class Marks : public testing::Test {
 protected:
  Marks() { DEMAND(database->CreateMachine(MachineId("mt"), "{}", Cell("")).ok()); }
  NewMark Collision() {
    return {MachineId("mt"), database.clock.UtcNow(), records::MarkKind::kCollision, {"EX0C", "EB0C"}, "hit the chuck"};
  }

  TempDatabase database;
};

TEST_F(Marks, AreKeptOverARestart) {
  const auto put = database->PutMark(Collision(), Cell("r"));
  ASSERT_TRUE(put.ok()) << put.status();
  database.Close();
  database.Open();
  const auto page = database->ListMarks(MachineId("mt"), {});
  ASSERT_TRUE(page.ok()) << page.status();
  ASSERT_EQ(page->rows.size(), 1u);
  const Mark& mark = page->rows[0];
  EXPECT_EQ(mark.id, put->id);
  EXPECT_EQ(mark.content.at, Collision().at);
  EXPECT_EQ(mark.content.kind, records::MarkKind::kCollision);
  EXPECT_EQ(mark.content.symbols, (std::vector<std::string>{"EX0C", "EB0C"}));
  EXPECT_EQ(mark.content.note, "hit the chuck");
  EXPECT_EQ(mark.created_by, "cell");
  EXPECT_FALSE(mark.withdrawn_at.has_value());
  EXPECT_EQ(database->ListAudit({})->rows[0].action, "mark.put");
}

TEST_F(Marks, TheSameRequestGivesTheSameMark) {
  const auto first = database->PutMark(Collision(), Cell("r")), again = database->PutMark(Collision(), Cell("r"));
  ASSERT_TRUE(again.ok()) << again.status();
  EXPECT_EQ(first->id, again->id);
  NewMark other = Collision();
  other.symbols = {"EX0C"};
  EXPECT_EQ(base::ErrorReason(database->PutMark(other, Cell("r")).status()), "REQUEST_ID_REUSED");
  EXPECT_NE(database->PutMark(Collision(), Cell("another"))->id, first->id);
}

TEST_F(Marks, OneThatWasAMistakeIsWithdrawnAndStays) {
  const MarkId id = database->PutMark(Collision(), Cell(""))->id;
  const auto withdrawn = database->WithdrawMark(id, {"ann", ""});
  ASSERT_TRUE(withdrawn.ok()) << withdrawn.status();
  EXPECT_EQ(withdrawn->withdrawn_by, "ann");
  ASSERT_TRUE(database->WithdrawMark(id, {"bob", ""}).ok());
  const auto page = database->ListMarks(MachineId("mt"), {});
  ASSERT_EQ(page->rows.size(), 1u);
  EXPECT_EQ(page->rows[0].withdrawn_by, "ann");
  EXPECT_TRUE(page->rows[0].withdrawn_at.has_value());
}

TEST_F(Marks, AreRefusedWithTheRule) {
  NewMark mark = Collision();
  mark.at = database.clock.UtcNow() + std::chrono::hours(1);
  EXPECT_EQ(base::ErrorReason(database->PutMark(mark, Cell("")).status()), "MARK_INVALID");
  mark = Collision();
  mark.machine = MachineId("none");
  EXPECT_EQ(base::ErrorReason(database->PutMark(mark, Cell("")).status()), "MACHINE_NOT_FOUND");
  EXPECT_EQ(base::ErrorReason(database->WithdrawMark(MarkId(7), Cell("")).status()), "MARK_NOT_FOUND");
  EXPECT_TRUE(database->ListMarks(MachineId("mt"), {})->rows.empty());
  ASSERT_TRUE(database->DeleteMachine(MachineId("mt"), 0, Cell("")).ok());
  EXPECT_EQ(base::ErrorReason(database->PutMark(Collision(), Cell("")).status()), "MACHINE_DELETED");
}

TEST_F(Marks, ListsAreNewestFirstInPages) {
  std::vector<int64_t> ids;
  for (int i = 0; i < 5; ++i) ids.push_back(database->PutMark(Collision(), Cell(""))->id.number());
  std::vector<int64_t> listed;
  PageRequest request{2, ""};
  do {
    const auto page = database->ListMarks(MachineId("mt"), request);
    ASSERT_TRUE(page.ok()) << page.status();
    for (const Mark& mark : page->rows) listed.push_back(mark.id.number());
    request.token = page->next_token;
  } while (!request.token.empty());
  std::reverse(ids.begin(), ids.end());
  EXPECT_EQ(listed, ids);
}

}  // namespace
}  // namespace axiscal::storage
