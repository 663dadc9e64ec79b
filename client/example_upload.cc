// Uploads one session file to an Axiscal server: example_upload ADDRESS MACHINE FILE.
#include <cstdio>

#include "client/client.h"
#include "core/session/read_session.h"

using namespace axiscal;

static absl::Status Upload(const std::string& address, const std::string& machine, const std::string& file) {
  ASSIGN_OR_RETURN(const session::Session session, session::ReadSessionFile(file));
  ASSIGN_OR_RETURN(client::Client client, client::Client::Connect(address, {.user = "cell-7"}));
  const auto show = [](const client::TransferProgress& progress) {
    std::printf("%ld of %ld readings are on disk\n", long(progress.done), long(progress.total));
  };
  ASSIGN_OR_RETURN(const client::UploadResult upload, client.Upload(MachineId(machine), session, show));
  std::printf("session %ld%s\n", long(upload.session.id.number()), upload.was_there ? " was there already" : "");
  return absl::OkStatus();
}

int main(int argc, char** argv) {
  if (argc != 4) return std::fprintf(stderr, "usage: example_upload ADDRESS MACHINE FILE\n"), 2;
  const absl::Status status = Upload(argv[1], argv[2], argv[3]);
  if (!status.ok()) std::fprintf(stderr, "%s\n", status.ToString().c_str());
  return status.ok() ? 0 : 1;
}
