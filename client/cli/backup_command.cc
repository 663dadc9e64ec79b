// axiscal backup
#include <sys/stat.h>

#include <CLI/CLI.hpp>
#include <memory>

#include "client/cli/commands.h"
#include "client/cli/context.h"
#include "core/base/files.h"

namespace axiscal::cli {
namespace {

absl::StatusOr<client::Backup> BringHere(client::Client& client, const std::string& output) {
  base::AtomicFile file;
  const mode_t before = umask(077);  // it holds everything, the hashes of tokens too
  const absl::Status opened = file.Open(output);
  umask(before);
  RETURN_IF_ERROR(opened);
  ASSIGN_OR_RETURN(client::Backup backup,
                   client.MakeBackup([&](const std::string& bytes) { return file.Write(bytes); }));
  RETURN_IF_ERROR(file.Commit());
  return backup;
}

absl::Status MakeBackup(Context& context, const std::string& output) {
  ASSIGN_OR_RETURN(client::Client * client, context.Connect());
  ASSIGN_OR_RETURN(const client::Backup backup, output.empty() ? client->MakeBackup() : BringHere(*client, output));
  std::vector<Json> damages;
  std::string texts;
  for (const auto& [resource, text] : backup.damages) {
    damages.push_back({{"resource", resource}, {"text", text}});
    absl::StrAppend(&texts, "DAMAGED ", resource, ": ", text, "\n");
  }
  const std::string file = output.empty() ? backup.file : output;
  context.Print({{"file", file},
                 {"size_bytes", backup.size_bytes},
                 {"sha256", backup.sha256},
                 {"damage_count", backup.damage_count},
                 {"damages", damages}},
                absl::StrCat(file, ": ", backup.size_bytes, " bytes, sha256 ", backup.sha256, "\n", texts));
  if (backup.damage_count == 0) return absl::OkStatus();
  return absl::DataLossError(
      absl::StrCat("the database is damaged in ", backup.damage_count, " places; so is its copy, which was kept"));
}

}  // namespace

void AddBackupCommand(CLI::App& app, Context& context) {
  const auto output = std::make_shared<std::string>();
  CLI::App* backup = app.add_subcommand("backup", "Copy the database of a running server, whole and looked through");
  backup->add_option("-o,--output", *output, "bring it here; without it, it stays in the server's folder for backups");
  backup->footer(
      "Examples:\n  axiscal --server axiscal.shop:7410 backup\n  axiscal backup -o axiscal-copy.db\n"
      "It is put back by: axiscald --db FILE restore axiscal-copy.db");
  SetAction(backup, context, [&context, output] { return MakeBackup(context, *output); });
}

}  // namespace axiscal::cli
