#include "core/sheet/setup_words.h"

#include <algorithm>
#include <utility>

#include "absl/strings/str_format.h"
#include "absl/strings/str_join.h"
#include "core/session/stated_facts.h"
#include "core/session/text.h"

namespace axiscal::sheet {
namespace {

using Header = std::vector<session::HeaderEntry>;

const std::string* Find(const Header& header, const std::string& key) {
  for (const session::HeaderEntry& entry : header) {
    if (entry.key == key) return &entry.value;
  }
  return nullptr;
}

struct Phrase {
  const char* key;
  const char* english;
  const char* german;
  const char* unit;  // behind the numbers; several are written as a point
};

constexpr Phrase kInstruments[] = {
    {"ballbar", "ballbar", "Kreisformmessgerät", ""},
    {"tracker", "laser tracker", "Lasertracker", ""},
    {"rtest", "R-test", "R-Test", ""},
    {"touch", "touch probe", "Messtaster", ""},
    {"centres", "touch probe (sphere centres)", "Messtaster (Kugelmitten)", ""},
    {"direction", "angle (autocollimator, level)", "Winkel (Autokollimator, Libelle)", ""},
    {"eccentricity", "ballbar (eccentricities)", "Kreisformmessgerät (Exzentrizitäten)", ""},
};

constexpr Phrase kPhrases[] = {
    {"table_ball_mm", "table ball at ", "Tischkugel bei ", " mm"},
    {"bar_length_mm", "bar ", "Stab ", " mm"},
    {"stylus_radius_mm", "stylus radius ", "Tasterradius ", " mm"},
    {"sphere_radius_mm", "sphere radius ", "Kugelradius ", " mm"},
    {"anchor_mm", "anchor at ", "Ankerpunkt bei ", " mm"},
    {"beam", "beam along ", "Strahl entlang ", ""},
    {"about", "turn around ", "Drehung um ", ""},
    {"knocked_s", "tracker knocked at t = ", "Tracker angestoßen bei t = ", " s"},
    {"setup", "set-up ", "Aufspannung ", ""},
    {"payload_kg", "payload ", "Zuladung ", " kg"},
    {"gravity", "down is ", "unten ist ", ""},
    {"temperature_sigma_K", "u of the thermometers ", "u der Thermometer ", " K"},
};

// Numbers as the language writes them, three as a point, others in a row; any other text as it is.
std::string NumbersText(const std::string& text, Language language) {
  std::vector<double> numbers;
  if (!session::ParseNumbers(text, &numbers)) return text;
  const std::string all = absl::StrJoin(numbers, "; ", [&](std::string* out, double number) {
    *out += base::NumberIn(language, absl::StrFormat("%.10g", number));
  });
  return numbers.size() == 3 ? "(" + all + ")" : all;
}

// What carries anchor, beam or level.
std::string CarrierText(const std::string* stated, Language language) {
  const bool is_bed = stated != nullptr && *stated == "bed", is_german = language == Language::kGerman;
  return is_bed ? (is_german ? " am Bett" : " on the bed") : (is_german ? " auf dem Tisch" : " on the table");
}

// "R1, R2" of the keys "reference R1", "reference R2".
std::string NamesOf(const Header& header, const std::string& prefix) {
  std::vector<std::string> names;
  for (const session::HeaderEntry& entry : header)
    if (entry.key.starts_with(prefix)) names.push_back(entry.key.substr(prefix.size()));
  return absl::StrJoin(names, ", ");
}

// What a header states of the set-up beside the tool point, a phrase each, in the order of the header.
std::vector<std::string> SetupPhrases(const Header& header, Language language) {
  const bool is_german = language == Language::kGerman;
  std::vector<std::string> phrases;
  for (const session::HeaderEntry& entry : header) {
    for (const Phrase& words : kPhrases) {
      if (entry.key != words.key) continue;
      std::string phrase =
          absl::StrCat(is_german ? words.german : words.english,
                       entry.key == "setup" ? entry.value : NumbersText(entry.value, language), words.unit);
      if (entry.key == "anchor_mm" || entry.key == "beam") phrase += CarrierText(Find(header, "anchor_on"), language);
      if (entry.key == "about") phrase += CarrierText(Find(header, "reference"), language);
      phrases.push_back(std::move(phrase));
    }
    constexpr char kFree[] = "free ", kSigma[] = "_sigma_um";
    if (entry.key == "datum" && entry.value.starts_with(kFree)) {
      phrases.push_back((is_german ? "Nullpunkt neu gesetzt: " : "work offset set anew: ") +
                        entry.value.substr(sizeof(kFree) - 1));
    } else if (entry.key.ends_with(kSigma)) {
      const std::string of = entry.key.substr(0, entry.key.size() - (sizeof(kSigma) - 1));
      const std::string value = NumbersText(entry.value, language);
      phrases.push_back(of == "scale" ? absl::StrCat(is_german ? "u der Teilung " : "u of the scale ", value, " µm/m")
                                      : absl::StrCat(is_german ? "u von " : "u of ", of, " ", value, " µm"));
    } else if (entry.key.starts_with("expansion ")) {
      const auto expansion = session::ParseExpansion(entry);
      if (expansion.ok()) phrases.push_back(expansion->text(language));
    }
  }
  if (const std::string names = NamesOf(header, "reference "); !names.empty())
    phrases.push_back((is_german ? "Referenzziele neben der Maschine: " : "references beside the machine: ") + names);
  if (const std::string names = NamesOf(header, "target "); !names.empty())
    phrases.push_back((is_german ? "Ziele am Werkzeug: " : "targets on the tool: ") + names);
  return phrases;
}

// A line for each text, with the sessions of which it is said.
class LinesOfSessions {
 public:
  void Add(const std::string& session, const std::string& text) {
    if (text.empty()) return;
    const auto at = std::find_if(of_.begin(), of_.end(), [&](const auto& one) { return one.first == text; });
    if (at == of_.end()) {
      of_.emplace_back(text, std::vector<std::string>{session});
    } else {
      at->second.push_back(session);
    }
  }

  // `count`: of all sessions.
  std::vector<std::string> Lines(size_t count, Language language) const {
    constexpr size_t kMostNames = 6;
    const bool is_german = language == Language::kGerman;
    std::vector<std::string> lines;
    for (const auto& [text, sessions] : of_) {
      const size_t shown = std::min(sessions.size(), kMostNames);
      std::string names = absl::StrJoin(sessions.begin(), sessions.begin() + static_cast<std::ptrdiff_t>(shown), ", ");
      if (sessions.size() > shown)
        absl::StrAppend(&names, is_german ? " und " : " and ", sessions.size() - shown,
                        is_german ? " weitere" : " more");
      if (sessions.size() == count && count > 1) names = is_german ? "alle Messungen" : "all sessions";
      lines.push_back(absl::StrCat(names, ": ", text));
    }
    return lines;
  }

 private:
  std::vector<std::pair<std::string, std::vector<std::string>>> of_;
};

}  // namespace

std::string InstrumentWords(const records::SessionRecord& session, Language language) {
  const bool is_german = language == Language::kGerman;
  if (session.instrument == "length") {
    if (Find(session.header, "beam") != nullptr)
      return is_german ? "Länge entlang eines Strahls" : "length along a beam";
    return is_german ? "Länge von einem Ankerpunkt" : "length from an anchor";
  }
  for (const Phrase& words : kInstruments)
    if (session.instrument == words.key) return is_german ? words.german : words.english;
  return session.instrument;
}

std::string ToolPointText(const Header& header, Language language) {
  const std::string* const stated = Find(header, "tool_tip_mm");
  return stated == nullptr ? "" : NumbersText(*stated, language) + " mm";
}

std::vector<std::string> SetupLines(const std::vector<const records::SessionRecord*>& sessions, Language language) {
  const std::string first = sessions.empty() ? "" : ToolPointText(sessions.front()->header, language);
  const bool is_one_point = std::all_of(sessions.begin(), sessions.end(), [&](const auto* session) {
    return ToolPointText(session->header, language) == first;
  });
  LinesOfSessions setups;
  for (const records::SessionRecord* const session : sessions) {
    std::vector<std::string> phrases = SetupPhrases(session->header, language);
    if (const std::string point = ToolPointText(session->header, language); !is_one_point && !point.empty())
      phrases.insert(phrases.begin(), (language == Language::kGerman ? "Werkzeugpunkt " : "tool point ") + point);
    setups.Add(session->name, absl::StrJoin(phrases, ", "));
  }
  return setups.Lines(sessions.size(), language);
}

std::vector<std::string> CertificateLines(const std::vector<const records::SessionRecord*>& sessions,
                                          Language language) {
  const bool is_german = language == Language::kGerman;
  LinesOfSessions certificates;
  for (const records::SessionRecord* const session : sessions) {
    for (const session::Certificate& certificate : session::CertificatesOf(session->header)) {
      std::string text =
          absl::StrCat(certificate.text(language), is_german ? ", gültig bis " : ", valid until ", certificate.due);
      if (session->measured_at && *session->measured_at >= certificate.valid_until)
        text += is_german ? " (bei der Messung abgelaufen)" : " (expired when measured)";
      certificates.Add(session->name, text);
    }
  }
  return certificates.Lines(sessions.size(), language);
}

std::string StatedFactText(const std::string& fact, const std::vector<records::SessionRecord>& sessions,
                           Language language) {
  for (const records::SessionRecord& session : sessions) {
    for (const session::Certificate& certificate : session::CertificatesOf(session.header))
      if (fact == certificate.text()) return certificate.text(language);
    const std::string* const kelvin = Find(session.header, session::kTemperatureSigmaKey);
    std::vector<double> sigma;
    if (kelvin == nullptr || !session::ParseNumbers(*kelvin, &sigma) || sigma.size() != 1) sigma.clear();
    for (const session::Expansion& expansion : session::ExpansionsOf(session.header)) {
      if (fact == expansion.text()) return expansion.text(language);
      if (!sigma.empty() && fact == session::ThermometerText(expansion.column, sigma[0]))
        return session::ThermometerText(expansion.column, sigma[0], language);
    }
  }
  return fact;
}

}  // namespace axiscal::sheet
