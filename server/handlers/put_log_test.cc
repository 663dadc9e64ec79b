#include "server/handlers/put_log.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "core/base/sha256.h"
#include "core/session/session.h"
#include "proto/convert/program.h"
#include "server/handlers/create_machine.h"
#include "server/handlers/testing/test_core.h"

namespace axiscal::handlers {
namespace {

using ::testing::HasSubstr;

// The tip is 100 mm below the axes' point, the ball's radius 3 mm: it touches z = 0 at Z103.
constexpr char kTemplate[] =
    "# machine: mt\n# session: top\n# instrument: touch\n# sigma_um: 2\n# tool_tip_mm: 0 0 -100\n"
    "# stylus_radius_mm: 3\n# plane top: 0 0 0 0 0 1\n# started: 2026-01-31T12:00:00Z\n"
    "line: X{X_mm} Y{Y_mm} Z{Z_mm} C{C_deg}\napproach: 0 0 -1\n";
constexpr char kLog[] = "X1.000 Y2.000 Z103.001 C0.000\nX5.000 Y2.000 Z103.002 C0.000\n";

class PutLogTest : public ::testing::Test, protected TestCore {
 protected:
  void SetUp() override {
    v1::CreateMachineRequest machine;
    machine.set_description_json(kMachineJson);
    ASSERT_TRUE(CreateMachine(core, call, machine).ok());
  }
  static v1::PutLogRequest Header(const std::string& log, const std::string& request_id = "log-1") {
    v1::PutLogRequest request;
    v1::PutLogHeader& header = *request.mutable_header();
    header.set_machine_id("mt");
    header.set_name("probe.log");
    header.set_size_bytes(static_cast<int64_t>(log.size()));
    header.set_sha256(base::Sha256Hex(log));
    header.set_request_id(request_id);
    header.mutable_form()->set_template_text(kTemplate);
    header.mutable_form()->set_template_name("top.txt");
    return request;
  }
  absl::StatusOr<v1::PutLogResponse> Send(const v1::PutLogRequest& header, const std::string& log) {
    PutLogStream stream(core, call);
    RETURN_IF_ERROR(stream.Receive(header));
    v1::PutLogRequest data;
    for (const char c : log) {
      data.set_data(std::string(1, c));
      RETURN_IF_ERROR(stream.Receive(data));
    }
    return stream.End();
  }
  absl::StatusOr<v1::PutLogResponse> Send(const std::string& log) { return Send(Header(log), log); }
  void ExpectNothingStored() {
    EXPECT_TRUE(database->ListSessions({}, {})->rows.empty());
    EXPECT_TRUE(database->ListPrograms({}, {})->rows.empty());
  }
  std::string BytesOf(int64_t program) {
    std::string text;
    EXPECT_TRUE(database
                    ->ReadProgram(ProgramId(program), 0,
                                  [&](const std::string& bytes) {
                                    text += bytes;
                                    return absl::OkStatus();
                                  })
                    .ok());
    return text;
  }
};

TEST_F(PutLogTest, ALogBecomesASessionAndStaysBesideIt) {
  const auto stored = Send(kLog);
  ASSERT_TRUE(stored.ok()) << stored.status();
  EXPECT_FALSE(stored->was_there());
  EXPECT_EQ(stored->session().state(), v1::SESSION_STATE_COMPLETE);
  EXPECT_EQ(stored->session().readings(), 2);
  EXPECT_EQ(stored->session().measured_utc_us(), 1769860800000000);
  EXPECT_EQ(stored->first_line(), 1);
  EXPECT_EQ(stored->last_line(), 2);
  EXPECT_THAT(stored->notes(), ::testing::Contains(HasSubstr("the log has no times")));
  EXPECT_EQ(stored->log().kind(), "log");
  EXPECT_EQ(BytesOf(stored->log().program_id()), kLog);
  const auto session = database->ReadSession(SessionId(stored->session().session_id()));
  ASSERT_TRUE(session.ok()) << session.status();
  EXPECT_EQ(session::FindColumn(*session, "Z_mm")->values[1], 103.002);
  EXPECT_EQ(session::FindHeader(*session, "log"), "probe.log");
  EXPECT_EQ(session::FindHeader(*session, "log_sha256"), base::Sha256Hex(kLog));
  EXPECT_EQ(session::FindHeader(*session, "log_program"), std::to_string(stored->log().program_id()));
  EXPECT_EQ(BytesOf(std::stoll(session::FindHeader(*session, "log_template").value_or("0"))), kTemplate);
  // Again, under its own id and another one: the first is that session, the second a new one of the same log.
  const auto again = Send(kLog);
  ASSERT_TRUE(again.ok()) << again.status();
  EXPECT_TRUE(again->was_there());
  EXPECT_EQ(again->session().session_id(), stored->session().session_id());
  EXPECT_EQ(again->log().program_id(), stored->log().program_id());
  const std::string other = std::string(kLog) + "X6.000 Y2.000 Z103.001 C0.000\n";
  const auto reused = Send(Header(other), other);
  EXPECT_EQ(base::ErrorReason(reused.status()), "REQUEST_ID_REUSED") << reused.status();
}

TEST_F(PutLogTest, APlanOfAnEarlierLogBringsNoneOfItsOrigin) {
  const auto first = Send(kLog);
  ASSERT_TRUE(first.ok()) << first.status();
  const std::string plan =
      "# machine: mt\n# session: top\n# instrument: touch\n# sigma_um: 2\n# tool_tip_mm: 0 0 -100\n"
      "# stylus_radius_mm: 3\n# plane top: 0 0 0 0 0 1\n# log: old.log\n# log_program: 999\n"
      "t_s,X_mm,Y_mm,Z_mm,C_deg,nx,ny,nz,feature\n0,1,2,103,0,0,0,-1,top\n6,5,2,103,0,0,0,-1,top\n";
  v1::PutLogRequest header = Header(kLog, "planned");
  header.mutable_header()->mutable_form()->set_template_text("dprnt");
  header.mutable_header()->mutable_form()->set_plan_text(plan);
  header.mutable_header()->mutable_form()->set_session_name("monday");
  const auto stored = Send(header, kLog);
  ASSERT_TRUE(stored.ok()) << stored.status();
  EXPECT_EQ(stored->session().name(), "monday");
  EXPECT_EQ(stored->log().program_id(), first->log().program_id()) << "the same bytes under the same name";
  const auto session = database->ReadSession(SessionId(stored->session().session_id()));
  ASSERT_TRUE(session.ok()) << session.status();
  EXPECT_EQ(session::FindHeader(*session, "log"), "probe.log");
  EXPECT_EQ(session::FindHeader(*session, "log_template"), "dprnt");
  EXPECT_EQ(BytesOf(std::stoll(session::FindHeader(*session, "log_plan").value_or("0"))), plan);
}

TEST_F(PutLogTest, WhatIsWrongIsToldWithItsPlaceAndStoresNothing) {
  const auto wrong = Send("X1.000 Y2.000 Z103.001 C0.000\nX1.000 Y2,0 Z103.001 C0.000\nX1.000 Y2.0 Z103.001 C0.000\n");
  const auto detail = base::GetErrorDetail(wrong.status());
  ASSERT_TRUE(detail.has_value()) << wrong.status();
  EXPECT_EQ(*detail, (base::ErrorDetail{"LOG_INVALID", {{"line", "2"}, {"column", "10"}}}));
  EXPECT_THAT(std::string(wrong.status().message()), HasSubstr("probe.log: line 2, column 10"));
  // What the machine cannot have done, and what nothing was touched at.
  for (const char* const log : {"X1.000 Y2.000 Z903.001 C0.000\n", "X1.000 Y2.000 Z203.001 C0.000\n", "%\n"}) {
    const auto refused = Send(log);
    EXPECT_EQ(base::ErrorReason(refused.status()), "LOG_INVALID") << log << refused.status();
  }
  v1::PutLogRequest header = Header(kLog);
  header.mutable_header()->mutable_form()->set_template_text("line: X{X_mm\n");
  EXPECT_EQ(base::ErrorReason(Send(header, kLog).status()), "LOG_INVALID");
  header.mutable_header()->mutable_form()->set_template_text("dprnt");
  header.mutable_header()->mutable_form()->set_plan_text("no plan\n");
  EXPECT_EQ(base::ErrorReason(Send(header, kLog).status()), "LOG_INVALID");
  header.mutable_header()->mutable_form()->clear_template_text();
  EXPECT_EQ(FieldOf(Send(header, kLog).status()), "header.form.template_text");
  header = Header(kLog);
  header.mutable_header()->set_machine_id("none");
  EXPECT_EQ(base::ErrorReason(Send(header, kLog).status()), "MACHINE_NOT_FOUND");
  header = Header(kLog);
  header.mutable_header()->set_name("../probe.log");
  EXPECT_EQ(FieldOf(Send(header, kLog).status()), "header.name");
  header = Header(kLog);
  header.mutable_header()->set_size_bytes(records::kMaxLogBytes + 1);
  EXPECT_EQ(base::ErrorReason(Send(header, kLog).status()), "LOG_TOO_LARGE");
  header.mutable_header()->set_size_bytes(3);
  EXPECT_EQ(base::ErrorReason(Send(header, kLog).status()), "SIZE_EXCEEDED");
  header.mutable_header()->set_size_bytes(1000);
  EXPECT_EQ(base::ErrorReason(Send(header, kLog).status()), "STREAM_INCOMPLETE");
  header = Header(kLog);
  header.mutable_header()->set_sha256(std::string(64, '0'));
  EXPECT_EQ(base::ErrorReason(Send(header, kLog).status()), "TOTALS_MISMATCH");
  PutLogStream stream(core, call);
  v1::PutLogRequest data;
  data.set_data("X");
  EXPECT_EQ(base::ErrorReason(stream.Receive(data)), "STREAM_INVALID");
  ExpectNothingStored();
}

TEST_F(PutLogTest, MemoryForLogsHasAnEnd) {
  v1::PutLogRequest header = Header(kLog), part;
  header.mutable_header()->set_size_bytes(records::kMaxLogBytes);
  part.set_data(std::string(static_cast<size_t>(convert::kMaxProgramPartBytes), '1'));
  absl::Status status;
  {
    PutLogStream first(core, call), second(core, call), idle(core, call);
    // Streams that send nothing take nothing.
    for (PutLogStream* stream : {&first, &second, &idle}) ASSERT_TRUE(stream->Receive(header).ok());
    for (int64_t sent = 0; sent < records::kMaxLogBytes && status.ok(); sent += convert::kMaxProgramPartBytes) {
      status = first.Receive(part);
      if (status.ok()) status = second.Receive(part);
    }
    EXPECT_EQ(base::ErrorReason(status), "QUEUE_FULL");
    EXPECT_EQ(base::ErrorReason(first.End().status()), "STREAM_INCOMPLETE");
  }
  PutLogStream later(core, call);
  ASSERT_TRUE(later.Receive(header).ok());
  EXPECT_TRUE(later.Receive(part).ok());
}

}  // namespace
}  // namespace axiscal::handlers
