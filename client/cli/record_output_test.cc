#include "client/cli/record_output.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace axiscal::cli {
namespace {

using ::testing::HasSubstr;
using ::testing::Not;

TEST(RecordOutput, ACalibrationOnRejectedSessionsSaysSo) {
  records::CalibrationRecord record;
  record.id = CalibrationId(2);
  record.content.machine = MachineId("mt");
  record.content.sessions = {SessionId(5), SessionId(6), SessionId(7)};
  EXPECT_THAT(CalibrationText(record), Not(HasSubstr("rejected")));
  record.rejected_sessions = {SessionId(5), SessionId(7)};
  EXPECT_THAT(CalibrationText(record), HasSubstr("it counts in no history: rejected was session 5, 7\n"));
  EXPECT_THAT(ToJson(record).Dump(), HasSubstr("\"rejected_sessions\""));
}

}  // namespace
}  // namespace axiscal::cli
