#include "server/watch/plan.h"

#include <gtest/gtest.h>

namespace axiscal::watch {
namespace {

using records::Event;
using records::EventKind;

const MachineId kMt("mt");
const std::set<EventKind> kAll(std::begin(records::kAllEventKinds), std::end(records::kAllEventKinds));

base::UtcTime Day(int day) { return base::FromUtcUs(0) + std::chrono::days(day); }

Condition StepOf(int from, int to, const std::string& text = "jumped", bool raises = true) {
  Condition condition;
  condition.raises = raises;
  condition.content.kind = EventKind::kStep;
  condition.content.text = text;
  condition.content.from = Day(from);
  condition.content.to = Day(to);
  return condition;
}

Condition WearOf(const std::string& symbol, bool raises = true) {
  Condition condition;
  condition.raises = raises;
  condition.content.kind = EventKind::kWear;
  condition.content.subject = symbol;
  condition.content.text = symbol + " wears";
  return condition;
}

Event Standing(int64_t id, const Condition& condition) {
  Event event;
  event.id = EventId(id);
  event.machine = kMt;
  event.content = condition.content;
  return event;
}

TEST(PlanChanges, RaisesWhatIsNewAndLeavesWhatIsKnown) {
  EXPECT_EQ(PlanChanges(kMt, kAll, {}, {WearOf("EX0C"), WearOf("EY0C", false)}).raised.size(), 1u);
  EXPECT_TRUE(PlanChanges(kMt, kAll, {Standing(1, WearOf("EX0C"))}, {WearOf("EX0C")}).empty());
  // What would not raise keeps what stands.
  EXPECT_TRUE(PlanChanges(kMt, kAll, {Standing(1, WearOf("EX0C"))}, {WearOf("EX0C", false)}).empty());
}

TEST(PlanChanges, ClearsOnlyKindsThatWereLookedAt) {
  const std::vector<Event> standing = {Standing(1, WearOf("EX0C"))};
  EXPECT_TRUE(PlanChanges(kMt, {EventKind::kSessionMissed}, standing, {}).empty());
  const storage::EventChanges changes = PlanChanges(kMt, kAll, standing, {WearOf("EY0C")});
  ASSERT_EQ(changes.cleared.size(), 1u);
  EXPECT_EQ(changes.cleared[0].event, EventId(1));
  EXPECT_FALSE(changes.cleared[0].why.empty());
  EXPECT_EQ(changes.raised.size(), 1u);
}

// With a calibration that comes late the dates of a step become closer: it is the same step.
TEST(PlanChanges, AStepIsTheSameWhereItsDatesOverlap) {
  const std::vector<Event> standing = {Standing(1, StepOf(10, 20))};
  const storage::EventChanges closer = PlanChanges(kMt, kAll, standing, {StepOf(10, 15, "jumped earlier")});
  EXPECT_TRUE(closer.raised.empty());
  EXPECT_TRUE(closer.cleared.empty());
  ASSERT_EQ(closer.updated.size(), 1u);
  EXPECT_EQ(closer.updated[0].content.from, Day(10));
  EXPECT_EQ(closer.updated[0].content.to, Day(20));
  // The next step begins where this one ended: another one.
  const storage::EventChanges next = PlanChanges(kMt, kAll, standing, {StepOf(10, 20), StepOf(20, 30)});
  EXPECT_EQ(next.raised.size(), 1u);
  EXPECT_TRUE(next.cleared.empty());
}

TEST(PlanChanges, AStepThatAPersonHasSeenIsNotToldAgain) {
  Event seen = Standing(1, StepOf(10, 20));
  seen.acknowledged_at = seen.cleared_at = Day(21);
  EXPECT_TRUE(PlanChanges(kMt, kAll, {seen}, {StepOf(10, 20)}).empty());
  EXPECT_TRUE(PlanChanges(kMt, kAll, {seen}, {}).empty());
}

}  // namespace
}  // namespace axiscal::watch
