#include "server/certificates.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>

#include "core/base/testing/source_path.h"

namespace axiscal::server {
namespace {

using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::IsEmpty;
using ::testing::SizeIs;

// A plant's authority with one certificate for a server, as deploy/make-certs makes them.
class Certificates : public testing::Test {
 protected:
  static void SetUpTestSuite() {
    std::string name = testing::TempDir() + "/axiscal-pki.XXXXXX";
    ASSERT_NE(mkdtemp(name.data()), nullptr);
    folder_ = name;
    MakeCerts("ca");
    MakeCerts("server localhost 127.0.0.1");
    MakeCerts("server other --days 20");
  }
  static void TearDownTestSuite() { std::filesystem::remove_all(folder_); }
  static void MakeCerts(const std::string& words) {
    const std::string command = base::SourcePath("/deploy/make-certs") + " " + folder_ + " " + words + " >/dev/null";
    ASSERT_EQ(std::system(command.c_str()), 0) << command;
  }
  static std::string File(const std::string& name) { return folder_ + "/" + name; }
  static std::string Write(const std::string& name, const std::string& text) {
    std::ofstream(File(name)) << text;
    return File(name);
  }
  static std::string Refusal(const TlsFiles& files) {
    const absl::Status status = ReadTls(files, base::SystemClock().UtcNow()).status();
    EXPECT_EQ(status.code(), absl::StatusCode::kInvalidArgument);
    return std::string(status.message());
  }

  static inline std::string folder_;
  const TlsFiles good_ = {File("server/localhost.crt"), File("server/localhost.key"), File("ca.crt")};
  const base::UtcTime now_ = base::SystemClock().UtcNow();
};

TEST_F(Certificates, OfMakeCertsAreRead) {
  const auto read = ReadTls(good_, now_);
  ASSERT_TRUE(read.ok()) << read.status();
  ASSERT_EQ(read->certificates.size(), 2u);
  EXPECT_EQ(read->certificates[0].subject, "CN = localhost");
  EXPECT_EQ(read->certificates[1].subject, "CN = Axiscal plant authority");
  EXPECT_GT(read->certificates[0].ends - now_, std::chrono::days(729));
  EXPECT_THAT(read->key_pem, HasSubstr("PRIVATE KEY"));
  EXPECT_TRUE(ReadTls({good_.certificate, good_.key, ""}, now_)->client_ca_pem.empty());
}

TEST_F(Certificates, ThatDoNotFitAreRefusedWithTheFile) {
  EXPECT_EQ(Refusal({good_.certificate, File("server/other.key"), ""}),
            File("server/other.key") + ": is not the key of the certificate in " + good_.certificate);
  EXPECT_THAT(Refusal({File("none.crt"), good_.key, ""}), HasSubstr(File("none.crt")));
  EXPECT_THAT(Refusal({good_.certificate, File("none.key"), ""}), HasSubstr(File("none.key")));
  EXPECT_THAT(Refusal({good_.certificate, good_.certificate, ""}), HasSubstr("no key can be read"));
  EXPECT_THAT(Refusal({good_.key, good_.key, ""}), HasSubstr(good_.key + ": certificate 1 cannot be read"));
  EXPECT_THAT(Refusal({good_.certificate, good_.key, Write("empty", "")}),
              HasSubstr(File("empty") + ": certificate 1 cannot be read"));
  // Cut off in the second certificate: a table with one bad line is refused whole.
  const std::string pem = ReadTls(good_, now_)->certificate_pem;
  EXPECT_THAT(Refusal({good_.certificate, good_.key, Write("cut", pem + pem.substr(0, pem.size() / 2))}),
              HasSubstr(File("cut") + ": certificate 2 cannot be read"));
}

TEST_F(Certificates, AKeyWithAPasswordIsRefusedWithoutAskingForIt) {
  const std::string command = "openssl pkcs8 -topk8 -in " + good_.key + " -out " + File("secret.key") +
                              " -v2 aes256 -passout pass:x 2>/dev/null";
  ASSERT_EQ(std::system(command.c_str()), 0);
  EXPECT_THAT(Refusal({good_.certificate, File("secret.key"), ""}), HasSubstr("without a password"));
}

TEST_F(Certificates, ThatAreNotValidNowAreRefusedWithTheirDays) {
  const absl::Status over = ReadTls(good_, now_ + std::chrono::days(731)).status();
  EXPECT_THAT(over.message(), HasSubstr(good_.certificate + ": the certificate of CN = localhost is valid from "));
  EXPECT_FALSE(ReadTls(good_, now_ - std::chrono::days(1)).ok());
}

TEST_F(Certificates, AreWarnedOfAMonthBeforeTheirEnd) {
  const auto good = ReadTls(good_, now_);
  EndWarnings warnings;
  EXPECT_THAT(warnings.Due(good->certificates, now_), IsEmpty());
  const std::string file = File("server/other.crt");
  const auto ending = ReadTls({file, File("server/other.key"), File("ca.crt")}, now_);
  ASSERT_TRUE(ending.ok()) << ending.status();
  EXPECT_THAT(warnings.Due(ending->certificates, now_),
              ElementsAre(HasSubstr(file + ": the certificate of CN = other ends in 19 days, on ")));
  EXPECT_THAT(warnings.Due(ending->certificates, now_ + std::chrono::hours(23)), IsEmpty());
  EXPECT_THAT(warnings.Due(ending->certificates, now_ + std::chrono::days(21)),
              ElementsAre(HasSubstr("the certificate of CN = other ended on ")));
}

TEST_F(Certificates, ThatTakeThePlaceOfOthersAreWarnedOfAtOnce) {
  const auto ending = ReadTls({File("server/other.crt"), File("server/other.key"), File("ca.crt")}, now_);
  ASSERT_TRUE(ending.ok()) << ending.status();
  EndWarnings warnings;
  EXPECT_THAT(warnings.Due(ending->certificates, now_), SizeIs(1));
  std::vector<Certificate> renewed = ending->certificates;
  renewed.front().ends -= std::chrono::days(10);
  EXPECT_THAT(warnings.Due(renewed, now_), ElementsAre(HasSubstr("ends in 9 days")));
}

}  // namespace
}  // namespace axiscal::server
