// axiscal spool add|list|send|retry|drop: the spool that axiscal-cell works on.
#include <CLI/CLI.hpp>
#include <filesystem>
#include <memory>

#include "client/cli/commands.h"
#include "client/cli/context.h"
#include "client/cli/log_form.h"
#include "client/cli/positive_number.h"
#include "client/cli/record_output.h"
#include "client/spool/sender.h"
#include "client/spool/spool.h"
#include "core/base/files.h"

namespace axiscal::cli {
namespace {

struct SpoolArguments {
  std::string folder, machine;
  int64_t max_megabytes = 1024, number = 0;
  std::vector<std::string> paths;
  LogFormArguments form;
};

constexpr std::pair<spool::Place, const char*> kPlaces[] = {
    {spool::Place::kWaiting, "waiting"}, {spool::Place::kRefused, "quarantined"}, {spool::Place::kSent, "sent"}};

const char* PlaceName(spool::Place place) {
  for (const auto& [known, name] : kPlaces) {
    if (known == place) return name;
  }
  return "";
}

absl::StatusOr<spool::Spool> OpenSpool(const SpoolArguments& arguments) {
  spool::SpoolOptions options;
  options.folder = arguments.folder;
  options.max_bytes = arguments.max_megabytes << 20;
  return spool::Spool::Open(options);
}

absl::Status AddToSpool(Context& context, const SpoolArguments& arguments) {
  ASSIGN_OR_RETURN(spool::Spool spool, OpenSpool(arguments));
  spool::Item item;
  item.machine = arguments.machine;
  item.is_log = !arguments.form.log_template.empty();
  if (item.is_log) {
    ASSIGN_OR_RETURN(item.form, ReadLogForm(arguments.form));
    if (item.machine.empty()) {
      ASSIGN_OR_RETURN(const MachineId machine, MachineOf(item.form));
      item.machine = machine.text();
    }
  }
  Json entries = Json::Array();
  std::vector<std::vector<std::string>> rows = {{"number", "", "file"}};
  for (const std::string& path : arguments.paths) {
    ASSIGN_OR_RETURN(const std::string bytes, base::ReadFile(path, static_cast<size_t>(records::kMaxLogBytes)));
    item.name = std::filesystem::path(path).filename().string();
    item.source = std::filesystem::absolute(path).string();
    const auto added = spool.Add(item, bytes);
    if (!added.ok()) return base::Within(path, added.status());
    const std::string place = PlaceName(added->place);
    entries.push_back({{"number", added->number}, {"was_there", added->was_there}, {"place", place}, {"file", path}});
    rows.push_back({absl::StrCat(added->number), added->was_there ? "was there, " + place : place, path});
  }
  context.Print({{"entries", entries}}, Table(rows));
  return absl::OkStatus();
}

absl::Status ListSpool(Context& context, const SpoolArguments& arguments) {
  ASSIGN_OR_RETURN(const spool::Spool spool, OpenSpool(arguments));
  Json entries = Json::Array();
  std::vector<std::vector<std::string>> rows = {{"number", "", "file", "bytes", "machine", "note"}};
  for (const auto& [place, name] : kPlaces) {
    ASSIGN_OR_RETURN(const std::vector<int64_t> numbers, spool.Numbers(place));
    for (const int64_t number : numbers) {
      const absl::StatusOr<spool::Entry> entry = spool.Get(place, number);
      if (absl::IsNotFound(entry.status())) continue;  // it has just moved on
      const spool::Note note = spool.NoteOf(place, number);
      Json json = {{"number", number}, {"place", name}};
      std::string words;
      if (entry.ok()) {
        json["file"] = entry->item.name;
        json["bytes"] = entry->size_bytes;
        json["machine"] = entry->item.machine;
        json["sha256"] = entry->sha256;
      } else {
        words = std::string(entry.status().message());
      }
      Json facts = Json::Object();
      for (const auto& [key, value] : note) facts[key] = value;
      json["note"] = facts;
      if (place == spool::Place::kSent && note.count("session_id") > 0) words = "session " + note.at("session_id");
      if (place == spool::Place::kRefused && note.count("text") > 0) words = note.at("text");
      rows.push_back({absl::StrCat(number), name, entry.ok() ? entry->item.name : "?",
                      entry.ok() ? absl::StrCat(entry->size_bytes) : "?", entry.ok() ? entry->item.machine : "?",
                      words});
      entries.push_back(std::move(json));
    }
  }
  context.Print({{"entries", entries}}, Table(rows));
  return absl::OkStatus();
}

absl::Status SendSpool(Context& context, const SpoolArguments& arguments) {
  ASSIGN_OR_RETURN(spool::Spool spool, OpenSpool(arguments));
  ASSIGN_OR_RETURN(const spool::SenderLock lock, spool::SenderLock::Take(arguments.folder));
  ASSIGN_OR_RETURN(client::Client * client, context.Connect());
  spool::Sender sender(spool, *client);
  Json entries = Json::Array();
  std::vector<std::vector<std::string>> rows = {{"number", "", "file", "note"}};
  absl::Status stopped, held;
  while (stopped.ok()) {
    ASSIGN_OR_RETURN(const std::optional<spool::Attempt> attempt, sender.SendNext());
    if (!attempt) break;
    const bool is_sent = attempt->fate == spool::Fate::kSent;
    if (attempt->fate == spool::Fate::kNotHere) {
      held = base::Within(attempt->name, attempt->status);
      entries.push_back({{"number", attempt->number},
                         {"place", "waiting"},
                         {"file", attempt->name},
                         {"note", std::string(attempt->status.message())}});
      rows.push_back({absl::StrCat(attempt->number), "waiting", attempt->name, std::string(attempt->status.message())});
      continue;
    }
    if (!is_sent && attempt->fate != spool::Fate::kRefused) {
      stopped = base::Within(attempt->name, attempt->status);
      break;
    }
    const std::string note =
        is_sent ? absl::StrCat("session ", attempt->session.id.number(), attempt->was_there ? ", was there" : "")
                : std::string(attempt->status.message());
    const char* const what = is_sent ? "sent" : "quarantined";
    entries.push_back({{"number", attempt->number}, {"place", what}, {"file", attempt->name}, {"note", note}});
    rows.push_back({absl::StrCat(attempt->number), what, attempt->name, note});
  }
  context.Print({{"entries", entries}}, Table(rows));
  return stopped.ok() ? held : stopped;
}

absl::Status MoveEntry(Context& context, const SpoolArguments& arguments,
                       absl::Status (spool::Spool::*move)(int64_t number)) {
  ASSIGN_OR_RETURN(spool::Spool spool, OpenSpool(arguments));
  RETURN_IF_ERROR((spool.*move)(arguments.number));
  const bool waits = move == &spool::Spool::Retry;
  context.Print({{"number", arguments.number}, {"place", waits ? "waiting" : "dropped"}},
                absl::StrCat(arguments.number, waits ? " waits again\n" : " is gone\n"));
  return absl::OkStatus();
}

}  // namespace

void AddSpoolCommand(CLI::App& app, Context& context) {
  auto arguments = std::make_shared<SpoolArguments>();
  CLI::App* spool = app.add_subcommand(
      "spool", "Files on their way to the server that survive power cuts and days without network (docs/cell.md)");
  spool->require_subcommand(1);
  const auto command = [&](const char* name, const char* meaning) {
    CLI::App* const one = spool->add_subcommand(name, meaning);
    one->add_option("--spool", arguments->folder, "the spool's folder, of axiscal-cell or your own")->required();
    return one;
  };
  CLI::App* add = command("add", "Put session files, or with --template logs, into the spool; durable when it returns");
  add->add_option("PATH", arguments->paths, "the files")->required();
  add->add_option("--machine", arguments->machine, "whose they are, where header, plan or template does not say so");
  add->add_option("--max-megabytes", arguments->max_megabytes, "of all that the spool holds; nothing unsent ever goes")
      ->check(CLI::Range(int64_t{1}, int64_t{1} << 20))
      ->capture_default_str();
  AddLogFormOptions(add, arguments->form);
  SetAction(add, context, [&context, arguments] { return AddToSpool(context, *arguments); });

  CLI::App* list = command("list", "What waits, what the server refused and why, what was sent last");
  SetAction(list, context, [&context, arguments] { return ListSpool(context, *arguments); });

  CLI::App* send = command("send", "Send what waits, in order; what the server refuses goes into quarantine");
  SetAction(send, context, [&context, arguments] { return SendSpool(context, *arguments); });

  CLI::App* retry = command("retry", "What was quarantined waits again");
  retry->add_option("NUMBER", arguments->number, "its number")->required()->check(PositiveNumber());
  SetAction(retry, context, [&context, arguments] { return MoveEntry(context, *arguments, &spool::Spool::Retry); });

  CLI::App* resend = command("resend",
                             "What was sent last waits again, for a server that was restored from a backup and may "
                             "lack it; what it has it says");
  SetAction(resend, context, [&context, arguments]() -> absl::Status {
    ASSIGN_OR_RETURN(spool::Spool opened, OpenSpool(*arguments));
    ASSIGN_OR_RETURN(const int count, opened.SendAgain());
    context.Print({{"count", count}}, absl::StrCat(count, " wait again\n"));
    return absl::OkStatus();
  });

  CLI::App* drop = command("drop", "What was quarantined goes for good");
  drop->add_option("NUMBER", arguments->number, "its number")->required()->check(PositiveNumber());
  SetAction(drop, context, [&context, arguments] { return MoveEntry(context, *arguments, &spool::Spool::Drop); });
}

}  // namespace axiscal::cli
