// Runs the axiscal binary in a folder of its own.
#ifndef AXISCAL_TESTS_CLI_COMMAND_LINE_H_
#define AXISCAL_TESTS_CLI_COMMAND_LINE_H_

#include <gtest/gtest.h>
#include <sys/wait.h>

#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <nlohmann/json.hpp>
#include <sstream>
#include <string>

#include "core/base/testing/source_path.h"

namespace axiscal::testing {

struct Outcome {
  int exit_code = -1;
  std::string out, err;

  nlohmann::json Json() const { return nlohmann::json::parse(out, nullptr, false); }
};

class CommandLine : public ::testing::Test {
 protected:
  CommandLine() {
    std::string name = (std::filesystem::temp_directory_path() / "axiscal-cli-XXXXXX").string();
    EXPECT_NE(mkdtemp(name.data()), nullptr);
    folder_ = name;
    unsetenv("AXISCAL_SERVER");
    unsetenv("AXISCAL_DB");
  }
  ~CommandLine() override { std::filesystem::remove_all(folder_); }

  // `arguments` as typed in a shell in the test's folder; the database is axiscal.db there.
  Outcome Run(const std::string& arguments) const {
    const std::string command =
        "cd '" + folder_.string() + "' && '" AXISCAL_PATH "' " + arguments + " >out.txt 2>err.txt </dev/null";
    const int status = std::system(command.c_str());
    return {WIFEXITED(status) ? WEXITSTATUS(status) : -1, Read("out.txt"), Read("err.txt")};
  }

  void Write(const std::string& name, const std::string& text) const {
    std::ofstream(folder_ / name, std::ios::binary) << text;
  }
  std::string Read(const std::string& name) const {
    std::stringstream text;
    text << std::ifstream(folder_ / name, std::ios::binary).rdbuf();
    return text.str();
  }
  bool Exists(const std::string& name) const { return std::filesystem::exists(folder_ / name); }

  std::filesystem::path folder_;
};

// `name` in the checkout.
inline std::string Source(const std::string& name) {
  return (std::filesystem::path(base::SourcePath("")) / name).string();
}

}  // namespace axiscal::testing

#endif  // AXISCAL_TESTS_CLI_COMMAND_LINE_H_
