#include "client/client.h"

#include <grpcpp/create_channel.h>
#include <grpcpp/security/credentials.h>

#include "client/client_impl.h"
#include "core/base/error_detail.h"
#include "core/base/files.h"

namespace axiscal::client {
namespace {

constexpr int kKeepaliveMs = 30'000, kKeepaliveTimeoutMs = 10'000;
// gRPC's own wait between attempts to connect would grow to two minutes.
constexpr int kFirstReconnectMs = 100, kMaxReconnectMs = 1'000;

// gRPC's own limit would be 4 MiB: reports of thousands of readings set aside, models with thousands of values and
// their covariances are longer.
constexpr int kMaxAnswerBytes = 256 << 20;

grpc::ChannelArguments ChannelArguments() {
  grpc::ChannelArguments arguments;
  arguments.SetMaxReceiveMessageSize(kMaxAnswerBytes);
  arguments.SetInt(GRPC_ARG_KEEPALIVE_TIME_MS, kKeepaliveMs);
  arguments.SetInt(GRPC_ARG_KEEPALIVE_TIMEOUT_MS, kKeepaliveTimeoutMs);
  arguments.SetInt(GRPC_ARG_INITIAL_RECONNECT_BACKOFF_MS, kFirstReconnectMs);
  arguments.SetInt(GRPC_ARG_MIN_RECONNECT_BACKOFF_MS, kFirstReconnectMs);
  arguments.SetInt(GRPC_ARG_MAX_RECONNECT_BACKOFF_MS, kMaxReconnectMs);
  return arguments;
}

constexpr size_t kMaxPemBytes = 16 << 20;

absl::StatusOr<std::shared_ptr<grpc::ChannelCredentials>> CredentialsOf(const Identity& identity) {
  if (!identity.has_tls()) return grpc::InsecureChannelCredentials();
  grpc::SslCredentialsOptions ssl;
  ASSIGN_OR_RETURN(ssl.pem_root_certs, base::ReadFile(identity.ca, kMaxPemBytes));
  if (!identity.certificate.empty()) {
    ASSIGN_OR_RETURN(ssl.pem_cert_chain, base::ReadFile(identity.certificate, kMaxPemBytes));
    ASSIGN_OR_RETURN(ssl.pem_private_key, base::ReadFile(identity.key, kMaxPemBytes));
  }
  return grpc::SslCredentials(ssl);
}

// Nobody between can read what goes there.
bool IsThisMachine(const std::string& address) {
  for (const std::string start : {"unix:", "unix-abstract:", "127.", "ipv4:127.",
                                  "[::1]:", "ipv6:[::1]:", "localhost:", "dns:localhost:", "dns:///localhost:"}) {
    if (address.rfind(start, 0) == 0) return true;
  }
  return false;
}

// gRPC tells no more than that there is no connection.
std::string WhyNot(const std::string& address, const Options& options) {
  const std::string no_server =
      absl::StrCat("no server at ", address, " within ", options.connect_deadline.count(), " ms");
  return no_server + (options.identity.has_tls()
                          ? "; or its certificate is not from " + options.identity.ca +
                                ", has another name, or it wants a certificate (or another one) from here"
                          : "; one with TLS answers only to clients that name its authority (--ca)");
}

}  // namespace

absl::StatusOr<Client> Client::Connect(const std::string& address, const Options& options) {
  RETURN_IF_ERROR(Validate(options));
  if (!options.identity.token_file.empty()) RETURN_IF_ERROR(ReadToken(options.identity.token_file).status());
  if (!options.identity.token_file.empty() && !options.identity.has_tls() && !IsThisMachine(address)) {
    return absl::InvalidArgumentError("a token for " + address +
                                      " would go over the network readable: name the server's authority (--ca)");
  }
  ASSIGN_OR_RETURN(const std::shared_ptr<grpc::ChannelCredentials> credentials, CredentialsOf(options.identity));
  std::shared_ptr<grpc::Channel> channel = grpc::CreateCustomChannel(address, credentials, ChannelArguments());
  const auto deadline = std::chrono::system_clock::now() + options.connect_deadline;
  if (options.connect_deadline.count() > 0 && !channel->WaitForConnected(deadline)) {
    return base::Error(absl::StatusCode::kUnavailable, WhyNot(address, options), {"NO_CONNECTION", {}});
  }
  return Client(std::make_unique<Impl>(std::move(channel), address, options));
}

absl::StatusOr<Client> Client::InProcess(std::shared_ptr<grpc::Channel> channel, const Options& options) {
  RETURN_IF_ERROR(Validate(options));
  return Client(std::make_unique<Impl>(std::move(channel), "", options));
}

Client::Client(std::unique_ptr<Impl> impl) : impl_(std::move(impl)) {}
Client::Client(Client&&) noexcept = default;
Client& Client::operator=(Client&&) noexcept = default;
Client::~Client() = default;

absl::StatusOr<MachineRecord> Client::CreateMachine(const std::string& description_json) {
  v1::CreateMachineRequest request;
  request.set_description_json(description_json);
  ASSIGN_OR_RETURN(const auto response, impl_->Call<v1::CreateMachineResponse>(
                                            *impl_->machines, &v1::Machines::Stub::CreateMachine, request));
  return convert::FromProto(response.machine());
}

absl::StatusOr<MachineRecord> Client::GetMachine(const MachineId& id) {
  v1::GetMachineRequest request;
  request.set_machine_id(id.text());
  ASSIGN_OR_RETURN(const auto response,
                   impl_->Call<v1::GetMachineResponse>(*impl_->machines, &v1::Machines::Stub::GetMachine, request));
  return convert::FromProto(response.machine());
}

absl::StatusOr<MachineRecord> Client::GetMachineRevision(const MachineId& id, int64_t revision) {
  v1::GetMachineRequest request;
  request.set_machine_id(id.text());
  request.set_revision(revision);
  ASSIGN_OR_RETURN(const auto response,
                   impl_->Call<v1::GetMachineResponse>(*impl_->machines, &v1::Machines::Stub::GetMachine, request));
  return convert::FromProto(response.machine());
}

absl::StatusOr<Page<MachineRecord>> Client::ListMachines(const PageRequest& page) {
  ASSIGN_OR_RETURN(const auto response,
                   impl_->Call<v1::ListMachinesResponse>(*impl_->machines, &v1::Machines::Stub::ListMachines,
                                                         PageOf<v1::ListMachinesRequest>(page)));
  return ReadPage<MachineRecord>(response.machines(), response.next_page_token());
}

absl::StatusOr<MachineRecord> Client::UpdateMachine(const std::string& description_json, int64_t etag) {
  v1::UpdateMachineRequest request;
  request.set_description_json(description_json);
  request.set_etag(etag);
  ASSIGN_OR_RETURN(const auto response, impl_->Call<v1::UpdateMachineResponse>(
                                            *impl_->machines, &v1::Machines::Stub::UpdateMachine, request));
  return convert::FromProto(response.machine());
}

absl::StatusOr<MachineRecord> Client::DeleteMachine(const MachineId& id, int64_t etag) {
  v1::DeleteMachineRequest request;
  request.set_machine_id(id.text());
  request.set_etag(etag);
  ASSIGN_OR_RETURN(const auto response, impl_->Call<v1::DeleteMachineResponse>(
                                            *impl_->machines, &v1::Machines::Stub::DeleteMachine, request));
  return convert::FromProto(response.machine());
}

absl::StatusOr<std::vector<DriftSeries>> Client::QueryDrift(const DriftQuery& query) {
  ASSIGN_OR_RETURN(const auto response, impl_->Call<v1::QueryDriftResponse>(
                                            *impl_->history, &v1::History::Stub::QueryDrift, convert::ToProto(query)));
  ASSIGN_OR_RETURN(Page<DriftSeries> all, ReadPage<DriftSeries>(response.series(), ""));
  return std::move(all.rows);
}

absl::StatusOr<records::DriftReport> Client::FindDrift(const records::DriftSearch& search) {
  ASSIGN_OR_RETURN(const auto response, impl_->Call<v1::FindDriftResponse>(
                                            *impl_->history, &v1::History::Stub::FindDrift, convert::ToProto(search)));
  return convert::FromProto(response);
}

absl::StatusOr<Page<records::MachineCare>> Client::ListCare(const PageRequest& page) {
  ASSIGN_OR_RETURN(const auto response, impl_->Call<v1::ListCareResponse>(*impl_->history, &v1::History::Stub::ListCare,
                                                                          PageOf<v1::ListCareRequest>(page)));
  return ReadPage<records::MachineCare>(response.machines(), response.next_page_token());
}

absl::StatusOr<records::Mark> Client::PutMark(const records::NewMark& mark, const std::string& request_id) {
  const v1::PutMarkRequest request = convert::ToProto(mark, request_id.empty() ? NewRequestId() : request_id);
  ASSIGN_OR_RETURN(const auto response,
                   impl_->Call<v1::PutMarkResponse>(*impl_->history, &v1::History::Stub::PutMark, request));
  return convert::FromProto(response.mark());
}

absl::StatusOr<Page<records::Mark>> Client::ListMarks(const MachineId& machine, const PageRequest& page) {
  auto request = PageOf<v1::ListMarksRequest>(page);
  request.set_machine_id(machine.text());
  ASSIGN_OR_RETURN(const auto response,
                   impl_->Call<v1::ListMarksResponse>(*impl_->history, &v1::History::Stub::ListMarks, request));
  return ReadPage<records::Mark>(response.marks(), response.next_page_token());
}

absl::StatusOr<records::Mark> Client::WithdrawMark(MarkId id) {
  v1::WithdrawMarkRequest request;
  request.set_mark_id(id.number());
  ASSIGN_OR_RETURN(const auto response,
                   impl_->Call<v1::WithdrawMarkResponse>(*impl_->history, &v1::History::Stub::WithdrawMark, request));
  return convert::FromProto(response.mark());
}

absl::StatusOr<Page<FleetRow>> Client::LatestFleet(const std::vector<std::string>& symbols, const PageRequest& page) {
  auto request = PageOf<v1::LatestFleetRequest>(page);
  for (const std::string& symbol : symbols) request.add_symbols(symbol);
  ASSIGN_OR_RETURN(const auto response,
                   impl_->Call<v1::LatestFleetResponse>(*impl_->history, &v1::History::Stub::LatestFleet, request));
  return ReadPage<FleetRow>(response.machines(), response.next_page_token());
}

absl::StatusOr<ServerInfo> Client::GetServerInfo() {
  ASSIGN_OR_RETURN(const auto response,
                   impl_->Call<v1::GetServerInfoResponse>(*impl_->admin, &v1::Admin::Stub::GetServerInfo,
                                                          v1::GetServerInfoRequest()));
  return ServerInfo{response.software_version(), response.schema_version(), response.open_uploads(),
                    response.max_uploads(),      response.workers(),        response.draining()};
}

absl::Status Client::CheckHealth() {
  ASSIGN_OR_RETURN(const auto response,
                   impl_->Call<grpc::health::v1::HealthCheckResponse>(
                       *impl_->health, &grpc::health::v1::Health::Stub::Check, grpc::health::v1::HealthCheckRequest()));
  if (response.status() == grpc::health::v1::HealthCheckResponse::SERVING) return absl::OkStatus();
  return base::Error(absl::StatusCode::kUnavailable, "the server is stopping [DRAINING]", {"DRAINING", {}});
}

}  // namespace axiscal::client
