// The whole service in this process on a fresh database file, its client, and what to send it.
#ifndef AXISCAL_TESTS_END_TO_END_TESTING_FIXTURE_H_
#define AXISCAL_TESTS_END_TO_END_TESTING_FIXTURE_H_

#include <gtest/gtest.h>

#include <memory>
#include <string>

#include "client/client.h"
#include "core/session/session.h"
#include "server/embedded.h"

namespace axiscal::testing {

// machine.json of a multi-tasking machine `id` (X Y Z B on the tool side, C under the table).
std::string MachineJson(const std::string& id);

// A ball-bar session of that machine with `readings` rows, different for every `name`.
session::Session BallbarSession(const std::string& machine, const std::string& name, int readings);

// A folder of its own, removed with what it holds.
class TempDir {
 public:
  TempDir();
  ~TempDir();
  std::string File(const std::string& name) const { return path_ + "/" + name; }

 private:
  std::string path_;
};

class EndToEnd : public ::testing::Test {
 protected:
  void SetUp() override;

  client::Client& client() { return embedded_->client; }
  std::shared_ptr<grpc::Channel> channel() { return embedded_->server->InProcessChannel(); }
  // Stops the service and starts it again on the same file.
  void Restart();

  TempDir dir_;
  std::unique_ptr<server::Embedded> embedded_;
};

}  // namespace axiscal::testing

// Stops the test when a StatusOr or Status holds an error, and shows it.
#define ASSERT_OK(expression)                                                     \
  do {                                                                            \
    const auto& axiscal_result = (expression);                                    \
    ASSERT_TRUE(axiscal_result.ok()) << ::axiscal::testing::Text(axiscal_result); \
  } while (false)

namespace axiscal::testing {

inline std::string Text(const absl::Status& status) { return status.ToString(); }
template <typename T>
std::string Text(const absl::StatusOr<T>& result) {
  return result.status().ToString();
}

}  // namespace axiscal::testing

#endif  // AXISCAL_TESTS_END_TO_END_TESTING_FIXTURE_H_
