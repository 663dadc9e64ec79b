// Writes the sessions of the worked examples: make_example_sessions DIR (deploy/examples in the checkout).
#include <cstdio>

#include "core/session/write_session.h"
#include "tests/known_answers/example_sessions.h"

int main(int argc, char** argv) {
  if (argc != 2) return std::fprintf(stderr, "usage: make_example_sessions DIR\n"), 2;
  const auto sessions = axiscal::known_answers::ExampleSessions();
  absl::Status status = sessions.status();
  for (size_t i = 0; status.ok() && i < sessions->size(); ++i) {
    const auto& [file, session] = (*sessions)[i];
    status = axiscal::session::WriteSessionFile(session, std::string(argv[1]) + "/" + file);
  }
  if (!status.ok()) std::fprintf(stderr, "%s\n", std::string(status.message()).c_str());
  return status.ok() ? 0 : 1;
}
