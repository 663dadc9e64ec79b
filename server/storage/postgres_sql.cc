#include "server/storage/postgres_sql.h"

#include <algorithm>
#include <cctype>

#include "absl/strings/match.h"
#include "absl/strings/str_cat.h"

namespace axiscal::storage {
namespace {

class Rewriter {
 public:
  explicit Rewriter(const std::string& sql) : sql_(sql) {}

  PostgresSql Run() && {
    while (at_ < sql_.size()) {
      const char c = sql_[at_];
      if (c == '\'' || c == '"') {
        Quoted(c);
      } else if (c == '?') {
        Parameter();
      } else if (Skip("/*!") || Skip("*/")) {
        continue;
      } else if (c == '+' && at_ + 1 < sql_.size() && IsLetter(sql_[at_ + 1])) {
        ++at_;
      } else if (IsLetter(c)) {
        Word();
      } else {
        out_.text.push_back(sql_[at_++]);
      }
    }
    return std::move(out_);
  }

 private:
  static bool IsLetter(char c) { return std::isalpha(static_cast<unsigned char>(c)) != 0 || c == '_'; }
  static bool IsOfWord(char c) { return IsLetter(c) || std::isdigit(static_cast<unsigned char>(c)) != 0; }

  // A text or a name, as it is. A doubled quote inside ends one and begins another.
  void Quoted(char quote) {
    const size_t end = sql_.find(quote, at_ + 1);
    const size_t next = end == std::string::npos ? sql_.size() : end + 1;
    out_.text.append(sql_, at_, next - at_);
    at_ = next;
  }
  void Parameter() {
    int number = 0;
    for (++at_; at_ < sql_.size() && std::isdigit(static_cast<unsigned char>(sql_[at_])) != 0; ++at_)
      number = 10 * number + (sql_[at_] - '0');
    const auto known = std::find(out_.parameters.begin(), out_.parameters.end(), number);
    absl::StrAppend(&out_.text, "$", known - out_.parameters.begin() + 1);
    if (known == out_.parameters.end()) out_.parameters.push_back(number);
  }
  void Word() {
    const size_t start = at_;
    while (at_ < sql_.size() && IsOfWord(sql_[at_])) ++at_;
    const std::string word = sql_.substr(start, at_ - start);
    if (word == "INDEXED" && Skip(" BY ")) {
      while (at_ < sql_.size() && IsOfWord(sql_[at_])) ++at_;
    } else if (word == "CROSS" && Skip(" JOIN")) {
      out_.text += "JOIN";
    } else if (word == "sqlite_sequence") {
      out_.text += "given_number";
    } else if (word == "json_each" && Skip("(")) {
      out_.text += "(SELECT CAST(jsonb_array_elements_text(CAST(";
      Parameter();
      out_.text += " AS jsonb)) AS BIGINT) AS value) AS json_each";
      Skip(")");
    } else {
      out_.text += word;
    }
  }
  bool Skip(const std::string& what) {
    if (sql_.compare(at_, what.size(), what) != 0) return false;
    at_ += what.size();
    return true;
  }

  const std::string& sql_;
  size_t at_ = 0;
  PostgresSql out_;
};

}  // namespace

PostgresSql ToPostgres(const std::string& sql) { return Rewriter(sql).Run(); }

}  // namespace axiscal::storage
