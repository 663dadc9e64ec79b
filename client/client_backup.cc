// A copy of the server's database, made there or brought here.
#include "client/client_impl.h"
#include "core/base/sha256.h"

namespace axiscal::client {

absl::StatusOr<Backup> Client::MakeBackup(const std::function<absl::Status(const std::string& bytes)>& take) {
  v1::BackupRequest request;
  request.set_download(take != nullptr);
  const auto context = impl_->connection.NewStreamContext();
  const auto stream = impl_->admin->Backup(context.get(), request);
  v1::BackupResponse message;
  v1::BackupSummary summary;
  base::Sha256 sha;
  int64_t received = 0;
  absl::Status taken;
  while (taken.ok() && stream->Read(&message)) {
    if (message.has_summary()) summary = message.summary();
    if (message.content_case() != v1::BackupResponse::kData || take == nullptr) continue;
    sha.Add(message.data());
    received += static_cast<int64_t>(message.data().size());
    taken = take(message.data());
  }
  if (!taken.ok()) context->TryCancel();
  const absl::Status status = impl_->connection.FromGrpc(stream->Finish());
  RETURN_IF_ERROR(taken);
  RETURN_IF_ERROR(status);
  if (take != nullptr && (received != summary.size_bytes() || sha.HexDigest() != summary.sha256()))
    return absl::DataLossError("the copy's size and checksum do not fit what came");
  Backup backup{summary.file(), summary.size_bytes(), summary.sha256(), summary.damage_count(), {}};
  for (const v1::StoreDamage& damage : summary.damages()) backup.damages.push_back({damage.resource(), damage.text()});
  return backup;
}

}  // namespace axiscal::client
