// Clients of the last release go on working: every message, field, enum value and method that it had is there, with its
// number and type. What was added since is not looked at. released.txt is written anew with a release:
//   AXISCAL_PRINT_API=1 build/release/bin/proto_test | grep -E '^(enum|field|message|rpc) ' > proto/released.txt
#include <google/protobuf/descriptor.h>
#include <gtest/gtest.h>

#include <cstdio>
#include <cstdlib>
#include <fstream>
#include <set>
#include <string>

#include "axiscal/v1/access_service.pb.h"
#include "axiscal/v1/admin_service.pb.h"
#include "axiscal/v1/calibrations_service.pb.h"
#include "axiscal/v1/history_service.pb.h"
#include "axiscal/v1/ingest_service.pb.h"
#include "axiscal/v1/jobs_service.pb.h"
#include "axiscal/v1/machines_service.pb.h"
#include "axiscal/v1/programs_service.pb.h"
#include "axiscal/v1/tables_service.pb.h"
#include "core/base/testing/source_path.h"

namespace axiscal {
namespace {

using google::protobuf::Descriptor;
using google::protobuf::EnumDescriptor;
using google::protobuf::FieldDescriptor;
using google::protobuf::FileDescriptor;
using google::protobuf::MethodDescriptor;

using Lines = std::set<std::string>;

void AddEnum(const EnumDescriptor& type, Lines& lines) {
  for (int i = 0; i < type.value_count(); ++i)
    lines.insert("enum " + type.full_name() + " " + type.value(i)->name() + " = " +
                 std::to_string(type.value(i)->number()));
}

std::string TypeOf(const FieldDescriptor& field) {
  if (field.message_type() != nullptr) return field.message_type()->full_name();
  if (field.enum_type() != nullptr) return field.enum_type()->full_name();
  return field.type_name();
}

void AddMessage(const Descriptor& message, Lines& lines) {
  lines.insert("message " + message.full_name());
  for (int i = 0; i < message.field_count(); ++i) {
    const FieldDescriptor& field = *message.field(i);
    const std::string label = field.is_repeated() ? "repeated " : field.has_optional_keyword() ? "optional " : "";
    const auto* const choice = field.real_containing_oneof();
    lines.insert("field " + message.full_name() + " " + label + TypeOf(field) + " " + field.name() + " = " +
                 std::to_string(field.number()) + (choice == nullptr ? "" : " in " + choice->name()));
  }
  for (int i = 0; i < message.nested_type_count(); ++i) AddMessage(*message.nested_type(i), lines);
  for (int i = 0; i < message.enum_type_count(); ++i) AddEnum(*message.enum_type(i), lines);
}

void AddFile(const FileDescriptor& file, std::set<const FileDescriptor*>& seen, Lines& lines) {
  if (!seen.insert(&file).second) return;
  for (int i = 0; i < file.dependency_count(); ++i) AddFile(*file.dependency(i), seen, lines);
  for (int i = 0; i < file.message_type_count(); ++i) AddMessage(*file.message_type(i), lines);
  for (int i = 0; i < file.enum_type_count(); ++i) AddEnum(*file.enum_type(i), lines);
  for (int s = 0; s < file.service_count(); ++s) {
    for (int m = 0; m < file.service(s)->method_count(); ++m) {
      const MethodDescriptor& method = *file.service(s)->method(m);
      lines.insert("rpc " + method.full_name() + (method.client_streaming() ? " stream " : " ") +
                   method.input_type()->full_name() + (method.server_streaming() ? " returns stream " : " returns ") +
                   method.output_type()->full_name());
    }
  }
}

Lines PresentApi() {
  const FileDescriptor* const files[] = {
      v1::GetIdentityRequest::descriptor()->file(),      v1::GetServerInfoRequest::descriptor()->file(),
      v1::GetCalibrationRequest::descriptor()->file(),   v1::QueryDriftRequest::descriptor()->file(),
      v1::CreateSessionRequest::descriptor()->file(),    v1::CreateJobRequest::descriptor()->file(),
      v1::GetMachineRequest::descriptor()->file(),       v1::PutProgramRequest::descriptor()->file(),
      v1::ListTableFormatsRequest::descriptor()->file(),
  };
  Lines lines;
  std::set<const FileDescriptor*> seen;
  for (const FileDescriptor* const file : files) AddFile(*file, seen, lines);
  return lines;
}

TEST(Compatibility, WhatTheLastReleaseHadIsThere) {
  const Lines present = PresentApi();
  if (std::getenv("AXISCAL_PRINT_API") != nullptr) {
    for (const std::string& line : present) std::printf("%s\n", line.c_str());
    return;
  }
  std::ifstream released(base::SourcePath("/proto/released.txt"));
  int count = 0;
  for (std::string line; std::getline(released, line); ++count) {
    EXPECT_TRUE(present.contains(line)) << "was in the last release, and is gone or another now: " << line;
  }
  EXPECT_GT(count, 300);
}

}  // namespace
}  // namespace axiscal
