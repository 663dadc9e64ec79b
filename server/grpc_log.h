// What gRPC itself has to say, such as that a handshake failed, as lines of the server's log.
#ifndef AXISCAL_SERVER_GRPC_LOG_H_
#define AXISCAL_SERVER_GRPC_LOG_H_

namespace axiscal::server {

// From now on, for the whole process, its messages are events `grpc` in place of lines of their own form: one a second,
// as whoever reaches the port brings them about; the next one says how many were left out. Not where the environment
// asks for gRPC's own log (GRPC_VERBOSITY). To be called once, after StartLog().
void TakeGrpcLog();

}  // namespace axiscal::server

#endif  // AXISCAL_SERVER_GRPC_LOG_H_
