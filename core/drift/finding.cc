#include "core/drift/finding.h"

#include <absl/strings/str_cat.h>
#include <absl/strings/str_format.h>
#include <absl/strings/str_join.h>

#include <algorithm>
#include <array>
#include <cmath>

namespace axiscal::drift {
namespace {

struct Date {
  std::chrono::year_month_day day;
  int64_t minutes = 0;  // of the day
};

Date DateOf(base::UtcTime at) {
  const auto day = std::chrono::floor<std::chrono::days>(at);
  return {std::chrono::year_month_day(day), std::chrono::duration_cast<std::chrono::minutes>(at - day).count()};
}

std::string DayText(const Date& date) { return absl::StrCat(static_cast<unsigned>(date.day.day())); }

std::string MonthText(const Date& date) {
  static constexpr std::array kMonths = {"January", "February", "March",     "April",   "May",      "June",
                                         "July",    "August",   "September", "October", "November", "December"};
  return kMonths[static_cast<unsigned>(date.day.month()) - 1];
}

std::string YearText(const Date& date) { return absl::StrCat(static_cast<int>(date.day.year())); }

std::string FullText(const Date& date) {
  return absl::StrCat(DayText(date), " ", MonthText(date), " ", YearText(date));
}

std::string ClockText(const Date& date) {
  return absl::StrFormat("%02d:%02d UTC", date.minutes / 60, date.minutes % 60);
}

std::string BetweenText(base::UtcTime after, base::UtcTime by) {
  const Date from = DateOf(after), to = DateOf(by);
  if (from.day == to.day)
    return absl::StrCat("on ", FullText(from), " between ", ClockText(from), " and ", ClockText(to));
  const bool same_year = from.day.year() == to.day.year();
  const bool same_month = same_year && from.day.month() == to.day.month();
  std::string start = DayText(from);
  if (!same_month) absl::StrAppend(&start, " ", MonthText(from));
  if (!same_year) absl::StrAppend(&start, " ", YearText(from));
  return absl::StrCat("between ", start, " and ", FullText(to));
}

// As many digits as the sigma leaves: two of the sigma at most, never more than three decimals.
std::string AmountText(const Amount& amount, double sigma) {
  const int decimals = sigma >= 1.0 ? 0 : sigma >= 0.1 ? 1 : sigma >= 0.01 ? 2 : 3;
  const std::string text = absl::StrFormat("%.*f", decimals, amount.size);
  const bool is_zero = text.find_first_of("123456789") == std::string::npos;
  return is_zero && text.front() == '-' ? text.substr(1) : text;
}

std::string And(const std::vector<std::string>& words) {
  if (words.size() < 2) return absl::StrJoin(words, "");
  return absl::StrCat(absl::StrJoin(words.begin(), words.end() - 1, ", "), " and ", words.back());
}

struct Parts {
  std::string symbols, sizes;
};

Parts PartsOf(const std::vector<Amount>& amounts) {
  std::vector<std::string> symbols, sizes;
  for (const Amount& amount : amounts) {
    symbols.push_back(amount.symbol);
    sizes.push_back(absl::StrCat(AmountText(amount, amount.sigma), " ", Text(amount.unit)));
  }
  return {And(symbols), And(sizes)};
}

// Never "100 %": nothing here is that sure.
std::string CertaintyText(double certainty) {
  const double percent = std::clamp(100.0 * certainty, 0.0, 99.9);
  return absl::StrFormat(percent >= 99.0 ? "certainty %.1f %%" : "certainty %.0f %%", percent);
}

std::string TextOf(const StepChange& step) {
  const Parts parts = PartsOf(step.amounts);
  return absl::StrCat(step.is_revision ? "corrected: " : "", BetweenText(step.after, step.by), " ", parts.symbols,
                      " jumped ", step.amounts.size() > 1 ? "together " : "", "by ", parts.sizes, ", ",
                      step.word == Word::kCertain ? "" : absl::StrCat(Text(step.word), ", "),
                      CertaintyText(step.certainty));
}

std::string TextOf(const Retraction& retraction) {
  return absl::StrCat(And(retraction.symbols), " went back: what was told as a jump ",
                      BetweenText(retraction.after, retraction.by), " was a bad calibration rather");
}

std::string TextOf(const Suspect& suspect) {
  const Parts parts = PartsOf(suspect.amounts);
  return absl::StrCat("the calibration of ", FullText(DateOf(suspect.at)), " has ", parts.symbols, " off by ",
                      parts.sizes, " from what was expected: a bad calibration or a jump, repeat it; ",
                      CertaintyText(suspect.certainty));
}

std::string TextOf(const Slope& slope) {
  const Amount& rate = slope.per_year;
  if (slope.is_over) return absl::StrCat(rate.symbol, " no longer wears one way");
  return absl::StrCat(rate.symbol, " wears by ", AmountText(rate, rate.sigma), " +- ",
                      AmountText({rate.symbol, rate.unit, rate.sigma, rate.sigma}, rate.sigma), " ", Text(rate.unit),
                      " a year, ", CertaintyText(slope.certainty));
}

std::string TextOf(const Season& season) {
  const Amount& yearly = season.amplitude;
  if (season.is_over) return absl::StrCat(yearly.symbol, " no longer goes with the season");
  std::string text = absl::StrCat(yearly.symbol, " goes with the season by ", AmountText(yearly, yearly.sigma), " ",
                                  Text(yearly.unit), " to either side");
  if (season.per_kelvin)
    text = absl::StrCat(yearly.symbol, " goes with the temperature by ",
                        AmountText(*season.per_kelvin, season.per_kelvin->sigma), " ", Text(yearly.unit),
                        " per K, and by ", AmountText(yearly, yearly.sigma), " ", Text(yearly.unit),
                        " to either side with the season");
  return absl::StrCat(text, ", ", CertaintyText(season.certainty));
}

std::string TextOf(const Noise& noise) {
  if (noise.is_over) return absl::StrCat(noise.symbol, " scatters as its calibrations state");
  return absl::StrFormat("%s scatters from calibration to calibration %.1f times as much as its calibrations state",
                         noise.symbol, noise.factor);
}

std::string TextOf(const Unstable& unstable) {
  return absl::StrCat("the calibrations from ", FullText(DateOf(unstable.since)), " to ", FullText(DateOf(unstable.at)),
                      " agree neither with those before nor with each other: the machine or the measurement is not "
                      "stable, and its history starts anew");
}

}  // namespace

const char* Text(Word word) {
  return word == Word::kPossible ? "possible" : word == Word::kProbable ? "probable" : "certain";
}

std::string Text(const Finding& finding) {
  return std::visit([](const auto& one) { return TextOf(one); }, finding);
}

Word WordOf(double score) { return score < 1.0 ? Word::kPossible : score <= 4.0 ? Word::kProbable : Word::kCertain; }

double CertaintyOf(double score) {
  // Score and share of right alarms, read off histories that were drawn for that (docs/drift.md, "Certainty").
  static constexpr double kTable[][2] = {{-1.0, 0.40}, {-0.5, 0.50},  {0.0, 0.57},  {0.5, 0.66},
                                         {1.5, 0.77},  {2.5, 0.86},   {3.5, 0.91},  {5.0, 0.95},
                                         {8.0, 0.975}, {12.0, 0.985}, {25.0, 0.995}};
  constexpr int kRows = sizeof(kTable) / sizeof(kTable[0]);
  if (score <= kTable[0][0]) return kTable[0][1];
  for (int i = 1; i < kRows; ++i) {
    if (score > kTable[i][0]) continue;
    const double share = (score - kTable[i - 1][0]) / (kTable[i][0] - kTable[i - 1][0]);
    return kTable[i - 1][1] + share * (kTable[i][1] - kTable[i - 1][1]);
  }
  return kTable[kRows - 1][1];
}

}  // namespace axiscal::drift
