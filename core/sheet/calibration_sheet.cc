#include "core/sheet/calibration_sheet.h"

#include <algorithm>
#include <cmath>
#include <set>
#include <utility>

#include "absl/strings/str_join.h"
#include "core/reports/stated_shares.h"
#include "core/sheet/error_words.h"
#include "core/sheet/numbers.h"
#include "core/sheet/setup_words.h"

namespace axiscal::sheet {
namespace {

// What fits on a page at a size that can be read.
constexpr size_t kMostErrors = 26, kMostInPairs = 60, kMostTogether = 18, kMostSessions = 8, kMostLines = 5;
constexpr size_t kMostListed = 8, kMostPoints = 3, kMostLetters = 180;
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
    if (it_.machine && IsArm(*it_.machine)) {
      sheet_.title = Say("Geometric errors of a robot arm", "Geometrische Abweichungen eines Roboterarms");
      sheet_.subtitle = Say("symbols after ISO 230-1; X, Y, Z: the machine's frame, with all joints at zero",
                            "Zeichen nach ISO 230-1; X, Y, Z: Maschinenkoordinaten, alle Gelenke auf null");
    } else {
      sheet_.title = Say("Geometric errors of a machine tool", "Geometrische Abweichungen einer Werkzeugmaschine");
      sheet_.subtitle = Say("symbols and terms after ISO 230-1 (assumed: not compared with its text)",
                            "Zeichen und Begriffe nach ISO 230-1 (angenommen: nicht mit ihrem Text verglichen)");
    }
    AddFacts();
    AddErrors();
    AddTogether();
    AddNotTold();
    AddResiduals();
    AddToolPoint();
    AddSessions();
    AddRemarks();
    sheet_.signatures = {Say("Measured: date, name, signature", "Gemessen: Datum, Name, Unterschrift"),
                         Say("Approved: date, name, signature", "Freigegeben: Datum, Name, Unterschrift")};
    sheet_.footer = Say(
        "Error = actual - nominal. u: standard uncertainty of the fit. U = k u: expanded uncertainty "
        "for 95 %. Both hold for the errors of this model and the readings as they are stated. Tool points, anchors "
        "and balls: machine coordinates with all axes at zero.",
        "Abweichung = Ist - Soll. u: Standardunsicherheit der Anpassung. U = k u: erweiterte "
        "Unsicherheit für 95 %. Beide gelten für die Abweichungen dieses Modells und die Messwerte, "
        "wie sie angegeben sind. Werkzeugpunkte, Ankerpunkte, Kugeln: Maschinenkoordinaten, alle Achsen auf null.");
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
    std::set<std::string> points;  // there the figures hold
    for (const records::SessionRecord& session : it_.sessions)
      if (std::string point = ToolPointText(session.header, language_); !point.empty()) points.insert(std::move(point));
    AddFact(Say("Tool point", "Werkzeugpunkt"),
            points.size() <= kMostPoints
                ? absl::StrJoin(points, ", ")
                : absl::StrCat(points.size(), Say(", below, with the sessions", ", unten, bei den Messungen")));
    if (!stored) return;
    AddFact(Say("Made", "Berechnet"), absl::StrCat(TimeText(stored->created_at), ", ", stored->content.created_by,
                                                   ", Axiscal ", stored->content.engine_version));
    AddFact(Say("Approved", "Freigegeben"),
            stored->approved_at ? absl::StrCat(TimeText(*stored->approved_at), ", ", stored->approved_by) : kNone);
  }

  // A row of numbers: value, u, U, unit.
  std::vector<std::string> NumbersOf(double value, double sigma, const std::string& unit) const {
    const double expanded = fitted_.coverage_factor * sigma;
    return {ValueText(value, std::isfinite(expanded) ? expanded : sigma, language_), UncertaintyText(sigma, language_),
            UncertaintyText(expanded, language_), UnitText(unit)};
  }
  std::vector<std::string> HeadOfNumbers() const {
    const double k = fitted_.coverage_factor;
    return {Say("value", "Wert"), "u", std::isfinite(k) ? absl::StrCat("U (k = ", Number(k), ")") : "U",
            Say("unit", "Einheit")};
  }
  static bool IsTold(const reports::Error& error) { return error.identifiable && std::isfinite(error.value); }

  void AddErrors() {
    Section section;
    section.title = Say("Errors", "Abweichungen");
    section.columns = "ttnnnt";
    section.head = {Say("error", "Abweichung"), Say("meaning", "Bedeutung")};
    for (std::string& head : HeadOfNumbers()) section.head.push_back(std::move(head));
    // Where those without a number would take the room of the meanings, they stand in the section below alone.
    const size_t all = fitted_.errors.size();
    const auto told = static_cast<size_t>(std::count_if(fitted_.errors.begin(), fitted_.errors.end(), IsTold));
    const bool are_told_alone = all > kMostErrors && told <= kMostErrors;
    for (const reports::Error& error : fitted_.errors) {
      if (are_told_alone && !IsTold(error)) continue;
      // "EXX:backlash" is a part of the positioning error of X.
      const size_t part = error.name.find(':');
      const std::string words =
          ErrorWords(error.symbol, it_.machine, language_) +
          (part == std::string::npos ? "" : ": " + PartWords(Cut(error.name.substr(part + 1), 30), language_));
      std::vector<std::string>& row = section.rows.emplace_back(std::vector<std::string>{Cut(error.name, 40), words});
      std::vector<std::string> numbers = {kNone, kNone, kNone, UnitText(error.unit)};
      if (IsTold(error)) numbers = NumbersOf(error.value, error.sigma, error.unit);
      for (std::string& number : numbers) row.push_back(std::move(number));
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
        absl::StrAppend(&shares, shares.empty() ? "" : ", ", UncertaintyText(share.by, language_), " ",
                        UnitText(share.unit), Say(" of ", " von "), share.error);
      }
      section->lines.push_back(absl::StrCat(Say("In u by the ", "In u durch "),
                                            StatedFactText(fact.of, it_.sessions, language_), ": ", shares));
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

  // Sums and differences that the readings determine although they do not tell their members.
  void AddTogether() {
    if (fitted_.determined.empty()) return;
    Section section;
    section.title = Say("Known together, though not one by one", "Zusammen bekannt, einzeln nicht");
    section.columns = "tnnnt";
    section.head = {Say("together", "zusammen")};
    for (std::string& head : HeadOfNumbers()) section.head.push_back(std::move(head));
    for (const reports::Combination& one : fitted_.determined) {
      std::vector<std::string> row = NumbersOf(one.value, one.sigma, one.unit);
      row.insert(row.begin(), Cut(CombinationText(one.name, language_)));
      section.rows.push_back(std::move(row));
    }
    Add(std::move(section), kMostTogether);
  }

  // Items behind a word, in as many lines as it takes.
  static void AddList(const std::string& title, const char* separator, const std::vector<std::string>& items,
                      Section* section) {
    std::string line = title;
    bool is_first = true;
    for (const std::string& item : items) {
      if (!is_first && line.size() + item.size() + 2 > kMostLetters) {
        section->lines.push_back(line + separator);
        line = item;
      } else {
        absl::StrAppend(&line, is_first ? "" : absl::StrCat(separator, " "), item);
      }
      is_first = false;
    }
    if (!items.empty()) section->lines.push_back(line);
  }

  void AddNotTold() {
    Section section;
    section.title = Say("What the readings do not tell", "Was die Messwerte nicht trennen");
    std::vector<std::string> without, directions;
    for (const reports::Error& error : fitted_.errors) {
      if (!error.identifiable) without.push_back(error.name);
    }
    AddList(Say("No number: ", "Ohne Zahl: "), ",", without, &section);
    for (const std::string& direction : fitted_.not_separable)
      directions.push_back(CombinationText(direction, language_));
    AddList(Say("Changes no reading: ", "Ändert keinen Messwert: "), ";", directions, &section);
    if (const auto* loop = std::get_if<reports::Loop>(&it_.report)) {
      for (const reports::Effect& effect : loop->effects) {
        if (effect.equivalent.empty()) continue;
        std::string line = effect.is.name + Say(" may as well be ", " kann ebenso sein: ");
        for (size_t i = 0; i < effect.equivalent.size(); ++i)
          absl::StrAppend(&line, i == 0 ? "" : ", ", effect.equivalent[i].name);
        section.lines.push_back(std::move(line));
      }
      AddList(Say("Axes that did not move: ", "Achsen, die nicht fuhren: "), ",", loop->axes_at_rest, &section);
    }
    if (section.lines.empty() && !fitted_.errors.empty()) {
      section.lines.push_back(
          Say("All errors above are told apart.", "Alle Abweichungen oben sind voneinander getrennt."));
    }
    Add(std::move(section), kMostListed);
  }

  // Of the readings, before and after what this calibration found: nothing is compensated in them.
  void AddResiduals() {
    Section section;
    section.title = Say("Residuals of the readings, µm", "Restfehler der Messwerte, µm");
    section.columns = "tnn";
    const auto add = [&](const std::string& name, double before, double after) {
      section.rows.push_back({name, Number(before), Number(after)});
    };
    const std::string rms = Say("readings, rms", "Messwerte, quadratisches Mittel (RMS)");
    const std::string most = Say("readings, greatest", "Messwerte, größter");
    std::string before_what, after_what = Say("with these errors", "mit diesen Abweichungen");
    if (const auto* loop = std::get_if<reports::Loop>(&it_.report)) {
      before_what = Say("declared model", "erklärtes Modell");
      after_what = Say("with all that was found", "mit allem Gefundenen");
      add(rms, loop->fit.before.rms_um, loop->fit.after.rms_um);
      add(most, loop->fit.before.max_um, loop->fit.after.max_um);
      if (loop->check) {
        add(loop->check->fitted ? Say("check sessions (fitted too), rms", "Prüfmessungen (auch angepasst), qu. Mittel")
                                : Say("check sessions, rms", "Prüfmessungen, quadratisches Mittel"),
            loop->check->before.rms_um, loop->check->after.rms_um);
      }
    } else {
      const auto& report = std::get<reports::Identification>(it_.report);
      before_what = !report.before ? Say("machine and set-ups as stated", "Maschine und Aufspannungen wie angegeben")
                    : report.held  ? Say("held errors alone", "nur festgehaltene Abweichungen")
                                   : Say("without these errors", "ohne diese Abweichungen");
      const reports::Statistics& before = report.before ? *report.before : report.nominal;
      add(rms, before.rms_um, report.fit.rms_um);
      add(most, before.max_um, report.fit.max_um);
    }
    section.head = {Say("what", "was"), before_what, after_what};
    Add(std::move(section), kMostLines);
  }

  // What a compensation with these errors does to the tool point.
  void AddToolPoint() {
    const auto* const loop = std::get_if<reports::Loop>(&it_.report);
    if (loop == nullptr || !loop->volumetric) return;
    const reports::Volumetric& box = *loop->volumetric;
    Section section;
    section.title = Say("Error of the tool point, µm", "Fehler am Werkzeugpunkt, µm");
    section.columns = "tnn";
    section.head = {Say("what", "was"), Say("machine as it is", "Maschine, wie sie ist"),
                    Say("compensated with these errors", "mit diesen Abweichungen kompensiert")};
    section.rows.push_back(
        {Say("tool point over the measured box, rms [95 %]", "Werkzeugpunkt im gemessenen Bereich, qu. Mittel [95 %]"),
         Figure(box.uncorrected), Figure(box.after)});
    std::vector<std::string> ranges;
    for (const reports::AxisRange& range : box.box) {
      ranges.push_back(absl::StrCat(range.axis, " ", Number(range.from), " … ", Number(range.to),
                                    range.unit == "deg" ? "°" : " " + range.unit));
    }
    AddList(Say("Measured box: ", "Gemessener Bereich: "), ",", ranges, &section);
    if (!box.gain_is_held) {
      section.lines.push_back(
          Say("The readings promise no gain over compensating the declared errors alone.",
              "Die Messwerte versprechen keinen Gewinn gegenüber den erklärten Abweichungen allein."));
    }
    Add(std::move(section), kMostLines);
  }

  std::string Figure(const reports::VolumetricFigure& figure) const {
    return IntervalText(figure.rms_um, figure.low_um, figure.high_um, language_);
  }

  void AddSessions() {
    Section section;
    section.title = Say("Measured with", "Gemessen mit");
    section.columns = "tttnnnn";
    section.head = {Say("session", "Messung"), Say("instrument, serial number", "Messmittel, Seriennummer"),
                    Say("when", "wann"),       Say("stated u, µm", "ang. u, µm"),
                    Say("readings", "Werte"),  Say("rms, µm", "RMS, µm"),
                    Say("max, µm", "max., µm")};
    for (const reports::SessionFit& fit : fitted_.sessions) {
      const records::SessionRecord* const found = RecordOf(fit);
      std::string instrument = NotStated(), when = kNone, sigma = kNone;
      if (found != nullptr) {
        const std::string* const serial = HeaderOf(*found, "serial");
        const std::string* const stated = HeaderOf(*found, "sigma_um");
        instrument = InstrumentWords(*found, language_) + ", " +
                     (serial ? *serial : Say("no serial number", "ohne Seriennummer"));
        if (found->measured_at) when = TimeText(*found->measured_at);
        if (stated) sigma = *stated;
        if (language_ == Language::kGerman) std::replace(sigma.begin(), sigma.end(), '.', ',');
      }
      section.rows.push_back({Cut(fit.in.session, 40), Cut(instrument, 60), when, Cut(sigma, 12),
                              absl::StrCat(fit.readings), Number(fit.rms_um), Number(fit.max_um)});
    }
    std::vector<const records::SessionRecord*> known;
    for (const reports::SessionFit& fit : fitted_.sessions)
      if (const auto* const record = RecordOf(fit); record != nullptr) known.push_back(record);
    for (const auto& [lines, most] :
         {std::pair{SetupLines(known, language_), kMostSessions}, {CertificateLines(known, language_), kMostLines}}) {
      section.lines.insert(section.lines.end(), lines.begin(), lines.begin() + std::min(lines.size(), most));
      if (lines.size() > most) section.lines.push_back(LeftOut(lines.size() - most));
    }
    Add(std::move(section), kMostSessions, kMostOfRemark, kMostSessions + kMostLines + 2);
  }

  const records::SessionRecord* RecordOf(const reports::SessionFit& fit) const {
    const auto found = std::find_if(it_.sessions.begin(), it_.sessions.end(),
                                    [&](const auto& session) { return session.name == fit.in.session; });
    return found == it_.sessions.end() ? nullptr : &*found;
  }

  // Reports of earlier versions have English alone.
  std::string InLanguage(const std::string& english, const std::string& german) const {
    if (language_ == Language::kEnglish) return english;
    return german.empty() ? absl::StrCat("(englisch) ", english) : german;
  }

  void AddRemarks() {
    Section section;
    section.title = Say("Remarks", "Bemerkungen");
    for (const reports::Warning& warning : fitted_.warnings)
      section.lines.push_back(InLanguage(warning.text, warning.german));
    if (const auto* loop = std::get_if<reports::Loop>(&it_.report)) {
      for (const reports::Cause& cause : loop->causes)
        section.lines.push_back(Say("Not the machine: ", "Nicht die Maschine: ") +
                                InLanguage(cause.subject, cause.subject_german));
      std::vector<std::string> held_back;
      for (const reports::HeldBack& held : loop->held_back) held_back.push_back(held.subject);
      AddList(Say("Found, and in none of the errors above: ", "Gefunden, und in keiner der Abweichungen oben: "), ",",
              held_back, &section);
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
    Add(std::move(section), most, most_letters, most);
  }
  void Add(Section section, size_t most, size_t most_letters, size_t most_lines) {
    for (std::string& line : section.lines) line = Cut(line, most_letters);
    if (section.lines.size() > most_lines) {
      const std::string more = LeftOut(section.lines.size() - most_lines);
      section.lines.resize(most_lines);
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
