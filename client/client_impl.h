// The parts of a client: its connection and one stub per service. Internal.
#ifndef AXISCAL_CLIENT_CLIENT_IMPL_H_
#define AXISCAL_CLIENT_CLIENT_IMPL_H_

#include <memory>

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
#include "client/client.h"
#include "client/connection.h"
#include "grpc/health/v1/health.grpc.pb.h"
#include "proto/convert/access.h"
#include "proto/convert/calibration.h"
#include "proto/convert/cell.h"
#include "proto/convert/event.h"
#include "proto/convert/history.h"
#include "proto/convert/job.h"
#include "proto/convert/job_params.h"
#include "proto/convert/machine.h"
#include "proto/convert/program.h"
#include "proto/convert/routine.h"
#include "proto/convert/session.h"
#include "proto/convert/table.h"
#include "proto/convert/webhook.h"

namespace axiscal::client {

class Client::Impl {
 public:
  Impl(std::shared_ptr<grpc::Channel> channel, const std::string& address, const Options& options)
      : connection(channel, address, options),
        machines(v1::Machines::NewStub(channel)),
        ingest(v1::Ingest::NewStub(channel)),
        jobs(v1::Jobs::NewStub(channel)),
        calibrations(v1::Calibrations::NewStub(channel)),
        programs(v1::Programs::NewStub(channel)),
        history(v1::History::NewStub(channel)),
        tables(v1::Tables::NewStub(channel)),
        admin(v1::Admin::NewStub(channel)),
        access(v1::Access::NewStub(channel)),
        health(grpc::health::v1::Health::NewStub(channel)),
        events(v1::Events::NewStub(channel)),
        routines(v1::Routines::NewStub(channel)),
        webhooks(v1::Webhooks::NewStub(channel)) {}

  // One unary call: Call<v1::GetJobResponse>(*jobs, &v1::Jobs::Stub::GetJob, request).
  template <typename Response, typename Stub, typename Method, typename Request>
  absl::StatusOr<Response> Call(Stub& stub, Method method, const Request& request) const {
    Response response;
    RETURN_IF_ERROR(connection.Call([&](grpc::ClientContext* context) {
      response.Clear();
      return (stub.*method)(context, request, &response);
    }));
    return response;
  }

  const Connection connection;
  const std::unique_ptr<v1::Machines::Stub> machines;
  const std::unique_ptr<v1::Ingest::Stub> ingest;
  const std::unique_ptr<v1::Jobs::Stub> jobs;
  const std::unique_ptr<v1::Calibrations::Stub> calibrations;
  const std::unique_ptr<v1::Programs::Stub> programs;
  const std::unique_ptr<v1::History::Stub> history;
  const std::unique_ptr<v1::Tables::Stub> tables;
  const std::unique_ptr<v1::Admin::Stub> admin;
  const std::unique_ptr<v1::Access::Stub> access;
  const std::unique_ptr<grpc::health::v1::Health::Stub> health;
  const std::unique_ptr<v1::Events::Stub> events;
  const std::unique_ptr<v1::Routines::Stub> routines;
  const std::unique_ptr<v1::Webhooks::Stub> webhooks;
};

// A page of rows that convert::FromProto reads.
template <typename Row, typename Messages>
absl::StatusOr<Page<Row>> ReadPage(const Messages& messages, const std::string& next_token) {
  Page<Row> page;
  page.next_token = next_token;
  for (const auto& message : messages) {
    ASSIGN_OR_RETURN(Row row, convert::FromProto(message));
    page.rows.push_back(std::move(row));
  }
  return page;
}

template <typename Request>
Request PageOf(const PageRequest& page) {
  Request request;
  request.set_page_size(page.size);
  request.set_page_token(page.token);
  return request;
}

}  // namespace axiscal::client

#endif  // AXISCAL_CLIENT_CLIENT_IMPL_H_
