// Tokens of any bytes, as they come in the field `authorization`, in cookies and in token files, and page tokens: who
// does not bring the very token is nobody, and a page begins only where a list has said so.
#include <sys/mman.h>
#include <unistd.h>

#include "client/connection.h"
#include "server/access/gate.h"
#include "server/http/sign_in.h"
#include "server/storage/page_token.h"
#include "server/storage/testing/temp_database.h"
#include "tests/fuzz/driver.h"

namespace axiscal::fuzz {
namespace {

// Its hash alone is stored; the corpus has it too.
constexpr char kToken[] = "axt_AAECAwQFBgcICQoLDA0ODxAREhMUFRYXGBkaGxwdHh8=";

storage::Database& Store() {
  static storage::TempDatabase* const database = [] {
    auto* made = new storage::TempDatabase();
    const storage::Caller caller = {"fuzz", ""};
    MUST((*made)->CreatePrincipal("ann", "", caller).ok());
    MUST((*made)->CreateToken({"ann", access::HashOfToken(kToken), "", {}}, caller).ok());
    return made;
  }();
  return **database;
}

void LookAtCredentials(const std::string& bytes) {
  static const access::Gate* const gate = new access::Gate(Store(), true);
  access::Credentials credentials;
  credentials.authorization = bytes;
  const auto identity = gate->Identify(credentials);
  MUST(identity.ok() == (bytes == std::string("Bearer ") + kToken));
  MUST(identity.ok() ? identity->name == "ann" : absl::IsUnauthenticated(identity.status()));
  credentials = {};
  credentials.certificate_name = bytes;
  MUST(gate->Identify(credentials).ok() == (bytes == "ann"));

  http::Request request;
  request.method = "POST";
  request.fields = {{"cookie", bytes}, {"host", bytes}, {"origin", bytes}, {"sec-fetch-site", "cross-site"}};
  http::SignIns sign_ins;
  const std::string secret = sign_ins.Add("Bearer x");
  const auto cookie = http::CookieOf(request);
  MUST(!cookie || !sign_ins.Find(*cookie));
  MUST(!http::CheckOrigin(request, true, "").ok());
  request.body = bytes;
  const auto answer = http::SignIn(request, *gate, sign_ins);
  MUST(!answer.ok() || bytes.find(std::string(kToken).substr(4, 8)) != std::string::npos);
}

void LookAtFile(const std::string& bytes) {
  const int file = memfd_create("token", 0);
  MUST(file >= 0 && write(file, bytes.data(), bytes.size()) == static_cast<ssize_t>(bytes.size()));
  const auto token = client::ReadToken("/proc/self/fd/" + std::to_string(file));
  close(file);
  // It goes into a header field: one line of printable characters.
  if (!token.ok()) return;
  MUST(!token->empty());
  for (const char c : *token) MUST(c > ' ' && c <= '~');
}

void LookAtPage(const std::string& bytes) {
  const auto by_key = storage::StartPage({10, bytes}, "sessions");
  const auto by_id = storage::StartPageById({10, bytes}, "sessions");
  MUST(by_key.ok() || absl::IsInvalidArgument(by_key.status()));
  MUST(by_id.ok() || absl::IsInvalidArgument(by_id.status()));
  MUST(!by_id.ok() || (by_key.ok() && by_id->before_id > 0));
  if (by_key.ok() && by_key->after) {
    const auto again = storage::StartPage({10, storage::MakePageToken(*by_key, *by_key->after)}, "sessions");
    MUST(again.ok() && again->after == by_key->after);
    MUST(!storage::StartPage({10, bytes}, "jobs").ok());
  }
}

}  // namespace

void Look(const std::string& bytes) {
  LookAtCredentials(bytes);
  LookAtFile(bytes);
  LookAtPage(bytes);
}

}  // namespace axiscal::fuzz
