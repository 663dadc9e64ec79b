// Who may do what, over the wire: every method of the API for every role in every scope, found in the descriptors, so
// that a new method fails here until somebody has said whose it is.
#include <gmock/gmock.h>
#include <grpcpp/grpcpp.h>

#include <filesystem>
#include <fstream>
#include <map>
#include <regex>
#include <set>
#include <thread>

#include "axiscal/v1/access_service.grpc.pb.h"
#include "axiscal/v1/admin_service.grpc.pb.h"
#include "axiscal/v1/calibrations_service.grpc.pb.h"
#include "axiscal/v1/events_service.grpc.pb.h"
#include "axiscal/v1/history_service.grpc.pb.h"
#include "axiscal/v1/ingest_service.grpc.pb.h"
#include "axiscal/v1/jobs_service.grpc.pb.h"
#include "axiscal/v1/machines_service.grpc.pb.h"
#include "axiscal/v1/programs_service.grpc.pb.h"
#include "axiscal/v1/routines_service.grpc.pb.h"
#include "axiscal/v1/tables_service.grpc.pb.h"
#include "axiscal/v1/webhooks_service.grpc.pb.h"
#include "core/base/error_detail.h"
#include "core/base/files.h"
#include "core/base/testing/fake_clock.h"
#include "grpc/health/v1/health.grpc.pb.h"
#include "server/access/forwarded.h"
#include "server/access/gate.h"
#include "server/denials.h"
#include "server/storage/check.h"
#include "server/storage/sqlite_database.h"
#include "tests/end_to_end/testing/fixture.h"
#include "tests/end_to_end/testing/raw_upload.h"

namespace axiscal {
namespace {

using google::protobuf::Descriptor;
using google::protobuf::FieldDescriptor;
using google::protobuf::Message;
using google::protobuf::MethodDescriptor;
using records::Role;
using records::Scope;
using ::testing::HasSubstr;
using testing::MachineJson;

// As somebody of the shop would say it, apart from the server's own table. A technician, an approver and an admin are
// viewers; an admin is a technician and a cell.
const std::set<Role> kViewers = {Role::kViewer, Role::kTechnician, Role::kApprover, Role::kAdmin};
const std::set<Role> kCells = {Role::kCell, Role::kAdmin};
const std::set<Role> kAnyRole = {Role::kViewer, Role::kCell, Role::kTechnician, Role::kApprover, Role::kAdmin};
const std::set<Role> kTechnicians = {Role::kTechnician, Role::kAdmin};
const std::set<Role> kApprovers = {Role::kApprover};
const std::set<Role> kTechniciansAndApprovers = {Role::kTechnician, Role::kApprover, Role::kAdmin};
const std::set<Role> kAdmins = {Role::kAdmin};

enum class For { kAnybody, kWhatIsNamed, kLists, kRolesOfAll };
struct Expected {
  For what;
  std::set<Role> roles;
};
const std::map<std::string, Expected>& AllExpected() {
  static const auto* const expected = new std::map<std::string, Expected>{
      {"Machines.CreateMachine", {For::kRolesOfAll, kAdmins}},
      {"Machines.GetMachine", {For::kWhatIsNamed, kAnyRole}},
      {"Machines.ListMachines", {For::kLists, kAnyRole}},
      {"Machines.UpdateMachine", {For::kWhatIsNamed, kAdmins}},
      {"Machines.DeleteMachine", {For::kWhatIsNamed, kAdmins}},
      {"Ingest.CreateSession", {For::kWhatIsNamed, kCells}},
      {"Ingest.Upload", {For::kWhatIsNamed, kCells}},
      {"Ingest.UploadOnce", {For::kWhatIsNamed, kCells}},
      {"Ingest.PutLog", {For::kWhatIsNamed, kCells}},
      {"Ingest.GetSession", {For::kWhatIsNamed, kAnyRole}},
      {"Ingest.FinishSession", {For::kWhatIsNamed, kCells}},
      {"Ingest.AbortSession", {For::kWhatIsNamed, kCells}},
      {"Ingest.AnnotateSession", {For::kWhatIsNamed, kTechniciansAndApprovers}},
      {"Ingest.RejectSession", {For::kWhatIsNamed, kTechniciansAndApprovers}},
      {"Ingest.ListSessions", {For::kLists, kViewers}},
      {"Ingest.DownloadSession", {For::kWhatIsNamed, kViewers}},
      {"Ingest.ReportCell", {For::kWhatIsNamed, kCells}},
      {"Ingest.ListCells", {For::kLists, kViewers}},
      {"Ingest.ForgetCell", {For::kWhatIsNamed, kTechnicians}},
      {"Jobs.CreateJob", {For::kWhatIsNamed, kTechnicians}},
      {"Jobs.GetJob", {For::kWhatIsNamed, kViewers}},
      {"Jobs.GetReport", {For::kWhatIsNamed, kViewers}},
      {"Jobs.ListJobs", {For::kLists, kViewers}},
      {"Jobs.CancelJob", {For::kWhatIsNamed, kTechnicians}},
      {"Jobs.RequeueJob", {For::kWhatIsNamed, kTechnicians}},
      {"Jobs.WaitJob", {For::kWhatIsNamed, kViewers}},
      {"Jobs.WatchJob", {For::kWhatIsNamed, kViewers}},
      {"Calibrations.ListCalibrations", {For::kLists, kViewers}},
      {"Calibrations.GetCalibration", {For::kWhatIsNamed, kViewers}},
      {"Calibrations.DrawCalibration", {For::kWhatIsNamed, kViewers}},
      {"Calibrations.ListResiduals", {For::kWhatIsNamed, kViewers}},
      {"Calibrations.GetVolumetricError", {For::kWhatIsNamed, kViewers}},
      {"Calibrations.ListVolumetricErrors", {For::kWhatIsNamed, kViewers}},
      {"Calibrations.CompareCalibrations", {For::kWhatIsNamed, kViewers}},
      {"Calibrations.ApproveCalibration", {For::kWhatIsNamed, kApprovers}},
      {"Calibrations.RetireCalibration", {For::kWhatIsNamed, kApprovers}},
      {"Programs.ListPrograms", {For::kLists, kViewers}},
      {"Programs.PutProgram", {For::kWhatIsNamed, kTechnicians}},
      {"Programs.GetProgram", {For::kWhatIsNamed, kViewers}},
      {"Programs.RewriteProgram", {For::kWhatIsNamed, kTechnicians}},
      {"Tables.ListTableFormats", {For::kAnybody, {}}},
      {"Tables.MakeTable", {For::kWhatIsNamed, kTechnicians}},
      {"History.QueryDrift", {For::kWhatIsNamed, kViewers}},
      {"History.FindDrift", {For::kWhatIsNamed, kViewers}},
      {"History.LatestFleet", {For::kLists, kViewers}},
      {"History.ListCare", {For::kLists, kViewers}},
      {"Events.GetExpectations", {For::kWhatIsNamed, kViewers}},
      {"Events.SetExpectations", {For::kWhatIsNamed, kTechniciansAndApprovers}},
      {"Events.ListEvents", {For::kLists, kViewers}},
      {"Events.WatchEvents", {For::kLists, kViewers}},
      {"Events.AcknowledgeEvent", {For::kWhatIsNamed, kTechniciansAndApprovers}},
      {"Events.ShelveEvent", {For::kWhatIsNamed, kTechniciansAndApprovers}},
      {"History.PutMark", {For::kWhatIsNamed, kTechniciansAndApprovers}},
      {"History.ListMarks", {For::kWhatIsNamed, kViewers}},
      {"History.WithdrawMark", {For::kWhatIsNamed, kTechniciansAndApprovers}},
      {"Routines.PutRoutine", {For::kRolesOfAll, kAdmins}},
      {"Routines.RemoveRoutine", {For::kRolesOfAll, kAdmins}},
      {"Routines.ListRoutines", {For::kLists, kViewers}},
      {"Routines.StopRoutine", {For::kWhatIsNamed, kTechniciansAndApprovers}},
      {"Routines.RetryRoutine", {For::kWhatIsNamed, kTechnicians}},
      {"Routines.ListRoutineRuns", {For::kLists, kViewers}},
      {"Webhooks.PutWebhook", {For::kRolesOfAll, kAdmins}},
      {"Webhooks.RemoveWebhook", {For::kRolesOfAll, kAdmins}},
      {"Webhooks.ListWebhooks", {For::kRolesOfAll, kAdmins}},
      {"Webhooks.TestWebhook", {For::kRolesOfAll, kAdmins}},
      {"Webhooks.ListDeadLetters", {For::kRolesOfAll, kAdmins}},
      {"Webhooks.ResendDeadLetters", {For::kRolesOfAll, kAdmins}},
      {"Admin.GetServerInfo", {For::kAnybody, {}}},
      {"Admin.GetMetrics", {For::kRolesOfAll, kViewers}},
      {"Admin.Diagnose", {For::kRolesOfAll, kViewers}},
      {"Admin.SetLogLevel", {For::kRolesOfAll, kAdmins}},
      {"Admin.Backup", {For::kRolesOfAll, kAdmins}},
      {"Access.GetIdentity", {For::kAnybody, {}}},
      {"Access.CreatePrincipal", {For::kRolesOfAll, kAdmins}},
      {"Access.RevokePrincipal", {For::kRolesOfAll, kAdmins}},
      {"Access.ListPrincipals", {For::kRolesOfAll, kAdmins}},
      {"Access.CreateToken", {For::kRolesOfAll, kAdmins}},
      {"Access.RevokeToken", {For::kRolesOfAll, kAdmins}},
      {"Access.ChangeRole", {For::kRolesOfAll, kAdmins}},
      {"Access.ChangeGroup", {For::kRolesOfAll, kAdmins}},
      {"Access.SetFourEyes", {For::kRolesOfAll, kAdmins}},
      {"Access.ListMachineAccess", {For::kRolesOfAll, kAdmins}},
      {"Access.ListAudit", {For::kRolesOfAll, kAdmins}},
      {"Access.CheckAudit", {For::kRolesOfAll, kAdmins}},
  };
  return *expected;
}

// The methods of all files of the API that this program links.
std::vector<const MethodDescriptor*> AllMethods() {
  const google::protobuf::FileDescriptor* const files[] = {
      v1::GetIdentityRequest::descriptor()->file(),      v1::GetServerInfoRequest::descriptor()->file(),
      v1::GetCalibrationRequest::descriptor()->file(),   v1::QueryDriftRequest::descriptor()->file(),
      v1::CreateSessionRequest::descriptor()->file(),    v1::CreateJobRequest::descriptor()->file(),
      v1::GetMachineRequest::descriptor()->file(),       v1::PutProgramRequest::descriptor()->file(),
      v1::ListTableFormatsRequest::descriptor()->file(), v1::ListEventsRequest::descriptor()->file(),
      v1::ListRoutinesRequest::descriptor()->file(),     v1::ListWebhooksRequest::descriptor()->file(),
  };
  std::vector<const MethodDescriptor*> methods;
  for (const auto* const file : files) {
    for (int s = 0; s < file->service_count(); ++s) {
      for (int m = 0; m < file->service(s)->method_count(); ++m) methods.push_back(file->service(s)->method(m));
    }
  }
  return methods;
}

// One machine with a row of each kind.
struct Rows {
  std::string machine;
  int64_t session = 0, job = 0, calibration = 0, program = 0, mark = 0, event = 0;
};

// Sets every field that names a row, as a client would; whether there was one. Of a choice between messages the first.
bool Fill(Message& message, const Rows& rows) {
  const auto& reflection = *message.GetReflection();
  const Descriptor& type = *message.GetDescriptor();
  std::set<const google::protobuf::OneofDescriptor*> chosen;
  bool is_named = false;
  for (int i = 0; i < type.field_count(); ++i) {
    const FieldDescriptor& field = *type.field(i);
    const std::string& name = field.name();
    if (field.cpp_type() == FieldDescriptor::CPPTYPE_MESSAGE) {
      if (field.is_repeated() ||
          (field.real_containing_oneof() && !chosen.insert(field.real_containing_oneof()).second))
        continue;
      is_named |= Fill(*reflection.MutableMessage(&message, &field), rows);
      continue;
    }
    if (name == "description_json") {
      reflection.SetString(&message, &field, MachineJson(rows.machine));
      is_named = true;
    } else if (name == "machine_id" || name == "approved_of_machine_id") {
      reflection.SetString(&message, &field, rows.machine);
      is_named = true;
    } else if (name.ends_with("_id") || name.ends_with("_ids")) {
      const int64_t number = name.find("session") != std::string::npos       ? rows.session
                             : name.find("calibration") != std::string::npos ? rows.calibration
                             : name == "job_id"                              ? rows.job
                             : name == "program_id"                          ? rows.program
                             : name == "mark_id"                             ? rows.mark
                             : name == "event_id"                            ? rows.event
                                                                             : 0;
      if (number == 0) continue;
      field.is_repeated() ? reflection.AddInt64(&message, &field, number)
                          : reflection.SetInt64(&message, &field, number);
      is_named = true;
    }
  }
  return is_named;
}

class Access : public ::testing::Test {
 protected:
  void SetUp() override {
    storage::SqliteOptions options;
    options.path = dir_.File("axiscal.db");
    auto opened = storage::OpenSqlite(options);
    ASSERT_OK(opened);
    storage::Database& database = **opened;
    for (Rows* const rows : {&here_, &there_}) Store(database, *rows);
    ASSERT_OK(database.ChangeGroup("turning", MachineId("here"), true, kAdmin));
    for (const Role role : records::kAllRoles) {
      const std::string name = records::NameOf(role);
      Add(database, name + "-all", {{role, {}}});
      Add(database, name + "-group", {{role, {Scope::Kind::kGroup, "turning"}}});
      Add(database, name + "-here", {{role, {Scope::Kind::kMachine, "here"}}});
      Add(database, name + "-there", {{role, {Scope::Kind::kMachine, "there"}}});
    }
    Add(database, "nothing", {});
    opened->reset();
    StartServer();
  }
  void StartServer() {
    server::ServerOptions options;
    options.database_path = dir_.File("axiscal.db");
    options.asks_identity = true;
    options.backup_folder = dir_.File("backups");
    std::filesystem::create_directory(options.backup_folder);
    options.ask_again = std::chrono::milliseconds(20);
    options.drain = std::chrono::milliseconds(200);
    options.calls_per_second = calls_per_second_;
    options.streams_per_principal = streams_per_principal_;
    auto started = server::Server::Start(options);
    ASSERT_OK(started);
    server_ = *std::move(started);
    channel_ = server_->InProcessChannel();
  }
  void Store(storage::Database& database, Rows& rows) {
    const MachineId machine(rows.machine);
    ASSERT_OK(database.CreateMachine(machine, MachineJson(rows.machine), kAdmin));
    storage::NewSession session;
    session.machine = machine;
    session.name = "S";
    session.instrument = "ballbar";
    const session::Session measured = testing::BallbarSession(rows.machine, "S", 1);
    session.header = measured.header;
    for (const session::Column& column : measured.columns) session.columns.push_back({column.name, false});
    rows.session = database.CreateSession(session)->id.number();
    const ProgramId program = database.BeginProgram({"nc", "O1", kAdmin})->id;
    const std::string text = "(" + rows.machine + ")\n";
    ASSERT_OK(database.AppendProgram(program, 0, text));
    rows.program = database.FinishProgram(program, static_cast<int64_t>(text.size()), "")->id.number();
    storage::NewJob job;
    job.kind = records::kIdentify;
    job.machine = machine;
    job.caller = kAdmin;
    rows.job = database.CreateJob(job, 10)->id.number();
    const auto claimed = database.ClaimJob(std::chrono::seconds(30));
    ASSERT_OK(claimed);
    storage::NewCalibration calibration;
    calibration.machine = machine;
    calibration.machine_revision = 1;
    calibration.model_json = calibration.options_json = calibration.report_json = "{}";
    calibration.created_by = "technician-all";
    const auto done = database.SucceedJob(storage::ClaimOf(**claimed), {"{}", calibration, {ProgramId(rows.program)}});
    ASSERT_OK(done);
    rows.calibration = done->calibration->number();
    rows.mark =
        database.PutMark({machine, base::FromUtcUs(0), records::MarkKind::kService, {}, ""}, kAdmin)->id.number();
    storage::EventContent event;
    event.kind = records::EventKind::kWear;
    event.subject = "EX0C";
    ASSERT_OK(database.ChangeEvents({.machine = machine, .raised = {event}}));
    rows.event = database.ListEvents({machine, true}, {}, {})->rows.at(0).id.number();
  }
  void Add(storage::Database& database, const std::string& name, const std::vector<records::Grant>& grants) {
    ASSERT_OK(database.CreatePrincipal(name, "", kAdmin));
    for (const records::Grant& grant : grants) ASSERT_OK(database.ChangeRole(name, grant, true, kAdmin));
    tokens_[name] = access::NewToken();
    ASSERT_OK(database.CreateToken({name, access::HashOfToken(tokens_[name]), "", {}}, kAdmin));
  }

  // The call with one message, as `name` makes it ("": shows nothing).
  grpc::Status Call(const std::string& name, const MethodDescriptor& method, const Message& request) {
    return testing::SendBytes(channel_, "/" + method.service()->full_name() + "/" + method.name(),
                              {request.SerializeAsString()}, name.empty() ? "" : "Bearer " + tokens_.at(name),
                              method.name() == "WatchEvents");
  }
  static std::unique_ptr<Message> NewRequest(const MethodDescriptor& method) {
    return std::unique_ptr<Message>(
        google::protobuf::MessageFactory::generated_factory()->GetPrototype(method.input_type())->New());
  }
  std::unique_ptr<grpc::ClientContext> ContextOf(const std::string& name) {
    auto context = std::make_unique<grpc::ClientContext>();
    context->AddMetadata("authorization", "Bearer " + tokens_.at(name));
    context->set_deadline(std::chrono::system_clock::now() + std::chrono::seconds(30));
    return context;
  }
  client::Client ClientOf(const std::string& name) {
    const std::string file = dir_.File(name + ".token");
    EXPECT_TRUE(base::WriteFileAtomically(file, tokens_.at(name) + "\n").ok());
    client::Options options;
    options.identity.token_file = file;
    return *client::Client::InProcess(channel_, options);
  }

  static inline const storage::Caller kAdmin = {"setup", ""};
  int calls_per_second_ = 1000, streams_per_principal_ = 100;
  testing::TempDir dir_;
  Rows here_{.machine = "here"}, there_{.machine = "there"};
  const Rows none_{
      .machine = "none", .session = 991, .job = 992, .calibration = 993, .program = 994, .mark = 995, .event = 996};
  std::map<std::string, std::string> tokens_;
  std::unique_ptr<server::Server> server_;
  std::shared_ptr<grpc::Channel> channel_;
};

std::string NameOf(const MethodDescriptor& method) { return method.service()->name() + "." + method.name(); }

bool IsLetIn(const grpc::Status& status) {
  return status.error_code() != grpc::StatusCode::PERMISSION_DENIED &&
         status.error_code() != grpc::StatusCode::UNAUTHENTICATED;
}

TEST_F(Access, EveryMethodOfTheApiIsPlaced) {
  std::set<std::string> methods, expected;
  for (const MethodDescriptor* const method : AllMethods()) methods.insert(NameOf(*method));
  for (const auto& [method, what] : AllExpected()) expected.insert(method);
  EXPECT_EQ(methods, expected);
}

TEST_F(Access, NobodyIsLetInWithoutIdentity) {
  for (const MethodDescriptor* const method : AllMethods()) {
    const std::unique_ptr<Message> request = NewRequest(*method);
    Fill(*request, here_);
    const grpc::Status nobody = Call("", *method, *request);
    EXPECT_EQ(nobody.error_code(), grpc::StatusCode::UNAUTHENTICATED) << NameOf(*method);
    EXPECT_EQ(testing::ReasonOf(nobody), "IDENTITY_MISSING") << NameOf(*method);
    const grpc::Status wrong = testing::SendBytes(channel_, "/" + method->service()->full_name() + "/" + method->name(),
                                                  {request->SerializeAsString()}, "Bearer axt_wrong");
    EXPECT_EQ(testing::ReasonOf(wrong), "TOKEN_INVALID") << NameOf(*method);
  }
  // Health is open.
  const auto health = grpc::health::v1::Health::NewStub(channel_);
  grpc::ClientContext context;
  grpc::health::v1::HealthCheckResponse response;
  EXPECT_TRUE(health->Check(&context, {}, &response).ok());
  // What the API is, is told to nobody.
  EXPECT_EQ(
      testing::SendBytes(channel_, "/grpc.reflection.v1alpha.ServerReflection/ServerReflectionInfo", {""}).error_code(),
      grpc::StatusCode::UNIMPLEMENTED);
}

// Role x method x scope. What a call that is let in answers is its handler's business.
TEST_F(Access, EachRoleMayDoWhatItIsFor) {
  for (const MethodDescriptor* const method : AllMethods()) {
    const std::string what = NameOf(*method);
    const auto found = AllExpected().find(what);
    ASSERT_NE(found, AllExpected().end()) << what;
    const Expected& expected = found->second;
    const std::unique_ptr<Message> request = NewRequest(*method), missing = NewRequest(*method);
    const bool names_rows = Fill(*request, here_);
    Fill(*missing, none_);
    for (const Role role : records::kAllRoles) {
      const std::string name = records::NameOf(role);
      const bool is_role = expected.what == For::kAnybody || expected.roles.contains(role);
      for (const std::string scope : {"-all", "-group", "-here"}) {
        const grpc::Status status = Call(name + scope, *method, *request);
        const bool is_for_all = expected.what == For::kRolesOfAll;
        const bool may = is_role && (!is_for_all || scope == "-all");
        EXPECT_EQ(IsLetIn(status), may) << name << scope << " " << what << ": " << status.error_message();
        if (may) continue;
        EXPECT_EQ(status.error_code(), grpc::StatusCode::PERMISSION_DENIED) << name << scope << " " << what;
        EXPECT_EQ(testing::ReasonOf(status), "ROLE_MISSING") << name << scope << " " << what;
        EXPECT_THAT(status.error_message(), HasSubstr("needs the role ")) << what;
      }
      const grpc::Status outside = Call(name + "-there", *method, *request);
      if (expected.what == For::kAnybody) {
        EXPECT_TRUE(IsLetIn(outside)) << name << " " << what;
      } else if (expected.what == For::kRolesOfAll) {
        EXPECT_EQ(testing::ReasonOf(outside), "ROLE_MISSING") << name << " " << what;
      } else if (!names_rows) {
        EXPECT_EQ(IsLetIn(outside), is_role) << name << " " << what << ": " << outside.error_message();
      } else {
        // Outside its scope nothing exists, whatever the role: as for what is nowhere.
        const grpc::Status nowhere = Call(name + "-there", *method, *missing);
        EXPECT_EQ(outside.error_code(), grpc::StatusCode::NOT_FOUND) << name << " " << what;
        EXPECT_EQ(nowhere.error_code(), grpc::StatusCode::NOT_FOUND) << name << " " << what;
        EXPECT_EQ(testing::ReasonOf(outside), testing::ReasonOf(nowhere)) << name << " " << what;
        const std::regex row("(machine|session|job|calibration|program|mark|event) [a-z0-9]+");
        EXPECT_EQ(std::regex_replace(outside.error_message(), row, "$1 #"),
                  std::regex_replace(nowhere.error_message(), row, "$1 #"));
        EXPECT_THAT(outside.error_message(), HasSubstr(" does not exist")) << what;
      }
    }
    const grpc::Status nothing = Call("nothing", *method, *request);
    EXPECT_EQ(nothing.error_code(), expected.what == For::kAnybody ? nothing.error_code()
                                    : names_rows && expected.what != For::kRolesOfAll
                                        ? grpc::StatusCode::NOT_FOUND
                                        : grpc::StatusCode::PERMISSION_DENIED)
        << what << ": " << nothing.error_message();
    EXPECT_TRUE(IsLetIn(nothing) || expected.what != For::kAnybody) << what;
  }
}

TEST_F(Access, ListsHoldWhatTheCallerMaySeeAndNothingElse) {
  for (const std::string name : {"viewer-here", "technician-group", "approver-here"}) {
    client::Client client = ClientOf(name);
    ASSERT_EQ(client.ListMachines()->rows.size(), 1u) << name;
    EXPECT_EQ(client.ListMachines()->rows[0].id.text(), "here");
    ASSERT_EQ(client.ListSessions()->rows.size(), 1u) << name;
    EXPECT_EQ(client.ListSessions()->rows[0].id.number(), here_.session);
    ASSERT_EQ(client.ListJobs()->rows.size(), 1u) << name;
    EXPECT_EQ(client.ListJobs()->rows[0].id.number(), here_.job);
    ASSERT_EQ(client.ListCalibrations()->rows.size(), 1u) << name;
    EXPECT_EQ(client.ListCalibrations()->rows[0].id.number(), here_.calibration);
    ASSERT_EQ(client.ListPrograms()->rows.size(), 1u) << name;
    EXPECT_EQ(client.ListPrograms()->rows[0].id.number(), here_.program);
    ASSERT_EQ(client.LatestFleet({})->rows.size(), 1u) << name;
    EXPECT_EQ(client.LatestFleet({})->rows[0].machine.text(), "here");
    EXPECT_EQ(client.ListSessions({MachineId("there"), {}}).status().code(), absl::StatusCode::kNotFound);
  }
  EXPECT_EQ(ClientOf("viewer-all").ListSessions()->rows.size(), 2u);
  EXPECT_EQ(ClientOf("cell-here").ListSessions().status().code(), absl::StatusCode::kPermissionDenied);
}

// A job of one's own machine may not draw on another's sessions, calibrations and programs, nor learn that they are
// there.
TEST_F(Access, AJobNamesNothingOutsideTheScope) {
  client::Client client = ClientOf("technician-here");
  const absl::Status session = client
                                   .CreateJob(records::IdentifyParams{
                                       MachineId("here"), {SessionId(here_.session), SessionId(there_.session)}, {}})
                                   .status();
  EXPECT_EQ(session.code(), absl::StatusCode::kNotFound) << session;
  records::CompensateParams compensate;
  compensate.machine = MachineId("here");
  compensate.program = ProgramId(there_.program);
  EXPECT_THAT(client.CreateJob(compensate).status().message(), HasSubstr("program"));
  EXPECT_EQ(client.CreateJob(compensate).status().code(), absl::StatusCode::kNotFound);
}

TEST_F(Access, NoNameThatIsStatedIsTrusted) {
  const auto stub = v1::Access::NewStub(channel_);
  const auto context = ContextOf("viewer-here");
  context->AddMetadata("axiscal-user", "admin-all");
  v1::GetIdentityResponse identity;
  ASSERT_TRUE(stub->GetIdentity(context.get(), {}, &identity).ok());
  EXPECT_EQ(identity.name(), "viewer-here");
  ASSERT_EQ(identity.grants_size(), 1);
  EXPECT_EQ(identity.grants(0).role(), v1::ROLE_VIEWER);
  // Who approves is who calls.
  client::Client approver = ClientOf("approver-here");
  v1::ApproveCalibrationRequest request;
  request.set_calibration_id(here_.calibration);
  request.set_etag(approver.GetCalibration(CalibrationId(here_.calibration))->etag);
  request.set_approved_by("technician-all");
  const auto calibrations = v1::Calibrations::NewStub(channel_);
  v1::ApproveCalibrationResponse approved;
  const grpc::Status status = calibrations->ApproveCalibration(ContextOf("approver-here").get(), request, &approved);
  EXPECT_EQ(status.ok() ? approved.calibration().approved_by() : "approver-here", "approver-here");
}

TEST_F(Access, ARevokedPrincipalIsCutOffInTheMidstOfAStream) {
  const auto stub = v1::Ingest::NewStub(channel_);
  const auto context = ContextOf("cell-here");
  const auto stream = stub->Upload(context.get());
  v1::UploadRequest header;
  header.mutable_header()->set_session_id(here_.session);
  ASSERT_TRUE(stream->Write(header));
  v1::UploadResponse response;
  ASSERT_TRUE(stream->Read(&response));  // it is open
  ASSERT_OK(ClientOf("admin-all").RevokePrincipal("cell-here"));
  EXPECT_FALSE(stream->Read(&response));
  EXPECT_EQ(stream->Finish().error_code(), grpc::StatusCode::CANCELLED);
  EXPECT_EQ(ClientOf("cell-here").GetServerInfo().status().code(), absl::StatusCode::kUnauthenticated);
}

TEST_F(Access, ARoleThatIsTakenAwayEndsTheStreamsThatNeedIt) {
  const auto stub = v1::Ingest::NewStub(channel_);
  const auto context = ContextOf("cell-here"), other_context = ContextOf("cell-group");
  const auto stream = stub->Upload(context.get());
  const auto other = stub->Upload(other_context.get());
  v1::UploadRequest header;
  header.mutable_header()->set_session_id(here_.session);
  v1::UploadResponse response;
  for (const auto* const one : {&stream, &other}) {
    ASSERT_TRUE((*one)->Write(header));
    ASSERT_TRUE((*one)->Read(&response));
  }
  ASSERT_OK(ClientOf("admin-all").ChangeRole("cell-here", {Role::kCell, {Scope::Kind::kMachine, "here"}}, false));
  EXPECT_FALSE(stream->Read(&response));
  EXPECT_EQ(stream->Finish().error_code(), grpc::StatusCode::CANCELLED);
  // Who has it still goes on.
  EXPECT_TRUE(other->WritesDone());
  EXPECT_TRUE(other->Finish().ok());
}

// A stream of what may be seen shows no more of a machine once its role is gone, though the caller has others.
TEST_F(Access, AStreamOfEventsBeginsAnewWhenRolesChange) {
  client::Client viewer = ClientOf("viewer-here"), admin = ClientOf("admin-all");
  std::set<std::string> seen;
  int64_t up_to = 0;
  bool is_there = false, has_lost = false;
  ASSERT_OK(viewer.WatchEvents({}, 0, [&](const records::EventNews& news) {
    up_to = news.up_to;
    if (news.change) seen.insert(news.change->event.machine.text());
    if (news.change && !is_there) {
      is_there = true;
      EXPECT_TRUE(admin.ChangeRole("viewer-here", {Role::kViewer, {Scope::Kind::kMachine, "there"}}, true).ok());
      EXPECT_TRUE(admin.ChangeRole("viewer-here", {Role::kViewer, {Scope::Kind::kMachine, "here"}}, false).ok());
    } else if (is_there && !news.change) {
      has_lost = true;  // the first message of the stream that began anew
    }
    return !has_lost;
  }));
  EXPECT_EQ(seen, std::set<std::string>{"here"});
  // A word about each machine's event: only that of the machine that may be seen now comes.
  ASSERT_OK(ClientOf("technician-here").AcknowledgeEvent(EventId(here_.event), "here"));
  ASSERT_OK(ClientOf("technician-there").AcknowledgeEvent(EventId(there_.event), "there"));
  std::string note;
  ASSERT_OK(viewer.WatchEvents({}, up_to, [&](const records::EventNews& news) {
    if (news.change) {
      EXPECT_EQ(news.change->event.machine.text(), "there");
      note = news.change->note;
    }
    return note != "there";  // what the server itself finds of that machine may come before
  }));
  EXPECT_EQ(note, "there");
}

TEST_F(Access, ATokenFileThatIsReplacedHoldsFromTheNextCallOn) {
  client::Client client = ClientOf("viewer-here");
  ASSERT_EQ(client.GetIdentity()->name, "viewer-here");
  ASSERT_TRUE(base::WriteFileAtomically(dir_.File("viewer-here.token"), tokens_["viewer-there"] + "\n").ok());
  EXPECT_EQ(client.GetIdentity()->name, "viewer-there");
}

// A job goes on only as long as its creator may create it.
TEST_F(Access, AJobOfWhoHasLostTheRoleIsCancelled) {
  client::Client technician = ClientOf("technician-here");
  records::IdentifyParams params{MachineId("here"), {}, {}};
  client::Client cell = ClientOf("cell-here");
  for (const char* name : {"a", "b", "c"}) {
    const auto upload = cell.Upload(MachineId("here"), testing::BallbarSession("here", name, 100'000));
    ASSERT_OK(upload);
    params.sessions.push_back(upload->session.id);
  }
  const auto job = technician.CreateJob(params);
  ASSERT_OK(job);
  ASSERT_OK(
      ClientOf("admin-all").ChangeRole("technician-here", {Role::kTechnician, {Scope::Kind::kMachine, "here"}}, false));
  const auto ended = ClientOf("viewer-here").WaitJob(job->id, std::chrono::minutes(5));
  ASSERT_OK(ended);
  EXPECT_EQ(ended->state, records::JobState::kCancelled);
  EXPECT_FALSE(ended->calibration.has_value());
}

// What one does too often is refused to him alone.
TEST_F(Access, AFloodIsRefusedToWhoMakesIt) {
  calls_per_second_ = 100'000;
  streams_per_principal_ = 2;
  server_.reset();
  StartServer();
  const auto call = [&](const std::string& name) {
    const auto stub = v1::Admin::NewStub(channel_);
    v1::GetServerInfoResponse response;
    if (!name.empty()) return stub->GetServerInfo(ContextOf(name).get(), {}, &response);
    grpc::ClientContext context;
    return stub->GetServerInfo(&context, {}, &response);
  };
  const auto ingest = v1::Ingest::NewStub(channel_);
  const auto stream = [&](const std::string& name, grpc::ClientContext& context, v1::UploadOnceResponse& response) {
    context.AddMetadata("authorization", "Bearer " + tokens_.at(name));
    return ingest->UploadOnce(&context, &response);
  };
  // Two streams that are open, and a third.
  grpc::ClientContext contexts[4];
  v1::UploadOnceResponse responses[4];
  const auto first = stream("cell-here", contexts[0], responses[0]);
  const auto second = stream("cell-here", contexts[1], responses[1]);
  v1::UploadRequest header;
  header.mutable_header()->set_session_id(here_.session);
  EXPECT_TRUE(first->Write(header));
  EXPECT_TRUE(second->Write(header));
  client::Client viewer = ClientOf("viewer-here");
  while (viewer.GetServerInfo()->open_uploads < 2) std::this_thread::yield();
  const grpc::Status third = stream("cell-here", contexts[2], responses[2])->Finish();
  EXPECT_EQ(third.error_code(), grpc::StatusCode::RESOURCE_EXHAUSTED) << third.error_message();
  EXPECT_EQ(testing::ReasonOf(third), "QUEUE_FULL");
  const auto of_another = stream("cell-all", contexts[3], responses[3]);
  of_another->WritesDone();
  EXPECT_NE(of_another->Finish().error_code(), grpc::StatusCode::RESOURCE_EXHAUSTED);
  first->WritesDone();
  second->WritesDone();
  EXPECT_NE(first->Finish().error_code(), grpc::StatusCode::RESOURCE_EXHAUSTED);
  EXPECT_NE(second->Finish().error_code(), grpc::StatusCode::RESOURCE_EXHAUSTED);
  // Calls, of a principal and of nobody.
  calls_per_second_ = 5;
  server_.reset();
  StartServer();
  for (const std::string name : {"technician-here", ""}) {
    grpc::Status refused;
    for (int calls = 0; calls < 1000 && refused.error_code() != grpc::StatusCode::RESOURCE_EXHAUSTED; ++calls)
      refused = call(name);
    EXPECT_EQ(testing::ReasonOf(refused), "RATE_EXCEEDED") << name;
  }
  EXPECT_TRUE(call("technician-all").ok());
}

TEST_F(Access, AdminsOfAllMakeBackups) {
  client::Client admin = ClientOf("admin-all");
  EXPECT_EQ(ClientOf("admin-here").MakeBackup().status().code(), absl::StatusCode::kPermissionDenied);
  const auto kept = admin.MakeBackup();
  ASSERT_OK(kept);
  EXPECT_EQ(kept->damage_count, 0);
  const std::string path = dir_.File("backups/" + kept->file);
  const auto checked = storage::CheckStoreFile(path);
  ASSERT_OK(checked);
  EXPECT_EQ(checked->damage_count, 0);
  EXPECT_EQ(checked->calibrations, 2);
  std::string bytes;
  const auto sent = admin.MakeBackup([&](const std::string& part) {
    bytes += part;
    return absl::OkStatus();
  });
  ASSERT_OK(sent);
  EXPECT_EQ(sent->file, "");
  EXPECT_EQ(static_cast<int64_t>(bytes.size()), sent->size_bytes);
  EXPECT_EQ(bytes.substr(0, 15), "SQLite format 3");
  const auto audit = admin.ListAudit({{}, {}, "admin-all", "store"});
  ASSERT_OK(audit);
  ASSERT_EQ(audit->rows.size(), 2u);
  EXPECT_EQ(audit->rows[1].became, kept->file + ", sha256 " + kept->sha256);
  // Nothing else stays in the folder.
  EXPECT_EQ(std::distance(std::filesystem::directory_iterator(dir_.File("backups")), {}), 2);  // and its lock
}

// A server that is killed in the midst of a backup leaves part of one, under a name that no later backup has.
TEST_F(Access, PartsOfBackupsThatAreOldGoWithTheNextOne) {
  const auto leave = [&](const std::string& name, int hours) {
    const std::filesystem::path path = dir_.File("backups/" + name);
    std::ofstream(path) << "part";
    std::filesystem::last_write_time(path, std::filesystem::file_time_type::clock::now() - std::chrono::hours(hours));
    return path;
  };
  const auto left = leave("axiscal-20260531T140307Z.db.part", 25), young = leave("axiscal-20260601T140307Z.db.part", 1),
             whole = leave("axiscal-20260531T140307Z.db", 25), mine = leave("mine.db.part", 25);
  ASSERT_OK(ClientOf("admin-all").MakeBackup());
  EXPECT_FALSE(std::filesystem::exists(left));
  for (const auto& path : {young, whole, mine}) EXPECT_TRUE(std::filesystem::exists(path)) << path;
}

TEST_F(Access, DeniedCallsAreInTheAudit) {
  const auto denied = ClientOf("technician-here").ApproveCalibration(CalibrationId(here_.calibration), 1);
  ASSERT_EQ(denied.status().code(), absl::StatusCode::kPermissionDenied);
  // What is hidden from a caller is told to the admin; what does not exist is no denial.
  ASSERT_EQ(ClientOf("viewer-there").GetJob(JobId(here_.job)).status().code(), absl::StatusCode::kNotFound);
  ASSERT_EQ(ClientOf("viewer-there").GetJob(JobId(992)).status().code(), absl::StatusCode::kNotFound);
  client::Client admin = ClientOf("admin-all");
  const auto entries_of = [&](const client::AuditFilter& filter) {
    std::vector<client::AuditEntry> entries;
    while (entries.empty()) {
      const auto audit = admin.ListAudit(filter);
      EXPECT_TRUE(audit.ok()) << audit.status();
      if (!audit.ok()) return std::vector<client::AuditEntry>(1);
      entries = audit->rows;
    }
    return entries;
  };
  const client::AuditEntry refused = entries_of({{}, {}, "technician-here", ""})[0];
  EXPECT_EQ(refused.action, "denied Calibrations.ApproveCalibration");
  EXPECT_EQ(refused.resource, absl::StrCat("calibrations/", here_.calibration));
  EXPECT_EQ(refused.outcome, "PERMISSION_DENIED");
  EXPECT_EQ(refused.detail, "ROLE_MISSING, 1 call");
  const std::vector<client::AuditEntry> hidden = entries_of({{}, {}, "viewer-there", ""});
  ASSERT_EQ(hidden.size(), 1u);
  EXPECT_EQ(hidden[0].resource, absl::StrCat("jobs/", here_.job));
  EXPECT_EQ(hidden[0].outcome, "NOT_FOUND");
  EXPECT_EQ(hidden[0].detail, "OUT_OF_SCOPE, 1 call");
  const auto head = admin.CheckAudit();
  ASSERT_OK(head);
  EXPECT_GE(head->last_entry, refused.number);
}

// A flood of denied calls is one entry for each kind, a bounded number of them, and hides nobody else's.
TEST_F(Access, AFloodOfDeniedCallsIsCounted) {
  base::FakeClock clock;
  server::Denials denials(clock);
  const auto flood = [&](int first, int calls) {
    for (int i = first; i < first + calls; ++i) {
      denials.Add("", access::PeerHost("ipv4:192.0." + std::to_string(i) + ":7"), "Jobs.GetJob",
                  absl::UnauthenticatedError("x"));
      denials.Add("bob", "", "Jobs.GetJob" + std::to_string(i), absl::PermissionDeniedError("x"));
      denials.Add("eve", access::PeerHost("ipv4:192.0.2.7:" + std::to_string(1000 + i % 5000)), "Jobs.CreateJob",
                  absl::PermissionDeniedError("x"));
      denials.Add("eve", "", "Jobs.CreateJob", absl::NotFoundError("x"));
    }
  };
  server_.reset();
  storage::SqliteOptions options;
  options.path = dir_.File("axiscal.db");
  const auto database = storage::OpenSqlite(options);
  ASSERT_OK(database);
  const auto written = [&] { return (*database)->CheckAudit()->id; };
  const auto of = [&](const std::string& user) { return (*database)->ListAudit({{}, {}, user, ""}, {1000, ""})->rows; };
  const int64_t before = written();
  flood(0, 10'000);
  ASSERT_OK(denials.Write(**database));
  constexpr int64_t kNobody = server::Denials::kMaxKinds / 2, kOne = server::Denials::kMaxKindsOfOne;
  EXPECT_EQ(written() - before, kNobody + 1 + kOne + 1 + 1);
  ASSERT_EQ(of("eve").size(), 1u);
  EXPECT_EQ(of("eve")[0].detail, "10000 calls");
  EXPECT_EQ(of("eve")[0].peer, "ipv4:192.0.2.7");
  EXPECT_EQ(static_cast<int64_t>(of("bob").size()), kOne + 1);
  // While it goes on, only what doubles is written, and the rest when the hour is over.
  for (int i = 1; i <= 9; ++i) {
    flood(i * 1000, 1000);
    ASSERT_OK(denials.Write(**database));
  }
  EXPECT_EQ(of("eve").size(), 1u);
  clock.Advance(std::chrono::hours(1));
  ASSERT_OK(denials.Write(**database));
  ASSERT_EQ(of("eve").size(), 2u);
  EXPECT_EQ(of("eve")[0].detail, "9000 calls");
  const int64_t after = written();
  ASSERT_OK(denials.Write(**database));
  EXPECT_EQ(written(), after);
  // The next hour begins anew.
  flood(0, 1);
  ASSERT_OK(denials.Write(**database, true));
  EXPECT_EQ(of("eve")[0].detail, "1 call");
}

TEST_F(Access, AdminsAddPrincipalsWhoseTokensWork) {
  client::Client admin = ClientOf("admin-all");
  ASSERT_OK(admin.CreatePrincipal("ann", "the desk"));
  ASSERT_OK(admin.ChangeRole("ann", {Role::kTechnician, {Scope::Kind::kGroup, "turning"}}, true));
  const auto token = admin.CreateToken("ann", "desk", base::SystemClock().UtcNow() + std::chrono::hours(1));
  ASSERT_OK(token);
  tokens_["ann"] = token->secret;
  EXPECT_EQ(ClientOf("ann").GetIdentity()->name, "ann");
  EXPECT_EQ(ClientOf("ann").ListJobs()->rows.size(), 1u);
  const auto principals = admin.ListPrincipals();
  ASSERT_OK(principals);
  EXPECT_EQ(principals->rows.front().name, "admin-all");
  for (const records::PrincipalRecord& record : principals->rows) {
    if (record.name != "ann") continue;
    EXPECT_EQ(record.created_by, "admin-all");
    ASSERT_EQ(record.tokens.size(), 1u);
    EXPECT_TRUE(record.tokens[0].last_used_at.has_value());
  }
  ASSERT_OK(admin.RevokeToken(token->record.id));
  EXPECT_EQ(ClientOf("ann").GetServerInfo().status().code(), absl::StatusCode::kUnauthenticated);
  EXPECT_EQ(base::ErrorReason(admin.CreateToken("ann", "", base::SystemClock().UtcNow()).status()), "FIELD_INVALID");
}

}  // namespace
}  // namespace axiscal
