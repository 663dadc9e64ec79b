#include "client/cli/log_form.h"

#include <CLI/CLI.hpp>
#include <algorithm>
#include <filesystem>

#include "core/base/files.h"
#include "core/logs/log_template.h"
#include "core/session/read_session.h"

namespace axiscal::cli {

void AddLogFormOptions(CLI::App* command, LogFormArguments& arguments) {
  CLI::Option* const form = command->add_option(
      "--template", arguments.log_template,
      "the paths are controllers' logs, which the server reduces and keeps: a template (docs/logs.md), or dprnt, "
      "linuxcnc-probe or sinumerik-write together with --plan");
  command->add_option("--plan", arguments.plan, "of logs: the planned session that was run")->needs(form);
  command->add_option("--session", arguments.session, "of a log: name of the session")->needs(form);
  command->add_option("--start-s", arguments.start_s, "of a log: t_s of the first reading where it has no times")
      ->needs(form);
}

absl::StatusOr<records::LogForm> ReadLogForm(const LogFormArguments& arguments) {
  records::LogForm form;
  form.session = arguments.session;
  form.start_s = arguments.start_s;
  const std::vector<std::string>& known = logs::KnownFormats();
  if (std::find(known.begin(), known.end(), arguments.log_template) != known.end()) {
    form.template_text = arguments.log_template;
  } else {
    ASSIGN_OR_RETURN(form.template_text, base::ReadFile(arguments.log_template, records::kMaxTemplateBytes));
    form.template_name = std::filesystem::path(arguments.log_template).filename().string();
  }
  if (arguments.plan.empty()) return form;
  ASSIGN_OR_RETURN(form.plan_text, base::ReadFile(arguments.plan, records::kMaxPlanBytes));
  form.plan_name = std::filesystem::path(arguments.plan).filename().string();
  return form;
}

absl::StatusOr<MachineId> MachineOf(const records::LogForm& form) {
  std::vector<session::HeaderEntry> header;
  if (!form.plan_text.empty()) {
    ASSIGN_OR_RETURN(const session::Session plan, session::ReadPlanText(form.plan_text, form.plan_name));
    header = plan.header;
  } else {
    ASSIGN_OR_RETURN(const logs::LogTemplate rules, logs::ReadTemplate(form.template_text, form.template_name));
    header = rules.header;
  }
  const std::optional<std::string> machine = session::FindHeader({header, {}}, "machine");
  if (machine) return MachineId(*machine);
  return absl::InvalidArgumentError(
      "which machine was measured? Neither template nor plan says '# machine: ...', "
      "expected --machine");
}

}  // namespace axiscal::cli
