// axiscal upload
#include <CLI/CLI.hpp>
#include <filesystem>
#include <map>
#include <memory>

#include "absl/strings/match.h"
#include "absl/strings/str_join.h"
#include "client/cli/commands.h"
#include "client/cli/context.h"
#include "client/cli/log_form.h"
#include "client/cli/record_output.h"
#include "core/base/files.h"
#include "core/base/json_limits.h"
#include "core/instruments/plausible.h"
#include "core/machine/machine_json.h"
#include "core/session/case.h"
#include "core/session/check_machine.h"
#include "core/session/read_session.h"

namespace axiscal::cli {
namespace {

namespace fs = std::filesystem;

struct UploadArguments {
  std::vector<std::string> paths;
  std::string machine;
  LogFormArguments form;  // of logs
};

struct File {
  std::string path;
  session::Session session;
};

// Session files, and machine.json files of case folders.
struct Inputs {
  std::vector<std::string> sessions, machines;
  std::vector<std::string> passed_over;  // tables beside a folder fit/
  int kept_back = 0;  // files of folders check/: no error is ever fitted to them, so `identify --all` must not see them
};

absl::StatusOr<Inputs> FindInputs(const std::vector<std::string>& paths) {
  Inputs inputs;
  for (const std::string& path : paths) {
    if (!fs::is_directory(path)) {
      inputs.sessions.push_back(path);
      continue;
    }
    const fs::path folder(path);
    // Beside fit/ stand other tables: poses.csv and truth.csv of `axiscal simulate`.
    std::vector<std::string> files = session::SessionFiles((folder / "fit").string());
    const std::vector<std::string> beside = session::SessionFiles(path);
    if (files.empty()) {
      files = beside;
    } else {
      inputs.passed_over.insert(inputs.passed_over.end(), beside.begin(), beside.end());
    }
    if (files.empty())
      return absl::InvalidArgumentError(path + ": no session files, expected *.csv in its folder fit or in it");
    inputs.sessions.insert(inputs.sessions.end(), files.begin(), files.end());
    inputs.kept_back += static_cast<int>(session::SessionFiles((folder / "check").string()).size());
    if (fs::exists(folder / "machine.json")) inputs.machines.push_back((folder / "machine.json").string());
  }
  return inputs;
}

// Descriptions by id: those of the folders are stored when the server has none, the others come from the server.
class Machines {
 public:
  explicit Machines(client::Client& client) : client_(client) {}

  absl::Status AddFile(const std::string& path) {
    ASSIGN_OR_RETURN(machine::Machine machine, machine::ReadMachineFile(path));
    ASSIGN_OR_RETURN(new_descriptions_[machine.id], base::ReadFile(path, base::kMaxJsonBytes));
    machines_.emplace(machine.id, std::move(machine));
    return absl::OkStatus();
  }

  absl::StatusOr<const machine::Machine*> Get(const std::string& id) {
    if (machines_.count(id) == 0) {
      ASSIGN_OR_RETURN(const records::MachineRecord record, client_.GetMachine(MachineId(id)));
      ASSIGN_OR_RETURN(machines_[id], machine::MachineFromJson(record.description_json));
    }
    return &machines_[id];
  }

  // Refused (MACHINE_EXISTS) when the server has another machine under this id.
  absl::Status StoreNew() {
    for (const auto& [id, description] : new_descriptions_)
      RETURN_IF_ERROR(client_.CreateMachine(description).status());
    return absl::OkStatus();
  }

 private:
  client::Client& client_;
  std::map<std::string, machine::Machine> machines_;
  std::map<std::string, std::string> new_descriptions_;
};

// Every file is read and checked before anything is sent.
absl::StatusOr<std::vector<File>> ReadAll(const Inputs& inputs, const UploadArguments& arguments, Machines& machines) {
  for (const std::string& path : inputs.machines) RETURN_IF_ERROR(machines.AddFile(path));
  std::vector<File> files;
  for (const std::string& path : inputs.sessions) {
    ASSIGN_OR_RETURN(session::Session session, session::ReadSessionFile(path));
    const std::string id = *session::FindHeader(session, "machine");
    if (!arguments.machine.empty() && id != arguments.machine) {
      return absl::InvalidArgumentError(
          absl::StrCat(path, ": machine: '", id, "', expected '", arguments.machine, "'"));
    }
    const auto machine = machines.Get(id);
    if (!machine.ok()) return base::Within(path, machine.status());
    RETURN_IF_ERROR(base::Within(path, session::CheckAgainstMachine(session, **machine)));
    RETURN_IF_ERROR(base::Within(path, instruments::CheckPlausible(session, **machine)));
    RETURN_IF_ERROR(base::Within(path, instruments::CheckWhole(session)));
    files.push_back({path, std::move(session)});
  }
  return files;
}

absl::Status Upload(Context& context, const UploadArguments& arguments) {
  ASSIGN_OR_RETURN(const Inputs inputs, FindInputs(arguments.paths));
  ASSIGN_OR_RETURN(client::Client * client, context.Connect());
  Machines machines(*client);
  ASSIGN_OR_RETURN(const std::vector<File> files, ReadAll(inputs, arguments, machines));
  RETURN_IF_ERROR(machines.StoreNew());
  Json sessions = Json::Array();
  std::vector<std::vector<std::string>> rows = {{"id", "session", "instrument", "readings", "", "file"}};
  for (const File& file : files) {
    ProgressBar bar = context.Bar(file.path);
    const auto progress = [&bar](const client::TransferProgress& now) {
      const double fraction = now.total == 0 ? 0 : static_cast<double>(now.done) / static_cast<double>(now.total);
      bar.Show(fraction, absl::StrCat(now.done, " of ", now.total, " readings"));
    };
    const auto result =
        client->Upload(MachineId(*session::FindHeader(file.session, "machine")), file.session, progress);
    if (!result.ok()) return base::Within(file.path, result.status());
    Json json = ToJson(result->session);
    json["file"] = file.path;
    json["was_there"] = result->was_there;
    sessions.push_back(std::move(json));
    rows.push_back({absl::StrCat(result->session.id.number()), result->session.name, result->session.instrument,
                    absl::StrCat(result->session.reading_count), result->was_there ? "was there" : "stored",
                    file.path});
  }
  if (!inputs.passed_over.empty())
    context.Note(
        absl::StrCat("passed over, as they stand beside a folder fit/ (upload them by name if they are sessions): ",
                     absl::StrJoin(inputs.passed_over, ", ")));
  if (inputs.kept_back > 0) {
    context.Note(absl::StrCat(
        inputs.kept_back,
        " check sessions were not uploaded: errors are never fitted to them (upload them by name to store them)"));
  }
  context.Print({{"sessions", sessions}}, Table(rows));
  return absl::OkStatus();
}

// ---- logs, which the server reduces

absl::Status UploadLogs(Context& context, const UploadArguments& arguments) {
  ASSIGN_OR_RETURN(const records::LogForm form, ReadLogForm(arguments.form));
  MachineId machine(arguments.machine);
  if (machine.empty()) {
    ASSIGN_OR_RETURN(machine, MachineOf(form));
  }
  ASSIGN_OR_RETURN(client::Client * client, context.Connect());
  Json sessions = Json::Array();
  std::vector<std::vector<std::string>> rows = {{"id", "session", "instrument", "readings", "", "file", "log"}};
  std::string notes;
  for (const std::string& path : arguments.paths) {
    RETURN_IF_ERROR(base::RequireFile(path));
    ASSIGN_OR_RETURN(const std::string bytes, base::ReadFile(path, static_cast<size_t>(records::kMaxLogBytes)));
    const std::string name = fs::path(path).filename().string();
    const auto stored = client->PutLog(machine, name, bytes, form);
    if (!stored.ok()) {
      const bool is_named = path == name && absl::StartsWith(stored.status().message(), name + ": ");
      return is_named ? stored.status() : base::Within(path, stored.status());
    }
    Json json = ToJson(stored->session);
    json["file"] = path;
    json["was_there"] = stored->was_there;
    json["log_program"] = stored->log.id.number();
    json["notes"] = stored->notes;
    if (stored->cut_line) json["cut_line"] = *stored->cut_line;
    sessions.push_back(std::move(json));
    rows.push_back({absl::StrCat(stored->session.id.number()), stored->session.name, stored->session.instrument,
                    absl::StrCat(stored->session.reading_count), stored->was_there ? "was there" : "stored", path,
                    absl::StrCat("program ", stored->log.id.number())});
    for (const std::string& note : stored->notes) absl::StrAppend(&notes, "note: ", path, ": ", note, "\n");
  }
  context.Print({{"sessions", sessions}}, Table(rows) + notes);
  return absl::OkStatus();
}

}  // namespace

void AddUploadCommand(CLI::App& app, Context& context) {
  auto arguments = std::make_shared<UploadArguments>();
  CLI::App* upload = app.add_subcommand("upload", "Store measuring sessions");
  upload
      ->add_option("PATH", arguments->paths,
                   "session files, or case folders (machine.json, fit/*.csv; check/*.csv stays)")
      ->required();
  upload->add_option("--machine", arguments->machine, "refuse files of any other machine; of logs: which it is");
  AddLogFormOptions(upload, arguments->form);
  upload->footer(
      "All files are checked before anything is stored; a bad one stops the upload with file, line and column. The "
      "same file\n"
      "again is recognised and stored once. A case folder's machine.json is stored when the machine is new.\n"
      "Examples: axiscal upload BX.csv BY.csv CR.csv\n"
      "          axiscal --server cell7:7410 upload tuesday/\n"
      "          axiscal --server cell7:7410 upload probe.log --template ball.txt");
  SetAction(upload, context, [&context, arguments] {
    return arguments->form.log_template.empty() ? Upload(context, *arguments) : UploadLogs(context, *arguments);
  });
}

}  // namespace axiscal::cli
