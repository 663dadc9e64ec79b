// axiscal admin whoami|principal|token|role|group|four-eyes|audit; webhooks: webhook_command.cc
#include <sys/stat.h>

#include <CLI/CLI.hpp>
#include <cstdio>
#include <memory>

#include "client/cli/commands.h"
#include "client/cli/context.h"
#include "client/cli/positive_number.h"
#include "client/cli/record_output.h"
#include "core/base/files.h"

namespace axiscal::cli {
namespace {

struct AdminArguments {
  std::string name, note, role, group, machine, page, output, on_off, resource, from, to;
  std::vector<std::string> machines;
  bool all = false, lines = false, check = false;
  int page_size = 0, days = 0;
  int64_t token = 0;
};

std::string RolesText(const std::vector<records::Grant>& grants) {
  std::string text;
  for (const records::Grant& grant : grants) absl::StrAppend(&text, text.empty() ? "" : "; ", GrantText(grant));
  return text.empty() ? "no role" : text;
}

std::string AccessText(const records::MachineAccess& access) {
  std::string groups;
  for (const std::string& group : access.groups) absl::StrAppend(&groups, groups.empty() ? "" : ", ", group);
  return absl::StrCat("machine ", access.machine.text(), ": groups ", groups.empty() ? "none" : groups,
                      access.four_eyes ? "; another person approves than identified" : "", "\n");
}

absl::Status WhoAmI(Context& context) {
  ASSIGN_OR_RETURN(client::Client * client, context.Connect());
  ASSIGN_OR_RETURN(const records::PrincipalRecord identity, client->GetIdentity());
  const bool is_local = identity.name.rfind("local:", 0) == 0;
  context.Print({{"name", identity.name}, {"roles", GrantsJson(identity.grants)}},
                identity.name + ": " +
                    (is_local ? "may do everything: this server asks nobody" : RolesText(identity.grants)) + "\n");
  return absl::OkStatus();
}

absl::Status LogLevel(Context& context, const AdminArguments& arguments) {
  ASSIGN_OR_RETURN(client::Client * client, context.Connect());
  std::optional<records::LogLevel> wanted;
  if (!arguments.name.empty()) wanted = records::LogLevelNamed(arguments.name);
  ASSIGN_OR_RETURN(const auto levels, client->SetLogLevel(wanted));
  const std::string now = records::NameOf(levels.second), former = records::NameOf(levels.first);
  context.Print({{"level", now}, {"former_level", former}},
                now == former
                    ? "the server's log has " + now + " and more\n"
                    : "the server's log has " + now + " and more, until its next start; it had " + former + "\n");
  return absl::OkStatus();
}

absl::Status AddPrincipal(Context& context, const AdminArguments& arguments) {
  ASSIGN_OR_RETURN(client::Client * client, context.Connect());
  ASSIGN_OR_RETURN(const records::PrincipalRecord record, client->CreatePrincipal(arguments.name, arguments.note));
  context.Print(ToJson(record), absl::StrCat("principal ", record.name, " is there; it has ", RolesText(record.grants),
                                             ": axiscal admin role add ", record.name, " ROLE ...\n"));
  return absl::OkStatus();
}

absl::Status RevokePrincipal(Context& context, const AdminArguments& arguments) {
  ASSIGN_OR_RETURN(client::Client * client, context.Connect());
  ASSIGN_OR_RETURN(const records::PrincipalRecord record, client->RevokePrincipal(arguments.name));
  context.Print(ToJson(record), absl::StrCat("principal ", record.name, " is revoked with its ", record.tokens.size(),
                                             " tokens; its open calls end within a minute\n"));
  return absl::OkStatus();
}

absl::Status ListPrincipals(Context& context, const AdminArguments& arguments) {
  ASSIGN_OR_RETURN(client::Client * client, context.Connect());
  ASSIGN_OR_RETURN(const auto page, client->ListPrincipals({arguments.page_size, arguments.page}));
  std::vector<std::vector<std::string>> rows = {
      {"principal", "token", "roles or note", "expires (UTC)", "last use (UTC)", "revoked (UTC)"}};
  for (const records::PrincipalRecord& record : page.rows) {
    rows.push_back({record.name, "", RolesText(record.grants), "-", "-", TimeText(record.revoked_at)});
    for (const records::TokenRecord& token : record.tokens) {
      rows.push_back({record.name, absl::StrCat(token.id), token.note, TimeText(token.expires_at),
                      TimeText(token.last_used_at), TimeText(token.revoked_at)});
    }
  }
  context.Print(PageJson("principals", page), Table(rows) + PageText(page));
  return absl::OkStatus();
}

absl::Status AddToken(Context& context, const AdminArguments& arguments) {
  ASSIGN_OR_RETURN(client::Client * client, context.Connect());
  std::optional<base::UtcTime> expires_at;
  if (arguments.days > 0) expires_at = base::SystemClock().UtcNow() + std::chrono::days(arguments.days);
  ASSIGN_OR_RETURN(const client::NewToken token, client->CreateToken(arguments.name, arguments.note, expires_at));
  Json document = ToJson(token.record);
  std::string text = absl::StrCat("token ", token.record.id, " of ", token.record.principal);
  if (arguments.output.empty()) {
    document["secret"] = token.secret;
    absl::StrAppend(&text, ", shown now and never again:\n", token.secret, "\n");
  } else {
    // For its owner alone.
    const mode_t before = umask(077);
    const absl::Status written = base::WriteFileAtomically(arguments.output, token.secret + "\n");
    umask(before);
    if (!written.ok()) {
      // A token that nobody has is ended.
      static_cast<void>(client->RevokeToken(token.record.id));
      return written;
    }
    absl::StrAppend(&text, " is in ", arguments.output, "\n");
  }
  context.Print(document, text);
  return absl::OkStatus();
}

absl::Status RevokeToken(Context& context, const AdminArguments& arguments) {
  ASSIGN_OR_RETURN(client::Client * client, context.Connect());
  ASSIGN_OR_RETURN(const records::TokenRecord record, client->RevokeToken(arguments.token));
  context.Print(ToJson(record), absl::StrCat("token ", record.id, " of ", record.principal, " is revoked\n"));
  return absl::OkStatus();
}

absl::Status ChangeRole(Context& context, const AdminArguments& arguments, bool holds) {
  if ((arguments.all ? 1 : 0) + (arguments.group.empty() ? 0 : 1) + (arguments.machine.empty() ? 0 : 1) != 1)
    return absl::InvalidArgumentError("role: expected exactly one of --all, --group and --machine");
  records::Grant grant;
  grant.role = *records::RoleNamed(arguments.role);
  if (!arguments.group.empty()) grant.scope = {records::Scope::Kind::kGroup, arguments.group};
  if (!arguments.machine.empty()) grant.scope = {records::Scope::Kind::kMachine, arguments.machine};
  ASSIGN_OR_RETURN(client::Client * client, context.Connect());
  ASSIGN_OR_RETURN(const records::PrincipalRecord record, client->ChangeRole(arguments.name, grant, holds));
  context.Print(ToJson(record), record.name + ": " + RolesText(record.grants) + "\n");
  return absl::OkStatus();
}

absl::Status ChangeGroup(Context& context, const AdminArguments& arguments, bool belongs) {
  ASSIGN_OR_RETURN(client::Client * client, context.Connect());
  Json rows = Json::Array();
  std::string text;
  for (const std::string& machine : arguments.machines) {
    ASSIGN_OR_RETURN(const records::MachineAccess access,
                     client->ChangeGroup(arguments.group, MachineId(machine), belongs));
    rows.push_back(ToJson(access));
    text += AccessText(access);
  }
  context.Print({{"machines", rows}}, text);
  return absl::OkStatus();
}

absl::Status ListGroups(Context& context, const AdminArguments& arguments) {
  ASSIGN_OR_RETURN(client::Client * client, context.Connect());
  ASSIGN_OR_RETURN(const auto page, client->ListMachineAccess({arguments.page_size, arguments.page}));
  std::string text;
  for (const records::MachineAccess& access : page.rows) text += AccessText(access);
  context.Print(PageJson("machines", page), text + PageText(page));
  return absl::OkStatus();
}

absl::Status FourEyes(Context& context, const AdminArguments& arguments) {
  ASSIGN_OR_RETURN(client::Client * client, context.Connect());
  ASSIGN_OR_RETURN(const records::MachineAccess access,
                   client->SetFourEyes(MachineId(arguments.machine), arguments.on_off == "on"));
  context.Print(ToJson(access), AccessText(access));
  return absl::OkStatus();
}

absl::Status CheckAudit(Context& context) {
  ASSIGN_OR_RETURN(client::Client * client, context.Connect());
  ASSIGN_OR_RETURN(const client::AuditHead head, client->CheckAudit());
  context.Print(
      {{"last_entry", head.last_entry}, {"sha256", head.sha256}},
      absl::StrCat("the chain is whole; the last entry is ", head.last_entry, ", its hash ", head.sha256, "\n"));
  return absl::OkStatus();
}

// All entries, one JSON document a line: a log collector's.
absl::Status PrintAuditLines(Context& context, const client::AuditFilter& filter) {
  ASSIGN_OR_RETURN(client::Client * client, context.Connect());
  client::PageRequest page{1000, ""};
  do {
    ASSIGN_OR_RETURN(const auto entries, client->ListAudit(filter, page));
    for (const client::AuditEntry& entry : entries.rows) std::printf("%s\n", ToJson(entry).Line().c_str());
    page.token = entries.next_token;
  } while (!page.token.empty());
  return absl::OkStatus();
}

absl::Status ListAudit(Context& context, const AdminArguments& arguments) {
  client::AuditFilter filter;
  filter.principal = arguments.name;
  filter.resource = arguments.resource;
  if (!arguments.from.empty()) {
    ASSIGN_OR_RETURN(filter.from, ParseTime("--from", arguments.from));
  }
  if (!arguments.to.empty()) {
    ASSIGN_OR_RETURN(filter.to, ParseTime("--to", arguments.to));
  }
  if (arguments.check) return CheckAudit(context);
  if (arguments.lines) return PrintAuditLines(context, filter);
  ASSIGN_OR_RETURN(client::Client * client, context.Connect());
  ASSIGN_OR_RETURN(const auto page, client->ListAudit(filter, {arguments.page_size, arguments.page}));
  std::vector<std::vector<std::string>> rows = {
      {"entry", "at (UTC)", "principal", "from", "action", "resource", "outcome", "was", "became", "detail"}};
  for (const client::AuditEntry& entry : page.rows) {
    rows.push_back({absl::StrCat(entry.number), TimeText(entry.at), entry.principal, entry.peer, entry.action,
                    entry.resource, entry.outcome, entry.was, entry.became, entry.detail});
  }
  context.Print(PageJson("entries", page), Table(rows) + PageText(page));
  return absl::OkStatus();
}

using Arguments = std::shared_ptr<AdminArguments>;

void AddPageOptions(CLI::App* command, const Arguments& arguments) {
  command->add_option("--page-size", arguments->page_size, "rows per page (1 to 1000)")->check(CLI::Range(1, 1000));
  command->add_option("--page", arguments->page, "token of the next page");
}

void AddPrincipalCommands(CLI::App* admin, Context& context, const Arguments& arguments) {
  CLI::App* principal = admin->add_subcommand("principal", "People and cells: add, list, revoke");
  principal->require_subcommand(1);
  CLI::App* add = principal->add_subcommand("add", "Add one; its certificate, if it has one, must name it so");
  add->add_option("NAME", arguments->name, "letters, digits, '.', '_', '@', '-'")->required();
  add->add_option("--note", arguments->note, "for people");
  SetAction(add, context, [&context, arguments] { return AddPrincipal(context, *arguments); });
  CLI::App* list = principal->add_subcommand("list", "List them with their roles and tokens");
  AddPageOptions(list, arguments);
  SetAction(list, context, [&context, arguments] { return ListPrincipals(context, *arguments); });
  CLI::App* revoke = principal->add_subcommand("revoke", "End one with all its tokens, for ever");
  revoke->add_option("NAME", arguments->name, "which one")->required();
  SetAction(revoke, context, [&context, arguments] { return RevokePrincipal(context, *arguments); });
}

void AddTokenCommands(CLI::App* admin, Context& context, const Arguments& arguments) {
  CLI::App* token = admin->add_subcommand("token", "Tokens: add, revoke");
  token->require_subcommand(1);
  CLI::App* add = token->add_subcommand("add", "Make a token; it is shown once");
  add->add_option("PRINCIPAL", arguments->name, "whose")->required();
  add->add_option("--days", arguments->days, "how long it is good (without: until it is revoked)")
      ->check(CLI::Range(1, 36500));
  add->add_option("--note", arguments->note, "for people");
  add->add_option("-o,--output", arguments->output, "write it into this file, for its owner alone, and do not show it");
  SetAction(add, context, [&context, arguments] { return AddToken(context, *arguments); });
  CLI::App* revoke = token->add_subcommand("revoke", "End one token");
  revoke->add_option("TOKEN", arguments->token, "its number (principal list)")->required()->check(PositiveNumber());
  SetAction(revoke, context, [&context, arguments] { return RevokeToken(context, *arguments); });
}

void AddRoleCommands(CLI::App* admin, Context& context, const Arguments& arguments) {
  CLI::App* role = admin->add_subcommand("role", "Roles: add, remove (viewer, cell, technician, approver, admin)");
  role->require_subcommand(1);
  std::vector<std::string> names;
  for (const records::Role one : records::kAllRoles) names.push_back(records::NameOf(one));
  for (const bool holds : {true, false}) {
    CLI::App* change = role->add_subcommand(holds ? "add" : "remove", holds ? "Give a role" : "Take a role away");
    change->add_option("PRINCIPAL", arguments->name, "whose")->required();
    change->add_option("ROLE", arguments->role, "which")->required()->check(CLI::IsMember(names));
    change->add_flag("--all", arguments->all, "for all machines, and the service itself");
    change->add_option("--group", arguments->group, "for the machines of this group");
    change->add_option("--machine", arguments->machine, "for this machine");
    change->footer("Example: axiscal admin role " + std::string(holds ? "add" : "remove") +
                   " cell-7 cell --machine mt");
    SetAction(change, context, [&context, arguments, holds] { return ChangeRole(context, *arguments, holds); });
  }
}

void AddAuditCommand(CLI::App* admin, Context& context, const Arguments& arguments) {
  CLI::App* audit = admin->add_subcommand("audit", "Who changed what, and which calls were denied; newest first");
  audit->add_option("--principal", arguments->name, "only of this principal");
  audit->add_option("--resource", arguments->resource, "only of this resource: calibrations/12, machines/mt");
  audit->add_option("--from", arguments->from, "at or after this time (UTC): 2026-05-31 or 2026-05-31T14:03:07");
  audit->add_option("--to", arguments->to, "before this time (UTC)");
  AddPageOptions(audit, arguments);
  audit->add_flag("--lines", arguments->lines, "all of them, each as one line of JSON");
  audit->add_flag("--check", arguments->check, "compare every entry with its hash; the first damaged one is named");
  SetAction(audit, context, [&context, arguments] { return ListAudit(context, *arguments); });
}

void AddGroupCommands(CLI::App* admin, Context& context, const Arguments& arguments) {
  CLI::App* group = admin->add_subcommand("group", "Groups of machines: add, remove, list");
  group->require_subcommand(1);
  for (const bool belongs : {true, false}) {
    CLI::App* change = group->add_subcommand(belongs ? "add" : "remove",
                                             belongs ? "Put machines into a group" : "Take machines out of a group");
    change->add_option("GROUP", arguments->group, "which")->required();
    change->add_option("MACHINE", arguments->machines, "the machines")->required();
    SetAction(change, context, [&context, arguments, belongs] { return ChangeGroup(context, *arguments, belongs); });
  }
  CLI::App* list = group->add_subcommand("list", "List the machines with their groups");
  AddPageOptions(list, arguments);
  SetAction(list, context, [&context, arguments] { return ListGroups(context, *arguments); });
  CLI::App* four_eyes = admin->add_subcommand("four-eyes", "Whether another person approves than identified");
  four_eyes->add_option("MACHINE", arguments->machine, "the machine")->required();
  four_eyes->add_option("STATE", arguments->on_off, "on or off")->required()->check(CLI::IsMember({"on", "off"}));
  SetAction(four_eyes, context, [&context, arguments] { return FourEyes(context, *arguments); });
}

}  // namespace

void AddAdminCommand(CLI::App& app, Context& context) {
  auto arguments = std::make_shared<AdminArguments>();
  CLI::App* admin = app.add_subcommand("admin", "Who may do what: principals, tokens, roles, groups; the server's log");
  admin->require_subcommand(1);
  CLI::App* whoami = admin->add_subcommand("whoami", "Say whom the server takes you for");
  SetAction(whoami, context, [&context] { return WhoAmI(context); });
  CLI::App* level =
      admin->add_subcommand("log-level", "What the server writes to its log from now on, or what it does");
  level->add_option("LEVEL", arguments->name, "debug, info, warning, error; without it nothing is changed")
      ->check(CLI::IsMember({"debug", "info", "warning", "error"}));
  SetAction(level, context, [&context, arguments] { return LogLevel(context, *arguments); });
  AddPrincipalCommands(admin, context, arguments);
  AddTokenCommands(admin, context, arguments);
  AddRoleCommands(admin, context, arguments);
  AddGroupCommands(admin, context, arguments);
  AddAuditCommand(admin, context, arguments);
  AddWebhookCommands(admin, context);
  admin->footer(
      "The first admin is made on the database file while no server has it:\n"
      "  axiscal --db FILE admin principal add ann && axiscal --db FILE admin role add ann admin --all\n"
      "  axiscal --db FILE admin token add ann -o ann.token");
}

}  // namespace axiscal::cli
