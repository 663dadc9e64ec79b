// What an IT department asks of a service: which call made a job, how cells stand, what is not well, what is logged.
#include <gmock/gmock.h>

#include "core/base/error_detail.h"
#include "tests/end_to_end/testing/job_fixture.h"

namespace axiscal {
namespace {

using ::testing::HasSubstr;
using testing::Job;

constexpr char kTraceId[] = "4bf92f3577b34da6a3ce929d0e0e4736";

TEST(TraceIdOf, TakesWhatTraceContextHas) {
  EXPECT_EQ(client::TraceIdOf(absl::StrCat("00-", kTraceId, "-00f067aa0ba902b7-01")), kTraceId);
  for (const char* const other : {"", "00-4bf92f3577b34da6a3ce929d0e0e4736-00f067aa0ba902b7",
                                  "01-4bf92f3577b34da6a3ce929d0e0e4736-00f067aa0ba902b7-01",
                                  "00-4BF92f3577b34da6a3ce929d0e0e4736-00f067aa0ba902b7-01",
                                  "00-4bf92f3577b34da6a3ce929d0e0e4736_00f067aa0ba902b7-01"})
    EXPECT_EQ(client::TraceIdOf(other), "") << other;
  client::Options options;
  options.trace_parent = "made up";
  EXPECT_THAT(std::string(client::Validate(options).message()), HasSubstr("trace_parent must be"));
}

TEST_F(Job, AJobKnowsTheTraceOfTheCallThatMadeIt) {
  const SessionId session = UploadSession("BX");
  client::Options options;
  options.trace_parent = absl::StrCat("00-", kTraceId, "-00f067aa0ba902b7-01");
  auto traced = client::Client::InProcess(channel(), options);
  ASSERT_OK(traced);
  const auto made = traced->CreateJob(records::IdentifyParams{MachineId("mt"), {session}, {}}, "one");
  ASSERT_OK(made);
  EXPECT_THAT(made->trace, HasSubstr(kTraceId));
  EXPECT_EQ(made->trace.size(), 55u);
  EXPECT_NE(made->trace, options.trace_parent) << "the call is a step of its own";
  ASSERT_OK(client().WatchJob(made->id, nullptr));
  Restart();
  EXPECT_EQ(client().GetJob(made->id)->trace, made->trace);
  const auto own = client().CreateJob(records::IdentifyParams{MachineId("mt"), {session}, {}}, "two");
  ASSERT_OK(own);
  EXPECT_EQ(own->trace.size(), 55u) << "without one the client has its own";
  EXPECT_THAT(own->trace, ::testing::Not(HasSubstr(kTraceId)));
}

TEST_F(Job, CellsReportAndAreForgotten) {
  records::CellReport report;
  report.machine = MachineId("mt");
  report.name = "cell-7";
  report.version = "0.1";
  report.problem = "2 files were refused";
  report.waiting_files = 3;
  ASSERT_OK(client().ReportCell(report));
  const auto cells = client().ListCells(std::nullopt);
  ASSERT_OK(cells);
  ASSERT_EQ(cells->rows.size(), 1u);
  EXPECT_EQ(cells->rows[0].report.name, "cell-7");
  EXPECT_EQ(cells->rows[0].report.waiting_files, 3);
  EXPECT_FALSE(cells->rows[0].is_silent());
  EXPECT_THAT(cells->rows[0].reported_by, HasSubstr("local:"));
  // The event follows at once.
  records::EventChange raised;
  ASSERT_OK(client().WatchEvents({}, 0, [&](const records::EventNews& news) {
    if (news.change) raised = *news.change;
    return !news.change;
  }));
  EXPECT_EQ(raised.event.content.kind, records::EventKind::kCellProblem);
  const auto diagnosis = client().Diagnose();
  ASSERT_OK(diagnosis);
  std::string found;
  for (const records::Finding& finding : diagnosis->findings) {
    if (finding.what == "files of cells") found = finding.text;
  }
  EXPECT_THAT(found, HasSubstr("cell-7 of mt: 2 files were refused"));
  EXPECT_EQ(base::ErrorReason(client().ForgetCell(MachineId("mt"), "cell-8")), "CELL_NOT_FOUND");
  ASSERT_OK(client().ForgetCell(MachineId("mt"), "cell-7"));
  EXPECT_TRUE(client().ListCells(MachineId("mt"))->rows.empty());
  report.machine = MachineId("none");
  EXPECT_EQ(base::ErrorReason(client().ReportCell(report).status()), "MACHINE_NOT_FOUND");
}

}  // namespace
}  // namespace axiscal
