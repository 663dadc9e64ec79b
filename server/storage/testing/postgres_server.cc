#include "server/storage/testing/postgres_server.h"

#include <fcntl.h>
#include <libpq-fe.h>
#include <pwd.h>
#include <signal.h>
#include <sys/wait.h>
#include <unistd.h>

#include <filesystem>
#include <vector>

#include "absl/strings/str_cat.h"
#include "core/base/demand.h"
#include "server/storage/postgres_connection.h"
#include "server/storage/postgres_database.h"

namespace axiscal::storage {
namespace {

constexpr char kUser[] = "axiscal", kTemplate[] = "present_schema";

// "/usr/lib/postgresql/15/bin", or empty.
std::string Programs() {
  std::string newest;
  std::error_code error;
  for (const auto& version : std::filesystem::directory_iterator("/usr/lib/postgresql", error)) {
    const std::string programs = version.path() / "bin";
    if (std::filesystem::exists(programs + "/initdb")) newest = std::max(newest, programs);
  }
  return newest;
}

// As nobody where this is root, whom PostgreSQL refuses; it ends with this process.
pid_t Spawn(const std::string& folder, std::vector<std::string> words) {
  std::vector<std::string> command = {"setpriv", "--pdeathsig", "KILL"};
  if (geteuid() == 0) {
    command.insert(command.end(), {"--reuid", "nobody", "--regid", "nogroup", "--clear-groups"});
  }
  command.insert(command.end(), words.begin(), words.end());
  std::vector<char*> arguments;
  for (std::string& word : command) arguments.push_back(word.data());
  arguments.push_back(nullptr);
  const std::string log = folder + "/log";
  const pid_t process = fork();
  if (process != 0) return process;
  const int descriptor = open(log.c_str(), O_WRONLY | O_CREAT | O_APPEND, 0644);
  dup2(descriptor, STDOUT_FILENO);
  dup2(descriptor, STDERR_FILENO);
  if (chdir(folder.c_str()) != 0) _exit(127);
  execvp(arguments[0], arguments.data());
  _exit(127);
}

int ExitCode(pid_t process) {
  int status = 0;
  waitpid(process, &status, 0);
  return WIFEXITED(status) ? WEXITSTATUS(status) : -1;
}

void RunAsOwner(const std::string& url, const std::string& sql) {
  PGconn* const server = PQconnectdb(url.c_str());
  PGresult* const result = PQexec(server, sql.c_str());
  DEMAND(PQresultStatus(result) == PGRES_COMMAND_OK);
  PQclear(result);
  PQfinish(server);
}

}  // namespace

absl::StatusOr<std::unique_ptr<PostgresServer>> PostgresServer::Start() {
  const std::string programs = Programs();
  if (programs.empty())
    return absl::NotFoundError("no PostgreSQL in /usr/lib/postgresql (deploy/install-deps --tests)");
  // Its socket's path must be short.
  std::string folder = "/tmp/axiscal-pg-XXXXXX";
  DEMAND(mkdtemp(folder.data()) != nullptr);
  if (geteuid() == 0) {
    const passwd* const nobody = getpwnam("nobody");
    DEMAND(nobody != nullptr && chown(folder.c_str(), nobody->pw_uid, nobody->pw_gid) == 0);
  }
  const std::string data = folder + "/data";
  if (ExitCode(Spawn(folder, {programs + "/initdb", "-D", data, "-U", kUser, "-A", "trust", "--no-sync", "-E", "UTF8",
                              "--locale=C.UTF-8"})) != 0)
    return absl::InternalError("initdb failed: " + folder + "/log");
  const pid_t process =
      Spawn(folder, {programs + "/postgres", "-D", data, "-k", folder, "-c", "listen_addresses=", "-c", "fsync=off",
                     "-c", "full_page_writes=off", "-c", "shared_buffers=32MB", "-c", "max_connections=200"});
  std::unique_ptr<PostgresServer> server(new PostgresServer(folder, process));
  RETURN_IF_ERROR(server->WaitUntilUp());
  RunAsOwner(server->UrlOf("postgres"), absl::StrCat("CREATE DATABASE ", kTemplate));
  PostgresOptions options;
  options.url = server->UrlOf(kTemplate);
  RETURN_IF_ERROR(OpenPostgres(options).status());
  return server;
}

PostgresServer::~PostgresServer() {
  kill(process_, SIGQUIT);
  ExitCode(process_);
  std::filesystem::remove_all(folder_);
}

absl::Status PostgresServer::WaitUntilUp() const {
  for (int i = 0; i < 600; ++i) {
    if (PQping(UrlOf("postgres").c_str()) == PQPING_OK) return absl::OkStatus();
    usleep(100'000);
  }
  return absl::InternalError("the server does not come up: " + folder_ + "/log");
}

std::string PostgresServer::UrlOf(const std::string& database) const {
  return absl::StrCat("postgresql://", kUser, "@/", database, "?host=", folder_);
}

std::string PostgresServer::MakeDatabase(bool has_schema) {
  const std::string name = absl::StrCat("test_", ++databases_);
  RunAsOwner(UrlOf("postgres"),
             absl::StrCat("CREATE DATABASE ", name, " TEMPLATE ", has_schema ? kTemplate : "template1"));
  return UrlOf(name);
}

void PostgresServer::DropDatabase(const std::string& url) {
  const size_t start = url.find("@/") + 2;
  const std::string name = url.substr(start, url.find('?') - start);
  RunAsOwner(UrlOf("postgres"), absl::StrCat("DROP DATABASE ", name, " WITH (FORCE)"));
}

}  // namespace axiscal::storage
