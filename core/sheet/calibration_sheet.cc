#include "core/sheet/calibration_sheet.h"

#include <algorithm>
#include <cmath>
#include <set>

#include "core/reports/stated_shares.h"
#include "core/session/stated_facts.h"
#include "core/sheet/iso_words.h"
#include "core/sheet/numbers.h"

namespace axiscal::sheet {
namespace {

// What fits on a page at a size that can be read.
constexpr size_t kMostErrors = 26, kMostInPairs = 60, kMostSessions = 8, kMostLines = 5, kMostLetters = 180;
constexpr size_t kMostOfRemark = 320;  // what is to be done about it stands at the end of most

// `text` to so many bytes, never within a letter.
std::string Cut(const std::string& text, size_t most = kMostLetters) {
  if (text.size() <= most) return text;
  size_t end = most;
  while (end > 0 && (static_cast<unsigned char>(text[end]) & 0xC0) == 0x80) --end;
  return text.substr(0, end) + "…";
}

std::string UnitText(const std::string& unit) {
  const bool is_micro = !unit.empty() && unit[0] == 'u' && (unit.rfind("um", 0) == 0 || unit.rfind("urad", 0) == 0);
  return is_micro ? "µ" + unit.substr(1) : unit;
}

const std::string* HeaderOf(const records::SessionRecord& session, const std::string& key) {
  for (const session::HeaderEntry& entry : session.header) {
    if (entry.key == key) return &entry.value;
  }
  return nullptr;
}

class Writer {
 public:
  Writer(const CalibrationToPrint& calibration, Language language)
      : it_(calibration), language_(language), fitted_(reports::FittedOf(calibration.report)) {}

  Sheet Write() {
    sheet_.language = language_;
    sheet_.title = Say("Geometric errors of a machine tool", "Geometrische Abweichungen einer Werkzeugmaschine");
    sheet_.subtitle = Say("symbols and terms after ISO 230-1; its text was not compared",
                          "Zeichen und Begriffe nach ISO 230-1; ihr Text wurde nicht verglichen");
    AddFacts();
    AddErrors();
    AddNotTold();
    AddBeforeAfter();
    AddSessions();
    AddRemarks();
    sheet_.signatures = {Say("Measured: date, name, signature", "Gemessen: Datum, Name, Unterschrift"),
                         Say("Approved: date, name, signature", "Freigegeben: Datum, Name, Unterschrift")};
    sheet_.footer =
        Say("Error = actual - nominal. u: standard uncertainty of the fit. U = k u: expanded uncertainty "
            "for 95 %. Both hold for the errors of this model and the readings as they are stated.",
            "Abweichung = Ist - Soll. u: Standardunsicherheit der Anpassung. U = k u: erweiterte "
            "Unsicherheit für 95 %. Beide gelten für die Abweichungen dieses Modells und die Messwerte, "
            "wie sie angegeben sind.");
    return std::move(sheet_);
  }

 private:
  std::string Say(const char* english, const char* german) const {
    return language_ == Language::kGerman ? german : english;
  }
  std::string NotStated() const { return Say("not stated", "nicht angegeben"); }
  std::string Number(double number) const { return NumberText(number, 3, language_); }

  void AddFact(const std::string& name, const std::string& value) {
    sheet_.facts.push_back({name, value.empty() ? NotStated() : Cut(value)});
  }

  // The values of a header entry over the sessions, each once.
  std::string AllOf(const std::string& key) const {
    std::set<std::string> found;
    for (const records::SessionRecord& session : it_.sessions) {
      if (const std::string* value = HeaderOf(session, key); value != nullptr && !value->empty()) found.insert(*value);
    }
    std::string text;
    for (const std::string& value : found) absl::StrAppend(&text, text.empty() ? "" : ", ", value);
    return text;
  }

  // As the sessions say it: a calibration's own time may be that of its making.
  std::string WhenMeasured() const {
    std::optional<base::UtcTime> first, last;
    for (const records::SessionRecord& session : it_.sessions) {
      if (!session.measured_at) continue;
      first = first ? std::min(*first, *session.measured_at) : *session.measured_at;
      last = last ? std::max(*last, *session.measured_at) : *session.measured_at;
    }
    if (!first) return "";
    return *first == *last ? TimeText(*first) : absl::StrCat(TimeText(*first), " … ", TimeText(*last));
  }

  void AddFacts() {
    std::string machine = it_.machine ? it_.machine->id : it_.stored ? it_.stored->content.machine.text() : "";
    if (it_.machine && !it_.machine->structure.empty()) absl::StrAppend(&machine, ", ", it_.machine->structure);
    AddFact(Say("Machine", "Maschine"), machine);
    const auto& stored = it_.stored;
    std::string number;
    if (stored) {
      using State = records::CalibrationState;
      number = absl::StrCat(stored->id.number(), ", ", Say("version ", "Version "), stored->version, ", ",
                            stored->state == State::kApproved    ? Say("in use", "in Gebrauch")
                            : stored->state == State::kCandidate ? Say("candidate", "Kandidat")
                                                                 : Say("retired", "zurückgezogen"));
    }
    AddFact(Say("Calibration", "Kalibrierung"), number);
    AddFact(Say("Measured", "Gemessen"), WhenMeasured());
    AddFact(Say("Operator", "Bediener"), AllOf("operator"));
    if (!stored) return;
    AddFact(Say("Made", "Berechnet"), absl::StrCat(TimeText(stored->created_at), ", ", stored->content.created_by,
                                                   ", Axiscal ", stored->content.engine_version));
    AddFact(Say("Approved", "Freigegeben"),
            stored->approved_at ? absl::StrCat(TimeText(*stored->approved_at), ", ", stored->approved_by) : kNone);
  }

  void AddErrors() {
    const double k = fitted_.coverage_factor;
    Section section;
    section.title = Say("Errors", "Abweichungen");
    section.columns = "ttnnnt";
    section.head = {Say("error", "Abweichung"),
                    Say("meaning", "Bedeutung"),
                    Say("value", "Wert"),
                    "u",
                    std::isfinite(k) ? absl::StrCat("U (k = ", Number(k), ")") : "U",
                    Say("unit", "Einheit")};
    for (const reports::Error& error : fitted_.errors) {
      const bool is_told = error.identifiable && std::isfinite(error.value);
      const double expanded = k * error.sigma;
      // "EXX:backlash" is a part of the positioning error of X.
      const size_t part = error.name.find(':');
      const std::string words = IsoWords(error.symbol, language_) +
                                (part == std::string::npos ? "" : ": " + Cut(error.name.substr(part + 1), 30));
      section.rows.push_back({Cut(error.name, 40), words,
                              is_told ? ValueText(error.value, error.sigma, language_) : kNone,
                              is_told ? NumberText(error.sigma, 2, language_) : kNone,
                              is_told ? NumberText(expanded, 2, language_) : kNone, UnitText(error.unit)});
    }
    if (fitted_.errors.empty()) section.lines.push_back(Say("None was fitted.", "Keine wurde angepasst."));
    if (section.rows.size() > kMostErrors) PutInPairs(&section);
    AddStated(&section);
    Add(std::move(section), kMostInPairs / 2);
  }

  // Expansions, certified values and thermometers that make a tenth of an uncertainty or more.
  void AddStated(Section* section) const {
    for (const reports::StatedShares& fact : reports::StatedSharesOf(fitted_)) {
      std::string shares;
      for (const reports::StatedShares::Share& share : fact.shares) {
        absl::StrAppend(&shares, shares.empty() ? "" : ", ", NumberText(share.by, 2, language_), " ",
                        UnitText(share.unit), Say(" of ", " von "), share.error);
      }
      section->lines.push_back(absl::StrCat(Say("In u by the ", "In u durch "), fact.of, ": ", shares));
    }
  }

  // Many errors: two beside each other by their symbols alone, so that a page that is signed has them all.
  void PutInPairs(Section* section) const {
    const std::vector<std::vector<std::string>> rows = std::move(section->rows);
    const auto without_meaning = [](std::vector<std::string> cells) {
      cells.erase(cells.begin() + 1);
      return cells;
    };
    section->rows.clear();
    section->columns = "tnnnttnnnt";
    section->head = without_meaning(section->head);
    const std::vector<std::string> head = section->head;
    section->head.insert(section->head.end(), head.begin(), head.end());
    const size_t shown = std::min(rows.size(), kMostInPairs), left = (shown + 1) / 2;
    for (size_t i = 0; i < left; ++i) {
      std::vector<std::string> row = without_meaning(rows[i]);
      std::vector<std::string> other(row.size());
      if (i + left < shown) other = without_meaning(rows[i + left]);
      row.insert(row.end(), other.begin(), other.end());
      section->rows.push_back(std::move(row));
    }
    if (rows.size() > shown) section->lines.push_back(LeftOut(rows.size() - shown));
  }

  void AddNotTold() {
    Section section;
    section.title = Say("What the readings do not tell", "Was die Messwerte nicht trennen");
    std::string without;
    for (const reports::Error& error : fitted_.errors) {
      if (!error.identifiable) absl::StrAppend(&without, without.empty() ? "" : ", ", error.name);
    }
    if (!without.empty()) section.lines.push_back(Say("No number: ", "Ohne Zahl: ") + without);
    for (const std::string& direction : fitted_.not_separable)
      section.lines.push_back(Say("Changes no reading: ", "Ändert keinen Messwert: ") + direction);
    if (const auto* loop = std::get_if<reports::Loop>(&it_.report)) {
      for (const reports::Effect& effect : loop->effects) {
        if (effect.equivalent.empty()) continue;
        std::string line = effect.is.name + Say(" may as well be ", " kann ebenso sein: ");
        for (size_t i = 0; i < effect.equivalent.size(); ++i)
          absl::StrAppend(&line, i == 0 ? "" : ", ", effect.equivalent[i].name);
        section.lines.push_back(std::move(line));
      }
      if (!loop->axes_at_rest.empty()) {
        std::string line = Say("Axes that did not move: ", "Achsen, die nicht fuhren: ");
        for (size_t i = 0; i < loop->axes_at_rest.size(); ++i)
          absl::StrAppend(&line, i == 0 ? "" : ", ", loop->axes_at_rest[i]);
        section.lines.push_back(std::move(line));
      }
    }
    if (section.lines.empty() && !fitted_.errors.empty()) {
      section.lines.push_back(
          Say("All errors above are told apart.", "Alle Abweichungen oben sind voneinander getrennt."));
    }
    for (const reports::Combination& one : fitted_.determined) {
      const std::string unit = " " + UnitText(one.unit);
      section.lines.push_back(absl::StrCat(Say("Known together: ", "Zusammen bekannt: "), one.name, " = ",
                                           ValueText(one.value, one.sigma, language_), unit,
                                           ", u = ", NumberText(one.sigma, 2, language_), unit));
    }
    Add(std::move(section), kMostLines);
  }

  void AddBeforeAfter() {
    Section section;
    section.title = Say("Before and after, µm", "Vorher und nachher, µm");
    section.columns = "tnn";
    section.head = {Say("what", "was"), Say("before", "vorher"), Say("after", "nachher")};
    const auto add = [&](const std::string& name, double before, double after) {
      section.rows.push_back({name, Number(before), Number(after)});
    };
    const std::string rms = Say("readings, rms", "Messwerte, quadratisches Mittel");
    const std::string most = Say("readings, greatest", "Messwerte, größter");
    if (const auto* loop = std::get_if<reports::Loop>(&it_.report)) {
      add(rms, loop->fit.before.rms_um, loop->fit.after.rms_um);
      add(most, loop->fit.before.max_um, loop->fit.after.max_um);
      if (loop->check) {
        add(loop->check->fitted ? Say("check sessions (fitted too), rms", "Prüfmessungen (auch angepasst), qu. Mittel")
                                : Say("check sessions, rms", "Prüfmessungen, quadratisches Mittel"),
            loop->check->before.rms_um, loop->check->after.rms_um);
      }
      if (loop->volumetric) {
        const reports::Volumetric& box = *loop->volumetric;
        section.rows.push_back({Say("tool point over the measured box, rms [95 %]",
                                    "Werkzeugpunkt im gemessenen Bereich, qu. Mittel [95 %]"),
                                Figure(box.uncorrected), Figure(box.after)});
      }
    } else {
      const auto& report = std::get<reports::Identification>(it_.report);
      const reports::Statistics& before = report.before ? *report.before : report.nominal;
      add(rms, before.rms_um, report.fit.rms_um);
      add(most, before.max_um, report.fit.max_um);
    }
    Add(std::move(section), kMostLines);
  }

  std::string Figure(const reports::VolumetricFigure& figure) const {
    return absl::StrCat(Number(figure.rms_um), " [", Number(figure.low_um), "; ", Number(figure.high_um), "]");
  }

  void AddSessions() {
    Section section;
    section.title = Say("Measured with", "Gemessen mit");
    section.columns = "tttnnnn";
    section.head = {Say("session", "Messung"),
                    Say("instrument, serial number", "Messmittel, Seriennummer"),
                    Say("when", "wann"),
                    Say("stated u, µm", "angegeben u, µm"),
                    Say("readings", "Messwerte"),
                    Say("rms, µm", "qu. Mittel, µm"),
                    Say("greatest, µm", "größter, µm")};
    for (const reports::SessionFit& fit : fitted_.sessions) {
      const auto found = std::find_if(it_.sessions.begin(), it_.sessions.end(),
                                      [&](const auto& session) { return session.name == fit.in.session; });
      std::string instrument = NotStated(), when = kNone, sigma = kNone;
      if (found != it_.sessions.end()) {
        const std::string* const serial = HeaderOf(*found, "serial");
        const std::string* const stated = HeaderOf(*found, "sigma_um");
        instrument = absl::StrCat(found->instrument, ", ", serial ? *serial : NotStated());
        if (found->measured_at) when = TimeText(*found->measured_at);
        if (stated) sigma = *stated;
        if (language_ == Language::kGerman) std::replace(sigma.begin(), sigma.end(), '.', ',');
      }
      section.rows.push_back({Cut(fit.in.session, 40), Cut(instrument, 60), when, Cut(sigma, 12),
                              absl::StrCat(fit.readings), Number(fit.rms_um), Number(fit.max_um)});
      if (found != it_.sessions.end()) AddCertificates(*found, &section);
    }
    Add(std::move(section), kMostSessions);
  }

  void AddCertificates(const records::SessionRecord& record, Section* section) const {
    for (const session::Certificate& certificate : session::CertificatesOf(record.header)) {
      std::string line =
          absl::StrCat(record.name, ": ", Say("certificate ", "Kalibrierschein "), certificate.number,
                       Say(" of ", " für "), certificate.of, Say(", valid until ", ", gültig bis "), certificate.due);
      if (record.measured_at && *record.measured_at >= certificate.valid_until)
        line += Say(" (expired when measured)", " (bei der Messung abgelaufen)");
      section->lines.push_back(std::move(line));
    }
  }

  void AddRemarks() {
    Section section;
    section.title = Say("Remarks", "Bemerkungen");
    for (const reports::Warning& warning : fitted_.warnings) section.lines.push_back(warning.text);
    if (const auto* loop = std::get_if<reports::Loop>(&it_.report)) {
      for (const reports::Cause& cause : loop->causes)
        section.lines.push_back(Say("Not the machine: ", "Nicht die Maschine: ") + cause.subject);
      if (!loop->unexplained.empty()) {
        section.lines.push_back(absl::StrCat(Say("Found without a name: ", "Gefunden, ohne Namen: "),
                                             loop->unexplained.size(),
                                             Say(" parts of the residuals", " Teile der Restfehler")));
      }
    }
    if (!fitted_.outliers.empty()) {
      section.lines.push_back(
          absl::StrCat(Say("Readings set aside: ", "Ausgeschlossene Messwerte: "), fitted_.outliers.size()));
    }
    if (!section.lines.empty()) Add(std::move(section), kMostLines, kMostOfRemark);
  }

  std::string LeftOut(size_t count) const {
    return absl::StrCat(Say("and ", "und "), count,
                        Say(" more, in the report as JSON", " weitere, im Bericht als JSON"));
  }

  // Lines are cut, and rows and lines beyond `most` give way to a word on how many there are.
  void Add(Section section, size_t most, size_t most_letters = kMostLetters) {
    for (std::string& line : section.lines) line = Cut(line, most_letters);
    if (section.lines.size() > most) {
      const std::string more = LeftOut(section.lines.size() - most);
      section.lines.resize(most);
      section.lines.push_back(more);
    }
    if (section.rows.size() > most) {
      section.lines.insert(section.lines.begin(), LeftOut(section.rows.size() - most));
      section.rows.resize(most);
    }
    sheet_.sections.push_back(std::move(section));
  }

  const CalibrationToPrint& it_;
  const Language language_;
  const reports::Fitted& fitted_;
  Sheet sheet_;
};

}  // namespace

Sheet CalibrationSheet(const CalibrationToPrint& calibration, Language language) {
  return Writer(calibration, language).Write();
}

}  // namespace axiscal::sheet
