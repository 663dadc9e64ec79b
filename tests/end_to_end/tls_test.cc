// TLS over a real port, with the certificates that deploy/make-certs makes.
#include "server/tls.h"

#include <gtest/gtest.h>
#include <signal.h>

#include <filesystem>
#include <fstream>
#include <sstream>

#include "core/base/error_detail.h"
#include "core/base/testing/fake_clock.h"
#include "core/base/testing/source_path.h"
#include "server/access/gate.h"
#include "server/storage/sqlite_database.h"
#include "tests/end_to_end/testing/fixture.h"
#include "tests/end_to_end/testing/process.h"
#include "tests/end_to_end/testing/raw_http2.h"

namespace axiscal {
namespace {

using testing::ServerProcess;

class TlsPort : public ::testing::Test {
 protected:
  void SetUp() override {
    for (const std::string authority : {"pki", "other"}) {
      MakeCerts(authority, "ca");
      MakeCerts(authority, "server localhost 127.0.0.1");
      MakeCerts(authority, "client cell-7");
    }
    for (const std::string part : {".crt", ".key"}) Use("pki", part);
    storage::SqliteOptions options;
    options.path = dir_.File("axiscal.db");
    auto database = storage::OpenSqlite(options);
    ASSERT_OK(database);
    ASSERT_OK((*database)->CreatePrincipal("cell-7", "", {"setup", ""}));
    ASSERT_OK((*database)->ChangeRole("cell-7", {records::Role::kAdmin, {}}, true, {"setup", ""}));
    ASSERT_OK((*database)->CreateToken({"cell-7", access::HashOfToken(kToken), "", {}}, {"setup", ""}));
    std::ofstream(dir_.File("token")) << kToken << "\n";
  }
  void MakeCerts(const std::string& authority, const std::string& words) {
    const std::string command =
        base::SourcePath("/deploy/make-certs") + " " + dir_.File(authority) + " " + words + " >/dev/null";
    ASSERT_EQ(std::system(command.c_str()), 0) << command;
  }
  // The server's file ".crt" or ".key" becomes that of this authority.
  void Use(const std::string& authority, const std::string& part) {
    std::filesystem::copy_file(dir_.File(authority + "/server/localhost" + part), dir_.File("new"),
                               std::filesystem::copy_options::overwrite_existing);
    std::filesystem::rename(dir_.File("new"), dir_.File("server" + part));
  }
  std::vector<std::string> Flags(bool asks_for_certificates = true) {
    std::vector<std::string> flags = {"--tls-certificate", dir_.File("server.crt"), "--tls-key",
                                      dir_.File("server.key")};
    if (asks_for_certificates) flags.insert(flags.end(), {"--tls-client-ca", dir_.File("pki/ca.crt")});
    return flags;
  }
  absl::StatusOr<ServerProcess> StartServer(const std::string& listen, const std::vector<std::string>& flags) {
    return ServerProcess::Start(dir_.File("axiscal.db"), listen, dir_.File("log"), flags);
  }
  client::Identity Shown(const std::string& authority, const std::string& server_authority) {
    return {dir_.File(server_authority + "/ca.crt"), dir_.File(authority + "/client/cell-7.crt"),
            dir_.File(authority + "/client/cell-7.key"), ""};
  }
  absl::Status Reach(const std::string& address, const client::Identity& identity) {
    auto client = client::Client::Connect(address, {.identity = identity, .connect_deadline = std::chrono::seconds(2)});
    return client.ok() ? client->GetServerInfo().status() : client.status();
  }
  std::string Log() {
    std::ifstream log(dir_.File("log"));
    return {std::istreambuf_iterator<char>(log), {}};
  }

  static constexpr char kToken[] = "axt_of-a-test";
  testing::TempDir dir_;
};

TEST_F(TlsPort, CallersShowACertificateOfThePlantsAuthority) {
  absl::StatusOr<ServerProcess> server = StartServer("127.0.0.1:0", Flags());
  ASSERT_OK(server);
  auto client = client::Client::Connect(server->address(), {.identity = Shown("pki", "pki")});
  ASSERT_OK(client);
  ASSERT_OK(client->CreateMachine(testing::MachineJson("mt")));
  ASSERT_OK(client->Upload(MachineId("mt"), testing::BallbarSession("mt", "BX", 500)));

  EXPECT_EQ(base::ErrorReason(Reach(server->address(), {})), "NO_CONNECTION");
  EXPECT_FALSE(Reach(server->address(), Shown("other", "pki")).ok());
  EXPECT_FALSE(Reach(server->address(), {dir_.File("pki/ca.crt"), "", "", ""}).ok());
  // A certificate of the same authority that is a server's does not make a caller.
  EXPECT_FALSE(Reach(server->address(), {dir_.File("pki/ca.crt"), dir_.File("pki/server/localhost.crt"),
                                         dir_.File("pki/server/localhost.key"), ""})
                   .ok());
  // Nor does the caller take another authority's server for this one.
  EXPECT_FALSE(Reach(server->address(), Shown("pki", "other")).ok());
  EXPECT_TRUE(Reach(server->address(), Shown("pki", "pki")).ok());
}

TEST_F(TlsPort, OtherMachinesAreLetInByTlsOnly) {
  EXPECT_FALSE(StartServer("0.0.0.0:0", {}).ok());
  EXPECT_NE(Log().find("0.0.0.0:0, can be reached from other machines"), std::string::npos) << Log();
  EXPECT_TRUE(StartServer("0.0.0.0:0", Flags()).ok()) << Log();
  // Without authorities of callers' certificates they show tokens.
  absl::StatusOr<ServerProcess> tokens = StartServer("0.0.0.0:0", Flags(false));
  ASSERT_OK(tokens);
  const std::string address = "127.0.0.1" + tokens->address().substr(tokens->address().rfind(':'));
  const client::Identity nobody = {dir_.File("pki/ca.crt"), "", "", ""};
  EXPECT_EQ(base::ErrorReason(Reach(address, nobody)), "IDENTITY_MISSING");
  EXPECT_TRUE(Reach(address, {dir_.File("pki/ca.crt"), "", "", dir_.File("token")}).ok());
  EXPECT_EQ(base::ErrorReason(Reach(address, Shown("pki", "pki"))), "IDENTITY_MISSING");
}

TEST_F(TlsPort, ATokenCountsBeforeACertificateAndNobodyIsWhomTheServerDoesNotKnow) {
  MakeCerts("pki", "client stranger");
  absl::StatusOr<ServerProcess> server = StartServer("127.0.0.1:0", Flags());
  ASSERT_OK(server);
  client::Identity stranger = {dir_.File("pki/ca.crt"), dir_.File("pki/client/stranger.crt"),
                               dir_.File("pki/client/stranger.key"), ""};
  EXPECT_EQ(base::ErrorReason(Reach(server->address(), stranger)), "PRINCIPAL_UNKNOWN");
  stranger.token_file = dir_.File("token");
  EXPECT_TRUE(Reach(server->address(), stranger).ok());
  client::Identity cell = Shown("pki", "pki");
  std::ofstream(dir_.File("wrong")) << "axt_wrong\n";
  cell.token_file = dir_.File("wrong");
  EXPECT_EQ(base::ErrorReason(Reach(server->address(), cell)), "TOKEN_INVALID");
  EXPECT_EQ(base::ErrorReason(Reach(server->address(), {dir_.File("pki/ca.crt"), "", "", ""})), "IDENTITY_MISSING");
}

// Revoked over TLS: the connection lives on, its principal does not.
TEST_F(TlsPort, ARevokedPrincipalIsOutOnAConnectionThatIsOpen) {
  absl::StatusOr<ServerProcess> server = StartServer("127.0.0.1:0", Flags());
  ASSERT_OK(server);
  auto client = client::Client::Connect(server->address(), {.identity = Shown("pki", "pki")});
  ASSERT_OK(client);
  EXPECT_EQ(client->GetIdentity()->name, "cell-7");
  ASSERT_OK(client->RevokePrincipal("cell-7"));
  EXPECT_EQ(base::ErrorReason(client->GetIdentity().status()), "PRINCIPAL_UNKNOWN");
}

TEST_F(TlsPort, NewFilesAreTakenTogetherAndWithoutARestart) {
  absl::StatusOr<ServerProcess> server = StartServer("127.0.0.1:0", Flags());
  ASSERT_OK(server);
  auto open = client::Client::Connect(server->address(), {.identity = Shown("pki", "pki")});
  ASSERT_OK(open);
  ASSERT_OK(open->GetServerInfo());
  // The certificate of the new pair without its key: the old pair goes on.
  Use("other", ".crt");
  while (Log().find("event=tls_kept") == std::string::npos)
    EXPECT_TRUE(Reach(server->address(), Shown("pki", "pki")).ok());
  EXPECT_NE(Log().find("is not the key of the certificate"), std::string::npos) << Log();
  EXPECT_FALSE(Reach(server->address(), Shown("pki", "other")).ok());
  Use("other", ".key");
  while (Log().find("event=tls_reloaded") == std::string::npos)
    static_cast<void>(Reach(server->address(), Shown("pki", "pki")));
  EXPECT_TRUE(Reach(server->address(), Shown("pki", "other")).ok());
  EXPECT_FALSE(Reach(server->address(), Shown("pki", "pki")).ok());
  // A connection that is open goes on.
  EXPECT_TRUE(open->GetServerInfo().ok());
}

TEST_F(TlsPort, FilesThatDoNotFitAreRefusedAtTheStart) {
  Use("other", ".key");
  EXPECT_FALSE(StartServer("127.0.0.1:0", Flags()).ok());
  EXPECT_NE(Log().find("is not the key of the certificate"), std::string::npos) << Log();
}

TEST_F(TlsPort, ACertificateThatEndsSoonIsNamedInTheLog) {
  MakeCerts("pki", "server localhost 127.0.0.1 --renew --days 20");
  for (const std::string part : {".crt", ".key"}) Use("pki", part);
  absl::StatusOr<ServerProcess> server = StartServer("127.0.0.1:0", Flags());
  ASSERT_OK(server);
  while (Log().find("event=certificate_ends") == std::string::npos)
    EXPECT_TRUE(Reach(server->address(), Shown("pki", "pki")).ok());
  EXPECT_NE(Log().find("ends in 19 days"), std::string::npos) << Log();
}

// Of each handshake that fails gRPC has something to say, in a form of its own; whoever reaches the port brings it
// about.
TEST_F(TlsPort, WhatGrpcSaysIsInTheLogInItsFormAndNotOften) {
  std::vector<std::string> flags = Flags();
  flags.push_back("--log-json");
  absl::StatusOr<ServerProcess> server = StartServer("127.0.0.1:0", flags);
  ASSERT_OK(server);
  constexpr int kTries = 100;
  for (int i = 0; i < kTries; ++i) {
    testing::RawConnection plain(server->address());
    plain.Greet();
    EXPECT_TRUE(plain.WaitForClose());
  }
  EXPECT_TRUE(Reach(server->address(), Shown("pki", "pki")).ok());
  server->Signal(SIGTERM);
  EXPECT_EQ(server->Wait(), 0);
  std::istringstream lines(Log());
  int told = 0;
  for (std::string line; std::getline(lines, line);) {
    EXPECT_EQ(line.rfind("{\"time\":", 0), 0u) << line;
    told += line.find("Handshake failed") != std::string::npos ? 1 : 0;
  }
  EXPECT_GT(told, 0);
  EXPECT_LT(told, kTries / 2);
}

TEST_F(TlsPort, ATokenIsNotSentReadable) {
  std::ofstream(dir_.File("token")) << "axt_x\n";
  client::Identity identity;
  identity.token_file = dir_.File("token");
  const absl::Status refused = Reach("192.0.2.1:7410", identity);
  EXPECT_EQ(refused.code(), absl::StatusCode::kInvalidArgument) << refused;
  EXPECT_NE(refused.message().find("--ca"), std::string::npos) << refused;
  identity.token_file = dir_.File("none");
  EXPECT_EQ(Reach("127.0.0.1:1", identity).code(), absl::StatusCode::kNotFound);
}

// The same where the clock is a test's: looks at the files once a second, tells each reason once.
TEST_F(TlsPort, LooksOnceASecondAndTellsEachReasonOnce) {
  base::FakeClock clock;
  clock.Advance(base::SystemClock().UtcNow() - clock.UtcNow());
  std::vector<absl::Status> told;
  const auto tls = server::Tls::Create(
      {dir_.File("server.crt"), dir_.File("server.key"), ""},
      [&](const absl::Status& status) { told.push_back(status); }, clock);
  ASSERT_OK(tls);
  const auto first = (*tls)->TakeNew();
  ASSERT_TRUE(first.has_value());
  EXPECT_FALSE((*tls)->TakeNew().has_value());
  Use("other", ".crt");
  EXPECT_FALSE((*tls)->TakeNew().has_value());
  EXPECT_TRUE(told.empty());
  for (int second = 0; second < 3; ++second) {
    clock.Advance(std::chrono::seconds(1));
    EXPECT_FALSE((*tls)->TakeNew().has_value());
  }
  ASSERT_EQ(told.size(), 1u);
  EXPECT_FALSE(told[0].ok());
  Use("other", ".key");
  clock.Advance(std::chrono::seconds(1));
  const auto second = (*tls)->TakeNew();
  ASSERT_TRUE(second.has_value());
  EXPECT_NE(second->certificate_pem, first->certificate_pem);
  ASSERT_EQ(told.size(), 2u);
  EXPECT_TRUE(told[1].ok());
  // What cannot be read keeps what is in use.
  std::filesystem::remove(dir_.File("server.key"));
  clock.Advance(std::chrono::seconds(1));
  EXPECT_FALSE((*tls)->TakeNew().has_value());
  EXPECT_EQ(told.size(), 3u);
}

}  // namespace
}  // namespace axiscal
