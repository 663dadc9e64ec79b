// The German of warning.cc: the same facts, kind by kind.
#include <string>

#include "absl/strings/str_cat.h"
#include "absl/strings/str_format.h"
#include "absl/strings/str_join.h"
#include "core/base/language.h"
#include "core/reports/digits.h"
#include "core/reports/warning.h"

namespace axiscal::reports {
namespace german {
namespace {

std::string Number(const std::string& text) { return base::NumberIn(base::Language::kGerman, text); }

std::string InDigits(double number, int digits) { return Number(Digits(number, digits)); }

std::string Unit(const std::string& unit) { return unit == "um" || unit == "urad" ? "µ" + unit.substr(1) : unit; }

std::string Join(const std::vector<std::string>& words) { return absl::StrJoin(words, ", "); }

std::string Offset(const std::string& name, const std::string& setup) {
  return absl::StrCat(name, setup.empty() ? "" : " der Aufspannung ", setup);
}

std::string Of(const Scatter& facts) {
  const bool is_cutter = facts.about == Scatter::About::kCutter;
  return absl::StrCat("die Messwerte streuen um das ", Number(absl::StrFormat("%.1f", facts.times_sigma)),
                      "-Fache ihrer angegebenen Standardunsicherheit um ",
                      is_cutter ? "die Kurven dieses Fräsers: eine seiner Angaben ist eine andere, oder Messwerte sind "
                                  "schlecht"
                                : "dieses Modell: ihm fehlt etwas, oder eine Messung ist schlecht");
}

std::string Of(const SetAside& facts) {
  return absl::StrFormat(
      "%d von %d Messwerten stechen heraus und wurden ausgeschlossen, zu viele für Späne: dem Modell fehlt etwas, das "
      "sie zeigen",
      facts.set_aside, facts.readings);
}

std::string Of(const NoInterval& facts) {
  return Join(facts.errors) +
         ": die Messwerte lassen die Aufspannung so offen, dass kein Intervall angegeben werden kann (eine andere "
         "Aufspannung mit anderen Abweichungen erklärt sie ebenso)";
}

std::string Of(const NoNumber& facts) {
  std::string sizes;
  for (const NoNumber::Size& error : facts.errors) {
    absl::StrAppend(&sizes, sizes.empty() ? "" : ", ",
                    absl::StrFormat("%s bei %.0f %s", error.error, error.size, Unit(error.unit)));
  }
  return sizes +
         ": dort endete die Anpassung, weil etwas aufnehmen musste, was die Messwerte zeigen; kein Messwert stützt "
         "eine "
         "solche Größe: abseits der gemessenen Stellungen nicht mit diesem Modell kompensieren";
}

std::string Of(const SharedStages& facts) {
  std::string of;
  for (const OffsetOf& offset : facts.offsets)
    absl::StrAppend(&of, of.empty() ? "" : ", ", Offset(offset.name, offset.setup));
  return absl::StrCat(
      facts.sessions.empty()
          ? absl::StrCat("die festgehaltenen Abweichungen beruhen auf derselben angegebenen Unsicherheit wie diese "
                         "Anpassung (",
                         of, ")")
          : absl::StrCat("die festgehaltenen Abweichungen kommen aus Messungen, die hier noch einmal benutzt werden (",
                         Join(facts.sessions), ")"),
      ": die angegebenen Unsicherheiten nehmen beide Stufen als unabhängig; aus allen Messungen gemeinsam "
      "identifizieren");
}

std::string Of(const CoarseReadings& facts) {
  return absl::StrFormat(
      "Messung %s: die Messwerte stehen in Stufen von %s µm, erwartet sind höchstens %s mal die angegebene "
      "Standardunsicherheit von %s µm: was das Runden verbirgt, zählt als Rauschen von %s µm",
      facts.session, InDigits(facts.step_um, 4), InDigits(facts.most_sigmas, 6), InDigits(facts.sigma_um, 4),
      InDigits(facts.rounding_sigma_um, 4));
}

std::string Of(const BeyondSize& facts) {
  std::string text;
  for (const auto* values : {&facts.errors, &facts.offsets}) {
    for (const BeyondSize::Value& value : *values) {
      absl::StrAppend(
          &text, text.empty() ? "" : ", ",
          absl::StrFormat("%s bei %.0f %s", Offset(value.name, value.setup), value.value, Unit(value.unit)));
    }
  }
  if (!facts.errors.empty()) {
    absl::StrAppend(
        &text, ": eine Maschine von etwa ", Number(absl::StrFormat("%.1f", 1e-3 * facts.size_mm)),
        absl::StrFormat(" m hat Abweichungen von höchstens %.0f µm und %.0f µrad", facts.limit_um, facts.limit_urad));
  }
  if (!facts.offsets.empty()) absl::StrAppend(&text, ": beim Aufspannen bleibt bei weitem weniger");
  absl::StrAppend(&text,
                  "; ist eine Werkzeuglänge (tool_tip_mm), ein Radius von Kugel oder Taster (vergessen oder doppelt "
                  "gezählt), ein point_mm in machine.json oder die Einheit einer Datei (m oder Zoll statt mm) falsch?");
  for (size_t i = 0; i < facts.near.size(); ++i) {
    const BeyondSize::Radius& radius = facts.near[i];
    absl::StrAppend(&text, i == 0 ? " Etwa so groß: " : ", ",
                    radius.sphere.empty() ? "der Tasterradius" : "der Radius der Kugel " + radius.sphere, " von ",
                    InDigits(radius.mm, 6), " mm");
  }
  return text;
}

std::string Of(const Quiet& facts) {
  return absl::StrCat(facts.sessions.size() == 1 ? "Messung " : "Messungen ", Join(facts.sessions),
                      ": die Messwerte streuen um die Anpassung mit dem ", InDigits(facts.share, 2),
                      "-Fachen ihrer angegebenen Standardunsicherheit, erwartet ist mindestens ein Zehntel: Stehen sie "
                      "in m oder Zoll statt mm (alle Abweichungen sind dann um denselben Faktor zu klein), oder ist "
                      "sigma_um zu groß?");
}

std::string Of(const DatumMoved& facts) {
  std::string text;
  for (const DatumMoved::Group& group : facts.groups) {
    std::string axes, names;
    for (const DatumMoved::Axis& axis : group.axes) {
      absl::StrAppend(&axes, axes.empty() ? "" : ", ", axis.name, " um ", InDigits(axis.moved_um, 4), " ± ",
                      InDigits(axis.sigma_um, 2), " µm");
      absl::StrAppend(&names, " ", axis.name);
    }
    const bool is_one = group.sessions.size() == 1;
    absl::StrAppend(&text, text.empty() ? "" : "; ", is_one ? "Messung " : "Messungen ", Join(group.sessions),
                    is_one ? " unterscheidet" : " unterscheiden",
                    " sich von den anderen um einen festen Wert der Sollstellung (", axes,
                    "): Wurde der Nullpunkt vorher neu gesetzt? Dann gehört '# datum: free", names, "' in ",
                    is_one ? "ihren Kopf" : "ihre Köpfe");
  }
  if (facts.in_place_of.empty()) return text;
  const bool is_one = facts.in_place_of.size() == 1;
  return absl::StrCat(Join(facts.in_place_of), is_one ? " ist" : " sind",
                      " vielleicht nicht an der Maschine: ohne diese Abweichung", is_one ? "" : "en", " gilt: ", text);
}

std::string Of(const NoFreedom& facts) {
  return absl::StrCat(
      "kein Freiheitsgrad: es sind so viele Unbekannte wie Messwerte, und nichts zeigt, um wie viel sie "
      "falsch sind: ",
      facts.without_sigma.empty() ? std::string("die Unsicherheiten beruhen allein auf dem, was vorher angegeben war")
                                  : Join(facts.without_sigma) + " ohne Unsicherheit",
      "; mehr messen, als es Unbekannte gibt");
}

std::string Of(const Expired& facts) {
  const std::string certificate = absl::StrCat("Messung ", facts.session, ": Kalibrierschein ", facts.number, " für ",
                                               facts.of, " gilt bis ", facts.due);
  if (facts.started.empty()) {
    return certificate + ", und kein '# started: ...' sagt, wann gemessen wurde: ob er dann galt, ist nicht bekannt";
  }
  return absl::StrCat(certificate, " und war abgelaufen, als die Messung am ", facts.started,
                      " begann: was er angibt, zählt, als ob er gälte; kalibrieren lassen und vergleichen");
}

std::string Of(const TwoClocks& facts) {
  return absl::StrCat("Messungen ", facts.session, " und ", facts.other,
                      " überlappen in der Zeit: t_s jeder zählt von einem eigenen Anfang, und ", Join(facts.errors),
                      " nahm dasselbe t_s für denselben Augenblick; t_s von Messung zu Messung weiterlaufen lassen");
}

std::string Of(const TrackerMoved& facts) {
  return absl::StrCat(
      "Messung ", facts.session,
      ": der Tracker selbst hat sich bewegt, nicht die Maschine: was in der Mitte seiner Messwerte steht, schien um "
      "bis "
      "zu ",
      InDigits(facts.moved_um, 3), " ± ", InDigits(facts.sigma_um, 2), " µm zu wandern und sich um ",
      InDigits(facts.turned_urad, 3), " ± ", InDigits(facts.turn_sigma_urad, 2),
      absl::StrFormat(" µrad zu drehen (t_s = %.0f), wie %d Referenzziele bei %d Blicken zeigen; das ist abgezogen und "
                      "steht in keiner Abweichung",
                      facts.at_s, facts.references, facts.looks));
}

}  // namespace
}  // namespace german

std::string InGerman(const WarningFacts& facts) {
  return std::visit([](const auto& of_a_kind) { return german::Of(of_a_kind); }, facts);
}

}  // namespace axiscal::reports
