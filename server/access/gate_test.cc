#include "server/access/gate.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "core/base/error_detail.h"
#include "server/access/named.h"
#include "server/storage/testing/temp_database.h"

namespace axiscal::access {
namespace {

using records::Role;
using records::Scope;
using storage::Resource;
using storage::ResourceKind;
using ::testing::HasSubstr;

class GateTest : public testing::Test {
 protected:
  void SetUp() override {
    session_ = storage::StoreSession(*database_, 1);  // of machine mt
    ASSERT_TRUE(database_->CreateMachine(MachineId("other"), "{}", {"admin", ""}).ok());
  }
  void Add(const std::string& name, const std::vector<records::Grant>& grants) {
    ASSERT_TRUE(database_->CreatePrincipal(name, "", {"admin", ""}).ok());
    for (const records::Grant& grant : grants)
      ASSERT_TRUE(database_->ChangeRole(name, grant, true, {"admin", ""}).ok());
  }
  std::string TokenOf(const std::string& name, std::optional<base::UtcTime> expires_at = std::nullopt) {
    const std::string token = NewToken();
    EXPECT_TRUE(database_->CreateToken({name, HashOfToken(token), "", expires_at}, {"admin", ""}).ok());
    return token;
  }
  static Credentials Bearer(const std::string& token) {
    Credentials credentials;
    credentials.authorization = "Bearer " + token;
    return credentials;
  }
  static Credentials Certificate(const std::string& name) {
    Credentials credentials;
    credentials.certificate_name = name;
    return credentials;
  }
  std::string ReasonOf(const Credentials& credentials) {
    const absl::Status status = gate_.Identify(credentials).status();
    EXPECT_EQ(status.code(), absl::StatusCode::kUnauthenticated) << status;
    return base::ErrorReason(status);
  }
  absl::Status Admit(const std::string& name, const std::string& method, const std::vector<Resource>& named) {
    const auto identity = gate_.Identify(Certificate(name));
    EXPECT_TRUE(identity.ok()) << identity.status();
    return gate_.Admit(*identity, method, named).status();
  }

  storage::TempDatabase database_;
  SessionId session_;
  const Gate gate_{*database_, true, database_.clock};
  const Resource mt_{ResourceKind::kMachine, "mt", 0}, other_{ResourceKind::kMachine, "other", 0},
      none_{ResourceKind::kMachine, "none", 0};
};

TEST_F(GateTest, WhoShowsNothingIsNobody) {
  EXPECT_EQ(ReasonOf({}), "IDENTITY_MISSING");
  Credentials login;
  login.login = "root";
  EXPECT_EQ(ReasonOf(login), "IDENTITY_MISSING");
  EXPECT_EQ(ReasonOf(Certificate("ann")), "PRINCIPAL_UNKNOWN");
  EXPECT_EQ(ReasonOf(Certificate("")), "PRINCIPAL_UNKNOWN");
}

TEST_F(GateTest, WhereNobodyIsAskedTheLoginIsWrittenDown) {
  Credentials credentials = Bearer("axt_whatever");
  credentials.login = "ann";
  const Gate local(*database_, false);
  const auto identity = local.Identify(credentials);
  ASSERT_TRUE(identity.ok());
  EXPECT_EQ(identity->name, "local:ann");
  EXPECT_TRUE(local.Admit(*identity, "Access.RevokePrincipal", std::vector<Resource>{}).ok());
  EXPECT_TRUE(local.Admit(*identity, "Calibrations.ApproveCalibration", std::vector<Resource>{mt_}).ok());
}

TEST_F(GateTest, ATokenStandsForItsPrincipalUntilItIsOverOrRevoked) {
  Add("ann", {});
  const std::string good = TokenOf("ann"),
                    short_lived = TokenOf("ann", database_.clock.UtcNow() + std::chrono::hours(1));
  EXPECT_EQ(good.size(), 4u + 43u);
  EXPECT_NE(good, TokenOf("ann"));
  EXPECT_EQ(gate_.Identify(Bearer(good))->name, "ann");
  EXPECT_EQ(gate_.Identify(Bearer(short_lived))->name, "ann");
  for (const std::string& wrong :
       std::vector<std::string>{"", good.substr(0, good.size() - 1), good + "x", HashOfToken(good)})
    EXPECT_EQ(ReasonOf(Bearer(wrong)), "TOKEN_INVALID") << wrong;
  Credentials basic = Certificate("ann");
  basic.authorization = "Basic YW5uOg==";
  EXPECT_EQ(ReasonOf(basic), "TOKEN_INVALID");  // a bad token is not made good by a certificate
  database_.clock.Advance(std::chrono::hours(1));
  EXPECT_EQ(ReasonOf(Bearer(short_lived)), "TOKEN_INVALID");
  EXPECT_EQ(gate_.Identify(Bearer(good))->name, "ann");
  const auto principals = database_->ListPrincipals({});
  ASSERT_TRUE(principals.ok());
  const int64_t first = principals->rows.at(0).tokens.at(0).id;
  EXPECT_EQ(principals->rows[0].tokens[0].last_used_at, database_.clock.UtcNow());
  ASSERT_TRUE(database_->RevokeToken(first, {"admin", ""}).ok());
  EXPECT_EQ(ReasonOf(Bearer(good)), "TOKEN_INVALID");
}

TEST_F(GateTest, ARevokedPrincipalIsOutWithTokensAndCertificateForEver) {
  Add("ann", {});
  const std::string token = TokenOf("ann");
  ASSERT_TRUE(database_->RevokePrincipal("ann", {"admin", ""}).ok());
  EXPECT_EQ(ReasonOf(Bearer(token)), "TOKEN_INVALID");
  EXPECT_EQ(ReasonOf(Certificate("ann")), "PRINCIPAL_UNKNOWN");
  EXPECT_EQ(base::ErrorReason(database_->CreatePrincipal("ann", "", {"admin", ""}).status()), "PRINCIPAL_EXISTS");
  EXPECT_EQ(base::ErrorReason(database_->CreateToken({"ann", "x", "", {}}, {"admin", ""}).status()),
            "PRINCIPAL_REVOKED");
}

TEST_F(GateTest, ACertificateThatHasEndedSinceTheConnectionBeganNamesNobody) {
  Add("ann", {});
  Credentials credentials = Certificate("ann");
  credentials.certificate_ends = database_.clock.UtcNow() + std::chrono::hours(1);
  EXPECT_TRUE(gate_.Identify(credentials).ok());
  database_.clock.Advance(std::chrono::hours(1));
  EXPECT_EQ(ReasonOf(credentials), "CERTIFICATE_ENDED");
}

TEST_F(GateTest, WhatIsOutsideEveryScopeIsNotFoundLikeWhatIsMissing) {
  Add("ann", {{Role::kTechnician, {Scope::Kind::kMachine, "other"}}});
  for (const std::string method : {"Machines.GetMachine", "Calibrations.ApproveCalibration", "Ingest.CreateSession"}) {
    const absl::Status outside = Admit("ann", method, {mt_}), missing = Admit("ann", method, {none_});
    EXPECT_EQ(outside.code(), absl::StatusCode::kNotFound) << outside;
    EXPECT_EQ(outside.message(), "machine mt does not exist");
    EXPECT_EQ(missing.message(), "machine none does not exist");
    EXPECT_EQ(base::ErrorReason(outside), base::ErrorReason(missing));
  }
  // One thing of several is enough.
  EXPECT_EQ(Admit("ann", "Jobs.CreateJob", {other_, {ResourceKind::kSession, "", session_.number()}}).message(),
            "session 1 does not exist");
}

TEST_F(GateTest, TooSmallARoleInScopeIsNamed) {
  Add("ann", {{Role::kTechnician, {Scope::Kind::kMachine, "mt"}}});
  EXPECT_TRUE(Admit("ann", "Jobs.CreateJob", {mt_}).ok());
  const absl::Status denied = Admit("ann", "Calibrations.ApproveCalibration", {mt_});
  EXPECT_EQ(denied.code(), absl::StatusCode::kPermissionDenied);
  EXPECT_EQ(base::ErrorReason(denied), "ROLE_MISSING");
  EXPECT_THAT(denied.message(), HasSubstr("needs the role approver for machine mt"));
  EXPECT_EQ(base::ErrorReason(Admit("ann", "Access.ListPrincipals", {})), "ROLE_MISSING");
}

TEST_F(GateTest, GroupsCountAsTheyAreNow) {
  Add("ann", {{Role::kViewer, {Scope::Kind::kGroup, "turning"}}});
  EXPECT_TRUE(absl::IsNotFound(Admit("ann", "Machines.GetMachine", {mt_})));
  ASSERT_TRUE(database_->ChangeGroup("turning", MachineId("mt"), true, {"admin", ""}).ok());
  EXPECT_TRUE(Admit("ann", "Machines.GetMachine", {mt_}).ok());
  EXPECT_TRUE(Admit("ann", "Ingest.GetSession", {{ResourceKind::kSession, "", session_.number()}}).ok());
  EXPECT_TRUE(absl::IsNotFound(Admit("ann", "Machines.GetMachine", {other_})));
  ASSERT_TRUE(database_->ChangeGroup("turning", MachineId("mt"), false, {"admin", ""}).ok());
  EXPECT_TRUE(absl::IsNotFound(Admit("ann", "Machines.GetMachine", {mt_})));
}

TEST_F(GateTest, AnAdminIsNoApprover) {
  Add("root", {{Role::kAdmin, {}}});
  EXPECT_TRUE(Admit("root", "Access.ChangeRole", {}).ok());
  EXPECT_TRUE(Admit("root", "Jobs.CreateJob", {mt_}).ok());
  EXPECT_EQ(base::ErrorReason(Admit("root", "Calibrations.ApproveCalibration", {mt_})), "ROLE_MISSING");
  // An admin of some machines is none of the service.
  Add("ann", {{Role::kAdmin, {Scope::Kind::kMachine, "mt"}}});
  EXPECT_TRUE(Admit("ann", "Machines.UpdateMachine", {mt_}).ok());
  EXPECT_EQ(base::ErrorReason(Admit("ann", "Access.ChangeRole", {})), "ROLE_MISSING");
  EXPECT_EQ(base::ErrorReason(Admit("ann", "Machines.CreateMachine", {mt_})), "ROLE_MISSING");
}

TEST_F(GateTest, FourEyes) {
  storage::NewCalibration calibration = storage::TestCalibration(database_.clock.UtcNow(), 1.0);
  calibration.created_by = "ann";
  const CalibrationId id = database_->CreateCalibration(calibration)->id;
  const Resource named{ResourceKind::kCalibration, "", id.number()};
  Add("ann", {{Role::kApprover, {}}});
  Add("bob", {{Role::kApprover, {Scope::Kind::kMachine, "mt"}}});
  EXPECT_TRUE(Admit("ann", "Calibrations.ApproveCalibration", {named}).ok());
  ASSERT_TRUE(database_->SetFourEyes(MachineId("mt"), true, {"admin", ""}).ok());
  const absl::Status own = Admit("ann", "Calibrations.ApproveCalibration", {named});
  EXPECT_EQ(base::ErrorReason(own), "FOUR_EYES") << own;
  EXPECT_EQ(own.code(), absl::StatusCode::kPermissionDenied);
  EXPECT_TRUE(Admit("bob", "Calibrations.ApproveCalibration", {named}).ok());
  EXPECT_TRUE(Admit("ann", "Calibrations.RetireCalibration", {named}).ok());
}

TEST_F(GateTest, AProgramBelongsToItsSenderAndToTheMachinesItIsRewrittenFor) {
  Add("ann", {{Role::kTechnician, {Scope::Kind::kMachine, "other"}}});
  Add("bob", {{Role::kTechnician, {Scope::Kind::kMachine, "mt"}}});
  const ProgramId id = database_->BeginProgram({"nc", "O1.nc", {"ann", "p"}})->id;
  ASSERT_TRUE(database_->AppendProgram(id, 0, "G01 X1\n").ok());
  ASSERT_TRUE(database_->FinishProgram(id, 7, "").ok());
  const Resource program{ResourceKind::kProgram, "", id.number()};
  EXPECT_TRUE(Admit("ann", "Programs.GetProgram", {program}).ok());
  EXPECT_TRUE(absl::IsNotFound(Admit("bob", "Programs.GetProgram", {program})));
  storage::NewJob job;
  job.kind = "compensate";
  job.machine = MachineId("mt");
  job.program = id;
  ASSERT_TRUE(database_->CreateJob(job, 10).ok());
  EXPECT_TRUE(Admit("bob", "Programs.GetProgram", {program}).ok());
}

TEST_F(GateTest, AMethodThatIsNotInTheTableIsForNobody) {
  Add("root", {{Role::kAdmin, {}}, {Role::kApprover, {}}});
  EXPECT_EQ(base::ErrorReason(Admit("root", "Machines.Explode", {})), "METHOD_NOT_PLACED");
  const Gate local(*database_, false);
  EXPECT_EQ(base::ErrorReason(local.Admit(*local.Identify({}), "Machines.Explode", std::vector<Resource>{}).status()),
            "METHOD_NOT_PLACED");
}

}  // namespace
}  // namespace axiscal::access
