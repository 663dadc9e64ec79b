// Which machine needs care, and why, as a technician asks for it: the sick ones first, by group and label, each what
// is his to see.
#include <gmock/gmock.h>

#include "tests/cli/command_line.h"
#include "tests/end_to_end/testing/process.h"

namespace axiscal {
namespace {

using ::testing::AllOf;
using ::testing::ElementsAre;
using ::testing::HasSubstr;
using testing::Outcome;
using testing::ServerProcess;
using testing::Source;

class CareCommand : public testing::CommandLine {
 protected:
  static constexpr int kRefused = 5, kNotFound = 4;

  Outcome Ok(const std::string& arguments) const {
    Outcome outcome = Run(arguments);
    EXPECT_EQ(outcome.exit_code, 0) << arguments << ": " << outcome.err;
    return outcome;
  }
  // Machine, upload of its sessions, and a calibration that nobody has approved.
  void AddMeasured() const {
    std::filesystem::copy(Source("deploy/examples/integrex"), folder_);
    Ok("machine add machine.json");
    Ok("upload B-short-run1.csv B-long-run1.csv");
    Ok("identify --machine integrex-i200 --sessions B-short-run1,B-long-run1 --declare EZ0T,EX0T");
  }
  void AddLike(const std::string& name) const {
    std::string json = Read("machine.json");
    json.replace(json.find("integrex-i200"), 13, name);
    Write("other.json", json);
    Ok("machine add other.json");
  }
  std::vector<std::string> Machines(const std::string& arguments) const {
    std::vector<std::string> names;
    const nlohmann::json fleet = Ok(arguments + " --json").Json();
    for (const auto& machine : fleet["machines"]) names.push_back(machine["machine"]);
    return names;
  }
};

TEST_F(CareCommand, AnEmptyFleetSaysWhatToDoFirst) {
  EXPECT_THAT(Ok("care").out, HasSubstr("the first comes with: axiscal machine add machine.json"));
  EXPECT_EQ(Ok("care --json").Json(), nlohmann::json::parse(R"({"machines": []})"));
}

TEST_F(CareCommand, TheSickOnesStandFirstWithTheirReasons) {
  AddMeasured();
  AddLike("a-new-one");
  // By what is to be done, then by name: one has at least a decision that waits, of the other nothing is known.
  EXPECT_THAT(Machines("care"), ElementsAre("integrex-i200", "a-new-one"));
  EXPECT_THAT(Ok("care").out,
              AllOf(HasSubstr("2 machines: "), HasSubstr("1 waiting for approval, none in use"),
                    HasSubstr("1 not known\n"), HasSubstr("never calibrated: upload a session, then identify")));
  Ok("approve 1");
  const auto used = Ok("care --json").Json()["machines"][0]["in_use"];
  EXPECT_EQ(used["calibration"], 1);
  EXPECT_LT(used["rms_after_um"], used["rms_before_um"]);
}

TEST_F(CareCommand, GroupsAndLabelsNarrowIt) {
  AddMeasured();
  AddLike("a-new-one");
  Ok("session annotate 1 --label cold");
  Ok("admin group add turning integrex-i200");
  Ok("admin group add hall-2 a-new-one");
  EXPECT_THAT(Machines("care --group hall-2"), ElementsAre("a-new-one"));
  EXPECT_THAT(Machines("care --label cold"), ElementsAre("integrex-i200"));
  EXPECT_THAT(Machines("care --label cold --group turning"), ElementsAre("integrex-i200"));
  EXPECT_THAT(Ok("care --label cold --group hall-2").out,
              HasSubstr("no machine is both in that group and has a session with that label"));
  // A slip of the pen must not read as a fleet that needs nothing.
  const Outcome group = Run("care --group trning");
  EXPECT_EQ(group.exit_code, kNotFound);
  EXPECT_THAT(group.err, HasSubstr("--group: none of the machines that you may see is in a group \"trning\"; there "
                                   "are: hall-2, turning"));
  const Outcome label = Run("care --label warm");
  EXPECT_EQ(label.exit_code, kNotFound);
  EXPECT_THAT(label.err, HasSubstr("--label: no session that you may see has the label \"warm\""));
}

TEST_F(CareCommand, EventsStandBeforeAllElse) {
  AddMeasured();
  Ok("expect --machine integrex-i200 --tolerance EZ0T=0..1 --candidates");
  auto started = ServerProcess::Start((folder_ / "axiscal.db").string(), "127.0.0.1:0", (folder_ / "log").string());
  ASSERT_TRUE(started.ok()) << started.status();
  const std::string server = "--server " + started->address() + " ";
  // Until the server has looked.
  nlohmann::json machine;
  do machine = Ok(server + "care --json").Json()["machines"][0];
  while (machine["new_events"] == 0 && !HasFailure());
  EXPECT_EQ(machine["care"], "now");
  EXPECT_GE(machine["new_events"], 1);
  EXPECT_THAT(machine["newest_event"].get<std::string>(), HasSubstr("EZ0T is"));
  EXPECT_THAT(Ok(server + "care").out, AllOf(HasSubstr("look now"), HasSubstr("nobody has seen"),
                                             HasSubstr("(axiscal events --machine integrex-i200 --open)")));
}

TEST_F(CareCommand, EachSeesHisOwn) {
  AddMeasured();
  AddLike("a-new-one");
  Ok("admin group add hall-2 a-new-one");
  Ok("admin group add secret integrex-i200");
  for (const std::string grant : {"vera viewer --group hall-2", "cell-7 cell --machine a-new-one"}) {
    const std::string name = grant.substr(0, grant.find(' '));
    Ok("admin principal add " + name);
    Ok("admin role add " + grant);
    Ok("admin token add " + name + " -o " + name + ".token");
  }
  auto started = ServerProcess::Start((folder_ / "axiscal.db").string(), "127.0.0.1:0", (folder_ / "log").string(),
                                      {"--ask-identity"});
  ASSERT_TRUE(started.ok()) << started.status();
  const auto as = [&](const std::string& who) {
    return "--server " + started->address() + " --token-file " + who + ".token ";
  };
  EXPECT_THAT(Machines(as("vera") + "care"), ElementsAre("a-new-one"));
  EXPECT_THAT(Machines(as("vera") + "care --group hall-2"), ElementsAre("a-new-one"));
  const Outcome hidden = Run(as("vera") + "care --group secret");
  EXPECT_EQ(hidden.exit_code, kNotFound);
  EXPECT_THAT(hidden.err, HasSubstr("in a group \"secret\"; there are: hall-2"));
  // A cell brings sessions and reads nothing of the fleet.
  const Outcome cell = Run(as("cell-7") + "care");
  EXPECT_EQ(cell.exit_code, kRefused);
  EXPECT_THAT(cell.err, HasSubstr("cell-7 may not call History.ListCare: it needs the role viewer"));
}

}  // namespace
}  // namespace axiscal
