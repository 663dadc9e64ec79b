// axiscal admin webhook put|list|remove|test|dead|resend
#include <sys/stat.h>

#include <CLI/CLI.hpp>
#include <memory>

#include "client/cli/commands.h"
#include "client/cli/context.h"
#include "client/cli/positive_number.h"
#include "client/cli/record_output.h"
#include "core/base/files.h"

namespace axiscal::cli {
namespace {

struct WebhookArguments {
  records::Webhook webhook;
  std::string machine, group, page, output;
  bool is_disabled = false, new_secret = false, all = false;
  int64_t change = 0;
  int page_size = 0;
};

Json ToJson(const records::WebhookRecord& record) {
  const records::Webhook& webhook = record.content;
  return {{"name", webhook.name},
          {"url", webhook.url},
          {"scope", records::TextOf(webhook.scope)},
          {"enabled", webhook.is_enabled},
          {"note", webhook.note},
          {"etag", record.etag},
          {"up_to_change", record.after_change},
          {"tries", record.tries},
          {"next_try_at", TimeJson(record.next_try_at)},
          {"last_error", record.last_error},
          {"last_sent_at", TimeJson(record.last_sent_at)},
          {"dead_letters", record.dead_letters},
          {"changed_by", record.changed_by}};
}

std::string WebhookText(const records::WebhookRecord& record) {
  const records::Webhook& webhook = record.content;
  std::string text =
      absl::StrCat("webhook ", webhook.name, webhook.is_enabled ? "" : " (disabled)", ": ", webhook.url, " for ",
                   records::TextOf(webhook.scope), ", said by ", record.changed_by, " (etag ", record.etag, ")\n");
  absl::StrAppend(&text, "  sent up to change ", record.after_change,
                  record.last_sent_at ? ", last at " + TimeText(*record.last_sent_at) + " UTC" : ", nothing yet", "\n");
  if (!record.last_error.empty()) absl::StrAppend(&text, "  last try: ", record.last_error, "\n");
  if (record.tries > 0) {
    absl::StrAppend(&text, "  change waits after ", record.tries, " tries",
                    record.next_try_at ? ", next at " + TimeText(*record.next_try_at) + " UTC" : "", "\n");
  }
  if (record.dead_letters > 0) {
    absl::StrAppend(&text, "  dead letters: ", record.dead_letters, " (axiscal admin webhook dead ", webhook.name,
                    ")\n");
  }
  if (!webhook.note.empty()) absl::StrAppend(&text, "  ", webhook.note, "\n");
  return text;
}

absl::Status Put(Context& context, const WebhookArguments& arguments) {
  if (!arguments.machine.empty() && !arguments.group.empty())
    return absl::InvalidArgumentError("webhook put: expected at most one of --group and --machine");
  records::Webhook webhook = arguments.webhook;
  webhook.is_enabled = !arguments.is_disabled;
  if (!arguments.group.empty()) webhook.scope = {records::Scope::Kind::kGroup, arguments.group};
  if (!arguments.machine.empty()) webhook.scope = {records::Scope::Kind::kMachine, arguments.machine};
  ASSIGN_OR_RETURN(client::Client * client, context.Connect());
  ASSIGN_OR_RETURN(const client::NewWebhook put, client->PutWebhook(webhook, arguments.new_secret));
  Json document = ToJson(put.record);
  std::string text = WebhookText(put.record);
  if (!put.secret.empty() && arguments.output.empty()) {
    document["secret"] = put.secret;
    absl::StrAppend(&text, "secret, shown now and never again:\n", put.secret, "\n");
  } else if (!put.secret.empty()) {
    // For its owner alone.
    const mode_t before = umask(077);
    const absl::Status written = base::WriteFileAtomically(arguments.output, put.secret + "\n");
    umask(before);
    if (!written.ok()) {
      return base::Within("the webhook is there, and its secret is lost: put it again with --new-secret", written);
    }
    absl::StrAppend(&text, "  its secret is in ", arguments.output, "\n");
  }
  context.Print(document, text);
  return absl::OkStatus();
}

absl::Status List(Context& context) {
  ASSIGN_OR_RETURN(client::Client * client, context.Connect());
  ASSIGN_OR_RETURN(const std::vector<records::WebhookRecord> webhooks, client->ListWebhooks());
  Json rows = Json::Array();
  std::string text;
  for (const records::WebhookRecord& record : webhooks) {
    rows.push_back(ToJson(record));
    text += WebhookText(record);
  }
  context.Print({{"webhooks", rows}}, text.empty() ? "no webhooks\n" : text);
  return absl::OkStatus();
}

absl::Status Remove(Context& context, const WebhookArguments& arguments) {
  ASSIGN_OR_RETURN(client::Client * client, context.Connect());
  ASSIGN_OR_RETURN(const records::WebhookRecord record, client->RemoveWebhook(arguments.webhook.name));
  context.Print(ToJson(record), absl::StrCat("webhook ", record.content.name, " is removed\n"));
  return absl::OkStatus();
}

absl::Status Test(Context& context, const WebhookArguments& arguments) {
  ASSIGN_OR_RETURN(client::Client * client, context.Connect());
  ASSIGN_OR_RETURN(const records::WebhookTrial trial, client->TestWebhook(arguments.webhook.name));
  if (!trial.error.empty()) {
    return absl::FailedPreconditionError(
        absl::StrCat("webhook ", arguments.webhook.name, " did not take the test letter: ", trial.error));
  }
  const char* const by = trial.is_mail ? "SMTP" : "HTTP";
  context.Print({{"by", by}, {trial.is_mail ? "smtp_reply" : "http_status", trial.status}, {"took_ms", trial.took_ms}},
                absl::StrCat("taken: ", by, " ", trial.status, " after ", trial.took_ms, " ms\n"));
  return absl::OkStatus();
}

absl::Status ListDead(Context& context, const WebhookArguments& arguments) {
  ASSIGN_OR_RETURN(client::Client * client, context.Connect());
  ASSIGN_OR_RETURN(const auto page,
                   client->ListDeadLetters(arguments.webhook.name, {arguments.page_size, arguments.page}));
  Json rows = Json::Array();
  std::vector<std::vector<std::string>> table = {
      {"change", "event", "machine", "tries", "last at (UTC)", "again", "last try"}};
  for (const records::DeadLetter& letter : page.rows) {
    rows.push_back({{"change", letter.change},
                    {"event", letter.event.number()},
                    {"machine", letter.machine.text()},
                    {"tries", letter.tries},
                    {"at", TimeJson(letter.at)},
                    {"wanted", letter.is_wanted},
                    {"error", letter.error}});
    table.push_back({absl::StrCat(letter.change), absl::StrCat(letter.event.number()), letter.machine.text(),
                     absl::StrCat(letter.tries), TimeText(letter.at), letter.is_wanted ? "soon" : "", letter.error});
  }
  context.Print({{"letters", rows}, {"next_page", page.next_token}}, Table(table) + PageText(page));
  return absl::OkStatus();
}

absl::Status Resend(Context& context, const WebhookArguments& arguments) {
  if ((arguments.change > 0) == arguments.all)
    return absl::InvalidArgumentError("webhook resend: expected either CHANGE or --all");
  ASSIGN_OR_RETURN(client::Client * client, context.Connect());
  const std::optional<int64_t> change = arguments.all ? std::nullopt : std::optional(arguments.change);
  ASSIGN_OR_RETURN(const int64_t count, client->ResendDeadLetters(arguments.webhook.name, change));
  context.Print({{"count", count}}, absl::StrCat(count, " dead letters are tried once more\n"));
  return absl::OkStatus();
}

}  // namespace

void AddWebhookCommands(CLI::App* admin, Context& context) {
  auto arguments = std::make_shared<WebhookArguments>();
  CLI::App* webhook =
      admin->add_subcommand("webhook", "Addresses that are told of events: put, list, remove, test, dead, resend");
  webhook->require_subcommand(1);
  CLI::App* put = webhook->add_subcommand("put", "Make one, or change the one of that name");
  put->add_option("NAME", arguments->webhook.name, "letters, digits, '.', '_', '@', '-'")->required();
  put->add_option("--url", arguments->webhook.url, "http://... or https://...")->required();
  put->add_option("--machine", arguments->machine, "of this machine alone");
  put->add_option("--group", arguments->group, "of the machines of this group");
  put->add_flag("--disabled", arguments->is_disabled, "keep it and send nothing; what happens is sent afterwards");
  put->add_flag("--new-secret", arguments->new_secret, "another secret takes the place of the present one");
  put->add_option("-o,--output", arguments->output, "write a new secret into this file, for its owner alone");
  put->add_option("--note", arguments->webhook.note, "for people");
  put->footer("Example: axiscal admin webhook put mes --url https://mes.shop/axiscal -o mes.secret");
  SetAction(put, context, [&context, arguments] { return Put(context, *arguments); });
  CLI::App* list = webhook->add_subcommand("list", "List them: what was sent, what waits, what failed");
  SetAction(list, context, [&context] { return List(context); });
  const auto add = [&](const char* name, const char* help) {
    CLI::App* command = webhook->add_subcommand(name, help);
    command->add_option("NAME", arguments->webhook.name, "which one")->required();
    return command;
  };
  CLI::App* remove = add("remove", "End one, its dead letters too");
  SetAction(remove, context, [&context, arguments] { return Remove(context, *arguments); });
  CLI::App* test = add("test", "Send a test letter and say what came of it");
  SetAction(test, context, [&context, arguments] { return Test(context, *arguments); });
  CLI::App* dead = add("dead", "List what could not be brought there");
  dead->add_option("--page-size", arguments->page_size, "rows per page (1 to 1000)")->check(CLI::Range(1, 1000));
  dead->add_option("--page", arguments->page, "token of the next page");
  SetAction(dead, context, [&context, arguments] { return ListDead(context, *arguments); });
  CLI::App* resend = add("resend", "Try dead letters once more");
  resend->add_option("CHANGE", arguments->change, "this one (dead)")->check(PositiveNumber());
  resend->add_flag("--all", arguments->all, "all of them");
  SetAction(resend, context, [&context, arguments] { return Resend(context, *arguments); });
}

}  // namespace axiscal::cli
