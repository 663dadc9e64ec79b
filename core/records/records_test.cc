#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "core/compensate/tables/format.h"
#include "core/records/job.h"
#include "core/records/job_params.h"
#include "core/records/session.h"
#include "core/records/table.h"

namespace axiscal::records {
namespace {

using ::testing::ElementsAre;

TEST(JobParams, SayTheirKindAndMachine) {
  std::vector<JobParams> all = {IdentifyParams(), CompensateParams(), CloseLoopParams(), ToolSetterParams()};
  std::vector<std::string> kinds, machines;
  for (JobParams& params : all) {
    std::visit([&](auto& of_kind) { of_kind.machine = MachineId("mt" + KindOf(params)); }, params);
    kinds.push_back(KindOf(params));
    machines.push_back(MachineOf(params).text());
  }
  EXPECT_THAT(kinds, ElementsAre("identify", "compensate", "close_loop", "tool_setter"));
  EXPECT_THAT(machines, ElementsAre("mtidentify", "mtcompensate", "mtclose_loop", "mttool_setter"));
}

TEST(SchemaOf, TellsTextsFromNumbersAndKeepsNoReading) {
  const session::Session session{{{"machine", "mt"}}, {{"t_s", {0.5}, {}}, {"feature", {}, {"top"}}}};
  const SessionSchema schema = SchemaOf(session);
  EXPECT_EQ(schema.header, session.header);
  EXPECT_THAT(schema.columns, ElementsAre(ColumnSpec{"t_s", false}, ColumnSpec{"feature", true}));
}

TEST(Summary, SaysWhatAFormatAssumesAndHolds) {
  tables::Format format;
  format.name = "pitch";
  format.limits.max_points = 128;
  format.assumed = "increments";
  format.cannot_carry = {"tilts"};
  const TableFormat summary = Summary(format);
  EXPECT_EQ(summary.name, "pitch");
  EXPECT_EQ(summary.max_points, 128);
  EXPECT_THAT(summary.limits, ::testing::EndsWith("; assumed: increments"));
  EXPECT_THAT(summary.cannot_carry, ElementsAre("tilts"));
}

TEST(Jobs, EndInFourStates) {
  for (const JobState state : {JobState::kSucceeded, JobState::kFailed, JobState::kCancelled, JobState::kDead})
    EXPECT_TRUE(IsTerminal(state));
  EXPECT_FALSE(IsTerminal(JobState::kQueued));
  EXPECT_FALSE(IsTerminal(JobState::kRunning));
}

}  // namespace
}  // namespace axiscal::records
