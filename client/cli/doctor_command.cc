// axiscal doctor: is all well between here and the service, and there; what to do where it is not.
#include <sys/stat.h>
#include <unistd.h>

#include <CLI/CLI.hpp>
#include <cerrno>
#include <cmath>
#include <cstring>
#include <memory>

#include "client/cli/commands.h"
#include "client/cli/context.h"
#include "client/cli/record_output.h"
#include "client/cli/tls_probe.h"
#include "core/base/error_detail.h"

namespace axiscal::cli {
namespace {

using records::Finding;
using records::FindingState;

// Marks may be 10 minutes ahead of the server's clock; people compare logs of two machines by the second.
constexpr double kSkewWarning_s = 5.0, kSkewFailed_s = 600.0;
constexpr int kDaysAhead = 14;
constexpr char kIdentityAdvice[] =
    "a token (--token-file) or certificate (--certificate, --key) of a principal that the server knows: axiscal admin "
    "token add NAME";

std::string WordOf(FindingState state) {
  switch (state) {
    case FindingState::kOk:
      return "ok";
    case FindingState::kWarning:
      return "WARNING";
    case FindingState::kFailed:
      return "FAILED";
    case FindingState::kUnknown:
      return "unknown";
  }
  return "unknown";
}

// Nothing was said of TLS, and TLS is what the other side speaks: it closes the connection.
std::string AdviceForNoAnswer(const Context& context, const TlsProbe& probe) {
  if (probe.has_no_address)
    return "is the name right (--server, AXISCAL_SERVER)? This machine finds no address for it: DNS, /etc/hosts";
  if (!probe.error.empty()) {
    return "is the address right (--server, AXISCAL_SERVER), does a firewall stand between? On the server: systemctl "
           "status axiscald; it must listen there (server.listen), not on 127.0.0.1 alone";
  }
  if (context.identity.ca.empty() && probe.speaks_tls)
    return "the server speaks TLS: name its authority by --ca (AXISCAL_CA)";
  if (!context.identity.ca.empty() && !probe.speaks_tls)
    return "the server does not speak TLS: leave --ca out, or set tls.certificate and tls.key on the server; or it "
           "closes each connection because its descriptors are used up: journalctl -u axiscald -n 50, LimitNOFILE= "
           "of its unit";
  if (!probe.refused.empty()) return "see 'server's certificate, from here'";
  return "something else than axiscald may listen there; on the server: journalctl -u axiscald -n 50";
}

void AddPath(const Context& context, const TlsProbe& probe, std::vector<Finding>& findings) {
  if (!probe.error.empty()) {
    findings.push_back({"way to the server", FindingState::kFailed, context.server + ": " + probe.error,
                        AdviceForNoAnswer(context, probe)});
    return;
  }
  findings.push_back({"way to the server", FindingState::kOk,
                      absl::StrFormat("%s takes connections, %.1f ms", context.server, probe.connect_ms), ""});
  if (!probe.speaks_tls) return;
  const std::string text = absl::StrCat(probe.subject, ", ends in ", probe.days_left, " days");
  if (!probe.refused.empty()) {
    findings.push_back({"server's certificate, from here", FindingState::kFailed, probe.subject + ": " + probe.refused,
                        probe.is_out_of_time
                            ? "is this machine's clock right (timedatectl)? Else make-certs ... --renew on the server"
                            : "call the server by a name that stands in its certificate, with the authority that "
                              "signed it (--ca)"});
  } else {
    findings.push_back({"server's certificate, from here",
                        probe.days_left >= kDaysAhead ? FindingState::kOk : FindingState::kWarning, text,
                        probe.days_left >= kDaysAhead ? "" : "make-certs ... --renew on the server"});
  }
}

// What this side shows: its certificate's time, and who may read its secrets.
void AddOwnFiles(const Context& context, std::vector<Finding>& findings) {
  if (!context.identity.certificate.empty()) {
    const absl::StatusOr<int> days = DaysLeftOf(context.identity.certificate);
    Finding own{"own certificate", FindingState::kOk, "", ""};
    if (!days.ok()) {
      own = {own.what, FindingState::kFailed, std::string(days.status().message()), "make-certs pki client NAME"};
    } else {
      own.text = *days < 0 ? context.identity.certificate + " has ended"
                           : absl::StrCat(context.identity.certificate, " ends in ", *days, " days");
      if (*days < kDaysAhead) {
        own.state = *days < 0 ? FindingState::kFailed : FindingState::kWarning;
        own.advice = "make-certs pki client NAME --renew";
      }
    }
    findings.push_back(own);
  }
  std::string open, lacking;
  for (const std::string& file : {context.identity.key, context.identity.token_file}) {
    struct stat info {};
    if (file.empty()) continue;
    if (::access(file.c_str(), R_OK) != 0 || stat(file.c_str(), &info) != 0) {
      absl::StrAppend(&lacking, lacking.empty() ? "" : ", ", file, ": ", std::strerror(errno));
    } else if ((info.st_mode & 0007) != 0) {
      absl::StrAppend(&open, open.empty() ? "" : ", ", absl::StrFormat("%s (%04o)", file, info.st_mode & 07777));
    }
  }
  if (!lacking.empty()) {
    findings.push_back({"own secrets", FindingState::kFailed, lacking,
                        "name files that you may read (--key, --token-file); a new token: axiscal admin token add NAME "
                        "-o FILE"});
  } else if (!context.identity.key.empty() || !context.identity.token_file.empty()) {
    findings.push_back(open.empty() ? Finding{"own secrets", FindingState::kOk, "key and token are yours alone", ""}
                                    : Finding{"own secrets", FindingState::kWarning,
                                              "everybody on this machine may read " + open, "chmod 600 on each"});
  }
}

// The server's clock and ours; its answer is about half a round trip old.
Finding ClockFinding(double skew_s, double round_trip_s) {
  const std::string text = absl::StrFormat("this clock is %.1f s %s the server's, give or take %.1f s",
                                           std::abs(skew_s), skew_s >= 0 ? "ahead of" : "behind", round_trip_s / 2);
  if (std::abs(skew_s) <= kSkewWarning_s + round_trip_s / 2) return {"clocks", FindingState::kOk, text, ""};
  return {"clocks", std::abs(skew_s) > kSkewFailed_s ? FindingState::kFailed : FindingState::kWarning, text,
          "timedatectl set-ntp true on both; times of sessions and marks, tokens and certificates hang on it"};
}

void AddVersions(const client::ServerInfo& info, std::vector<Finding>& findings) {
  const bool is_same = info.software_version == AXISCAL_VERSION;
  findings.push_back({"versions", is_same ? FindingState::kOk : FindingState::kWarning,
                      absl::StrCat("axiscal ", AXISCAL_VERSION, ", axiscald ", info.software_version, ", schema ",
                                   info.schema_version),
                      is_same ? "" : "install the same version on both; the server first"});
}

Finding Refusal(const std::string& what, const absl::Status& status, const std::string& advice) {
  return {what, FindingState::kFailed, std::string(status.message()), advice};
}

void AddServer(client::Client& client, std::vector<Finding>& findings) {
  const absl::StatusOr<records::PrincipalRecord> identity = client.GetIdentity();
  if (!identity.ok()) {
    findings.push_back(Refusal("identity", identity.status(), kIdentityAdvice));
    return;
  }
  std::string roles;
  for (const records::Grant& grant : identity->grants)
    absl::StrAppend(&roles, roles.empty() ? ", " : "; ", GrantText(grant));
  findings.push_back({"identity", FindingState::kOk, "the server takes you for " + identity->name + roles, ""});
  const base::UtcTime before = base::SystemClock().UtcNow();
  const auto diagnosis = client.Diagnose();
  const base::UtcTime after = base::SystemClock().UtcNow();
  if (!diagnosis.ok()) {
    findings.push_back({"server's own side", FindingState::kUnknown, std::string(diagnosis.status().message()),
                        absl::IsPermissionDenied(diagnosis.status())
                            ? "ask as a viewer of all machines: axiscal admin role add NAME viewer --all"
                            : "journalctl -u axiscald -n 50 on the server"});
    return;
  }
  const double round_trip_s = std::chrono::duration<double>(after - before).count();
  const base::UtcTime middle = before + (after - before) / 2;
  findings.push_back(ClockFinding(std::chrono::duration<double>(middle - diagnosis->now).count(), round_trip_s));
  findings.insert(findings.end(), diagnosis->findings.begin(), diagnosis->findings.end());
}

absl::Status Doctor(Context& context) {
  std::vector<Finding> findings;
  TlsProbe probe;
  if (!context.server.empty()) {
    context.Note("looks for " + context.server + " ...");
    probe = ProbeServer(context.server, context.identity.ca);
    AddPath(context, probe, findings);
    AddOwnFiles(context, findings);
  }
  absl::Status reached;
  if (probe.error.empty()) {
    const absl::StatusOr<client::Client*> client = context.Connect();
    const absl::StatusOr<client::ServerInfo> info =
        client.ok() ? (*client)->GetServerInfo() : absl::StatusOr<client::ServerInfo>(client.status());
    if (absl::IsUnauthenticated(info.status())) {
      findings.push_back(Refusal("identity", info.status(), kIdentityAdvice));
    } else if (absl::IsNotFound(info.status())) {
      findings.push_back(Refusal("answer", info.status(), "it was not asked: a file that is named here is missing"));
    } else if (!info.ok()) {
      reached = info.status();
      findings.push_back(Refusal("answer", info.status(), AdviceForNoAnswer(context, probe)));
    } else {
      AddVersions(*info, findings);
      AddServer(**client, findings);
    }
  } else {
    reached = base::Error(absl::StatusCode::kUnavailable, "no way to " + context.server, {"NO_CONNECTION", {}});
  }
  Json json = Json::Array();
  std::vector<std::vector<std::string>> rows;
  std::string advice;
  int bad = 0;
  for (const Finding& finding : findings) {
    json.push_back(
        {{"what", finding.what}, {"state", WordOf(finding.state)}, {"text", finding.text}, {"advice", finding.advice}});
    rows.push_back({WordOf(finding.state), finding.what, finding.text});
    if (finding.state == FindingState::kWarning || finding.state == FindingState::kFailed) ++bad;
    if (!finding.advice.empty()) absl::StrAppend(&advice, "\n", finding.what, ": ", finding.advice);
  }
  context.Print({{"findings", json}}, Table(rows) + (advice.empty() ? "all is well\n" : "what to do:" + advice + "\n"));
  RETURN_IF_ERROR(reached);
  if (bad == 0) return absl::OkStatus();
  return absl::FailedPreconditionError(absl::StrCat(bad, " of ", findings.size(), " are not well"));
}

}  // namespace

void AddDoctorCommand(CLI::App& app, Context& context) {
  CLI::App* doctor = app.add_subcommand("doctor",
                                        "Look at what can be wrong: connection, certificates, clocks, versions, "
                                        "database, disk, permissions, descriptors, "
                                        "the last backup, cells that say nothing; each with what to do");
  doctor->footer(
      "Exit code 0: all is well; 5: something is not; 6: the server cannot be reached.\nExample: axiscal --server "
      "axiscal.shop:7410 --ca ca.crt --token-file ann.token doctor");
  SetAction(doctor, context, [&context] { return Doctor(context); });
}

}  // namespace axiscal::cli
