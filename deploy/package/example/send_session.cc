// send_session ADDRESS MACHINE FILE: stores a session file on a server, and says what it is called there.
#include <cstdio>

#include "client/client.h"
#include "core/session/read_session.h"

int main(int argc, char** argv) {
  if (argc != 4) return std::fprintf(stderr, "usage: send_session ADDRESS MACHINE FILE\n"), 2;
  const auto fail = [](const absl::Status& status) {
    std::fprintf(stderr, "send_session: %s\n", std::string(status.message()).c_str());
    return 1;
  };
  const absl::StatusOr<axiscal::session::Session> session = axiscal::session::ReadSessionFile(argv[3]);
  if (!session.ok()) return fail(session.status());
  absl::StatusOr<axiscal::client::Client> client = axiscal::client::Client::Connect(argv[1], {.user = "send_session"});
  if (!client.ok()) return fail(client.status());
  const absl::StatusOr<axiscal::client::UploadResult> upload = client->Upload(axiscal::MachineId(argv[2]), *session);
  if (!upload.ok()) return fail(upload.status());
  std::printf("session %ld%s\n", long(upload->session.id.number()), upload->was_there ? " was there already" : "");
  return 0;
}
