#ifndef AXISCAL_CLIENT_SILENCE_GRPC_H_
#define AXISCAL_CLIENT_SILENCE_GRPC_H_

namespace axiscal::client {

// For programs, which say by themselves that there is no connection: from now on gRPC writes nothing to standard error
// of its own attempts, in the whole process, unless the environment asks for it (GRPC_VERBOSITY).
void SilenceGrpc();

}  // namespace axiscal::client

#endif  // AXISCAL_CLIENT_SILENCE_GRPC_H_
