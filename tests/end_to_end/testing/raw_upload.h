// Uploads message by message, as clients that are not ours (or not well) would do them.
#ifndef AXISCAL_TESTS_END_TO_END_TESTING_RAW_UPLOAD_H_
#define AXISCAL_TESTS_END_TO_END_TESTING_RAW_UPLOAD_H_

#include <grpcpp/grpcpp.h>

#include <string>
#include <vector>

#include "axiscal/v1/ingest_service.grpc.pb.h"
#include "core/session/session.h"

namespace axiscal::testing {

v1::CreateSessionRequest CreateRequest(const std::string& machine, const std::string& request_id,
                                       const session::Session& session);

// The header, every chunk, and the finish.
std::vector<v1::UploadRequest> UploadMessages(int64_t session_id, const session::Session& session, int chunk_readings);

struct RawResult {
  grpc::Status status;
  std::vector<v1::UploadResponse> responses;
  int64_t next_seq() const { return responses.empty() ? -1 : responses.back().next_seq(); }
  bool completed() const { return !responses.empty() && responses.back().has_completed_session(); }
};

// Sends them all and half-closes.
RawResult SendAll(v1::Ingest::Stub& stub, const std::vector<v1::UploadRequest>& messages);

// Sends bytes as messages of a stream to a method ("/axiscal.v1.Ingest/UploadOnce"), half-closes and returns the call's
// status. `authorization`, unless empty, is the metadata of that name.
grpc::Status SendBytes(const std::shared_ptr<grpc::Channel>& channel, const std::string& method,
                       const std::vector<std::string>& messages, const std::string& authorization = "",
                       bool leaves_with_first_answer = false);

// ErrorInfo.reason and the first BadRequest field of a status' details; empty when there are none.
std::string ReasonOf(const grpc::Status& status);
std::string FieldOf(const grpc::Status& status);
bool HasRetryInfo(const grpc::Status& status);

}  // namespace axiscal::testing

#endif  // AXISCAL_TESTS_END_TO_END_TESTING_RAW_UPLOAD_H_
