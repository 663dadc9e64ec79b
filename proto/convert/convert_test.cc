// What goes over the wire comes back as it was; what must not come in is refused with its field.
#include <gtest/gtest.h>

#include <cmath>
#include <functional>

#include "core/base/error_detail.h"
#include "google/rpc/error_details.pb.h"
#include "proto/convert/calibration.h"
#include "proto/convert/history.h"
#include "proto/convert/job.h"
#include "proto/convert/machine.h"
#include "proto/convert/program.h"
#include "proto/convert/session.h"
#include "proto/convert/status.h"
#include "proto/convert/table.h"

namespace axiscal::convert {
namespace {

std::string FieldOf(const absl::Status& status) {
  const auto detail = base::GetErrorDetail(status);
  return detail && detail->facts.count("field") ? detail->facts.at("field") : "";
}

const std::vector<records::ColumnSpec> kColumns = {{"t_s", false}, {"feature", true}};

records::Chunk GoodChunk() {
  return records::Chunk::Seal(3, {{"t_s", {0.5, std::nan(""), -0.0}, {}}, {"feature", {}, {"top", "", "ball"}}});
}

TEST(ChunkOnTheWire, ComesBackBitForBit) {
  const auto back = FromProto(ToProto(GoodChunk()), kColumns);
  ASSERT_TRUE(back.ok()) << back.status();
  EXPECT_EQ(back->seq(), 3);
  EXPECT_EQ(back->crc32c(), GoodChunk().crc32c());
  EXPECT_TRUE(std::isnan(back->columns()[0].values[1]));
  EXPECT_TRUE(std::signbit(back->columns()[0].values[2]));
  EXPECT_EQ(back->columns()[1].texts, GoodChunk().columns()[1].texts);
}

TEST(ChunkOnTheWire, RefusesWhatDoesNotFitItsSchema) {
  const auto reason = [](const std::function<void(v1::Chunk&)>& spoil) {
    v1::Chunk message = ToProto(GoodChunk());
    spoil(message);
    return base::ErrorReason(FromProto(message, kColumns).status());
  };
  EXPECT_EQ(reason([](v1::Chunk&) {}), "");
  EXPECT_EQ(reason([](v1::Chunk& c) { c.set_crc32c(1); }), "CHUNK_CORRUPT");
  EXPECT_EQ(reason([](v1::Chunk& c) { c.mutable_columns(0)->set_values(0, 0.6); }), "CHUNK_CORRUPT");
  EXPECT_EQ(reason([](v1::Chunk& c) { c.set_seq(-1); }), "CHUNK_INVALID");
  EXPECT_EQ(reason([](v1::Chunk& c) { c.mutable_columns()->RemoveLast(); }), "CHUNK_INVALID");
  EXPECT_EQ(reason([](v1::Chunk& c) { c.mutable_columns(1)->add_texts("one more"); }), "CHUNK_INVALID");
  EXPECT_EQ(reason([](v1::Chunk& c) { c.mutable_columns(1)->add_values(1); }), "CHUNK_INVALID");
  EXPECT_EQ(reason([](v1::Chunk& c) { c.mutable_columns(0)->set_values(0, INFINITY); }), "CHUNK_INVALID");
  EXPECT_EQ(reason([](v1::Chunk& c) {
              c.mutable_columns(0)->mutable_values()->Resize(records::kMaxChunkReadings + 1, 0);
              for (int i = 3; i <= records::kMaxChunkReadings; ++i) c.mutable_columns(1)->add_texts("x");
            }),
            "CHUNK_INVALID");
  EXPECT_EQ(reason([](v1::Chunk& c) {
              c.mutable_columns(0)->clear_values();
              c.mutable_columns(1)->clear_texts();
            }),
            "CHUNK_INVALID");
}

TEST(SchemaOnTheWire, RefusesUnsetKindsAndRepeatedNames) {
  const records::SessionSchema schema{{{"machine", "mt"}, {"note", ""}}, kColumns};
  const auto back = FromProto(ToProto(schema));
  ASSERT_TRUE(back.ok()) << back.status();
  EXPECT_TRUE(*back == schema);

  v1::SessionSchema message = ToProto(schema);
  message.mutable_columns(1)->set_kind(v1::COLUMN_KIND_UNSPECIFIED);
  EXPECT_EQ(FieldOf(FromProto(message).status()), "columns[1].kind");
  message = ToProto(schema);
  message.mutable_columns(1)->set_name("t_s");
  EXPECT_EQ(FieldOf(FromProto(message).status()), "columns[1].name");
  message.clear_columns();
  EXPECT_EQ(FieldOf(FromProto(message).status()), "columns");
}

TEST(SessionOnTheWire, ComesBack) {
  records::SessionRecord record;
  record.id = SessionId(7);
  record.machine = MachineId("mt");
  record.name = "BX";
  record.instrument = "ballbar";
  record.state = records::SessionState::kComplete;
  record.next_seq = 3;
  record.reading_count = 2500;
  record.closed_at = base::FromUtcUs(5);
  const auto back = FromProto(ToProto(record));
  ASSERT_TRUE(back.ok()) << back.status();
  EXPECT_EQ(back->state, records::SessionState::kComplete);
  EXPECT_EQ(back->reading_count, 2500);
  EXPECT_EQ(back->closed_at, record.closed_at);
  EXPECT_FALSE(back->measured_at.has_value());

  v1::Session message = ToProto(record);
  message.set_state(v1::SESSION_STATE_UNSPECIFIED);
  EXPECT_EQ(FieldOf(FromProto(message).status()), "state");
}

TEST(TotalsOnTheWire, RefuseAHashThatIsNone) {
  const records::SessionTotals totals{2, 10, std::string(64, 'a')};
  EXPECT_TRUE(FromProto(ToProto(totals)).ok());
  v1::SessionTotals message = ToProto(totals);
  message.set_sha256("xyz");
  EXPECT_EQ(FieldOf(FromProto(message).status()), "sha256");
  message = ToProto(totals);
  message.set_chunks(-1);
  EXPECT_EQ(FieldOf(FromProto(message).status()), "chunks");
}

TEST(JobParamsOnTheWire, ComeBack) {
  records::CompensateParams params;
  params.machine = MachineId("mt");
  params.program = ProgramId(4);
  params.calibration = CalibrationId(9);
  params.tool_tip_mm = {0, 1, -350.5};
  params.temperature_celsius = 22.5;
  params.options.on_unsupported = nc::OnUnsupported::kPass;
  params.options.tool_lengths = {{3, 120.5}};
  params.options.tool_radii = {{4, 6.25}};
  params.options.tool_change_keeps = {"B", "C"};
  params.tables_are_off = true;
  params.options.cutter_tolerance_mm = 0.007;
  params.options.decimals_mm = 3;
  params.options.initial_position = {{"X", 1.5}};
  params.options.work_offsets = {{"G54", {{"Z", -20}}}};
  const auto back = ParseJobParams(Serialize(params));
  ASSERT_TRUE(back.ok()) << back.status();
  const auto& got = std::get<records::CompensateParams>(*back);
  EXPECT_EQ(got.machine, params.machine);
  EXPECT_EQ(got.program, params.program);
  EXPECT_EQ(got.calibration, params.calibration);
  EXPECT_EQ(got.tool_tip_mm, params.tool_tip_mm);
  EXPECT_EQ(got.temperature_celsius, params.temperature_celsius);
  EXPECT_FALSE(got.time_s.has_value());
  EXPECT_EQ(got.options.on_unsupported, nc::OnUnsupported::kPass);
  ASSERT_EQ(got.options.tool_lengths.size(), 1u);
  EXPECT_EQ(got.options.tool_lengths[0].number, 3);
  EXPECT_EQ(got.options.tool_lengths[0].length_mm, 120.5);
  ASSERT_EQ(got.options.tool_radii.size(), 1u);
  EXPECT_EQ(got.options.tool_radii[0].number, 4);
  EXPECT_EQ(got.options.tool_radii[0].radius_mm, 6.25);
  EXPECT_EQ(got.options.tool_change_keeps, (std::vector<std::string>{"B", "C"}));
  EXPECT_TRUE(got.tables_are_off);
  EXPECT_EQ(got.options.cutter_tolerance_mm, 0.007);
  EXPECT_EQ(got.options.decimals_mm, 3);
  EXPECT_EQ(got.options.initial_position[0].value, 1.5);
  EXPECT_EQ(got.options.work_offsets[0].offsets[0].axis, "Z");
  EXPECT_EQ(Serialize(*back), Serialize(params));
}

TEST(JobParamsOnTheWire, WhatIsLeftToTheProfileIsUnset) {
  records::CompensateParams params;
  params.machine = MachineId("mt");
  params.program = ProgramId(4);
  params.open = {true, true, true, true, true, true};
  const v1::CompensateParams message = ToProto(params);
  EXPECT_EQ(message.tool_tip_mm_size(), 0);
  EXPECT_FALSE(message.options().has_dialect() || message.options().has_decimals_mm() ||
               message.options().has_decimals_inch());
  EXPECT_EQ(message.options().integer_words(), v1::INTEGER_WORDS_UNSPECIFIED);
  EXPECT_EQ(message.options().block_delete(), v1::BLOCK_DELETE_UNSPECIFIED);
  const auto back = FromProto(message, true);
  ASSERT_TRUE(back.ok()) << back.status();
  EXPECT_TRUE(back->open.tool_tip && back->open.dialect && back->open.integer_words && back->open.decimals &&
              back->open.block_delete);
  params.open = {};
  params.without_profile = true;
  const auto stated = FromProto(ToProto(params), true);
  ASSERT_TRUE(stated.ok()) << stated.status();
  EXPECT_FALSE(stated->open.tool_tip || stated->open.dialect || stated->open.integer_words || stated->open.decimals ||
               stated->open.block_delete);
  EXPECT_TRUE(stated->without_profile);
}

TEST(JobParamsOnTheWire, AreRefusedWithTheirField) {
  EXPECT_EQ(FieldOf(FromProto(v1::JobParams()).status()), "kind");
  v1::JobParams identify;
  identify.mutable_identify()->set_machine_id("mt");
  EXPECT_EQ(FieldOf(FromProto(identify).status()), "identify.session_ids");
  identify.mutable_identify()->add_session_ids(3);
  EXPECT_TRUE(FromProto(identify).ok());
  identify.mutable_identify()->add_session_ids(3);
  EXPECT_EQ(FieldOf(FromProto(identify).status()), "identify.session_ids[1]");

  v1::JobParams compensate;
  compensate.mutable_compensate()->set_machine_id("mt");
  compensate.mutable_compensate()->set_program_id(1);
  // The machine's profile may state it, where it is asked.
  EXPECT_TRUE(FromProto(compensate).ok());
  compensate.mutable_compensate()->set_without_profile(true);
  EXPECT_EQ(FieldOf(FromProto(compensate).status()), "compensate.tool_tip_mm");
  compensate.mutable_compensate()->clear_without_profile();
  compensate.mutable_compensate()->add_tool_tip_mm(0.0);
  EXPECT_EQ(FieldOf(FromProto(compensate).status()), "compensate.tool_tip_mm");
  compensate.mutable_compensate()->clear_tool_tip_mm();
  for (const double value_mm : {0.0, std::nan(""), -350.0}) compensate.mutable_compensate()->add_tool_tip_mm(value_mm);
  EXPECT_EQ(FieldOf(FromProto(compensate).status()), "compensate.tool_tip_mm[1]");
  compensate.mutable_compensate()->set_tool_tip_mm(1, 0);
  EXPECT_TRUE(FromProto(compensate).ok());
  compensate.mutable_compensate()->mutable_options()->set_tolerance_mm(std::nan(""));
  EXPECT_EQ(FieldOf(FromProto(compensate).status()), "compensate.options.tolerance_mm");
  compensate.mutable_compensate()->mutable_options()->clear_tolerance_mm();
  compensate.mutable_compensate()->mutable_options()->set_max_rotary_correction_rad(0.2);
  EXPECT_EQ(FieldOf(FromProto(compensate).status()), "compensate.options.max_rotary_correction_rad");
  compensate.mutable_compensate()->mutable_options()->set_max_rotary_correction_rad(0.1);
  compensate.mutable_compensate()->mutable_options()->set_tolerance_rad(0);
  EXPECT_EQ(FieldOf(FromProto(compensate).status()), "compensate.options.tolerance_rad");
}

// Each entry costs a look-up before the call is answered, and a message could hold a million.
TEST(JobParamsOnTheWire, ListsHaveALimit) {
  v1::JobParams identify;
  identify.mutable_identify()->set_machine_id("mt");
  for (int id = 1; id <= 10'000; ++id) identify.mutable_identify()->add_session_ids(id);
  for (int i = 0; i < 1000; ++i) identify.mutable_identify()->add_declared_errors("EX0C");
  EXPECT_TRUE(FromProto(identify).ok());
  identify.mutable_identify()->add_declared_errors("EX0C");
  EXPECT_EQ(FieldOf(FromProto(identify).status()), "identify.declared_errors");
  identify.mutable_identify()->add_session_ids(10'001);
  EXPECT_EQ(FieldOf(FromProto(identify).status()), "identify.session_ids");

  v1::JobParams loop;
  loop.mutable_close_loop()->set_machine_id("mt");
  loop.mutable_close_loop()->add_fit_session_ids(1);
  for (int id = 1; id <= 10'000; ++id) loop.mutable_close_loop()->add_check_session_ids(id + 1);
  EXPECT_TRUE(FromProto(loop).ok());
  loop.mutable_close_loop()->add_check_session_ids(1);
  EXPECT_EQ(FieldOf(FromProto(loop).status()), "close_loop.check_session_ids[10000]");
  loop.mutable_close_loop()->set_check_session_ids(10'000, 20'000);
  EXPECT_EQ(FieldOf(FromProto(loop).status()), "close_loop.check_session_ids");
}

TEST(JobParamsOnTheWire, HeldErrorsComeBackAsOneOfTwo) {
  records::IdentifyParams params{MachineId("mt"), {SessionId(1)}, {"EA0B"}};
  params.held_calibration = CalibrationId(7);
  const auto by_id = ParseJobParams(Serialize(params));
  ASSERT_TRUE(by_id.ok()) << by_id.status();
  EXPECT_EQ(std::get<records::IdentifyParams>(*by_id).held_calibration, CalibrationId(7));
  EXPECT_EQ(std::get<records::IdentifyParams>(*by_id).held_errors_json, "");
  params.held_calibration.reset();
  params.held_errors_json = R"({"EX0C": 1})";
  const auto by_value = ParseJobParams(Serialize(params));
  ASSERT_TRUE(by_value.ok()) << by_value.status();
  EXPECT_FALSE(std::get<records::IdentifyParams>(*by_value).held_calibration.has_value());
  EXPECT_EQ(std::get<records::IdentifyParams>(*by_value).held_errors_json, params.held_errors_json);
  params.held_calibration = CalibrationId(7);
  EXPECT_EQ(FieldOf(ParseJobParams(Serialize(params)).status()), "identify.held_errors_json");
}

TEST(JobOnTheWire, ComesBackWithItsErrorOrResult) {
  records::JobRecord record;
  record.id = JobId(5);
  record.params = Serialize(records::IdentifyParams{MachineId("mt"), {SessionId(1)}, {"EA0B"}});
  record.state = records::JobState::kFailed;
  record.progress = {"fit", 0.25, "iteration 4"};
  record.error = records::JobError{absl::StatusCode::kFailedPrecondition, "RANK_DEFICIENT", "EX0B - EX0C"};
  const auto failed = FromProto(ToProto(record));
  ASSERT_TRUE(failed.ok()) << failed.status();
  EXPECT_EQ(failed->kind, records::kIdentify);
  EXPECT_EQ(failed->machine, MachineId("mt"));
  EXPECT_EQ(failed->params, record.params);
  EXPECT_EQ(failed->progress, record.progress);
  EXPECT_EQ(failed->error->reason, "RANK_DEFICIENT");

  record.state = records::JobState::kSucceeded;
  record.error.reset();
  record.calibration = CalibrationId(3);
  record.programs = {ProgramId(4)};
  record.result = "{}";
  const auto done = FromProto(ToProto(record));
  ASSERT_TRUE(done.ok()) << done.status();
  EXPECT_EQ(done->calibration, CalibrationId(3));
  EXPECT_EQ(done->programs, record.programs);
  EXPECT_EQ(done->result, "{}");
}

TEST(CalibrationOnTheWire, KeepsAbsentValuesAbsent) {
  records::CalibrationRecord record;
  record.id = CalibrationId(2);
  record.version = 3;
  record.etag = 4;
  record.state = records::CalibrationState::kApproved;
  record.content.machine = MachineId("mt");
  record.content.rank = 8;
  record.content.rms_after_um = 2.97;
  record.content.estimates = {{"EA0B", records::EstimateUnit::kUrad, true, -101.2, 0.6},
                              {"EX0B", records::EstimateUnit::kUm, false, {}, {}}};
  record.content.report_json =
      R"({"not_separable": ["EX0B - EX0C"], "determined": [{"name": "EX0B + EX0C", "value": 1.5, "unit": "um"}]})";
  const v1::Calibration message = ToProto(record);
  ASSERT_EQ(message.combinations_size(), 1);
  EXPECT_EQ(message.combinations(0).name(), "EX0B + EX0C");
  EXPECT_EQ(message.combinations(0).value(), 1.5);
  EXPECT_FALSE(message.combinations(0).has_sigma());
  ASSERT_EQ(message.not_separable_size(), 1);
  EXPECT_EQ(message.not_separable(0), "EX0B - EX0C");
  const auto back = FromProto(message);
  ASSERT_TRUE(back.ok()) << back.status();
  EXPECT_EQ(back->content.estimates, record.content.estimates);
  EXPECT_EQ(back->content.rms_after_um, record.content.rms_after_um);
  EXPECT_FALSE(back->content.rms_before_um.has_value());
  EXPECT_EQ(back->version, 3);
}

// An empty list would say that everything can be told apart.
TEST(CalibrationOnTheWire, SaysWhyItsReportIsNotRead) {
  records::CalibrationRecord record;
  record.id = CalibrationId(2);
  record.version = record.etag = 1;
  record.content.machine = MachineId("mt");
  EXPECT_EQ(ToProto(record).report_problem(), "");
  record.content.report_json = R"({"not_separable": "EX0B - EX0C"})";
  const v1::Calibration message = ToProto(record);
  EXPECT_EQ(message.not_separable_size(), 0);
  EXPECT_EQ(message.report_problem(), "report: not_separable = \"EX0B - EX0C\", expected a list");
}

TEST(EstimateOnTheWire, RefusesNaNAndUnsetUnits) {
  v1::Estimate message = ToProto(records::Estimate{"EA0B", records::EstimateUnit::kUrad, true, 1, 0.5});
  EXPECT_TRUE(FromProto(message).ok());
  message.set_value(std::nan(""));
  EXPECT_EQ(FieldOf(FromProto(message).status()), "value");
  message.set_value(1);
  message.set_sigma(-1);
  EXPECT_EQ(FieldOf(FromProto(message).status()), "sigma");
  message.clear_sigma();
  message.set_unit(v1::ESTIMATE_UNIT_UNSPECIFIED);
  EXPECT_EQ(FieldOf(FromProto(message).status()), "unit");
  message.set_unit(v1::ESTIMATE_UNIT_UM);
  message.clear_value();
  EXPECT_EQ(FieldOf(FromProto(message).status()), "value");
}

TEST(DriftQueryOnTheWire, HasItsDefaultsAndLimits) {
  v1::QueryDriftRequest message;
  message.set_machine_id("mt");
  const auto query = FromProto(message);
  ASSERT_TRUE(query.ok()) << query.status();
  EXPECT_EQ(query->max_points, kDefaultDriftPoints);
  message.set_max_points(kMaxDriftPoints + 1);
  EXPECT_EQ(FieldOf(FromProto(message).status()), "max_points");
  message.set_max_points(1);
  message.set_from_utc_us(2);
  message.set_to_utc_us(1);
  EXPECT_EQ(FieldOf(FromProto(message).status()), "from_utc_us");
  message.set_to_utc_us(3);
  for (int i = 0; i <= kMaxSymbols; ++i) message.add_symbols(absl::StrCat("E", i));
  EXPECT_EQ(FieldOf(FromProto(message).status()), "symbols");
}

TEST(CareOnTheWire, ComesAsItIsAndRefusesWhatIsNotKnown) {
  v1::MachineCare good;
  good.set_machine_id("mt");
  good.set_care(v1::CARE_NOW);
  v1::StandingFinding& finding = *good.add_findings();
  finding.set_kind(v1::DRIFT_FINDING_KIND_STEP);
  finding.set_text("jumped");
  finding.set_at_utc_us(5);
  good.mutable_in_use()->set_calibration_id(7);
  good.mutable_in_use()->set_rms_after_um(0.0);
  good.add_groups("turning");
  const auto care = FromProto(good);
  ASSERT_TRUE(care.ok()) << care.status();
  EXPECT_EQ(care->care, records::Care::kNow);
  EXPECT_EQ(care->findings.at(0).kind, records::DriftKind::kStep);
  EXPECT_EQ(care->findings.at(0).at, base::FromUtcUs(5));
  EXPECT_EQ(care->in_use->calibration, CalibrationId(7));
  EXPECT_FALSE(care->in_use->rms_before_um.has_value());
  EXPECT_EQ(care->in_use->rms_after_um, 0.0);
  EXPECT_EQ(care->groups, std::vector<std::string>{"turning"});
  EXPECT_EQ(ToProto(*care).SerializeAsString(), good.SerializeAsString());
  const auto field_with = [&](const std::function<void(v1::MachineCare&)>& change) {
    v1::MachineCare bad = good;
    change(bad);
    return FieldOf(FromProto(bad).status());
  };
  EXPECT_EQ(field_with([](auto& bad) { bad.clear_machine_id(); }), "machine_id");
  EXPECT_EQ(field_with([](auto& bad) { bad.set_care(v1::CARE_UNSPECIFIED); }), "care");
  EXPECT_EQ(field_with([](auto& bad) { bad.mutable_findings(0)->clear_kind(); }), "findings.kind");
  EXPECT_EQ(field_with([](auto& bad) { bad.mutable_in_use()->set_rms_after_um(std::nan("")); }), "in_use.rms_after_um");
}

TEST(MachineAndProgramOnTheWire, AreRefusedWithoutTheirIds) {
  EXPECT_EQ(FieldOf(FromProto(v1::Machine()).status()), "machine_id");
  EXPECT_EQ(FieldOf(FromProto(v1::Program()).status()), "program_id");
}

TEST(StatusOnTheWire, CarriesReasonFactsFieldAndRetry) {
  const absl::Status status = base::Error(absl::StatusCode::kResourceExhausted, "full",
                                          {"QUEUE_FULL", {{"field", "params"}, {"rule", "must wait"}}});
  const google::rpc::Status message = ToProto(status);
  ASSERT_EQ(message.details_size(), 3);
  google::rpc::BadRequest bad_request;
  ASSERT_TRUE(message.details(1).UnpackTo(&bad_request));
  EXPECT_EQ(bad_request.field_violations(0).description(), "must wait");
  google::rpc::RetryInfo retry;
  ASSERT_TRUE(message.details(2).UnpackTo(&retry));
  EXPECT_GT(retry.retry_delay().seconds(), 0);
  const absl::Status back = FromProto(message);
  EXPECT_EQ(back.code(), status.code());
  EXPECT_EQ(base::GetErrorDetail(back), base::GetErrorDetail(status));
}

records::TableParams SomeTable() {
  records::TableParams params{MachineId("mt"), CalibrationId(3), {}};
  params.request.format = "siemens-cec";
  params.request.state = {{1.0, 2.0, -350.5}, 60.0, 23.5};
  params.request.axes = {"X", "Z(X)"};
  params.request.ranges = {{"X", -300.0, 300.25}};
  params.request.reference = {{"C", 0.5}};
  params.request.tolerance_mm = 3e-4;
  params.request.max_points = 77;
  params.request.resolution = 1e-3;
  return params;
}

TEST(TableOnTheWire, TheRequestComesBack) {
  const auto back = FromProto(ToProto(SomeTable()));
  ASSERT_TRUE(back.ok()) << back.status();
  EXPECT_EQ(ToProto(*back).SerializeAsString(), ToProto(SomeTable()).SerializeAsString());
  EXPECT_EQ(back->request.ranges[0].max, 300.25);
  EXPECT_EQ(back->request.axes, SomeTable().request.axes);
  EXPECT_EQ(back->request.state.temperature_celsius, 23.5);
  EXPECT_EQ(back->calibration, CalibrationId(3));
}

TEST(TableOnTheWire, WhatMustNotComeInIsRefusedWithItsField) {
  const auto field_of = [](const std::function<void(v1::MakeTableRequest&)>& change) {
    v1::MakeTableRequest message = ToProto(SomeTable());
    change(message);
    return FieldOf(FromProto(message).status());
  };
  EXPECT_EQ(field_of([](auto& m) { m.set_machine_id(""); }), "machine_id");
  EXPECT_EQ(field_of([](auto& m) { m.set_calibration_id(0); }), "calibration_id");
  EXPECT_EQ(field_of([](auto& m) { m.clear_format(); }), "format");
  EXPECT_EQ(field_of([](auto& m) { m.add_tool_tip_mm(1); }), "tool_tip_mm");
  EXPECT_EQ(field_of([](auto& m) { m.set_tool_tip_mm(1, std::nan("")); }), "tool_tip_mm[1]");
  EXPECT_EQ(field_of([](auto& m) { m.mutable_ranges(0)->set_max_mm_or_rad(INFINITY); }), "ranges[0].max_mm_or_rad");
  EXPECT_EQ(field_of([](auto& m) { m.mutable_reference(0)->clear_axis(); }), "reference[0].axis");
  EXPECT_EQ(field_of([](auto& m) { m.set_axes(1, "X\n"); }), "axes[1]");
  EXPECT_EQ(field_of([](auto& m) { m.set_tolerance_mm(std::nan("")); }), "tolerance_mm");
}

// A message or fact with other bytes would make the whole of the details unreadable.
TEST(StatusOnTheWire, HoldsUtf8WhateverTheStatusShows) {
  const absl::Status status = base::Error(absl::StatusCode::kInvalidArgument, "line 3: caf\xE9",
                                          {"FIELD_INVALID", {{"field", "data"}, {"rule", "no \xE9"}}});
  const google::rpc::Status message = ToProto(status);
  google::rpc::Status read;
  ASSERT_TRUE(read.ParseFromString(message.SerializeAsString()));
  EXPECT_EQ(read.message(), "line 3: caf\xEF\xBF\xBD");
  const auto detail = base::GetErrorDetail(FromProto(read));
  ASSERT_TRUE(detail.has_value());
  EXPECT_EQ(detail->facts.at("rule"), "no \xEF\xBF\xBD");
}

TEST(StatusOnTheWire, AlwaysHasAReason) {
  EXPECT_EQ(base::ErrorReason(FromProto(ToProto(absl::NotFoundError("x")))), "NOT_FOUND");
}

}  // namespace
}  // namespace axiscal::convert
