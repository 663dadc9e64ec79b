#include "core/reports/warning.h"

#include <gtest/gtest.h>

namespace axiscal::reports {
namespace {

void Says(const WarningFacts& facts, WarningKind kind, const std::string& text) {
  const Warning warning = InWords(facts);
  EXPECT_EQ(warning.kind, kind);
  EXPECT_EQ(warning.text, text);
}

TEST(Warning, EachKindIsWorded) {
  Says(
      Scatter{.times_sigma = 2.34}, WarningKind::kScatter,
      "the readings scatter by 2.3 times their stated sigma about this model: it lacks something, or a session is bad");
  Says(Scatter{.times_sigma = 3.0, .about = Scatter::About::kCutter}, WarningKind::kScatter,
       "the readings scatter by 3.0 times their stated sigma about the curves of this cutter: a number of it is "
       "another, or readings are bad");
  Says(SetAside{12, 100}, WarningKind::kSetAside,
       "12 of 100 readings stand out and were set aside, too many for chips: the model lacks something that they show");
  Says(NoInterval{{"EX0C", "EA0C"}}, WarningKind::kInterval,
       "EX0C, EA0C: the readings leave the set-up so open that no interval can be stated (another set-up with other "
       "errors explains them as well)");
  Says(NoNumber{{{"EX0C", 1234.5, "um"}, {"EA0C", -400.0, "urad"}}}, WarningKind::kNoNumber,
       "EX0C at 1234 um, EA0C at -400 urad: the fit ended there because something had to take up what the readings "
       "show, but no reading supports such a size; do not compensate with this model away from the measured poses");
  Says(SharedStages{{"BX", "BY"}, {{"run_out_x", "mount"}}}, WarningKind::kHeld,
       "the held errors come from sessions that are used again (BX, BY): the stated sigmas take both stages for "
       "independent; identify from all sessions together");
  Says(SharedStages{{}, {{"run_out_x", "mount"}}}, WarningKind::kHeld,
       "the held errors rest on the same stated sigma as this fit (run_out_x of set-up mount): the stated sigmas take "
       "both stages for independent; identify from all sessions together");
  Says(CoarseReadings{"CR", 2.0, 0.3, 0.57735, 2.0}, WarningKind::kResolution,
       "session 'CR': readings stand in steps of 2 um, expected at most 2 times the stated sigma of 0.3 um: what "
       "rounding hides is counted as noise of 0.5774 um");
  Says(BeyondSize{{{"EZ0T", 5012.3, "um"}}, {}, 900.0, 1800.0, 2000.0, {{5.0}}}, WarningKind::kSize,
       "EZ0T at 5012 um: a machine about 0.9 m across has errors of at most 1800 um and 2000 urad; is a tool length "
       "(tool_tip_mm), a radius of sphere or stylus (forgotten or counted twice), a point_mm of machine.json or the "
       "unit "
       "of a file (m or inch in place of mm) wrong? About as large: the stylus radius of 5 mm");
  Says(Quiet{{"BX", "BY"}, 0.0394}, WarningKind::kQuiet,
       "sessions BX, BY: the readings scatter about the fit by 0.039 of their stated sigma, expected at least a tenth: "
       "are they in m or inch in place of mm (all errors are then too small by the same factor), or is sigma_um too "
       "large?");
  Says(
      DatumMoved{{{{"C-1", "C-2"}, {{"X", -37.21, 1.5}, {"Z", 12.0, 0.4}}}}, {}}, WarningKind::kDatum,
      "sessions C-1, C-2 disagree with the others by a constant of the commanded position (X by -37.21 +- 1.5 um, Z by "
      "12 +- 0.4 um): was the work offset set anew before? Then '# datum: free X Z' belongs into their headers");
  Says(NoFreedom{"Z, pitch", "2 rods", {"Z", "pitch"}, "state rod_sigma of each rod, or measure more rods"},
       WarningKind::kNoFreedom,
       "no degree of freedom: Z, pitch from 2 rods, so that nothing shows by how much they are wrong: Z, pitch without "
       "sigma; state rod_sigma of each rod, or measure more rods");
  Says(TwoClocks{"grid", "random", {"EZT:drift"}}, WarningKind::kClock,
       "sessions grid and random overlap in time: t_s of each counts from a start of its own, and EZT:drift took the "
       "same t_s for the same moment; let t_s run on from session to session");
  Says(TrackerMoved{.session = "T",
                    .references = 3,
                    .looks = 5,
                    .moved_um = 43.21,
                    .sigma_um = 3.0,
                    .turned_urad = 20.3,
                    .turn_sigma_urad = 1.5,
                    .at_s = 1810.4},
       WarningKind::kMoved,
       "session 'T': the tracker itself moved, not the machine: what stands in the middle of its readings seemed to go "
       "by up to 43.2 +- 3 um and to turn by 20.3 +- 1.5 urad (t_s = 1810), as 3 reference targets show in 5 looks; it "
       "is taken off and in no error");
  Says(NoFreedom{"8 unknowns", "8 readings", {}, "measure more"}, WarningKind::kNoFreedom,
       "no degree of freedom: 8 unknowns from 8 readings, so that nothing shows by how much they are wrong: the sigmas "
       "rest on what was stated beforehand alone; measure more");
  Says(Expired{"BX", "bar_length", "4711", "2027-01-31", "2027-02-01"}, WarningKind::kCertificate,
       "session BX: certificate 4711 of bar_length is valid until 2027-01-31 and was expired when the session began on "
       "2027-02-01: what it states counts as if it were valid; have it calibrated and compare");
  Says(Expired{"BX", "bar_length", "4711", "2027-01-31", ""}, WarningKind::kCertificate,
       "session BX: certificate 4711 of bar_length is valid until 2027-01-31, and no '# started: ...' says when the "
       "session was measured: whether it was valid then is not known");
}

// Each kind, with every choice of words: no English, numbers with a comma.
TEST(Warning, EachKindIsWordedInGerman) {
  const auto says = [](const WarningFacts& facts, const std::string& text) { EXPECT_EQ(InWords(facts).german, text); };
  says(Scatter{.times_sigma = 2.34},
       "die Messwerte streuen um das 2,3-Fache ihrer angegebenen Standardunsicherheit um dieses Modell: ihm fehlt "
       "etwas, oder eine Messung ist schlecht");
  says(SharedStages{{}, {{"run_out_x", "mount"}}},
       "die festgehaltenen Abweichungen beruhen auf derselben angegebenen Unsicherheit wie diese Anpassung (run_out_x "
       "der Aufspannung mount): die angegebenen Unsicherheiten nehmen beide Stufen als unabhängig; aus allen Messungen "
       "gemeinsam identifizieren");
  says(CoarseReadings{"X-1.5", 2.0, 0.3, 0.57735, 2.0},
       "Messung X-1.5: die Messwerte stehen in Stufen von 2 µm, erwartet sind höchstens 2 mal die angegebene "
       "Standardunsicherheit von 0,3 µm: was das Runden verbirgt, zählt als Rauschen von 0,5774 µm");
  says(BeyondSize{{{"EZ0T", 5012.3, "um"}}, {{"ball_z", 70000.0, "um", "BX"}}, 900.0, 1800.0, 2000.0, {{5.0, "S1"}}},
       "EZ0T bei 5012 µm, ball_z der Aufspannung BX bei 70000 µm: eine Maschine von etwa 0,9 m hat Abweichungen von "
       "höchstens 1800 µm und 2000 µrad: beim Aufspannen bleibt bei weitem weniger; ist eine Werkzeuglänge "
       "(tool_tip_mm), ein Radius von Kugel oder Taster (vergessen oder doppelt gezählt), ein point_mm in machine.json "
       "oder die Einheit einer Datei (m oder Zoll statt mm) falsch? Etwa so groß: der Radius der Kugel S1 von 5 mm");
  says(DatumMoved{{{{"C-1"}, {{"X", -37.21, 1.5}}}}, {"EX0C"}},
       "EX0C ist vielleicht nicht an der Maschine: ohne diese Abweichung gilt: Messung C-1 unterscheidet sich von den "
       "anderen um einen festen Wert der Sollstellung (X um -37,21 ± 1,5 µm): Wurde der Nullpunkt vorher neu gesetzt? "
       "Dann gehört '# datum: free X' in ihren Kopf");
  says(TrackerMoved{"T", 3, 5, 1630.0, 190.0, 719.0, 6.5, 130.0},
       "Messung T: der Tracker selbst hat sich bewegt, nicht die Maschine: was in der Mitte seiner Messwerte steht, "
       "schien um bis zu 1630 ± 190 µm zu wandern und sich um 719 ± 6,5 µrad zu drehen (t_s = 130), wie 3 "
       "Referenzziele bei 5 Blicken zeigen; das ist abgezogen und steht in keiner Abweichung");
  const WarningFacts all[] = {Scatter{.about = Scatter::About::kCutter},
                              SetAside{12, 100},
                              NoInterval{{"EX0C"}},
                              NoNumber{{{"EX0C", 1234.5, "um"}}},
                              SharedStages{{"BX"}, {}},
                              Quiet{{"BX"}, 0.039},
                              NoFreedom{"8 unknowns", "8 readings", {}, "measure more"},
                              Expired{"BX", "bar_length", "4711", "2027-01-31", "2027-02-01"},
                              Expired{"BX", "bar_length", "4711", "2027-01-31", ""},
                              TwoClocks{"grid", "random", {"EZT:drift"}}};
  for (const WarningFacts& facts : all) {
    const std::string german = InWords(facts).german;
    EXPECT_FALSE(german.empty());
    for (const char* word : {" the ", " of ", " is ", " and ", " um)", "+-", "unknowns"})
      EXPECT_EQ(german.find(word), std::string::npos) << german;
  }
}

TEST(Warning, OfAStoredCalibrationSaysWhatToDo) {
  EXPECT_EQ(PoorFitText(5.2, false),
            "the readings scatter by 2.280 times their stated sigma about this model: it lacks something (axiscal "
            "close-loop looks for it), or a session is bad");
  EXPECT_EQ(PoorFitText(5.2, true),
            "the readings scatter by 2.280 times their stated sigma about this model: it lacks something that has no "
            "name yet, or a session is bad");
}

}  // namespace
}  // namespace axiscal::reports
