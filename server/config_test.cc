#include "server/config.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <fstream>
#include <sstream>

#include "core/base/error_detail.h"
#include "core/base/testing/source_path.h"

namespace axiscal::server {
namespace {

using ::testing::HasSubstr;

std::string FileText(const std::string& path) {
  std::ostringstream text;
  text << std::ifstream(base::SourcePath("/" + path)).rdbuf();
  return text.str();
}

std::string Refusal(const std::string& toml) {
  Configured configured;
  const absl::Status status = ReadToml(toml, "etc/axiscald.toml", configured);
  EXPECT_EQ(status.code(), absl::StatusCode::kInvalidArgument) << toml;
  EXPECT_TRUE(configured.place.empty()) << toml;
  return std::string(status.message());
}

TEST(Config, FileEnvironmentAndFlagsOverrideEachOther) {
  Configured configured;
  ASSERT_TRUE(ReadToml("[store]\ndatabase = '/var/a.db'\n[jobs]\nworkers = 3\n[server]\nlisten = \"[::1]:1\"\n"
                       "[log]\njson = true\n",
                       "/etc/x.toml", configured)
                  .ok());
  ASSERT_TRUE(
      ReadEnvironment({"HOME=/", "AXISCALD_WORKERS=4", "AXISCALD_LISTEN=localhost:2", "AXISCALD_CONFIG=x"}, configured)
          .ok());
  ASSERT_TRUE(SetText(Settings()[1], "127.0.0.1:3", "--listen", configured).ok());
  EXPECT_EQ(Settings()[1].key, "server.listen");
  EXPECT_EQ(configured.config.database, "/var/a.db");
  EXPECT_EQ(configured.config.workers, 4);
  EXPECT_EQ(configured.config.listen, "127.0.0.1:3");
  EXPECT_TRUE(configured.config.log_json);
  EXPECT_EQ(configured.place["store.database"], "/etc/x.toml:2");
  EXPECT_EQ(configured.place["jobs.workers"], "AXISCALD_WORKERS");
  EXPECT_EQ(configured.place["server.listen"], "--listen");
  EXPECT_FALSE(configured.place.contains("limits.idle_seconds"));
  EXPECT_TRUE(Check(configured).ok());
}

TEST(Config, LettersOutsideOfTextsAreRefusedWithTheirLine) {
  for (const std::string letter :
       {"\xC2\xA1", "\xC3\xBC", "\xC9\xBF", "\xE2\x82\xAC", "\xEF\xBB\xBF", "\xF0\x9F\x98\x80"}) {
    for (const std::string& text :
         {"jobs.workers = 3" + letter, letter + " = 3", "jobs." + letter + " = 3", "jobs.workers = 0" + letter + "1",
          "[jobs" + letter + "]", "a = 1979-05-27T0" + letter})
      EXPECT_THAT(Refusal("store.database = 'a.db'\n" + text + "\n"), HasSubstr("axiscald.toml:2")) << text;
  }
}

TEST(Config, RelativeFilesStandBesideTheConfiguration) {
  Configured configured;
  ASSERT_TRUE(ReadToml("store.database = 'a.db'", "/etc/axiscal/x.toml", configured).ok());
  EXPECT_EQ(configured.config.database, "/etc/axiscal/a.db");
  ASSERT_TRUE(SetText(Settings()[0], "a.db", "--db", configured).ok());
  EXPECT_EQ(configured.config.database, "a.db");
}

TEST(Config, RefusalsNameFileLineKeyAndRule) {
  EXPECT_EQ(
      Refusal("\n[server]\nlisen = 'x'\n"),
      "etc/axiscald.toml:3: unknown key server.lisen; known keys here: listen, http, drain_seconds, ask_identity");
  EXPECT_THAT(Refusal("[sever]\nlisten = 'x'\n"),
              HasSubstr("etc/axiscald.toml:1: unknown key sever; known tables "
                        "here: store, server, tls, jobs, limits, webhooks, mail, backup, retention, metrics, log"));
  EXPECT_THAT(Refusal("jobs = 3"), HasSubstr("etc/axiscald.toml:1: jobs must be a table with the keys workers"));
  EXPECT_THAT(Refusal("[[jobs]]\nworkers = 3"), HasSubstr("jobs must be a table"));
  EXPECT_EQ(Refusal("[jobs]\n\nworkers = 0"), "etc/axiscald.toml:3: jobs.workers = 0, must be 1 to 1024");
  EXPECT_THAT(Refusal("[jobs]\nworkers = '2'"), HasSubstr(":2: jobs.workers must be a whole number of 1 to 1024"));
  EXPECT_THAT(Refusal("[jobs]\nworkers = 2.0"), HasSubstr("must be a whole number"));
  EXPECT_THAT(Refusal("[jobs]\nworkers.x = 2"), HasSubstr("must be a whole number"));
  EXPECT_THAT(Refusal("[log]\njson = 'yes'"), HasSubstr(":2: log.json must be true or false"));
  EXPECT_THAT(Refusal("[server]\nlisten = 7410"), HasSubstr(":2: server.listen must be a text in quotes"));
  EXPECT_THAT(Refusal("[server]\nlisten = ''"), HasSubstr("must be a text that is not empty"));
  EXPECT_THAT(Refusal("[jobs]\nworkers = 2\nworkers = 3\n"), HasSubstr("etc/axiscald.toml:3: "));
  EXPECT_THAT(Refusal("[jobs\n"), HasSubstr("etc/axiscald.toml:1: "));
  EXPECT_THAT(Refusal("[server]\nlisten = \"\xff\"\n"), HasSubstr("etc/axiscald.toml:2: "));
  EXPECT_THAT(Refusal("[jobs]\nworkers = 99999999999999999999\n"), HasSubstr("etc/axiscald.toml:2: "));
  EXPECT_THAT(Refusal(std::string(10'000, '[')), HasSubstr("etc/axiscald.toml:1: "));
}

TEST(Config, AWrongFileChangesNothing) {
  Configured configured;
  EXPECT_FALSE(ReadToml("[jobs]\nworkers = 7\n[log]\njson = 1\n", "x", configured).ok());
  EXPECT_EQ(configured.config.workers, Config().workers);
  EXPECT_TRUE(configured.place.empty());
}

TEST(Config, UnknownVariablesAndWrongValuesAreRefused) {
  Configured configured;
  EXPECT_THAT(ReadEnvironment({"AXISCALD_LISTN=x"}, configured).message(), HasSubstr("AXISCALD_LISTN is no setting"));
  EXPECT_EQ(ReadEnvironment({"AXISCALD_WORKERS=many"}, configured).message(),
            "AXISCALD_WORKERS: jobs.workers = many, must be 1 to 1024");
  EXPECT_EQ(ReadEnvironment({"AXISCALD_LOG_JSON=1"}, configured).message(),
            "AXISCALD_LOG_JSON: log.json = 1, must be true or false");
}

// Whoever reaches the port can approve a calibration.
TEST(Config, AddressesThatOtherMachinesReachAreRefusedWithTheWayOut) {
  for (const std::string address :
       {"0.0.0.0:7410", "[::]:7410", "192.0.2.1:7410", "dns:0.0.0.0:1", "[::ffff:192.0.2.1]:1"}) {
    Configured configured;
    configured.config.database = "a.db";
    ASSERT_TRUE(ReadToml("\nserver.listen = '" + address + "'", "x.toml", configured).ok());
    const absl::Status status = Check(configured);
    EXPECT_EQ(base::ErrorReason(status), "LISTEN_UNPROTECTED") << address << status;
    EXPECT_THAT(status.message(), HasSubstr("x.toml:2: server.listen: " + address + ", can be reached"));
    EXPECT_THAT(status.message(), HasSubstr("127.0.0.1:PORT"));
  }
  for (const std::string address : {"127.0.0.1:0", "127.1.2.3:7", "[::1]:7410", "[::ffff:127.0.0.1]:1", "localhost:1",
                                    "unix:/run/a.sock", "unix-abstract:a"}) {
    Configured configured;
    configured.config.database = "a.db";
    configured.config.listen = address;
    EXPECT_TRUE(Check(configured).ok()) << address << Check(configured);
  }
}

TEST(Config, HttpIsHeldToTheSameRule) {
  Configured configured;
  configured.config.database = "a.db";
  ASSERT_TRUE(ReadToml("[server]\nhttp = '0.0.0.0:7480'", "x.toml", configured).ok());
  const absl::Status status = Check(configured);
  EXPECT_EQ(base::ErrorReason(status), "LISTEN_UNPROTECTED") << status;
  EXPECT_THAT(status.message(), HasSubstr("x.toml:2: server.http: 0.0.0.0:7480, can be reached"));
  configured.config.http = "[::1]:7480";
  EXPECT_TRUE(Check(configured).ok()) << Check(configured);
}

TEST(Config, CertificateAndKeyComeTogether) {
  const std::pair<std::string, std::string> wrong[] = {
      {"tls.certificate = 'a.crt'", "etc/x.toml:1: tls.certificate is set, tls.certificate and tls.key must be set"},
      {"\ntls.key = 'a.key'", "etc/x.toml:2: tls.key is set, tls.certificate and tls.key must be set"},
      {"tls.client_ca = 'ca.crt'", "etc/x.toml:1: tls.client_ca is set, must come with tls.certificate and tls.key"},
      {"[tls]\ncertificate = 'none.crt'\nkey = 'none.key'", "etc/x.toml:2: tls: etc/none.crt"}};
  for (const auto& [toml, text] : wrong) {
    Configured configured;
    configured.config.database = "a.db";
    ASSERT_TRUE(ReadToml(toml, "etc/x.toml", configured).ok()) << toml;
    EXPECT_THAT(Check(configured).message(), HasSubstr(text)) << toml;
  }
}

TEST(Config, WebhooksMayCallAddressesAndNoNames) {
  Configured configured;
  configured.config.database = "a.db";
  ASSERT_TRUE(ReadToml("[webhooks]\nallowed = '127.0.0.1:8080, localhost'", "x.toml", configured).ok());
  EXPECT_THAT(Check(configured).message(), HasSubstr("x.toml:2: webhooks.allowed: 'localhost' is no address"));
  configured.config.webhooks_allowed = "127.0.0.1:8080, ::1";
  EXPECT_TRUE(Check(configured).ok()) << Check(configured);
  configured.config.webhooks_ca = "none.crt";
  EXPECT_THAT(Check(configured).message(), HasSubstr("webhooks.ca: none.crt"));
}

TEST(Config, TheDatabaseMustBeNamed) { EXPECT_THAT(Check({}).message(), HasSubstr("store.database is not set")); }

TEST(Config, TheShippedFileIsRightAndNamesEveryKey) {
  const std::string text = FileText("deploy/axiscald.toml");
  Configured configured;
  const absl::Status status = ReadToml(text, "/etc/axiscald.toml", configured);
  ASSERT_TRUE(status.ok()) << status;
  EXPECT_TRUE(Check(configured).ok()) << Check(configured);
  // What it shows as defaults are the defaults.
  std::string shown = text;
  for (size_t at = 0; (at = shown.find("\n# ", at)) != std::string::npos; ++at) {
    const size_t equals = shown.find(" = ", at), end = shown.find('\n', at + 1);
    if (equals < end) shown.erase(at + 1, 2);
  }
  ASSERT_TRUE(ReadToml(shown, "/etc/axiscald.toml", configured).ok());
  for (const Setting& setting : Settings()) {
    EXPECT_TRUE(configured.place.contains(setting.key)) << setting.key;
    // Files have no default, and what is off has none.
    if (setting.is_path || ValueText(setting, Config()).empty()) continue;
    EXPECT_EQ(ValueText(setting, configured.config), ValueText(setting, Config())) << setting.key;
  }
}

TEST(Config, ThePageTellsEverySettingAsItIs) {
  const std::string page = FileText("docs/configuration.md");
  for (const Setting& setting : Settings()) {
    const std::string value = ValueText(setting, Config());
    EXPECT_THAT(page, HasSubstr("| `" + setting.key + "` | `" + setting.flag + "` | `" + EnvironmentName(setting) +
                                "` | " + (value.empty() ? "" : "`" + value + "` ") + "| " + setting.meaning + " |\n"));
  }
}

}  // namespace
}  // namespace axiscal::server
