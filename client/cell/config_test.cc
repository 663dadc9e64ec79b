#include "client/cell/config.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cstdlib>
#include <filesystem>
#include <fstream>

#include "client/cell/cell.h"

namespace axiscal::cell {
namespace {

namespace fs = std::filesystem;
using ::testing::HasSubstr;

class CellConfig : public ::testing::Test {
 protected:
  CellConfig() {
    std::string name = (fs::temp_directory_path() / "axiscal-cell-XXXXXX").string();
    EXPECT_NE(mkdtemp(name.data()), nullptr);
    folder_ = name;
    std::ofstream(folder_ / "ball.txt") << "line: X{X_mm} Y{Y_mm}\n";
  }
  ~CellConfig() override { fs::remove_all(folder_); }
  absl::StatusOr<Config> Read(const std::string& text) const {
    return ReadConfig(text, (folder_ / "cell.toml").string());
  }
  std::string Refusal(const std::string& text) const {
    const absl::StatusOr<Config> config = Read(text);
    EXPECT_EQ(config.status().code(), absl::StatusCode::kInvalidArgument) << text << config.status();
    return std::string(config.status().message());
  }

  fs::path folder_;
};

constexpr char kLeast[] = "server.address = 'unix:/x'\nspool.folder = 'spool'\n[[watch]]\nfolder = 'logs'\n";

TEST_F(CellConfig, EachKeyIsRead) {
  const auto config = Read(
      "[server]\naddress = 'axiscal.shop:7410'\nca = 'ca.pem'\ntoken_file = '/etc/token'\n"
      "[spool]\nfolder = '/var/spool'\nmax_megabytes = 20\nmax_file_megabytes = 2\n"
      "[cell]\nname = 'cell-7'\nlook_seconds = 3\nsettle_seconds = 4\nmax_wait_seconds = 60\n"
      "[[watch]]\nfolder = 'logs'\nfiles = '*.log'\nmachine = 'mt'\ntemplate = 'ball.txt'\nend_line = '%'\n"
      "[[watch]]\nfolder = '/srv/bar'\nremove_sent = true\n");
  ASSERT_TRUE(config.ok()) << config.status();
  EXPECT_EQ(config->server, "axiscal.shop:7410");
  EXPECT_EQ(config->client.identity.ca, (folder_ / "ca.pem").string()) << "beside the file";
  EXPECT_EQ(config->client.identity.token_file, "/etc/token");
  EXPECT_EQ(config->client.user, "cell-7");
  EXPECT_EQ(config->spool.max_bytes, 20 << 20);
  EXPECT_EQ(config->spool.max_file_bytes, 2 << 20);
  EXPECT_EQ(config->status_file, "/var/spool/status.json");
  EXPECT_EQ(config->look_every, std::chrono::seconds(3));
  EXPECT_EQ(config->settle, std::chrono::seconds(4));
  EXPECT_EQ(config->last_wait, std::chrono::seconds(60));
  ASSERT_EQ(config->watches.size(), 2u);
  EXPECT_EQ(config->watches[0].files, "*.log");
  EXPECT_EQ(config->watches[0].end_line, "%");
  EXPECT_EQ(config->watches[1].folder, "/srv/bar");
  EXPECT_TRUE(config->watches[1].removes);
  const auto item = ItemOf(config->watches[0], "/a/b/probe.log");
  ASSERT_TRUE(item.ok()) << item.status();
  EXPECT_TRUE(item->is_log);
  EXPECT_EQ(item->machine, "mt");
  EXPECT_EQ(item->name, "probe.log");
  EXPECT_EQ(item->form.template_name, "ball.txt");
  EXPECT_THAT(item->form.template_text, HasSubstr("line: X{X_mm}"));
  EXPECT_FALSE(ItemOf(config->watches[1], "/a/b/BX.csv")->is_log);
}

TEST_F(CellConfig, WhatIsWrongIsToldWithItsPlace) {
  ASSERT_TRUE(Read(kLeast).ok()) << Read(kLeast).status();
  EXPECT_THAT(Refusal("spool.folder = 'x'\n"), HasSubstr("server.address is missing"));
  EXPECT_THAT(Refusal("server.address = 'x:1'\n"), HasSubstr("spool.folder is missing"));
  EXPECT_THAT(Refusal("server.address = 'x:1'\nspool.folder = 'x'\n"), HasSubstr("[[watch]] is missing"));
  const std::string least = kLeast;
  EXPECT_THAT(Refusal(least + "fils = '*'\n"),
              HasSubstr("cell.toml:5: watch[0].fils is no key; known are end_line, files"));
  EXPECT_THAT(Refusal("cell.look_seconds = 0\n" + least),
              HasSubstr("cell.toml:1: cell.look_seconds must be a whole number"));
  EXPECT_THAT(Refusal("cell.look_seconds = '3'\n" + least), HasSubstr("without quotes"));
  EXPECT_THAT(Refusal("spool.max_megabytes = 1\n" + least), HasSubstr("spool.max_file_megabytes is more"));
  EXPECT_THAT(Refusal("sever.address = 'x'\n" + least), HasSubstr("cell.toml:1: sever"));
  EXPECT_THAT(Refusal("watch = 3\n"), HasSubstr("must be [[watch]]"));
  EXPECT_THAT(Refusal("[watch]\nfolder = 'x'\n"), HasSubstr("must be [[watch]]"));
  EXPECT_THAT(Refusal("[[watch]]\nfiles = '*'\n" + least.substr(0, least.find("[["))), HasSubstr("cell.toml"));
  EXPECT_THAT(Refusal(least + "plan = 'p.csv'\n"), HasSubstr("plan needs template"));
  EXPECT_THAT(Refusal(least + "template = 'dprnt'\n"), HasSubstr("template needs machine"));
  EXPECT_THAT(Refusal(least + "remove_sent = 'yes'\n"), HasSubstr("must be true or false"));
  EXPECT_THAT(Refusal("[["), HasSubstr("cell.toml:1: "));
  // A template that is none, or not there, is told at once and not with each log.
  std::ofstream(folder_ / "bad.txt") << "lin: X\n";
  EXPECT_THAT(Refusal(least + "machine = 'mt'\ntemplate = 'bad.txt'\n"), HasSubstr("bad.txt"));
  EXPECT_FALSE(Read(least + "machine = 'mt'\ntemplate = 'none.txt'\n").ok());
}

TEST(NameOf, KeepsTwoNamesTwo) {
  EXPECT_EQ(NameOf("/a/b/probe 1.log"), "probe 1.log");
  EXPECT_EQ(NameOf("/a/caf\xe9.log"), "caf%E9.log");
  EXPECT_EQ(NameOf("/a/caf\xe8.log"), "caf%E8.log");
  EXPECT_EQ(NameOf("/\xff/caf\xc3\xa9.log"), "caf\xc3\xa9.log") << "UTF-8 stays";
  EXPECT_EQ(NameOf("/a/two\nlines\x7f.log"), "two%0Alines%7F.log") << "the server takes no control characters in names";
}

TEST(LongestWait, DoublesUpToItsEnd) {
  Config config;
  EXPECT_EQ(LongestWait(config, 1), std::chrono::seconds(1));
  EXPECT_EQ(LongestWait(config, 2), std::chrono::seconds(2));
  EXPECT_EQ(LongestWait(config, 5), std::chrono::seconds(16));
  EXPECT_EQ(LongestWait(config, 9), std::chrono::seconds(256));
  EXPECT_EQ(LongestWait(config, 100), std::chrono::minutes(5));
}

}  // namespace
}  // namespace axiscal::cell
