#include "core/figures/eccentricities.h"

#include <algorithm>
#include <cmath>

#include "absl/strings/str_format.h"
#include "core/base/units.h"
#include "core/figures/noise.h"
#include "core/instruments/run.h"

namespace axiscal::figures {
namespace {

using instruments::MeasuringRun;

constexpr const char* kNames[] = {"ex", "ey", "ez"};

// Readings of one sense, and the weights that make a centre of them.
struct OfSense {
  int sense = 0;
  std::vector<int> readings;
  Eigen::Matrix3Xd weights;
  Eigen::RowVectorXd radius;
};

std::vector<OfSense> Senses(const machine::Machine& machine, const MeasuringRun& run, const eccentricity::Path& path) {
  std::vector<OfSense> senses;
  for (const int sense : {1, -1}) {
    OfSense of{sense, {}, {}, {}};
    std::vector<double> angles;
    double low = INFINITY, high = -INFINITY;
    for (int k = 0; k < run.reading_count(); ++k) {
      if ((run.StateOf(k).axes[static_cast<size_t>(path.axis)].sense < 0.0) != (sense < 0)) continue;
      of.readings.push_back(k);
      angles.push_back(run.PositionsOf(k)[path.axis]);
      low = std::min(low, angles.back());
      high = std::max(high, angles.back());
    }
    constexpr size_t kFewest = 10;
    constexpr double kLeastRad = 30.0 * base::kRadPerDeg;
    if (angles.size() < kFewest || high - low < kLeastRad) continue;
    of.weights = eccentricity::CentreWeights(machine, path, angles, &of.radius);
    senses.push_back(std::move(of));
  }
  return senses;
}

Eigen::VectorXd ReadingsOf(const MeasuringRun& run, const OfSense& of) {
  Eigen::VectorXd readings(static_cast<Eigen::Index>(of.readings.size()));
  for (size_t i = 0; i < of.readings.size(); ++i)
    readings[static_cast<Eigen::Index>(i)] = run.measured_mm(0, of.readings[i]);
  return readings;
}

const char* WordOf(int sense) { return sense > 0 ? "rising" : "falling"; }

}  // namespace

absl::StatusOr<RunEccentricities> EccentricitiesOf(const machine::Machine& machine, const MeasuringRun& run) {
  RunEccentricities out;
  ASSIGN_OR_RETURN(out.path, eccentricity::PathOf(machine, run));
  for (const OfSense& of : Senses(machine, run, out.path)) {
    const Eigen::VectorXd readings = ReadingsOf(run, of);
    Eccentricity one{of.sense, static_cast<int>(readings.size()), of.weights * readings,
                     run.sigma_mm * of.weights.rowwise().norm(), of.radius.dot(readings)};
    for (int c = 0; c < 3; ++c)
      if (!eccentricity::Shows(machine, out.path, c)) one.centre_mm[c] = one.sigma_mm[c] = NAN;
    out.by_sense.push_back(one);
  }
  if (out.by_sense.empty()) return absl::InvalidArgumentError("fewer than ten readings over 30 deg in either sense");
  return out;
}

MeasuredTest EccentricityTest(const machine::Machine& machine, const MeasuringRun& run,
                              const RunEccentricities& found) {
  MeasuredTest test;
  test.kind = "eccentricity";
  test.what = absl::StrCat("eccentricity, ", eccentricity::ToText(machine, found.path));
  test.sessions = {run.session};
  test.temperature_celsius = MeanTemperature({&run});
  NoteStated({&run}, &test.notes);
  const std::vector<OfSense> senses = Senses(machine, run, found.path);
  test.figures = WithNoise([&](const std::function<double()>& noise, bool is_alone) {
    std::vector<double> off;  // each stated fact, by so many standard uncertainties
    for (size_t i = 0; i < run.stated.size(); ++i) off.push_back(noise());
    std::vector<Figure> figures;
    for (const OfSense& of : senses) {
      Eigen::VectorXd readings = ReadingsOf(run, of);
      if (is_alone) readings.setZero();
      for (Eigen::Index i = 0; i < readings.size(); ++i) {
        readings[i] += run.sigma_mm * noise();
        for (size_t f = 0; f < off.size(); ++f)
          readings[i] += off[f] * run.stated[f].by_sigma_mm(0, of.readings[static_cast<size_t>(i)]);
      }
      const Eigen::Vector3d centre_mm = of.weights * readings;
      const char* const suffix = of.sense > 0 ? "(up)" : "(down)";
      for (int c = 0; c < 3; ++c) {
        if (eccentricity::Shows(machine, found.path, c))
          figures.push_back({absl::StrCat(kNames[c], suffix),
                             absl::StrCat("centre of the polar trace, ", WordOf(of.sense)), centre_mm[c]});
      }
      figures.push_back({absl::StrCat("r0", suffix),
                         absl::StrCat("its radius beside the bar's length, ", WordOf(of.sense)),
                         of.radius.dot(readings)});
    }
    return figures;
  });
  return test;
}

absl::StatusOr<session::Session> EccentricitySession(const machine::Machine& machine,
                                                     const std::vector<session::Session>& sessions,
                                                     const std::string& name) {
  session::Session out;
  out.columns = {{"run", {}, {}}, {"sense", {}, {}}, {"ex_um", {}, {}}, {"ey_um", {}, {}}, {"ez_um", {}, {}}};
  double sigma_mm = 0.0;
  std::vector<session::HeaderEntry> paths;
  const auto is_of_mounting = [](const std::string& key) {
    return key == "machine" || key == "tool_tip_mm" || key == "table_ball_mm" || key == "bar_length_mm" ||
           key.ends_with("_sigma_um");
  };
  for (const session::Session& session : sessions) {
    ASSIGN_OR_RETURN(const instruments::MeasuringRun run, instruments::BindSession(session, machine));
    std::vector<session::HeaderEntry> mounting;
    for (const session::HeaderEntry& entry : session.header)
      if (is_of_mounting(entry.key)) mounting.push_back(entry);
    if (out.header.empty()) {
      out.header = mounting;
    } else if (out.header != mounting) {
      return absl::InvalidArgumentError(absl::StrCat(
          "session ", run.session, ": its machine, tool, ball, bar or stated set-up is not that of session ",
          sessions[0].header.empty() ? "" : *session::FindHeader(sessions[0], "session"), ", expected one mounting"));
    }
    const auto found = run.kind == instruments::Kind::kBallbar
                           ? EccentricitiesOf(machine, run)
                           : absl::StatusOr<RunEccentricities>(absl::InvalidArgumentError("it is of no ball bar"));
    if (!found.ok()) return base::Within(absl::StrCat("session ", run.session), found.status());
    std::string run_name;
    for (const char c : run.session) run_name += c == ' ' || c == ',' || c == ':' ? '-' : c;
    paths.push_back({"path " + run_name, eccentricity::ToText(machine, found->path)});
    for (const Eccentricity& one : found->by_sense) {
      out.columns[0].texts.push_back(run_name);
      out.columns[1].values.push_back(one.sense);
      for (size_t c = 0; c < 3; ++c) {
        out.columns[2 + c].values.push_back(one.centre_mm[static_cast<Eigen::Index>(c)] * base::kUmPerMm);
        const double sigma = one.sigma_mm[static_cast<Eigen::Index>(c)];
        if (std::isfinite(sigma)) sigma_mm = std::max(sigma_mm, sigma);
      }
    }
  }
  out.header.insert(out.header.begin() + 1,
                    {{"session", name},
                     {"instrument", "eccentricity"},
                     {"sigma_um", absl::StrFormat("%.3g", std::max(sigma_mm * base::kUmPerMm, 1e-3))}});
  out.header.insert(out.header.end(), paths.begin(), paths.end());
  return out;
}

}  // namespace axiscal::figures
