// What ISO 230-1 calls an error: in the words of the page to print (core/sheet/iso_words.cc; tests/browser compares the two).
import { language } from "./text";

const kLinear = "XYZUV", kRotary = "ABC";
// 0 to 2: along or about x, y, z.
const directionOf = (letter: string) => ("XUA".includes(letter) ? 0 : "YVB".includes(letter) ? 1 : 2);

// English, German; %1: the axis, %2: the direction of the component, %3: the axis that is square to both.
function wordsOf(component: string, isConstant: boolean, axis: string): [string, string] {
  const isAngle = kRotary.includes(component);
  if (axis === "T")
    return isAngle
      ? ["tilt of spindle and tool around %2", "Neigung von Spindel und Werkzeug um %2"]
      : ["offset of spindle and tool in %2", "Versatz von Spindel und Werkzeug in %2"];
  if (axis === "W")
    return isAngle
      ? ["tilt of what the table carries around %2", "Neigung auf dem Tisch um %2"]
      : ["offset of the table ball in %2", "Versatz der Tischkugel in %2"];
  const isLinear = kLinear.includes(axis[0]);
  if (!isLinear && !kRotary.includes(axis[0]))
    return isAngle ? ["error of %1 around %2", "Abweichung von %1 um %2"] : ["error of %1 in %2", "Abweichung von %1 in %2"];
  const isOwn = directionOf(component) === directionOf(axis[0]);
  if (isConstant) {
    if (isAngle && !isOwn) return ["squareness error of %1 to %3", "Rechtwinkligkeitsabweichung von %1 zu %3"];
    if (isOwn && isAngle !== isLinear) return ["zero position error of %1", "Nullpunktabweichung von %1"];
    if (isAngle) return ["roll of %1, constant part", "Rollabweichung von %1, fester Anteil"];
    return ["position error of %1 in %2", "Lageabweichung von %1 in %2"];
  }
  if (isLinear) {
    if (isAngle)
      return isOwn
        ? ["roll error motion of %1", "Rollabweichung von %1"]
        : ["angular error motion of %1 around %2", "Winkelabweichung von %1 um %2"];
    return isOwn
      ? ["positioning error of %1", "Positionierabweichung von %1"]
      : ["straightness error motion of %1 in %2", "Geradheitsabweichung von %1 in %2"];
  }
  if (isAngle)
    return isOwn
      ? ["angular positioning error of %1", "Winkelpositionierabweichung von %1"]
      : ["tilt error motion of %1 around %2", "Taumelabweichung von %1 um %2"];
  return isOwn
    ? ["axial error motion of %1", "Axialabweichung von %1"]
    : ["radial error motion of %1 in %2", "Radialabweichung von %1 in %2"];
}

// The errors that a text names, each once.
export function errorsIn(text: string): string[] {
  return [...new Set(text.match(/\bE[XYZABC]0?[XYZUVWABCT][0-9]*\b/g) ?? [])];
}

// "squareness error of Y to X" of "EC0Y", also of an effect of it ("EXX:backlash"). A text that is no symbol: empty.
export function isoWords(name: string): string {
  const [, component, zero, axis] = /^E([XYZABC])(0?)([A-Z][0-9]*)(?::.*)?$/.exec(name) ?? [];
  if (component === undefined) return "";
  const along = directionOf(component), own = directionOf(axis[0]);
  const said = wordsOf(component, zero === "0", axis)[language.value === "de" ? 1 : 0];
  return said.replace("%1", axis).replace("%2", "XYZ"[along]).replace("%3", "XYZ"[3 - along - own]);
}
