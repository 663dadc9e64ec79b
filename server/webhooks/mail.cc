#include "server/webhooks/mail.h"

#include <algorithm>

#include "absl/strings/ascii.h"
#include "absl/strings/escaping.h"
#include "absl/strings/match.h"
#include "absl/strings/str_format.h"
#include "absl/strings/str_join.h"
#include "absl/strings/str_split.h"
#include "proto/convert/field.h"

namespace axiscal::webhooks {
namespace {

constexpr char kScheme[] = "mailto:";
constexpr size_t kMostRecipients = 10;
// Of RFC 2047: an encoded word has at most 75 characters, "=?UTF-8?B?" and "?=" among them: 60 of base64, 45 bytes.
constexpr size_t kWordBytes = 45;
// Of RFC 2045: a line of base64 has at most 76 characters, 57 bytes.
constexpr size_t kLineBytes = 57;

std::string TimeText(base::UtcTime at) {
  const std::time_t seconds = base::ToUtcUs(at) / 1'000'000;
  std::tm utc = {};
  gmtime_r(&seconds, &utc);
  return absl::StrFormat("%04d-%02d-%02d %02d:%02d UTC", utc.tm_year + 1900, utc.tm_mon + 1, utc.tm_mday, utc.tm_hour,
                         utc.tm_min);
}

// As RFC 5322 has it: "Tue, 24 Nov 2026 18:30:25 +0000".
std::string DateOf(base::UtcTime at) {
  constexpr const char* kDays[] = {"Sun", "Mon", "Tue", "Wed", "Thu", "Fri", "Sat"};
  constexpr const char* kMonths[] = {"Jan", "Feb", "Mar", "Apr", "May", "Jun",
                                     "Jul", "Aug", "Sep", "Oct", "Nov", "Dec"};
  const std::time_t seconds = base::ToUtcUs(at) / 1'000'000;
  std::tm utc = {};
  gmtime_r(&seconds, &utc);
  return absl::StrFormat("%s, %02d %s %04d %02d:%02d:%02d +0000", kDays[utc.tm_wday], utc.tm_mday, kMonths[utc.tm_mon],
                         utc.tm_year + 1900, utc.tm_hour, utc.tm_min, utc.tm_sec);
}

// In words of RFC 2047, each of whole characters.
std::string HeaderText(const std::string& text) {
  std::vector<std::string> words;
  for (size_t at = 0; at < text.size();) {
    size_t size = std::min(kWordBytes, text.size() - at);
    // Bytes 10xxxxxx go on with a character.
    while (at + size < text.size() && size > 1 && (static_cast<unsigned char>(text[at + size]) & 0xC0) == 0x80) --size;
    words.push_back(absl::StrCat("=?UTF-8?B?", absl::Base64Escape(text.substr(at, size)), "?="));
    at += size;
  }
  return absl::StrJoin(words, "\r\n ");
}

}  // namespace

bool IsMail(const std::string& url) { return absl::StartsWithIgnoreCase(url, kScheme); }

absl::StatusOr<std::vector<std::string>> RecipientsOf(const std::string& url) {
  const std::vector<std::string> recipients = absl::StrSplit(url.substr(sizeof(kScheme) - 1), ',');
  if (recipients.size() > kMostRecipients) {
    return convert::FieldError("webhook.url", absl::StrCat(recipients.size(), " addresses, at most ", kMostRecipients));
  }
  for (const std::string& one : recipients) {
    if (!IsMailAddress(one))
      return convert::FieldError("webhook.url",
                                 "'" + one + "' is no e-mail address (mailto:ann@plant.example,bob@...)");
  }
  return recipients;
}

bool IsToldByMail(records::EventChangeKind what) {
  return what == records::EventChangeKind::kRaised || what == records::EventChangeKind::kCleared ||
         what == records::EventChangeKind::kBack;
}

std::string SubjectOf(const records::EventChange& change) {
  const records::EventContent& content = change.event.content;
  return absl::StrCat("[axiscal] ", change.event.machine.text(), ": ", records::WordOf(content.kind),
                      content.subject.empty() ? "" : " ", content.subject, ", ", records::WordOf(change.what));
}

std::string TextOf(const records::EventChange& change) {
  const records::EventContent& content = change.event.content;
  std::string text = absl::StrCat("Machine ", change.event.machine.text(), ": ", records::WordOf(content.kind),
                                  content.subject.empty() ? "" : " ", content.subject, ", ",
                                  records::WordOf(change.what), " ", TimeText(change.at), "\n\n", content.text, "\n");
  if (!change.note.empty()) absl::StrAppend(&text, "\n", records::WordOf(change.what), ": ", change.note, "\n");
  const bool is_over = change.what == records::EventChangeKind::kCleared;
  if (!is_over && !content.advice.empty()) absl::StrAppend(&text, "\nWhat to do: ", content.advice, "\n");
  if (!is_over && content.certainty) absl::StrAppendFormat(&text, "\nCertainty: %.1f %%\n", 100 * *content.certainty);
  absl::StrAppend(&text, "\nEvent ", change.event.id.number(), ", change ", change.id, ".");
  if (!is_over) {
    absl::StrAppend(&text, " Whoever takes care of it says so: axiscal events ack ", change.event.id.number(),
                    " --note \"...\"");
  }
  return text + "\n";
}

std::string MessageOf(const MailHead& head, const std::string& text) {
  std::string message =
      absl::StrCat("Date: ", DateOf(head.at), "\r\nFrom: ", head.from, "\r\nTo: ", absl::StrJoin(head.to, ",\r\n "),
                   "\r\nSubject: ", HeaderText(head.subject), "\r\nMessage-ID: <", head.id,
                   "@axiscal.invalid>\r\nAuto-Submitted: auto-generated\r\nMIME-Version: 1.0\r\n"
                   "Content-Type: text/plain; charset=UTF-8\r\n"
                   "Content-Transfer-Encoding: base64\r\n\r\n");
  for (size_t at = 0; at < text.size(); at += kLineBytes)
    absl::StrAppend(&message, absl::Base64Escape(text.substr(at, kLineBytes)), "\r\n");
  return message;
}

}  // namespace axiscal::webhooks
