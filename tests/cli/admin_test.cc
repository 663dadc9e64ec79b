// Who may do what, as a plant's people would meet it: certificates and tokens, a cell, a technician and an approver,
// each refused what is not theirs.
#include <gmock/gmock.h>
#include <signal.h>
#include <sys/stat.h>

#include "tests/cli/command_line.h"
#include "tests/end_to_end/testing/process.h"

namespace axiscal {
namespace {

using ::testing::HasSubstr;
using testing::Outcome;
using testing::ServerProcess;
using testing::Source;

class Plant : public testing::CommandLine {
 protected:
  void SetUp() override {
    std::filesystem::copy(Source("deploy/examples/integrex"), folder_);
    std::string json = Read("machine.json");
    json.replace(json.find("integrex-i200"), 13, "other-machine");
    Write("other.json", json);
    for (const std::string words : {"ca", "server localhost 127.0.0.1", "client cell-7", "client stranger"}) {
      const std::string command = Source("deploy/make-certs") + " '" + File("pki") + "' " + words + " >/dev/null";
      ASSERT_EQ(std::system(command.c_str()), 0) << command;
    }
    // On the file, while no server has it.
    Ok("machine add machine.json");
    Ok("machine add other.json");
    Ok("admin principal add ann --note 'shop IT'");
    Ok("admin role add ann admin --all");
    Ok("admin token add ann -o ann.token");
    auto started = ServerProcess::Start(File("axiscal.db"), "127.0.0.1:0", File("log"),
                                        {"--tls-certificate", File("pki/server/localhost.crt"), "--tls-key",
                                         File("pki/server/localhost.key"), "--tls-client-ca", File("pki/ca.crt")});
    ASSERT_TRUE(started.ok()) << started.status();
    server_.emplace(*std::move(started));
  }
  std::string File(const std::string& name) const { return (folder_ / name).string(); }
  Outcome Ok(const std::string& arguments) const {
    Outcome outcome = Run(arguments);
    EXPECT_EQ(outcome.exit_code, 0) << arguments << ": " << outcome.err;
    return outcome;
  }
  std::string Server() const { return "--server " + server_->address() + " --ca pki/ca.crt "; }
  std::string As(const std::string& person) const { return Server() + "--token-file " + person + ".token "; }
  std::string WithCertificate(const std::string& name) const {
    return Server() + "--certificate pki/client/" + name + ".crt --key pki/client/" + name + ".key ";
  }
  void AddPerson(const std::string& name, const std::string& role) const {
    Ok(As("ann") + "admin principal add " + name);
    Ok(As("ann") + "admin role add " + name + " " + role);
    Ok(As("ann") + "admin token add " + name + " --days 365 -o " + name + ".token");
  }

  std::optional<ServerProcess> server_;
};

constexpr int kRefused = 5, kNotFound = 4;

TEST_F(Plant, EachDoesHisPartAndNobodyElses) {
  struct stat info = {};
  ASSERT_EQ(stat(File("ann.token").c_str(), &info), 0);
  EXPECT_EQ(info.st_mode & 0777, 0600u);
  EXPECT_THAT(Ok(As("ann") + "admin whoami").out, HasSubstr("ann: admin of all machines"));
  Ok(As("ann") + "admin principal add cell-7");
  Ok(As("ann") + "admin role add cell-7 cell --machine integrex-i200");
  Ok(As("ann") + "admin group add turning integrex-i200");
  AddPerson("bob", "technician --group turning");
  AddPerson("eve", "approver --machine integrex-i200");
  Ok(As("ann") + "admin four-eyes integrex-i200 on");

  // The cell by its certificate, for its own machine.
  EXPECT_THAT(Ok(WithCertificate("cell-7") + "admin whoami").out, HasSubstr("cell-7: cell of machine integrex-i200"));
  Ok(WithCertificate("cell-7") + "upload B-short-run1.csv B-long-run1.csv B-short-run2.csv B-long-run2.csv");
  std::string csv = Read("B-short-run1.csv");
  csv.replace(csv.find("integrex-i200"), 13, "other-machine");
  Write("elsewhere.csv", csv);
  const Outcome elsewhere = Run(WithCertificate("cell-7") + "upload elsewhere.csv");
  EXPECT_EQ(elsewhere.exit_code, kNotFound) << elsewhere.err;
  EXPECT_THAT(elsewhere.err, HasSubstr("machine other-machine does not exist"));
  EXPECT_EQ(Run(WithCertificate("stranger") + "session list").exit_code, kRefused);
  EXPECT_THAT(Run(Server() + "session list").err, HasSubstr("IDENTITY_MISSING"));

  // The technician identifies, and may not approve.
  const Outcome identified =
      Ok(As("bob") +
         "identify --machine integrex-i200 --sessions B-short-run1,B-long-run1,B-short-run2,B-long-run2 "
         "--declare EZ0T,EX0T --json");
  EXPECT_EQ(identified.Json()["created_by"], "bob");
  const std::string id = std::to_string(identified.Json()["id"].get<int>());
  const Outcome denied = Run(As("bob") + "approve " + id);
  EXPECT_EQ(denied.exit_code, kRefused);
  EXPECT_THAT(denied.err, HasSubstr("bob may not call Calibrations.ApproveCalibration: it needs the role approver"));
  // Neither may he once he is an approver too: four eyes.
  Ok(As("ann") + "admin role add bob approver --all");
  EXPECT_THAT(Run(As("bob") + "approve " + id).err, HasSubstr("FOUR_EYES"));
  EXPECT_THAT(Ok(As("eve") + "--user bob approve " + id + " --reason 'as after the service'").out,
              HasSubstr("is approved by eve"));
  Ok(As("bob") +
     "compensate --machine integrex-i200 --dialect mazak --unit mm --tool-tip '0 0 -356.3945' --max-correction-um 5000 "
     "fig-4.30-original.nc -o out.nc");

  // What bob cannot see is not there.
  EXPECT_EQ(Ok(As("bob") + "machine list --json").Json()["machines"].size(), 2u);  // approver of all is a viewer of all
  Ok(As("ann") + "admin role remove bob approver --all");
  EXPECT_EQ(Ok(As("bob") + "machine list --json").Json()["machines"].size(), 1u);
  EXPECT_EQ(Run(As("bob") + "machine show other-machine").exit_code, kNotFound);

  // Revoked: by the next call.
  Ok(As("ann") + "admin principal revoke cell-7");
  const Outcome revoked = Run(WithCertificate("cell-7") + "upload B-short-run1.csv");
  EXPECT_EQ(revoked.exit_code, kRefused) << revoked.err;
  EXPECT_THAT(revoked.err, HasSubstr("PRINCIPAL_UNKNOWN"));
  EXPECT_THAT(Ok(As("ann") + "admin audit --resource calibrations/" + id).out,
              AllOf(HasSubstr("eve"), HasSubstr("ipv4:127.0.0.1"), HasSubstr("calibration.approve"),
                    HasSubstr("as after the service")));
  // Out of use, with a reason too; a reason that is no text changes nothing.
  EXPECT_THAT(Run(As("eve") + "calibration retire " + id + " --reason '" + std::string(201, 'x') + "'").err,
              HasSubstr("reason"));
  EXPECT_THAT(Ok(As("eve") + "calibration list").out, HasSubstr("approved"));
  EXPECT_THAT(Ok(As("eve") + "calibration retire " + id + " --reason 'the ball was loose'").out,
              HasSubstr("nothing of this machine is corrected"));
  EXPECT_THAT(Ok(As("ann") + "admin audit --resource calibrations/" + id).out, HasSubstr("the ball was loose"));
  Ok(As("eve") + "approve " + id);
  EXPECT_THAT(Ok(As("ann") + "admin audit --check").out, HasSubstr("is whole"));
  const std::string lines = Ok(As("ann") + "admin audit --lines").out;
  EXPECT_TRUE(nlohmann::json::accept(lines.substr(0, lines.find('\n')))) << lines;
  const Outcome list = Ok(As("ann") + "admin principal list");
  EXPECT_THAT(list.out, HasSubstr("technician of group turning"));
  EXPECT_THAT(list.out, Not(HasSubstr("axt_")));

  // A copy, and the plug is pulled: what was acknowledged is there. One byte that changes is named, and a backup helps.
  EXPECT_EQ(Run(As("bob") + "backup -o copy.db").exit_code, kRefused);
  EXPECT_THAT(Run(As("ann") + "backup").err, HasSubstr("BACKUP_FOLDER_MISSING"));
  EXPECT_THAT(Ok(As("ann") + "backup -o copy.db").out, HasSubstr("copy.db: "));
  struct stat copy = {};
  ASSERT_EQ(stat(File("copy.db").c_str(), &copy), 0);
  EXPECT_EQ(copy.st_mode & 0777, 0600u);  // it holds the hashes of tokens
  server_->Signal(SIGKILL);
  server_->Wait();
  std::string output;
  EXPECT_EQ(testing::RunProgram({AXISCALD_PATH, "check", File("axiscal.db")}, &output), 0) << output;
  EXPECT_THAT(output, HasSubstr("1 calibrations"));
  EXPECT_THAT(output, HasSubstr("\nwhole\n"));
  std::string bytes = Read("axiscal.db");
  const size_t at = bytes.rfind("calibration.approve");
  ASSERT_NE(at, std::string::npos);
  bytes[at] = 'C';
  Write("axiscal.db", bytes);
  EXPECT_EQ(testing::RunProgram({AXISCALD_PATH, "check", File("axiscal.db")}, &output), 2) << output;
  EXPECT_THAT(output, HasSubstr("DAMAGED audit: audit entry "));
  EXPECT_THAT(output, HasSubstr("is not what was written"));
  EXPECT_EQ(testing::RunProgram({AXISCALD_PATH, "--db", File("axiscal.db"), "restore", File("copy.db")}, &output), 0)
      << output;
  EXPECT_EQ(testing::RunProgram({AXISCALD_PATH, "--db", File("axiscal.db"), "check"}, &output), 0) << output;
  EXPECT_EQ(testing::RunProgram({AXISCALD_PATH, "compact", File("axiscal.db")}, &output), 0) << output;
  EXPECT_THAT(Ok("--db axiscal.db calibration list").out, HasSubstr("approved"));
}

TEST_F(Plant, ATokenIsShownOnceAndRolesNeedOneScope) {
  const Outcome shown = Ok(As("ann") + "admin token add ann --json");
  EXPECT_THAT(shown.Json()["secret"].get<std::string>(), HasSubstr("axt_"));
  EXPECT_THAT(Run(As("ann") + "admin role add ann viewer").err,
              HasSubstr("exactly one of --all, --group and --machine"));
  EXPECT_NE(Run(As("ann") + "admin role add ann king --all").exit_code, 0);
  EXPECT_EQ(Run(As("ann") + "admin role add nobody viewer --all").exit_code, kNotFound);
  Ok(As("ann") + "admin token revoke " + std::to_string(shown.Json()["id"].get<int>()));
}

}  // namespace
}  // namespace axiscal
