#include "server/handlers/create_session.h"

#include <gtest/gtest.h>

#include "server/handlers/create_machine.h"
#include "server/handlers/testing/test_core.h"

namespace axiscal::handlers {
namespace {

class CreateSessionTest : public ::testing::Test, protected TestCore {
 protected:
  void SetUp() override {
    v1::CreateMachineRequest request;
    request.set_description_json(kMachineJson);
    ASSERT_TRUE(CreateMachine(core, call, request).ok());
  }
  v1::CreateSessionRequest request_ = Parse<v1::CreateSessionRequest>(kTrackerSession);
};

TEST_F(CreateSessionTest, OpensItOncePerRequestId) {
  const auto first = CreateSession(core, call, request_);
  ASSERT_TRUE(first.ok()) << first.status();
  EXPECT_EQ(first->session().state(), v1::SESSION_STATE_OPEN);
  EXPECT_EQ(first->session().name(), "T1");
  EXPECT_EQ(first->session().instrument(), "tracker");
  EXPECT_EQ(first->session().created_by(), "tester");
  EXPECT_EQ(first->session().measured_utc_us(), 1'769'860'800'000'000);
  EXPECT_EQ(first->window_chunks(), core.limits.window_chunks);
  EXPECT_EQ(CreateSession(core, call, request_)->session().session_id(), first->session().session_id());
  request_.mutable_schema()->mutable_header(3)->set_value("6");
  EXPECT_EQ(base::ErrorReason(CreateSession(core, call, request_).status()), "REQUEST_ID_REUSED");
}

TEST_F(CreateSessionTest, RefusesWhatNoFileCouldHold) {
  const auto reason = [&](const std::function<void(v1::CreateSessionRequest&)>& spoil) {
    v1::CreateSessionRequest request = request_;
    spoil(request);
    return base::ErrorReason(CreateSession(core, call, request).status());
  };
  EXPECT_EQ(reason([](auto& r) { r.clear_request_id(); }), "FIELD_INVALID");
  EXPECT_EQ(reason([](auto& r) { r.set_machine_id("other"); }), "MACHINE_NOT_FOUND");
  EXPECT_EQ(reason([](auto& r) { r.mutable_schema()->mutable_header(0)->set_value("tm"); }), "SESSION_INVALID");
  EXPECT_EQ(reason([](auto& r) { r.mutable_schema()->mutable_header(3)->set_value("0"); }), "SESSION_INVALID");
  EXPECT_EQ(reason([](auto& r) { r.mutable_schema()->mutable_columns(1)->set_name("X_deg"); }), "SESSION_INVALID");
  EXPECT_EQ(reason([](auto& r) { r.mutable_schema()->mutable_columns(1)->set_name("A_deg"); }), "SESSION_INVALID");
  EXPECT_EQ(reason([](auto& r) { r.mutable_schema()->mutable_columns()->RemoveLast(); }), "SESSION_INVALID");
  EXPECT_EQ(reason([](auto& r) { r.mutable_schema()->mutable_columns(1)->set_kind(v1::COLUMN_KIND_TEXT); }),
            "SESSION_INVALID");
  EXPECT_TRUE(database->ListSessions({}, {})->rows.empty());
}

// Beam and rods stand in the header: a session that could never be evaluated is not stored.
TEST_F(CreateSessionTest, RefusesARodThatCannotStandInTheBeam) {
  const auto create = [&](const std::string& phi_deg) {
    const auto request = Parse<v1::CreateSessionRequest>(R"(
      request_id: "rod-)" + phi_deg + R"(" machine_id: "mt"
      schema {
        header { key: "machine" value: "mt" } header { key: "session" value: "rod )" +
                                                         phi_deg + R"(" }
        header { key: "instrument" value: "tool-setter" } header { key: "sigma_um" value: "0.5" }
        header { key: "tool_tip_mm" value: "0 0 0" } header { key: "beam" value: "0.2 0 0" }
        header { key: "rod standard" value: "5 0.03 )" + phi_deg +
                                                         R"( 0 133.702 0" }
        columns { name: "rod" kind: COLUMN_KIND_TEXT } columns { name: "readout" kind: COLUMN_KIND_NUMBER }
        columns { name: "Z_mm" kind: COLUMN_KIND_NUMBER }
      })");
    return CreateSession(core, call, request).status();
  };
  EXPECT_TRUE(create("90").ok()) << create("90");
  EXPECT_EQ(base::ErrorReason(create("-90")), "SESSION_INVALID");
  EXPECT_NE(create("-90").message().find("phi = -90 deg, expected"), std::string::npos) << create("-90");
  EXPECT_EQ(database->ListSessions({}, {})->rows.size(), 1u);
}

TEST_F(CreateSessionTest, TakesNothingWhileDraining) {
  core.draining = true;
  const absl::Status status = CreateSession(core, call, request_).status();
  EXPECT_EQ(status.code(), absl::StatusCode::kUnavailable);
  EXPECT_EQ(base::ErrorReason(status), "DRAINING");
}

}  // namespace
}  // namespace axiscal::handlers
