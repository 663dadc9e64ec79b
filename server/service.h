// The gRPC services of the API over one Core. Thin: one line per call.
#ifndef AXISCAL_SERVER_SERVICE_H_
#define AXISCAL_SERVER_SERVICE_H_

#include <grpcpp/impl/codegen/service_type.h>

#include <memory>
#include <vector>

#include "server/handlers/core.h"

namespace axiscal::server {

// All of them. `core` must outlive them.
std::vector<std::unique_ptr<grpc::Service>> MakeServices(handlers::Core& core);
// Those whose calls stream bytes in and out: part of the above.
std::unique_ptr<grpc::Service> MakeIngestService(handlers::Core& core);
std::unique_ptr<grpc::Service> MakeProgramsService(handlers::Core& core);

}  // namespace axiscal::server

#endif  // AXISCAL_SERVER_SERVICE_H_
