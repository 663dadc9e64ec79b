// The technician's way: identify, look, approve, roll back, compensate, look at the history.
#include <gmock/gmock.h>

#include <cmath>
#include <cstdlib>
#include <map>
#include <nlohmann/json.hpp>
#include <set>

#include "axiscal/v1/calibrations_service.grpc.pb.h"
#include "axiscal/v1/jobs_service.grpc.pb.h"
#include "axiscal/v1/programs_service.grpc.pb.h"
#include "core/base/error_detail.h"
#include "proto/convert/job_params.h"
#include "server/local_login.h"
#include "server/storage/page_token.h"
#include "server/storage/sqlite_database.h"
#include "tests/end_to_end/testing/job_fixture.h"
#include "tests/end_to_end/testing/raw_upload.h"

namespace axiscal {
namespace {

using records::CalibrationState;
using records::JobState;
using ::testing::HasSubstr;
using testing::Job;
using testing::MachineJson;

constexpr double kToleranceUm = 0.05;  // the readings are exact to 1e-4 um; priors on the setups pull by less than this

TEST_F(Job, IdentifyMakesACandidateWithItsProvenance) {
  const SessionId session = UploadSession("BX");
  const records::IdentifyParams params{MachineId("mt"), {session}, {}};
  const auto created = client().CreateJob(params, "identify-1");
  ASSERT_OK(created);
  std::vector<client::JobRecord> seen;
  const auto ended = client().WatchJob(created->id, [&](const client::JobRecord& job) {
    seen.push_back(job);
    return true;
  });
  ASSERT_OK(ended);
  ASSERT_EQ(ended->state, JobState::kSucceeded) << (ended->error ? ended->error->message : "");
  ASSERT_FALSE(seen.empty());
  EXPECT_EQ(seen.back().state, JobState::kSucceeded);
  EXPECT_EQ(ended->attempt, 1);
  ASSERT_TRUE(ended->calibration.has_value());

  const auto calibration = client().GetCalibration(*ended->calibration);
  ASSERT_OK(calibration);
  EXPECT_EQ(calibration->state, CalibrationState::kCandidate);
  EXPECT_EQ(calibration->version, 1);
  EXPECT_EQ(calibration->job, created->id);
  EXPECT_EQ(calibration->content.sessions, params.sessions);
  EXPECT_EQ(calibration->content.machine_revision, 1);
  ASSERT_EQ(calibration->content.estimates.size(), 2u);
  EXPECT_EQ(calibration->content.estimates[0].symbol, "EX0C");
  EXPECT_NEAR(calibration->content.estimates[0].value.value_or(NAN), 12, kToleranceUm);
  EXPECT_NEAR(calibration->content.estimates[1].value.value_or(NAN), -5, kToleranceUm);
  EXPECT_GT(calibration->content.estimates[0].sigma.value_or(NAN), 0);
  EXPECT_LT(calibration->content.rms_after_um.value_or(NAN), kToleranceUm);

  // The same request is the same job, another one under its id is refused.
  const auto again = client().CreateJob(params, "identify-1");
  ASSERT_OK(again);
  EXPECT_EQ(again->id, created->id);
  const auto other = client().CreateJob(records::IdentifyParams{MachineId("mt"), {session}, {"EX0C"}}, "identify-1");
  EXPECT_EQ(base::ErrorReason(other.status()), "REQUEST_ID_REUSED");
}

// "... before: rms 12.3 um ..." -> 12.3
double RmsUm(const std::string& svg, const std::string& panel) {
  const std::string words = panel + ": rms ";
  const size_t at = svg.find(words);
  return at == std::string::npos ? NAN : std::strtod(svg.c_str() + at + words.size(), nullptr);
}

TEST_F(Job, ACalibrationIsDrawnWithoutAndWithItsErrors) {
  // X is 100 um/m too long: 10 um at the bar's end, seen as the square of the cosine, which no set-up can take up.
  session::Session session = testing::BallbarSession("mt", "BX", 720);
  for (size_t k = 0; k < session.columns[1].values.size(); ++k) {
    const double cosine = session.columns[1].values[k] / 100;
    session.columns.back().values[k] += 0.010 * cosine * cosine;
  }
  const client::JobRecord job = RunJob(records::IdentifyParams{
      MachineId("mt"), {UploadSession(session)}, {"EX0C", "EY0C", R"({"symbol": "EXX", "shape": "linear"})"}});
  ASSERT_EQ(job.state, JobState::kSucceeded) << (job.error ? job.error->message : "");
  const CalibrationId id = *job.calibration;
  const auto stub = v1::Calibrations::NewStub(channel());
  v1::DrawCalibrationRequest request;
  request.set_calibration_id(id.number());
  v1::DrawCalibrationResponse drawn;
  grpc::ClientContext context;
  ASSERT_TRUE(stub->DrawCalibration(&context, request, &drawn).ok());
  EXPECT_GT(drawn.readings(), 100);
  EXPECT_EQ(drawn.left_out_size(), 0);
  std::map<std::string, std::string> pictures;
  for (const v1::CalibrationPicture& picture : drawn.pictures()) pictures[picture.file()] = picture.svg();
  // C turns under a ball bar: residuals over C, and a trace by its angle.
  for (const char* file : {"residual-C.svg", "trace-BX.svg"}) {
    ASSERT_TRUE(pictures.count(file)) << file;
    EXPECT_THAT(pictures[file], HasSubstr("<svg xmlns="));
    // 5 um of amplitude are left by the set-ups alone, nothing with the errors.
    EXPECT_NEAR(RmsUm(pictures[file], "before"), 5 / std::sqrt(2), 0.1);
    EXPECT_LT(RmsUm(pictures[file], "after"), kToleranceUm);
  }
  // What it shows is at hand as numbers, too. The square of a cosine is the second order, of half its size.
  std::map<std::string, v1::CalibrationPicture> shown;
  for (const v1::CalibrationPicture& picture : drawn.pictures()) shown[picture.file()] = picture;
  EXPECT_EQ(shown["residual-C.svg"].x_label(), "C, deg");
  ASSERT_EQ(shown["residual-C.svg"].series_size(), 2);  // before, after
  EXPECT_EQ(shown["residual-C.svg"].series(0).y_size(), 720);
  EXPECT_EQ(shown["residual-C.svg"].series(0).x_size(), 720);
  ASSERT_EQ(shown["spectrum-C.svg"].series_size(), 2);
  EXPECT_EQ(shown["spectrum-C.svg"].series(0).x(1), 2.0);
  EXPECT_NEAR(shown["spectrum-C.svg"].series(0).y(1), 5.0, 0.1);
  EXPECT_LT(shown["spectrum-C.svg"].series(1).y(1), kToleranceUm);
  request.set_file("spectrum-C.svg");
  grpc::ClientContext one;
  ASSERT_TRUE(stub->DrawCalibration(&one, request, &drawn).ok());
  ASSERT_EQ(drawn.pictures_size(), 1);
  EXPECT_EQ(drawn.pictures(0).series_size(), 2);
  request.set_file("spectrum-Q.svg");
  grpc::ClientContext none;
  EXPECT_THAT(stub->DrawCalibration(&none, request, &drawn).error_message(), HasSubstr("no picture 'spectrum-Q.svg'"));
  // In the reader's language.
  request.set_file("residual-C.svg");
  request.set_language("de");
  grpc::ClientContext in_german;
  ASSERT_TRUE(stub->DrawCalibration(&in_german, request, &drawn).ok());
  ASSERT_EQ(drawn.pictures_size(), 1);
  EXPECT_EQ(drawn.pictures(0).x_label(), "C, °");
  EXPECT_THAT(drawn.pictures(0).svg(), HasSubstr("vorher: quadr. Mittel 3,5"));
  request.set_language("fr");
  grpc::ClientContext in_french;
  EXPECT_THAT(stub->DrawCalibration(&in_french, request, &drawn).error_message(), HasSubstr("language = 'fr'"));
  request.clear_language();
  request.clear_file();

  request.set_calibration_id(id.number() + 1);
  grpc::ClientContext other;
  EXPECT_EQ(stub->DrawCalibration(&other, request, &drawn).error_code(), grpc::StatusCode::NOT_FOUND);
}

TEST_F(Job, ACalibrationIsComparedBeforeItTakesAnothersPlace) {
  const CalibrationId in_use = Identify();  // EX0C = 12 um
  // 80 um less of EX0C, which is far beyond what the set-ups leave open.
  session::Session session = testing::BallbarSession("mt", "BX-later", 720);
  for (size_t k = 0; k < session.columns[1].values.size(); ++k)
    session.columns.back().values[k] += 0.080 * session.columns[1].values[k] / 100;
  const client::JobRecord job = RunJob(records::IdentifyParams{MachineId("mt"), {UploadSession(session)}, {}});
  ASSERT_EQ(job.state, JobState::kSucceeded) << (job.error ? job.error->message : "");
  const auto stub = v1::Calibrations::NewStub(channel());
  v1::CompareCalibrationsRequest request;
  request.set_calibration_id(job.calibration->number());
  const auto compare = [&](v1::CompareCalibrationsResponse* response) {
    grpc::ClientContext context;
    response->Clear();
    return stub->CompareCalibrations(&context, request, response);
  };
  v1::CompareCalibrationsResponse made;
  EXPECT_EQ(compare(&made).error_code(), grpc::StatusCode::NOT_FOUND);  // none is in use
  ASSERT_OK(client().ApproveCalibration(in_use, client().GetCalibration(in_use)->etag));
  ASSERT_TRUE(compare(&made).ok());
  EXPECT_EQ(made.calibration_id(), job.calibration->number());
  EXPECT_EQ(made.with_calibration_id(), in_use.number());
  ASSERT_EQ(made.errors_size(), 2);
  EXPECT_EQ(made.errors(0).name(), "EX0C");
  EXPECT_NEAR(made.errors(0).other(), 12, kToleranceUm);
  EXPECT_NEAR(made.errors(0).difference(), -80, 2 * kToleranceUm);
  EXPECT_EQ(made.errors(0).verdict(), v1::DIFFERENCE_VERDICT_DIFFERS);
  EXPECT_EQ(made.errors(1).verdict(), v1::DIFFERENCE_VERDICT_AGREES);
  EXPECT_LT(made.probability(), 1e-6);
  // Over what was measured; a set-up that is made anew takes all of a shift up.
  const auto span_of = [&made](const std::string& axis) {
    for (const v1::AxisSpan& one : made.box())
      if (one.axis() == axis) return one;
    return v1::AxisSpan();
  };
  ASSERT_EQ(made.box_size(), 5);
  EXPECT_NEAR(span_of("X").from_mm_or_deg(), -100, 1e-6);
  EXPECT_GT(made.poses(), 100);
  EXPECT_NEAR(made.as_programmed().max_um(), 80, 2 * kToleranceUm);
  EXPECT_EQ(made.as_programmed().largest_at_mm_or_deg_size(), 5);
  EXPECT_EQ(made.as_programmed().by(0), "EX0C");
  EXPECT_GT(made.as_programmed().max_um(), made.as_programmed().chance_max_um());
  EXPECT_LE(made.set_anew().rms_um(), made.as_programmed().rms_um());
  // Over a part's box, and the other way round.
  v1::AxisSpan& span = *request.add_box();
  span.set_axis("C");
  span.set_from_mm_or_deg(10);
  span.set_to_mm_or_deg(20);
  request.set_calibration_id(in_use.number());
  request.set_with_calibration_id(job.calibration->number());
  ASSERT_TRUE(compare(&made).ok());
  EXPECT_NEAR(made.errors(0).difference(), 80, 2 * kToleranceUm);
  EXPECT_NEAR(span_of("C").from_mm_or_deg(), 10, 1e-9);
  EXPECT_NEAR(span_of("C").to_mm_or_deg(), 20, 1e-9);
  span.set_axis("Q");
  EXPECT_THAT(compare(&made).error_message(), HasSubstr("box[0].axis"));
  request.clear_box();
  request.set_with_calibration_id(99);
  EXPECT_EQ(compare(&made).error_code(), grpc::StatusCode::NOT_FOUND);
}

// Nothing of another machine takes a calibration's place.
TEST_F(Job, ACalibrationIsComparedWithItsOwnMachinesAlone) {
  const CalibrationId id = Identify();
  ASSERT_OK(client().CreateMachine(MachineJson("other")));
  const auto upload = client().Upload(MachineId("other"), testing::BallbarSession("other", "BX", 720));
  ASSERT_OK(upload);
  const client::JobRecord job = RunJob(records::IdentifyParams{MachineId("other"), {upload->session.id}, {}});
  ASSERT_EQ(job.state, JobState::kSucceeded) << (job.error ? job.error->message : "");
  v1::CompareCalibrationsRequest request;
  request.set_calibration_id(id.number());
  request.set_with_calibration_id(job.calibration->number());
  v1::CompareCalibrationsResponse made;
  grpc::ClientContext context;
  const grpc::Status status = v1::Calibrations::NewStub(channel())->CompareCalibrations(&context, request, &made);
  EXPECT_EQ(status.error_code(), grpc::StatusCode::INVALID_ARGUMENT);
  EXPECT_THAT(status.error_message(), HasSubstr("with_calibration_id"));
}

TEST_F(Job, ResidualsComeInPages) {
  const SessionId session = UploadSession("BX");
  const client::JobRecord job = RunJob(records::IdentifyParams{MachineId("mt"), {session}, {}});
  ASSERT_EQ(job.state, JobState::kSucceeded) << (job.error ? job.error->message : "");
  const auto stub = v1::Calibrations::NewStub(channel());
  v1::ListResidualsRequest request;
  request.set_calibration_id(job.calibration->number());
  request.set_page_size(500);
  const auto ask = [&](v1::ListResidualsResponse* page) {
    grpc::ClientContext context;
    page->Clear();
    return stub->ListResiduals(&context, request, page);
  };
  v1::ListResidualsResponse page;
  ASSERT_TRUE(ask(&page).ok());
  ASSERT_EQ(page.residuals_size(), 500);
  EXPECT_EQ(page.residuals(0).reading(), 1);
  ASSERT_EQ(page.sessions_size(), 1);
  EXPECT_EQ(page.sessions(0).name(), "BX");
  EXPECT_EQ(page.sessions(0).instrument(), "ballbar");
  EXPECT_EQ(page.sessions(0).readings(), 720);
  // Of one session alone its own set-up takes up where the axis stands: nothing is left before either.
  EXPECT_LT(page.sessions(0).rms_before_um(), kToleranceUm);
  EXPECT_LT(page.sessions(0).rms_after_um(), kToleranceUm);
  const int c = static_cast<int>(std::find(page.axes().begin(), page.axes().end(), "C_deg") - page.axes().begin());
  ASSERT_LT(c, page.axes_size());
  // The same reading as in the file: its own position, and a residual that fits the others of its angle.
  const v1::Residual& reading = page.residuals(180);
  EXPECT_EQ(reading.positions_mm_or_deg_size(), page.axes_size());
  ASSERT_EQ(reading.before_um_size(), 1);
  EXPECT_LT(std::abs(reading.after_um(0)), 5 * kToleranceUm);
  double sum = 0;
  for (const v1::Residual& one : page.residuals()) sum += one.before_um(0) * one.before_um(0);
  request.set_page_token(page.next_page_token());
  ASSERT_TRUE(ask(&page).ok());
  ASSERT_EQ(page.residuals_size(), 220);
  EXPECT_EQ(page.residuals(0).reading(), 501);
  EXPECT_EQ(page.next_page_token(), "");
  for (const v1::Residual& one : page.residuals()) sum += one.before_um(0) * one.before_um(0);
  EXPECT_NEAR(std::sqrt(sum / 720), page.sessions(0).rms_before_um(), 1e-9);

  // A token that the caller made up.
  storage::PageStart made_up;
  made_up.list = absl::StrCat("residuals|", job.calibration->number(), "|0");
  for (const char* const last : {"-5", "-1000000000", "9223372036854775807", "x"}) {
    request.set_page_token(storage::MakePageToken(made_up, last));
    EXPECT_EQ(ask(&page).error_code(), grpc::StatusCode::INVALID_ARGUMENT) << last;
  }
  request.set_page_token(storage::MakePageToken(made_up, "499"));
  ASSERT_TRUE(ask(&page).ok());
  EXPECT_EQ(page.residuals_size(), 220);

  request.set_session_id(session.number());
  EXPECT_THAT(ask(&page).error_message(), HasSubstr("belongs to another list"));
  request.clear_page_token();
  ASSERT_TRUE(ask(&page).ok());
  EXPECT_EQ(page.residuals_size(), 500);
  request.set_session_id(99);
  EXPECT_THAT(ask(&page).error_message(), HasSubstr("does not stand on session 99"));
  request.set_page_size(-1);
  EXPECT_EQ(ask(&page).error_code(), grpc::StatusCode::INVALID_ARGUMENT);
  request.set_calibration_id(99);
  request.set_page_size(0);
  EXPECT_EQ(ask(&page).error_code(), grpc::StatusCode::NOT_FOUND);
}

// Outliers by the thousand make a report longer than any message that a client sends.
TEST_F(Job, AReportMayBeLongerThanAMessageThatIsSent) {
  embedded_.reset();
  storage::SqliteOptions sqlite;
  sqlite.path = dir_.File("axiscal.db");
  auto database = storage::OpenSqlite(sqlite);
  ASSERT_OK(database);
  storage::NewCalibration calibration;
  calibration.machine = MachineId("mt");
  calibration.machine_revision = 1;
  calibration.options_json = calibration.model_json = "{}";
  calibration.report_json = "{\"text\": \"" + std::string(6 << 20, 'x') + "\"}";
  const auto stored = (*database)->CreateCalibration(calibration);
  ASSERT_OK(stored);
  database->reset();
  server::ServerOptions options;
  options.database_path = sqlite.path;
  options.listen_address = "127.0.0.1:0";
  const auto server = server::Server::Start(options);
  ASSERT_OK(server);
  auto by_port = client::Client::Connect(absl::StrCat("127.0.0.1:", (*server)->port()));
  ASSERT_OK(by_port);
  auto in_process = client::Client::InProcess((*server)->InProcessChannel(), {});
  ASSERT_OK(in_process);
  for (client::Client* const one : {&*by_port, &*in_process}) {
    const auto read = one->GetCalibration(stored->id);
    ASSERT_OK(read);
    EXPECT_EQ(read->content.report_json, calibration.report_json);
  }
}

TEST_F(Job, ErrorsMayBeDeclaredForOneFit) {
  const SessionId session = UploadSession("BX");
  const client::JobRecord job = RunJob(records::IdentifyParams{
      MachineId("mt"), {session}, {"EX0C", "EY0C", R"({"symbol": "EXX", "shape": "backlash"})"}});
  ASSERT_EQ(job.state, JobState::kSucceeded) << (job.error ? job.error->message : "");
  const auto calibration = client().GetCalibration(*job.calibration);
  ASSERT_OK(calibration);
  ASSERT_EQ(calibration->content.estimates.size(), 3u);
  EXPECT_EQ(calibration->content.estimates[2].symbol, "EXX:backlash");

  const auto bad = client().CreateJob(records::IdentifyParams{MachineId("mt"), {session}, {"EX0C", "EX0Q"}});
  const auto detail = base::GetErrorDetail(bad.status());
  ASSERT_TRUE(detail.has_value()) << bad.status();
  EXPECT_EQ(detail->facts.at("field"), "params.identify.declared_errors[1]");
}

TEST_F(Job, WhatCannotWorkIsRefusedAtOnce) {
  const SessionId session = UploadSession("BX");
  const auto reason = [&](const records::JobParams& params) {
    return base::ErrorReason(client().CreateJob(params).status());
  };
  EXPECT_EQ(reason(records::IdentifyParams{MachineId("none"), {session}, {}}), "MACHINE_NOT_FOUND");
  EXPECT_EQ(reason(records::IdentifyParams{MachineId("mt"), {SessionId(99)}, {}}), "SESSION_NOT_FOUND");
  ASSERT_OK(client().CreateMachine(MachineJson("other")));
  EXPECT_EQ(reason(records::IdentifyParams{MachineId("other"), {session}, {}}), "FIELD_INVALID");
  records::CompensateParams compensate;
  compensate.machine = MachineId("mt");
  compensate.program = ProgramId(99);
  EXPECT_EQ(reason(compensate), "PROGRAM_NOT_FOUND");
  const auto program = client().PutProgram("a.nc", "G01 X1.0\n");
  ASSERT_OK(program);
  compensate.program = program->id;
  EXPECT_EQ(reason(compensate), "CALIBRATION_NOT_APPROVED");
  EXPECT_EQ(base::ErrorReason(client().GetJob(JobId(99)).status()), "JOB_NOT_FOUND");
}

TEST_F(Job, ApprovingRetiresTheOneBeforeAndTheWayBackIsTheSame) {
  const CalibrationId first = Identify();
  const CalibrationId second = Identify();
  ASSERT_NE(first, second);
  EXPECT_EQ(base::ErrorReason(client().GetApprovedCalibration(MachineId("mt")).status()), "CALIBRATION_NOT_FOUND");

  const auto stale = client().ApproveCalibration(first, 77);
  EXPECT_EQ(base::ErrorReason(stale.status()), "ETAG_MISMATCH");
  const auto approve = [&](CalibrationId id) {
    const auto calibration = client().GetCalibration(id);
    EXPECT_TRUE(calibration.ok());
    return client().ApproveCalibration(id, calibration->etag);
  };
  ASSERT_OK(approve(first));
  EXPECT_EQ(client().GetApprovedCalibration(MachineId("mt"))->id, first);
  ASSERT_OK(approve(second));
  EXPECT_EQ(client().GetApprovedCalibration(MachineId("mt"))->id, second);
  EXPECT_EQ(client().GetCalibration(first)->state, CalibrationState::kRetired);
  ASSERT_OK(approve(first));
  EXPECT_EQ(client().GetApprovedCalibration(MachineId("mt"))->id, first);
  EXPECT_EQ(client().GetApprovedCalibration(MachineId("mt"))->approved_by, "local:" + server::LoginOfProcess());
  EXPECT_EQ(client().GetCalibration(second)->state, CalibrationState::kRetired);

  const auto all = client().ListCalibrations({.machine = MachineId("mt"), .state = {}});
  ASSERT_OK(all);
  ASSERT_EQ(all->rows.size(), 2u);
  EXPECT_EQ(all->rows[0].version, 2);
}

TEST_F(Job, CompensateRewritesForTheApprovedCalibration) {
  const CalibrationId calibration = Identify();
  const auto program = client().PutProgram(
      "part.nc", "%\r\nG90 G21 (keep me)\r\nN10 G01 X100.0000 Y0.0000 Z421.9000 B0.0000 C0.0000 F1000\r\n%\r\n");
  ASSERT_OK(program);
  records::CompensateParams params;
  params.machine = MachineId("mt");
  params.program = program->id;
  params.tool_tip_mm = {0, 0, -356.4};
  params.calibration = calibration;  // a candidate, by name
  const client::JobRecord by_name = RunJob(params);
  ASSERT_EQ(by_name.state, JobState::kSucceeded) << (by_name.error ? by_name.error->message : "");

  ASSERT_OK(client().ApproveCalibration(calibration, client().GetCalibration(calibration)->etag));
  params.calibration.reset();
  const client::JobRecord job = RunJob(params);
  ASSERT_EQ(job.state, JobState::kSucceeded) << (job.error ? job.error->message : "");
  ASSERT_EQ(job.programs.size(), 1u);
  EXPECT_EQ(job.programs, by_name.programs);  // the same bytes
  const auto rewritten = client().GetProgram(job.programs[0]);
  ASSERT_OK(rewritten);
  // The table's axis stands 12 um further in X and -5 um in Y: so must the tool.
  EXPECT_NE(rewritten->find("X100.0120 Y-0.0050 Z421.9000 B0.0000 C0.0000 F1000\r\n"), std::string::npos) << *rewritten;
  EXPECT_NE(rewritten->find("(keep me)"), std::string::npos);
  EXPECT_NE(rewritten->find("mt v1"), std::string::npos) << *rewritten;
  EXPECT_NE(job.result.find("\"corrected\": 1"), std::string::npos) << job.result;
  EXPECT_EQ(job.result.find("\"orientation\""), std::string::npos) << job.result;

  params.options.orientation = true;
  params.options.max_rotary_correction_rad = 0.001;
  const client::JobRecord turned = RunJob(params);
  ASSERT_EQ(turned.state, JobState::kSucceeded) << (turned.error ? turned.error->message : "");
  EXPECT_NE(turned.result.find("\"orientation\""), std::string::npos) << turned.result;
}

// The same words and numbers as the JSON text beside it, and of another kind another message.
TEST_F(Job, AReportComesAsAMessageToo) {
  const auto stub = v1::Jobs::NewStub(channel());
  v1::GetReportRequest request;
  v1::GetReportResponse response;
  const auto ask = [&](JobId id) {
    grpc::ClientContext context;
    request.set_job_id(id.number());
    response.Clear();
    return stub->GetReport(&context, request, &response);
  };
  const client::JobRecord identified = RunJob(records::IdentifyParams{MachineId("mt"), {UploadSession("BX")}, {}});
  ASSERT_EQ(identified.state, JobState::kSucceeded);
  ASSERT_TRUE(ask(identified.id).ok());
  ASSERT_TRUE(response.report().has_identification());
  const v1::IdentificationReport& report = response.report().identification();
  const nlohmann::json text = nlohmann::json::parse(identified.result, nullptr, false);
  ASSERT_EQ(report.errors_size(), 2);
  for (int i = 0; i < report.errors_size(); ++i) {
    const v1::ReportError& error = report.errors(i);
    EXPECT_EQ(error.symbol(), text["errors"][i]["symbol"]);
    EXPECT_EQ(error.value(), text["errors"][i]["value"].get<double>());
    EXPECT_EQ(error.sigma(), text["errors"][i]["sigma"].get<double>());
    EXPECT_EQ(error.unit(), "um");
    EXPECT_TRUE(error.identifiable());
  }
  EXPECT_NEAR(report.errors(0).value(), 12.0, kToleranceUm);
  EXPECT_EQ(report.rank(), 2);
  ASSERT_EQ(report.sessions_size(), 1);
  EXPECT_EQ(report.sessions(0).session(), "BX");

  records::CompensateParams params;
  params.machine = MachineId("mt");
  params.program = client().PutProgram("part.nc", "G90 G21\nG01 X100 Y0 Z421.9 B0 C0 F1000\n")->id;
  params.tool_tip_mm = {0, 0, -356.4};
  params.calibration = identified.calibration;
  const client::JobRecord rewritten = RunJob(params);
  ASSERT_EQ(rewritten.state, JobState::kSucceeded) << (rewritten.error ? rewritten.error->message : "");
  ASSERT_TRUE(ask(rewritten.id).ok());
  ASSERT_TRUE(response.report().has_rewrite());
  EXPECT_EQ(response.report().rewrite().blocks().corrected(), 1);

  // Another name than the source's, and no longer one than file systems take.
  const std::string umlauts = "\xC3\xBC\xC3\xBC\xC3\xBC\xC3\xBC";
  params.program =
      client().PutProgram(std::string(243, 'n') + umlauts + ".nc", "G90 G21\nG01 X90 Y0 Z421.9 B0 C0 F1000\n")->id;
  ASSERT_EQ(RunJob(params).state, JobState::kSucceeded);
  const auto kept = client().ListPrograms();
  ASSERT_OK(kept);
  std::set<std::string> names;
  for (const client::ProgramRecord& one : kept->rows) names.insert(one.name);
  EXPECT_THAT(names,
              ::testing::IsSupersetOf({std::string("part-compensated.nc"), std::string(240, 'n') + "-compensated.nc"}));

  EXPECT_EQ(ask(JobId(999)).error_code(), grpc::StatusCode::NOT_FOUND);
  params.program = client().PutProgram("bad.nc", "G90 G21\nG999 X100\n")->id;
  const client::JobRecord failed = RunJob(params);
  ASSERT_EQ(failed.state, JobState::kFailed);
  const grpc::Status refused = ask(failed.id);
  EXPECT_EQ(refused.error_code(), grpc::StatusCode::FAILED_PRECONDITION);
  EXPECT_THAT(refused.error_message(), HasSubstr(absl::StrCat("job ", failed.id.number(), " has no report")));
}

// The tool point's error before and after a calibration: over what was measured, over a part, over a program's moves.
TEST_F(Job, TheVolumetricErrorIsOfABoxAPartOrAProgram) {
  // X is too long by 100 um/m: 10 um at 100 mm, which no work offset takes up. A bar along X reads all of it.
  const auto identify = [&](const std::string& name) {
    session::Session session = testing::BallbarSession("mt", name, 720);
    for (size_t i = 0; i < session.reading_count(); ++i)
      session.columns[6].values[i] = 0.01 * std::pow(session.columns[1].values[i] / 100.0, 2);
    return RunJob(records::IdentifyParams{
                      MachineId("mt"), {UploadSession(session)}, {R"({"symbol": "EXX", "shape": "linear"})"}})
        .calibration.value_or(CalibrationId());
  };
  const CalibrationId first = identify("BX");
  const auto of_measured = client().GetVolumetricError(first);
  ASSERT_OK(of_measured);
  EXPECT_EQ(of_measured->calibration, first);
  EXPECT_EQ(of_measured->state, CalibrationState::kCandidate);
  EXPECT_FALSE(of_measured->before_calibration.has_value());
  EXPECT_FALSE(of_measured->before.has_value());
  EXPECT_EQ(of_measured->known_share, 1.0);
  ASSERT_EQ(of_measured->box.size(), 5u);
  EXPECT_NEAR(of_measured->uncorrected.max.expected_um, 10.0, 1.0);
  EXPECT_LT(of_measured->after.rms.expected_um, 0.1 * of_measured->uncorrected.rms.expected_um);
  EXPECT_LE(of_measured->after.rms.low_um, of_measured->after.rms.expected_um);
  EXPECT_GE(of_measured->after.rms.high_um, of_measured->after.rms.expected_um);

  // A part that lies half beyond what was measured in X.
  const auto of_part = client().GetVolumetricError(first, {{"X", 0.0, 200.0}, {"C", 0.0, 90.0}});
  ASSERT_OK(of_part);
  EXPECT_NEAR(of_part->known_share, 0.5, 0.1);
  const auto span_of = [](const records::VolumetricError& error, const std::string& axis) {
    for (const records::AxisSpan& span : error.box) {
      if (span.axis == axis) return span;
    }
    return records::AxisSpan{};
  };
  EXPECT_EQ(span_of(*of_part, "X").from, 0.0);
  EXPECT_EQ(span_of(*of_part, "X").to, 200.0);
  EXPECT_GT(of_part->uncorrected.max.expected_um, of_part->uncorrected.rms.expected_um);
  ASSERT_TRUE(of_part->after_where_known.has_value());
  EXPECT_THAT(std::string(client().GetVolumetricError(first, {{"Q", 0.0, 1.0}}).status().message()),
              HasSubstr("'Q', is no axis"));

  records::CompensateParams params;
  params.machine = MachineId("mt");
  params.program = client().PutProgram("part.nc", "G90 G21\nG01 X50 Y0 Z421.9 B0 C0 F1000\nX80 C45\n")->id;
  params.tool_tip_mm = {0, 0, -356.4};
  params.calibration = first;
  const client::JobRecord rewritten = RunJob(params);
  ASSERT_EQ(rewritten.state, JobState::kSucceeded) << (rewritten.error ? rewritten.error->message : "");
  const auto of_program = client().GetVolumetricError(first, {}, rewritten.id);
  ASSERT_OK(of_program);
  EXPECT_NEAR(span_of(*of_program, "X").from, 50.0, 1e-3);
  EXPECT_NEAR(span_of(*of_program, "X").to, 80.0, 1e-3);
  EXPECT_NEAR(span_of(*of_program, "C").to, 45.0, 1e-3);
  EXPECT_THAT(std::string(client().GetVolumetricError(first, {{"X", 0.0, 1.0}}, rewritten.id).status().message()),
              HasSubstr("at most one of box and job_id"));
  const JobId identified = *client().GetCalibration(first)->job;
  EXPECT_THAT(std::string(client().GetVolumetricError(first, {}, identified).status().message()),
              HasSubstr("must be of a COMPENSATE job"));

  // The history: the newest first, each with what was in use before it.
  ASSERT_OK(client().ApproveCalibration(first, client().GetCalibration(first)->etag));
  const CalibrationId second = identify("BY");
  const auto newest = client().ListVolumetricErrors(MachineId("mt"), {}, {1, ""});
  ASSERT_OK(newest);
  ASSERT_EQ(newest->rows.size(), 1u);
  EXPECT_EQ(newest->rows[0].calibration, second);
  EXPECT_EQ(newest->rows[0].before_calibration, first);
  ASSERT_TRUE(newest->rows[0].before.has_value());
  EXPECT_LT(newest->rows[0].before->rms.expected_um, 0.1 * newest->rows[0].uncorrected.rms.expected_um);
  const auto older = client().ListVolumetricErrors(MachineId("mt"), {}, {1, newest->next_token});
  ASSERT_OK(older);
  ASSERT_EQ(older->rows.size(), 1u);
  EXPECT_EQ(older->rows[0].calibration, first);
  EXPECT_EQ(older->rows[0].state, CalibrationState::kApproved);
  EXPECT_EQ(older->next_token, "");
}

// A job whose answer nobody wants any more is stopped while it works.
TEST_F(Job, AJobIsStoppedAtItsDeadline) {
  records::IdentifyParams endless{MachineId("mt"), {UploadSession("a", 10'000)}, {}};
  endless.monte_carlo_runs = 100'000;
  const base::UtcTime deadline =
      std::chrono::time_point_cast<base::UtcTime::duration>(std::chrono::system_clock::now() + std::chrono::seconds(2));
  const auto job = client().CreateJob(endless, "", {.deadline = deadline});
  ASSERT_OK(job);
  EXPECT_EQ(job->deadline, deadline);
  const auto ended = client().WaitJob(job->id, std::chrono::seconds(60));
  ASSERT_OK(ended);
  ASSERT_EQ(ended->state, JobState::kFailed);
  EXPECT_EQ(ended->error->code, absl::StatusCode::kDeadlineExceeded);
  EXPECT_EQ(ended->error->reason, "JOB_TOO_LATE");
  EXPECT_GE(*ended->ended_at, deadline);
  EXPECT_TRUE(client().ListCalibrations()->rows.empty());
  EXPECT_EQ(base::ErrorReason(client().RequeueJob(job->id).status()), "JOB_TOO_LATE");
  // Of the same sessions and without haste it is made all the same.
  const client::JobRecord other = RunJob(records::IdentifyParams{MachineId("mt"), endless.sessions, {}});
  EXPECT_EQ(other.state, JobState::kSucceeded);
}

// Nothing is stored, and the bytes are those of the job.
TEST_F(Job, AProgramIsRewrittenWhileItIsSent) {
  const CalibrationId calibration = Identify();
  std::string program = "%\r\nG90 G21\r\n";
  for (int i = 0; i < 20000; ++i) {
    program += absl::StrCat("N", i, " G01 X", 100 + i % 977, ".5 Y0.0000 Z421.9000 B0.0000 C", i % 180, ". F1000\r\n");
  }
  records::CompensateParams params;
  params.machine = MachineId("mt");
  params.tool_tip_mm = {0, 0, -356.4};
  const auto rewrite = [&](const std::string& bytes, std::string* rewritten) {
    rewritten->clear();
    return client().RewriteProgram(params, bytes, [&](const std::string& part) {
      *rewritten += part;
      return absl::OkStatus();
    });
  };
  std::string rewritten;
  EXPECT_EQ(base::ErrorReason(rewrite(program, &rewritten).status()), "CALIBRATION_NOT_APPROVED");
  params.calibration = calibration;
  const auto report = rewrite(program, &rewritten);
  ASSERT_OK(report);
  EXPECT_THAT(*report, HasSubstr("\"corrected\": 20000"));
  EXPECT_TRUE(client().ListPrograms()->rows.empty());

  const auto put = client().PutProgram("part.nc", program);
  ASSERT_OK(put);
  params.program = put->id;
  const client::JobRecord job = RunJob(params);
  ASSERT_EQ(job.state, JobState::kSucceeded) << (job.error ? job.error->message : "");
  const auto by_job = client().GetProgram(job.programs.at(0));
  ASSERT_OK(by_job);
  EXPECT_TRUE(*by_job == rewritten);
  EXPECT_EQ(job.result, *report);
  const auto stored = base::GetErrorDetail(rewrite(program, &rewritten).status());
  ASSERT_TRUE(stored.has_value());
  EXPECT_EQ(stored->facts.at("field"), "header.params.program_id");
  params.program = ProgramId();

  const auto refused = rewrite(program + "G41 D1 X1.\r\n", &rewritten);
  EXPECT_EQ(refused.status().code(), absl::StatusCode::kFailedPrecondition);
  EXPECT_THAT(std::string(refused.status().message()), HasSubstr("line 20003"));
  EXPECT_TRUE(rewrite("G21 G01 X1.0 Y0. Z0. B0. C0.\n", &rewritten).ok());
  // The unit travels with the options, in a stream and in a job.
  const std::string unstated = "G01 X1.0 Y0. Z0. B0. C0.\n";
  EXPECT_THAT(std::string(rewrite(unstated, &rewritten).status().message()), HasSubstr("the unit is not known"));
  params.options.unit = nc::ProgramUnit::kMillimetre;
  EXPECT_TRUE(rewrite(unstated, &rewritten).ok());
  params.options.unit = nc::ProgramUnit::kInch;
  std::string in_inch;
  EXPECT_TRUE(rewrite(unstated, &in_inch).ok());
  EXPECT_NE(in_inch, rewritten);
  const auto put_unstated = client().PutProgram("unstated.nc", unstated);
  ASSERT_OK(put_unstated);
  params.program = put_unstated->id;
  const client::JobRecord inch_job = RunJob(params);
  ASSERT_EQ(inch_job.state, JobState::kSucceeded) << (inch_job.error ? inch_job.error->message : "");
  EXPECT_EQ(*client().GetProgram(inch_job.programs.at(0)), in_inch);
  params.program = ProgramId();
  params.options.unit = nc::ProgramUnit::kUnstated;
  const absl::Status full =
      client().RewriteProgram(params, program, [](const std::string&) { return absl::DataLossError("disk"); }).status();
  EXPECT_EQ(full.code(), absl::StatusCode::kDataLoss);
}

// What the client library never does: sizes and checksums that do not fit, messages out of order.
TEST_F(Job, ABrokenRewriteIsRefused) {
  Identify();
  v1::RewriteProgramRequest header, data;
  records::CompensateParams params;
  params.machine = MachineId("mt");
  params.calibration = CalibrationId(1);
  *header.mutable_header()->mutable_params() = convert::ToProto(params);
  header.mutable_header()->set_size_bytes(4);
  header.mutable_header()->set_crc32c(1);
  data.set_data("G0X2");
  const auto send = [&](std::vector<std::string> messages) {
    return testing::ReasonOf(testing::SendBytes(channel(), "/axiscal.v1.Programs/RewriteProgram", messages));
  };
  const std::string first = header.SerializeAsString(), second = data.SerializeAsString();
  EXPECT_EQ(send({first, second}), "TOTALS_MISMATCH");
  EXPECT_EQ(send({first}), "STREAM_INCOMPLETE");
  EXPECT_EQ(send({second}), "STREAM_INVALID");
  EXPECT_EQ(send({first, first}), "STREAM_INVALID");
  EXPECT_EQ(send({first, second, second}), "SIZE_EXCEEDED");
}

TEST_F(Job, AProgramThatCannotBeCorrectedFailsWithItsLine) {
  const CalibrationId calibration = Identify();
  const auto program =
      client().PutProgram("arc.nc", "G90 G21 G01 X1.0 Y0.0 Z0.0 B0.0 C0.0 F100\nG81 X2.0 Y1.0 Z-5.0 R1.0\n");
  ASSERT_OK(program);
  records::CompensateParams params;
  params.machine = MachineId("mt");
  params.program = program->id;
  params.calibration = calibration;
  params.tool_tip_mm = {0, 0, -356.4};
  const client::JobRecord job = RunJob(params);
  EXPECT_EQ(job.state, JobState::kFailed);
  ASSERT_TRUE(job.error.has_value());
  EXPECT_NE(job.error->message.find("line 2"), std::string::npos) << job.error->message;
  EXPECT_TRUE(job.programs.empty());
}

// The simulation would take hours: the job cannot end before it is told to.
TEST_F(Job, ACancelledJobStoresNothing) {
  records::IdentifyParams params{MachineId("mt"), {UploadSession("a", 10'000)}, {}};
  params.monte_carlo_runs = 100'000;
  const auto job = client().CreateJob(params);
  ASSERT_OK(job);
  const auto cancel_when_it_runs = [&] {
    bool has_run = false;
    const auto ended = client().WatchJob(job->id, [&](const client::JobRecord& record) {
      if (!has_run && record.state == JobState::kRunning && record.progress.stage == "simulating") {
        has_run = true;
        EXPECT_TRUE(client().CancelJob(job->id).ok());
      }
      return true;
    });
    EXPECT_TRUE(has_run);
    return ended.ok() ? ended->state : JobState::kFailed;
  };
  EXPECT_EQ(cancel_when_it_runs(), JobState::kCancelled);
  const auto all = client().ListCalibrations();
  ASSERT_OK(all);
  EXPECT_TRUE(all->rows.empty());
  // And it can be run again after all.
  ASSERT_OK(client().RequeueJob(job->id));
  EXPECT_EQ(cancel_when_it_runs(), JobState::kCancelled);
}

// Long jobs hold every worker, so that the one behind them is cancelled before it begins.
TEST_F(Job, AJobThatWasCancelledRunsToItsEndOnceItIsQueuedAgain) {
  const SessionId session = UploadSession("a", 10'000);
  records::IdentifyParams endless{MachineId("mt"), {session}, {}};
  endless.monte_carlo_runs = 100'000;
  std::vector<JobId> busy;
  for (int i = 0; i < 8; ++i) {
    const auto job = client().CreateJob(endless);
    ASSERT_OK(job);
    busy.push_back(job->id);
  }
  const auto job = client().CreateJob(records::IdentifyParams{MachineId("mt"), {session}, {}});
  ASSERT_OK(job);
  ASSERT_OK(client().CancelJob(job->id));
  EXPECT_EQ(client().WaitJob(job->id, std::chrono::seconds(60))->state, JobState::kCancelled);
  for (const JobId& id : busy) ASSERT_OK(client().CancelJob(id));
  for (const JobId& id : busy) ASSERT_OK(client().WaitJob(id, std::chrono::seconds(60)));
  ASSERT_OK(client().RequeueJob(job->id));
  EXPECT_EQ(client().WaitJob(job->id, std::chrono::seconds(60))->state, JobState::kSucceeded);
}

TEST_F(Job, ListsAreNewestFirstAndStable) {
  const SessionId session = UploadSession("BX");
  const records::IdentifyParams params{MachineId("mt"), {session}, {}};
  std::vector<JobId> created;
  for (int i = 0; i < 5; ++i) created.push_back(client().CreateJob(params)->id);
  std::vector<JobId> listed;
  records::PageRequest page{2, ""};
  do {
    const auto rows = client().ListJobs({.machine = MachineId("mt"), .state = {}}, page);
    ASSERT_OK(rows);
    for (const auto& row : rows->rows) listed.push_back(row.id);
    page.token = rows->next_token;
    if (listed.size() == 2) {
      ASSERT_OK(client().CreateJob(params));
    }
  } while (!page.token.empty());
  EXPECT_EQ(listed, std::vector<JobId>(created.rbegin(), created.rend()));
  for (const JobId& id : created)
    EXPECT_EQ(client().WaitJob(id, std::chrono::seconds(60))->state, JobState::kSucceeded);
}

TEST_F(Job, TheHistoryShowsWhatWasIdentified) {
  const CalibrationId first = Identify();
  Identify();
  records::DriftQuery query;
  query.machine = MachineId("mt");
  query.from = base::FromUtcUs(0);
  query.to = base::UtcTime::max();
  const auto drift = client().QueryDrift(query);
  ASSERT_OK(drift);
  ASSERT_EQ(drift->size(), 2u);
  EXPECT_EQ((*drift)[0].symbol, "EX0C");
  int64_t count = 0;
  for (const auto& point : (*drift)[0].points) {
    count += point.count;
    EXPECT_NEAR(point.mean, 12, kToleranceUm);
  }
  EXPECT_EQ(count, 2);
  const auto fleet = client().LatestFleet({"EY0C"});
  ASSERT_OK(fleet);
  ASSERT_EQ(fleet->rows.size(), 1u);
  ASSERT_EQ(fleet->rows[0].latest.size(), 1u);
  EXPECT_NEAR(*fleet->rows[0].latest[0].estimate.value, -5, kToleranceUm);
  EXPECT_GT(fleet->rows[0].latest[0].calibration, first);
}

}  // namespace
}  // namespace axiscal
