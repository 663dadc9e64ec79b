// A Core on a database of its own whose jobs wait: nothing runs, nothing is sent.
#ifndef AXISCAL_SERVER_HANDLERS_TESTING_TEST_CORE_H_
#define AXISCAL_SERVER_HANDLERS_TESTING_TEST_CORE_H_

#include <google/protobuf/text_format.h>

#include <string>

#include "core/base/error_detail.h"
#include "server/handlers/core.h"
#include "server/storage/testing/temp_database.h"

namespace axiscal::handlers {

struct TestCore {
  TestCore() : jobs(*database, Options()), core{.database = *database, .jobs = jobs, .limits = {}, .workers = 1} {
    jobs.Register("identify", {[](const records::JobRecord&, jobs::JobContext&) { return storage::JobProduct(); }});
    jobs.Register("compensate", {[](const records::JobRecord&, jobs::JobContext&) { return storage::JobProduct(); }});
  }
  static jobs::JobRunnerOptions Options() {
    jobs::JobRunnerOptions options;
    options.max_queued = 2;
    return options;
  }

  storage::TempDatabase database;
  jobs::JobRunner jobs;
  Core core;
  const Call call{.user = "tester"};
};

template <typename Message>
Message Parse(const std::string& text) {
  Message message;
  DEMAND(google::protobuf::TextFormat::ParseFromString(text, &message));
  return message;
}

inline std::string FieldOf(const absl::Status& status) {
  const auto detail = base::GetErrorDetail(status);
  return detail && detail->facts.count("field") ? detail->facts.at("field") : "";
}

inline constexpr char kMachineJson[] = R"({"id": "mt", "axes": {
  "X": {"kind": "linear", "direction": [1, 0, 0]}, "Y": {"kind": "linear", "direction": [0, 1, 0]},
  "Z": {"kind": "linear", "direction": [0, 0, 1], "travel_mm": [0, 400]},
  "C": {"kind": "rotary", "direction": [0, 0, 1], "point_mm": [0, 0, 0]}},
 "tool_branch": ["Z", "Y", "X"], "work_branch": ["C"], "tool_direction": [0, 0, -1], "declared": ["EX0C"]})";

// A CreateSessionRequest of a tracker session of machine mt.
inline constexpr char kTrackerSession[] = R"(
  request_id: "r-1" machine_id: "mt"
  schema {
    header { key: "machine" value: "mt" } header { key: "session" value: "T1" }
    header { key: "instrument" value: "tracker" } header { key: "sigma_um" value: "5" }
    header { key: "tool_tip_mm" value: "0 0 -100" } header { key: "started" value: "2026-01-31T12:00:00Z" }
    columns { name: "t_s" kind: COLUMN_KIND_NUMBER } columns { name: "X_mm" kind: COLUMN_KIND_NUMBER }
    columns { name: "Y_mm" kind: COLUMN_KIND_NUMBER } columns { name: "Z_mm" kind: COLUMN_KIND_NUMBER }
    columns { name: "C_deg" kind: COLUMN_KIND_NUMBER } columns { name: "px_mm" kind: COLUMN_KIND_NUMBER }
    columns { name: "py_mm" kind: COLUMN_KIND_NUMBER } columns { name: "pz_mm" kind: COLUMN_KIND_NUMBER }
  })";

}  // namespace axiscal::handlers

#endif  // AXISCAL_SERVER_HANDLERS_TESTING_TEST_CORE_H_
