// What the certainty of a finding is of. That a value changed, and that it was the machine which changed, are two questions (docs/drift.md): the
// first is answered by the size and its sigma, the second by the stated certainty.
import { certaintyText, numberText, sigmaText, unitText, valueText } from "./format";
import type { DriftAmount } from "./gen/axiscal/v1/history_service_pb";
import { t } from "./text";

// A change of so many sigmas is one, whatever made it.
const kSureSigmas = 4;

// Of a jump that is less than certain. Nothing where one number says all.
export function jumpWords(amounts: DriftAmount[], certainty?: number): string {
  if (certainty === undefined || certainty > 0.9) return "";
  const share = t("certaintyOfJump", { n: certaintyText(certainty) });
  const sure = amounts.filter((one) => one.sigma > 0 && Math.abs(one.size) >= kSureSigmas * one.sigma);
  if (sure.length === 0) return share;
  const list = sure.map((a) => `${a.symbol} ${valueText(a.size, a.sigma)} ± ${sigmaText(a.sigma)} ${unitText(a.unit)}`).join(", ");
  return `${t("changeIsSure", { list, n: numberText(Math.floor(Math.min(...sure.map((a) => Math.abs(a.size) / a.sigma))), 3) })} ${share}`;
}

// Of a calibration that is beside what was expected.
export const suspectWords = (certainty?: number): string => (certainty === undefined ? "" : t("certaintyOfSuspect", { n: certaintyText(certainty) }));
