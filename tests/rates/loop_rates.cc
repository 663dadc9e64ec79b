// Rates at which the loop names what went into simulated machines: `loop_rates KIND COUNT [FIRST_SEED] [-v]`, KIND one
// of null one pair dirty dirty-null misstated bump slip probe-slip wander wander-null coarse coarse-null, with `dense-`
// before it of ten times as many readings; or how often
// the sessions that it proposes leave the true effect alone in its class: `loop_rates next COUNT [FIRST_SEED] [-v]`,
// COUNT machines with one effect; or what the loop leaves of the error over the box of machines with other physics:
// `loop_rates physics KIND COUNT [FIRST_SEED] [-t] [-v]`, KIND one of physics_case.h; -t: also of a loop that is told
// the form, which takes twice as long. -v prints every case, otherwise those that went wrong.
#include <algorithm>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <map>
#include <string>
#include <vector>

#include "tests/rates/next_session.h"
#include "tests/rates/physics_score.h"
#include "tests/rates/score.h"

namespace {

double Quantile(std::vector<double> values, double share) {
  if (values.empty()) return 0.0;
  std::sort(values.begin(), values.end());
  return values[std::min(values.size() - 1, static_cast<size_t>(share * static_cast<double>(values.size())))];
}

int NextRates(int count, int first, bool is_verbose) {
  int held = 0, shrunk = 0;
  double seconds = 0.0;
  for (int seed = first; seed < first + count; ++seed) {
    const axiscal::rates::NextScore score = axiscal::rates::JudgeNext(seed);
    held += score.held_others;
    shrunk += score.held_others && score.is_alone;
    seconds += score.seconds;
    if (is_verbose || (score.held_others && !score.is_alone)) std::printf("next %d: %s\n", seed, score.text.c_str());
    std::fflush(stdout);
  }
  std::printf(
      "next: %d cases, the class held the truth and others in %d, the truth alone after the proposed sessions "
      "in %d (%.1f %%); %.2f s each\n",
      count, held, shrunk, held > 0 ? 100.0 * shrunk / held : 100.0, seconds / count);
  return 0;
}

int PhysicsRates(const char* word, int count, int first, bool is_verbose, bool with_told) {
  const char* const* const words = axiscal::rates::PhysicsWords();
  int kind = 0;
  while (words[kind] != nullptr && std::strcmp(words[kind], word) != 0) ++kind;
  if (words[kind] == nullptr) {
    std::fprintf(stderr, "loop_rates physics: '%s' is no kind, expected one of", word);
    for (int i = 0; words[i] != nullptr; ++i) std::fprintf(stderr, " %s", words[i]);
    std::fprintf(stderr, "\n");
    return 2;
  }
  std::vector<double> before, all, after, told, known, seconds;
  std::map<std::string, int> verdicts;
  int causes = 0, right = 0, in_class = 0, silent = 0, wrong = 0, harmed = 0, promised = 0, broken = 0;
  int intervals = 0, held = 0, would_harm = 0, held_back = 0;
  for (int seed = first; seed < first + count; ++seed) {
    const axiscal::rates::PhysicsScore score = axiscal::rates::JudgePhysics(
        axiscal::rates::DrawPhysics(static_cast<axiscal::rates::Physics>(kind), seed), with_told);
    before.push_back(score.before_um);
    after.push_back(score.after_um);
    told.push_back(score.told_um);
    known.push_back(score.known_um);
    seconds.push_back(score.seconds);
    ++verdicts[score.Verdict()];
    causes += score.causes;
    right += score.right;
    in_class += score.in_class;
    silent += score.silent;
    wrong += score.wrong;
    harmed += score.IsHarmed();
    would_harm += score.WouldBeHarmed();
    held_back += score.held_back > 0;
    all.push_back(score.all_um);
    promised += score.is_gain_held;
    broken += score.is_gain_held && score.after_um > score.before_um;
    intervals += score.has_interval;
    held += score.has_interval && score.IsIntervalRight();
    if (is_verbose || score.IsHarmed())
      std::printf("%s %d: %s%s %.3f -> %.3f um (told the form %.3f, knows %.3f), %.1f s:%s\n", word, seed,
                  score.IsHarmed() ? "HARMED " : "", score.Verdict(), score.before_um, score.after_um, score.told_um,
                  score.known_um, score.seconds, score.text.c_str());
    std::fflush(stdout);
  }
  std::printf(
      "physics %s: %d cases, over the box %.3f -> %.3f um (medians; told the form %.3f, who knows %.3f), harmed %d; "
      "%.2f s median, %.2f s worst\n  held back in %d; if nothing were: %.3f um, harmed %d\n",
      word, count, Quantile(before, 0.5), Quantile(after, 0.5), Quantile(told, 0.5), Quantile(known, 0.5), harmed,
      Quantile(seconds, 0.5), Quantile(seconds, 1.0), held_back, Quantile(all, 0.5), would_harm);
  std::printf(
      "  cases right %d, in class %d, silent %d, wrong %d; causes named %d of %d, %d more in classes, %d not; beside "
      "them %d\n  a gain over the box promised in %d, %d of them worse; %d of %d intervals hold what is left\n",
      verdicts["right"], verdicts["in class"], verdicts["silent"], verdicts["wrong"], right, causes, in_class, silent,
      wrong, promised, broken, held, intervals);
  return 0;
}

}  // namespace

int main(int argc, char** argv) {
  using axiscal::rates::Kind;
  const std::map<std::string, Kind> kinds = {{"null", Kind::kNull},
                                             {"one", Kind::kOne},
                                             {"pair", Kind::kPair},
                                             {"dirty", Kind::kDirty},
                                             {"dirty-null", Kind::kDirtyNull},
                                             {"misstated", Kind::kMisstated},
                                             {"bump", Kind::kBump},
                                             {"slip", Kind::kSlip},
                                             {"probe-slip", Kind::kProbeSlip},
                                             {"wander", Kind::kWander},
                                             {"wander-null", Kind::kWanderNull},
                                             {"coarse", Kind::kCoarse},
                                             {"coarse-null", Kind::kCoarseNull}};
  const bool is_next = argc >= 3 && std::strcmp(argv[1], "next") == 0;
  const bool is_verbose = std::strcmp(argv[argc - 1], "-v") == 0;
  if (argc >= 4 && std::strcmp(argv[1], "physics") == 0) {
    const int first_seed = argc > 4 ? std::max(1, std::atoi(argv[4])) : 1;
    const bool with_told =
        std::any_of(argv + 4, argv + argc, [](const char* word) { return !std::strcmp(word, "-t"); });
    return PhysicsRates(argv[2], std::atoi(argv[3]), first_seed, is_verbose, with_told);
  }
  const std::string word = argc > 1 ? argv[1] : "";
  constexpr char kDensePrefix[] = "dense-";
  const bool is_dense = word.starts_with(kDensePrefix);
  const std::string name = is_dense ? word.substr(sizeof kDensePrefix - 1) : word;
  if (argc < 3 || (!is_next && !kinds.contains(name))) {
    std::fprintf(stderr,
                 "usage: loop_rates [dense-]"
                 "null|one|pair|dirty|dirty-null|misstated|bump|slip|probe-slip|wander|wander-null|coarse|coarse-null|"
                 "next COUNT "
                 "[FIRST_SEED] [-v]\n       loop_rates physics KIND COUNT [FIRST_SEED] [-t] [-v]\n");
    return 2;
  }
  const int count = std::atoi(argv[2]);
  const int first = argc > 3 ? std::atoi(argv[3]) : 1;
  if (is_next) return NextRates(count, first, is_verbose);
  const Kind kind = kinds.at(name);
  constexpr int kDense = 10;
  axiscal::rates::Score total;
  int spurious_cases = 0, noticed = 0, left_alone = 0;
  std::vector<double> check_ratio, sigma_ratio, seconds;
  for (int seed = first; seed < first + count; ++seed) {
    const axiscal::rates::Score score =
        axiscal::rates::Judge(axiscal::rates::Draw(kind, seed, is_dense ? kDense : 1), kind);
    total.effects += score.effects;
    total.named += score.named;
    total.first += score.first;
    total.spurious += score.spurious;
    spurious_cases += score.spurious > 0;
    noticed += score.is_structure_noticed;
    left_alone += score.spurious == 0 && score.effects == 0;
    total.bad += score.bad;
    total.bad_listed += score.bad_listed;
    total.good += score.good;
    total.good_listed += score.good_listed;
    check_ratio.push_back(score.check_ratio);
    sigma_ratio.push_back(std::max(score.sigma_ratio, 1.0 / score.sigma_ratio));
    seconds.push_back(score.seconds);
    const bool is_wrong = score.named < score.effects || score.spurious > 0 ||
                          ((kind == Kind::kBump || IsSlip(kind)) && !score.is_structure_noticed);
    if (is_verbose || is_wrong)
      std::printf("%s %d: %s  check x%.3f sigma x%.2f %.2f s\n", argv[1], seed, score.text.c_str(), score.check_ratio,
                  score.sigma_ratio, score.seconds);
    std::fflush(stdout);
  }
  std::printf("%s: %d cases, effects named %d of %d (own name %d), spurious in %d cases, noticed %d, left alone %d\n",
              argv[1], count, total.named, total.effects, total.first, spurious_cases, noticed, left_alone);
  std::printf("  bad readings listed %d of %d, good ones listed %d of %d; sigma off by x%.3f median, x%.3f at 95 %%\n",
              total.bad_listed, total.bad, total.good_listed, total.good, Quantile(sigma_ratio, 0.5),
              Quantile(sigma_ratio, 0.95));
  std::printf(
      "  check rms over that of a fit that knows: %.4f median, %.4f at 95 %%, %.4f worst; %.2f s median, %.2f s "
      "worst\n",
      Quantile(check_ratio, 0.5), Quantile(check_ratio, 0.95), Quantile(check_ratio, 1.0), Quantile(seconds, 0.5),
      Quantile(seconds, 1.0));
  return 0;
}
