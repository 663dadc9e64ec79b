// What a hostile or broken client does to the server as a process, over a real port: others must not feel it.
#include <signal.h>
#include <sqlite3.h>

#include "axiscal/v1/machines_service.grpc.pb.h"
#include "tests/end_to_end/testing/fixture.h"
#include "tests/end_to_end/testing/process.h"
#include "tests/end_to_end/testing/raw_http2.h"
#include "tests/end_to_end/testing/raw_upload.h"

namespace axiscal {
namespace {

using testing::BallbarSession;
using testing::MachineJson;
using testing::RawConnection;
using testing::ServerProcess;

class Hostile : public ::testing::Test {
 protected:
  void StartServer(const std::vector<std::string>& flags = {}) {
    absl::StatusOr<ServerProcess> started =
        ServerProcess::Start(dir_.File("axiscal.db"), "127.0.0.1:0", dir_.File("log"), flags);
    ASSERT_OK(started);
    server_ = std::make_unique<ServerProcess>(*std::move(started));
    Connect();
  }
  void Connect() {
    absl::StatusOr<client::Client> client = client::Client::Connect(server_->address());
    ASSERT_OK(client);
    client_ = std::make_unique<client::Client>(*std::move(client));
  }
  std::shared_ptr<grpc::Channel> Channel() {
    return grpc::CreateChannel(server_->address(), grpc::InsecureChannelCredentials());
  }

  testing::TempDir dir_;
  std::unique_ptr<ServerProcess> server_;
  std::unique_ptr<client::Client> client_;
};

// What a caller says in metadata is written down and listed to all.
TEST_F(Hostile, AUserThatIsNoUtf8IsRefusedAndSpoilsNoList) {
  StartServer();
  ASSERT_OK(client_->CreateMachine(MachineJson("mt")));
  const auto create = [this](const std::string& user, const std::string& request_id) {
    RawConnection connection(server_->address());
    return connection.Call(
        "/axiscal.v1.Ingest/CreateSession", {{"axiscal-user", user}},
        testing::CreateRequest("mt", request_id, BallbarSession("mt", "BX", 100)).SerializeAsString());
  };
  for (const std::string user : {"cell\xFF", "caf\xE9", "\xC3", "\xED\xA0\x80", ""}) {
    EXPECT_NE(create(user, "r-1").find("axiscal-user: "), std::string::npos) << user;
  }
  ASSERT_OK(client_->ListSessions());
  EXPECT_TRUE(client_->ListSessions()->rows.empty());
  EXPECT_EQ(create("M\xC3\xBCller", "r-1").find("axiscal-user: "), std::string::npos);
  const auto sessions = client_->ListSessions();
  ASSERT_OK(sessions);
  ASSERT_EQ(sessions->rows.size(), 1u);
  EXPECT_EQ(sessions->rows[0].created_by, "M\xC3\xBCller");
}

// Written by a version that took any bytes.
TEST_F(Hostile, TextsThatAreStoredAndNoUtf8SpoilNoList) {
  StartServer();
  ASSERT_OK(client_->CreateMachine(MachineJson("mt")));
  ASSERT_OK(client_->Upload(MachineId("mt"), BallbarSession("mt", "BX", 100)));
  server_->Signal(SIGTERM);
  ASSERT_EQ(server_->Wait(), 0);
  sqlite3* db = nullptr;
  ASSERT_EQ(sqlite3_open(dir_.File("axiscal.db").c_str(), &db), SQLITE_OK);
  EXPECT_EQ(sqlite3_exec(db, "UPDATE session SET created_by = CAST(x'63616665FF' AS TEXT)", nullptr, nullptr, nullptr),
            SQLITE_OK)
      << sqlite3_errmsg(db);
  sqlite3_close(db);
  StartServer();
  const auto sessions = client_->ListSessions();
  ASSERT_OK(sessions);
  ASSERT_EQ(sessions->rows.size(), 1u);
  EXPECT_EQ(sessions->rows[0].created_by, "cafe\xEF\xBF\xBD");
}

// gRPC decompresses a message before it compares its size with the limit: 64 KB of gzip are 64 MB of blanks.
TEST_F(Hostile, CompressedMessagesAreRefusedBeforeTheyGrow) {
  StartServer();
  const int64_t peak_bytes = server_->PeakMemoryBytes();
  const auto stub = v1::Machines::NewStub(Channel());
  for (const grpc_compression_algorithm algorithm : {GRPC_COMPRESS_GZIP, GRPC_COMPRESS_DEFLATE}) {
    grpc::ClientContext context;
    context.set_compression_algorithm(algorithm);
    v1::CreateMachineRequest request;
    request.set_description_json(std::string(64 << 20, ' '));
    v1::CreateMachineResponse response;
    const grpc::Status status = stub->CreateMachine(&context, request, &response);
    EXPECT_EQ(status.error_code(), grpc::StatusCode::UNIMPLEMENTED) << status.error_message();
  }
  EXPECT_LT(server_->PeakMemoryBytes(), peak_bytes + (32 << 20));
  ASSERT_OK(client_->CreateMachine(MachineJson("mt")));
}

// As many keys as a message can hold are answered while the caller waits.
TEST_F(Hostile, JsonOfDistinctKeysIsAnswered) {
  StartServer();
  std::string json = "{";
  for (int i = 0; json.size() < 3'900'000; ++i) absl::StrAppend(&json, i == 0 ? "" : ",", "\"k", i, "\":0");
  json += "}";
  const auto created = client_->CreateMachine(json);
  EXPECT_EQ(created.status().code(), absl::StatusCode::kInvalidArgument) << created.status();
  EXPECT_NE(created.status().message().find("k0: unknown field"), std::string::npos) << created.status();
}

}  // namespace
}  // namespace axiscal
