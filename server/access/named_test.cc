#include "server/access/named.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <set>

#include "axiscal/v1/access_service.pb.h"
#include "axiscal/v1/admin_service.pb.h"
#include "axiscal/v1/calibrations_service.pb.h"
#include "axiscal/v1/events_service.pb.h"
#include "axiscal/v1/history_service.pb.h"
#include "axiscal/v1/ingest_service.pb.h"
#include "axiscal/v1/jobs_service.pb.h"
#include "axiscal/v1/machines_service.pb.h"
#include "axiscal/v1/programs_service.pb.h"
#include "axiscal/v1/routines_service.pb.h"
#include "axiscal/v1/tables_service.pb.h"
#include "axiscal/v1/webhooks_service.pb.h"
#include "server/access/methods.h"

namespace axiscal::access {
namespace {

using google::protobuf::Descriptor;
using google::protobuf::FieldDescriptor;
using google::protobuf::FileDescriptor;
using google::protobuf::MethodDescriptor;
using storage::Resource;
using storage::ResourceKind;
using ::testing::ElementsAre;
using ::testing::IsEmpty;

std::vector<const MethodDescriptor*> AllMethods() {
  const FileDescriptor* const files[] = {
      v1::GetIdentityRequest::descriptor()->file(),      v1::GetServerInfoRequest::descriptor()->file(),
      v1::GetCalibrationRequest::descriptor()->file(),   v1::QueryDriftRequest::descriptor()->file(),
      v1::CreateSessionRequest::descriptor()->file(),    v1::CreateJobRequest::descriptor()->file(),
      v1::GetMachineRequest::descriptor()->file(),       v1::PutProgramRequest::descriptor()->file(),
      v1::ListTableFormatsRequest::descriptor()->file(), v1::ListEventsRequest::descriptor()->file(),
      v1::ListRoutinesRequest::descriptor()->file(),     v1::ListWebhooksRequest::descriptor()->file(),
  };
  std::vector<const MethodDescriptor*> methods;
  for (const FileDescriptor* const file : files) {
    for (int s = 0; s < file->service_count(); ++s) {
      for (int m = 0; m < file->service(s)->method_count(); ++m) methods.push_back(file->service(s)->method(m));
    }
  }
  return methods;
}

// Names of fields that name a row, in the message and all that it holds.
void IdFields(const Descriptor& message, std::set<const Descriptor*>& seen, std::set<std::string>& names) {
  if (!seen.insert(&message).second) return;
  for (int i = 0; i < message.field_count(); ++i) {
    const FieldDescriptor& field = *message.field(i);
    if (field.cpp_type() == FieldDescriptor::CPPTYPE_MESSAGE) IdFields(*field.message_type(), seen, names);
    const std::string& name = field.name();
    if (name.ends_with("_id") || name.ends_with("_ids")) names.insert(name);
  }
}

// A field that is added and names something else would be let through unseen.
TEST(Named, EveryFieldThatEndsInIdIsKnown) {
  std::set<const Descriptor*> seen;
  std::set<std::string> names;
  for (const MethodDescriptor* const method : AllMethods()) IdFields(*method->input_type(), seen, names);
  EXPECT_TRUE(names.contains("held_calibration_id"));
  for (const std::string& name : names) EXPECT_TRUE(IsKnownId(name)) << name;
}

TEST(Named, FindsWhatIsNamedWhereverItStands) {
  v1::CreateJobRequest job;
  job.set_request_id("r");
  job.mutable_params()->mutable_identify()->set_machine_id("mt");
  for (const int64_t id : {7, 5, 7}) job.mutable_params()->mutable_identify()->add_session_ids(id);
  job.mutable_params()->mutable_identify()->set_held_calibration_id(3);
  EXPECT_THAT(NamedIn(job),
              ElementsAre(Resource{ResourceKind::kMachine, "mt", 0}, Resource{ResourceKind::kSession, "", 5},
                          Resource{ResourceKind::kSession, "", 7}, Resource{ResourceKind::kCalibration, "", 3}));
  v1::UploadRequest upload;
  upload.mutable_header()->set_session_id(4);
  EXPECT_THAT(NamedIn(upload), ElementsAre(Resource{ResourceKind::kSession, "", 4}));
  v1::GetCalibrationRequest approved;
  approved.set_approved_of_machine_id("mt");
  EXPECT_THAT(NamedIn(approved), ElementsAre(Resource{ResourceKind::kMachine, "mt", 0}));
  EXPECT_THAT(NamedIn(v1::ListSessionsRequest()), IsEmpty());
}

TEST(Named, ADescriptionNamesItsMachine) {
  v1::UpdateMachineRequest update;
  update.set_description_json(R"({"id": "mt", "axes": {"X": {"kind": "linear", "direction": [1, 0, 0]}},
      "tool_branch": ["X"], "work_branch": [], "tool_direction": [0, 0, -1]})");
  EXPECT_THAT(NamedIn(update), ElementsAre(Resource{ResourceKind::kMachine, "mt", 0}));
  update.set_description_json("{");
  EXPECT_THAT(NamedIn(update), IsEmpty());
}

// A method that is new may be called by nobody until it is placed.
TEST(Methods, EveryMethodOfTheApiIsPlacedOnce) {
  std::set<std::string> methods, placed;
  for (const MethodDescriptor* const method : AllMethods())
    methods.insert(method->service()->name() + "." + method->name());
  for (const MethodRule& rule : Methods()) {
    EXPECT_TRUE(placed.insert(rule.method).second) << rule.method << " stands twice";
    EXPECT_EQ(rule.any_of.empty(), rule.reach == Reach::kAnyone) << rule.method;
  }
  EXPECT_EQ(methods, placed);
}

}  // namespace
}  // namespace axiscal::access
