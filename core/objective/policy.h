// Every constant of the decisions, with its meaning, its unit and why it has this value.
#ifndef AXISCAL_CORE_OBJECTIVE_POLICY_H_
#define AXISCAL_CORE_OBJECTIVE_POLICY_H_

#include <cstdint>

namespace axiscal::objective {

struct Policy {
  // What an effect must be worth beyond its own looks, chi-square units: the most that chance reaches in 99 of 100
  // data sets in which nothing is, over all families together.
  double evidence = 16.0;
  // Times ln(members of its family that the data see), chi-square units: 2 is what the largest of that many
  // independent chances needs.
  double per_look = 2.0;
  // For each free amplitude beyond the first, chi-square units: chance fits one more each.
  double per_column = 4.0;
  // For members of families that a plain name rivals, and for local structure without a name, which any name rivals,
  // chi-square units: decides ties in favour of the name (exp(-3) in odds), and no more.
  double exotic = 6.0;

  // Prior standard deviation of an effect's size in the rows, before set-ups and declared errors hide a part of it, as
  // a multiple of all that is left to explain (both root mean squares): what would have to act tens of times as
  // strongly as anything that is seen is less likely than a rival that need not, and would do so where nothing was
  // measured.
  double largest_hidden = 10.0;

  // A column of which less than this share of its squares is left beyond the declared errors and set-ups is not seen.
  double visible = 1e-5;
  // Members of scans (source.h) are taken to keep this share at least, until they are looked at closely: of those that
  // keep less, few are overlooked, as their neighbours show.
  double scan_visible = 0.2;
  // The same beyond the effects of a state: less cannot be told from a combination of them.
  double distinct = 1e-4;

  // The variance of a block's prior is looked for on a grid, in units of its prior spectrum over the mean eigenvalue of
  // its Gram matrix: from a part of one sigma to all that data can hold, a factor of e apart (the evidence is flat
  // within one).
  double smallest_log_variance = -6.0, largest_log_variance = 15.0;

  // Columns of each family on which the design effect is judged: with forty of them the quantile below moves by a
  // percent or two from draw to draw; with ten, names of a faint effect (case-012) hung on the draw.
  int design_columns = 40;
  // Quantile of the columns' design effects that counts: above the median, as too small a design effect names what is
  // not there; below the largest, which is the effect that is looked for.
  double design_quantile = 0.7;
  // Fewer clusters say nothing about how a column's products scatter over them: a variance from n of them is off by
  // sqrt(2 / n) of itself, here a third; with half as many one error that is still missing stops the search.
  int fewest_clusters = 16;

  // A replacement must gain this much, chi-square units: less is a matter of rounding and could go back and forth.
  double replacement_gain = 0.5;
  // First effects from which each start is followed.
  int beam = 3;
  // Additions that do not pay by themselves and are tried with what they make superfluous, per state.
  int trials = 3;
  // What explains as much within this could be it as well, chi-square units: odds of 20 to 1.
  double alike = 6.0;
  // Effects of one state, bad rows not counted: no machine has more that one data set tells; bounds the time of a
  // search.
  int most_effects = 200;
  // An effect with a shape is corrected only where the machine cannot be worse for it over the measured box: by more
  // than this share and this many mm rms (what nobody would notice does not count), with more than this probability
  // (what 95 % intervals leave).
  double harm_share = 0.1, harm_mm = 0.2e-3, harm_probability = 0.05;
  // Where no gain is held, what is left to correct (constants beside an instrument at fault, a slip, bad readings) must
  // take away this share of the expected error over the box: less is chance as often as not, and no reason to move a
  // machine.
  double least_gain = 0.25;
  // What is left over the box is stated with more than the fit's own uncertainty: the true form of an effect is off
  // from the one that is named by this share of what it does there (one standard deviation; it was found among the
  // forms of a dictionary), and standard uncertainties are known to this share of themselves (noise and its correlation
  // are judged from the same readings).
  double form_share = 0.25, sigma_share = 0.3;
  // Odds of the orders or pitches that the measured positions do not tell from what was found fall with this power of
  // the frequency: between 1 (a gear may have any number of teeth, and each factor of numbers is as likely) and 2 (the
  // power spectrum of worn and ground surfaces).
  double order_falloff = 1.5;
  // Of the columns that are drawn for the design effect: the same data give the same result.
  uint32_t seed = 1;
};

}  // namespace axiscal::objective

#endif  // AXISCAL_CORE_OBJECTIVE_POLICY_H_
