// Fang 2022, ch. 4: one sphere, two patterns, eleven errors of a belt grinder. The thesis' exact model is the engine's;
// its first-order equations, its staged identification and its printed chain stand here for comparison only.
#include "tests/known_answers/fang_grinder.h"

#include <gtest/gtest.h>

#include <Eigen/QR>
#include <Eigen/SVD>
#include <random>
#include <set>

#include "core/base/files.h"
#include "core/base/testing/source_path.h"
#include "core/identify/identify.h"
#include "core/identify/monte_carlo.h"
#include "core/instruments/evaluation.h"
#include "core/synthetic/simulate.h"
#include "tests/known_answers/published.h"

namespace axiscal::known_answers::grinder {
namespace {

std::string TextOf(const Vector3d& v) { return absl::StrFormat("%.17g %.17g %.17g", v.x(), v.y(), v.z()); }

// The linear commands by the engine: what a `centres` reading says, less the tool point as the rotary axes turn it.
std::vector<Vector3d> EngineCommands(const Lines& lines, const std::vector<RotaryPose>& poses) {
  const InEngine engine = ToEngine(lines);
  session::Session session = CentresSession("engine", poses, 0.0, 1e-3, TextOf(engine.tip_mm));
  for (const char* name : {"cx_mm", "cy_mm", "cz_mm"})
    session.columns.push_back({name, std::vector<double>(poses.size(), 0.0), {}});
  const auto run = instruments::BindSession(session, Machine());
  EXPECT_TRUE(run.ok()) << run.status();
  std::vector<Vector3d> commands;
  for (size_t k = 0; k < poses.size(); ++k) {
    const double no_setup[3] = {};
    Vector3d reading;
    instruments::Predict(Machine(), *run, static_cast<int>(k), engine.errors, no_setup, reading.data());
    double rotary_only[6] = {0, 0, poses[k].b_deg * base::kRadPerDeg, poses[k].c_deg * base::kRadPerDeg, 0, 0};
    commands.push_back(reading -
                       machine::EvaluateChain<double>(Machine(), rotary_only, {}).bed_from_tool * engine.tip_mm);
  }
  return commands;
}

TEST(FangGrinder, TestVectors) {
  const struct {
    RotaryPose pose;
    Vector3d commands;
  } rows[] = {{{0, 0}, {-269.740000, 287.435000, 469.720000}},     {{0, 45}, {-625.246841, 69.412652, 469.629932}},
              {{0, 90}, {-722.463059, -336.133635, 469.343272}},   {{16, 70}, {-711.519179, -146.254615, 618.776027}},
              {{-20, 90}, {-673.537243, -337.133653, 288.380494}}, {{20, 90}, {-706.544768, -335.314629, 656.127103}},
              {{45, 90}, {-599.120320, -334.692830, 863.626127}}};
  constexpr double kToleranceMm = 1e-6;
  for (const auto& row : rows) {
    const Lines lines = LinesOf(Given());
    EXPECT_LT((CommandsAt(lines, row.pose.b_deg, row.pose.c_deg) - row.commands).cwiseAbs().maxCoeff(), kToleranceMm);
    EXPECT_LT((EngineCommands(lines, {row.pose})[0] - row.commands).cwiseAbs().maxCoeff(), kToleranceMm);
  }
}

// The errors in our symbols: exact, and what the first order misses.
TEST(FangGrinder, TheSameErrorsInOurSymbols) {
  const Unknowns u = Given();
  const InEngine engine = ToEngine(LinesOf(u));
  constexpr double kPrinted = 1e-7;
  EXPECT_NEAR(engine.errors[kJointC][0], -0.1494809, kPrinted);
  EXPECT_NEAR(engine.errors[kJointC][1], -1.9573621, kPrinted);
  EXPECT_NEAR(engine.errors[kJointB][5] * base::kDegPerRad, -0.1838980, kPrinted);
  EXPECT_NEAR(engine.errors[kJointC][3] * base::kDegPerRad, 0.3102596, kPrinted);
  EXPECT_NEAR(engine.errors[kJointC][4] * base::kDegPerRad, 0.0130959, kPrinted);
  EXPECT_LT((engine.tip_mm - Vector3d(87.1496151, -287.8689624, -452.1015989)).cwiseAbs().maxCoeff(), kPrinted);
  EXPECT_DOUBLE_EQ(engine.errors[kJointB][0], u[kExob]);
  EXPECT_NEAR(engine.errors[kJointB][2], -u[kEzob], 1e-12);  // the thesis counts downwards
  const Design design;
  const double a_b = u[kEaob] * base::kRadPerDeg, c_b = u[kEcob] * base::kRadPerDeg;
  constexpr double kSecondOrderMm = 0.02;  // 500 mm times (0.3 deg)^2
  EXPECT_NEAR(engine.errors[kJointC][0], u[kExoc] - u[kExob] + c_b * design.rcy, kSecondOrderMm);
  EXPECT_NEAR(engine.errors[kJointC][1], u[kEyoc] - c_b * (design.rcx - design.rbx) + a_b * design.rbz, kSecondOrderMm);
  EXPECT_NEAR(engine.errors[kJointC][3] * base::kDegPerRad, u[kEaoc] - u[kEaob], 1e-3);
  EXPECT_NEAR(engine.errors[kJointC][4] * base::kDegPerRad, u[kEboc], 1e-3);
  EXPECT_LT((FromEngine(engine.errors[kJointB], engine.errors[kJointC], engine.tip_mm) - u).cwiseAbs().maxCoeff(),
            1e-9);
}

Matrix3d Skew(const Vector3d& v) {
  Matrix3d m;
  m << 0, -v.z(), v.y(), v.z(), 0, -v.x(), -v.y(), v.x(), 0;
  return m;
}

struct FirstOrder {
  Matrix3d r_y, r_z, s_b, s_c;
  FirstOrder(const Unknowns& u, const RotaryPose& pose)
      : r_y(Eigen::AngleAxisd(pose.b_deg * base::kRadPerDeg, Vector3d::UnitY())),
        r_z(Eigen::AngleAxisd(pose.c_deg * base::kRadPerDeg, Vector3d::UnitZ())),
        s_b(Skew(base::kRadPerDeg * Vector3d(u[kEaob], 0, u[kEcob]))),
        s_c(Skew(base::kRadPerDeg * Vector3d(u[kEaoc], u[kEboc], 0))) {}
};

// Equations 4.23 to 4.25 and 4.30 to 4.32 in one formula.
Vector3d PublishedFirstOrder(const Unknowns& u, const RotaryPose& pose) {
  const Lines lines = LinesOf(u);
  const FirstOrder f(u, pose);
  const Vector3d arm = lines.probe - lines.point_of_c;
  const Vector3d q0 = f.r_z * arm + lines.point_of_c - lines.point_of_b, q1 = (f.s_c * f.r_z - f.r_z * f.s_c) * arm;
  return f.r_y * (q0 + q1) + (f.s_b * f.r_y - f.r_y * f.s_b) * q0 + lines.point_of_b;
}

// Equations 4.7 to 4.9 as printed: I + S and I - S in the place of rotations.
Vector3d PrintedChain(const Unknowns& u, const RotaryPose& pose) {
  const Lines lines = LinesOf(u);
  const FirstOrder f(u, pose);
  const Matrix3d one = Matrix3d::Identity();
  const Matrix3d turn_b = (one + f.s_b) * f.r_y * (one - f.s_b), turn_c = (one + f.s_c) * f.r_z * (one - f.s_c);
  return lines.point_of_b + turn_b * (lines.point_of_c - lines.point_of_b + turn_c * (lines.probe - lines.point_of_c));
}

// Largest difference from the exact model over a pattern, um per coordinate.
template <typename Formula>
Vector3d LargestOffUm(const Formula& formula, const std::vector<RotaryPose>& poses) {
  Vector3d largest = Vector3d::Zero();
  const Lines lines = LinesOf(Given());
  for (const RotaryPose& pose : poses) {
    const Vector3d off = formula(Given(), pose) - ProbeAt(lines, pose.b_deg, pose.c_deg);
    largest = largest.cwiseMax(off.cwiseAbs() / base::kMmPerUm);
  }
  return largest;
}

TEST(FangGrinder, ThePublishedEquationsAreFirstOrder) {
  const double one_um = LargestOffUm(PublishedFirstOrder, PatternOne()).maxCoeff();
  const double two_um = LargestOffUm(PublishedFirstOrder, PatternTwo()).maxCoeff();
  EXPECT_LE(one_um, 0.4);
  EXPECT_GT(one_um, 0.3);
  EXPECT_LE(two_um, 5.5);
  EXPECT_GT(two_um, 5.4);
}

TEST(FangGrinder, ThePrintedChainTurnsByWhatIsNoRotation) {
  std::vector<RotaryPose> poses = PatternOne();
  for (const RotaryPose& pose : PatternTwo()) poses.push_back(pose);
  const Vector3d off_um = LargestOffUm(PrintedChain, poses);
  EXPECT_NEAR(off_um.x(), 5.1, 0.1);
  EXPECT_NEAR(off_um.y(), 10.8, 0.1);
  EXPECT_NEAR(off_um.z(), 11.4, 0.1);
  EXPECT_GT(LargestOffUm(PrintedChain, {{0, 0}}).maxCoeff(), 5.0);  // even at home
}

Vector3d PlaneNormal(const std::vector<Vector3d>& points) {
  Eigen::MatrixXd centred(points.size(), 3);
  for (size_t k = 0; k < points.size(); ++k) centred.row(k) = points[k].transpose();
  centred.rowwise() -= centred.colwise().mean().eval();
  return Eigen::JacobiSVD<Eigen::MatrixXd>(centred, Eigen::ComputeThinV).matrixV().col(2);
}

// The published stages: normals of the two planes, then linear least squares. `one`, `two`: w at the poses.
Unknowns Staged(const std::vector<Vector3d>& one, const std::vector<Vector3d>& two) {
  Unknowns u = Unknowns::Zero();
  const Design design;
  const Vector3d v1 = PlaneNormal(one), v2 = PlaneNormal(two);
  u[kEaoc] = std::atan(-v1.y() / v1.z()) * base::kDegPerRad;
  u[kEboc] = std::atan(v1.x() / v1.z()) * base::kDegPerRad;
  u[kEaob] = std::atan(v2.z() / v2.y()) * base::kDegPerRad;
  u[kEcob] = std::atan(-v2.x() / v2.y()) * base::kDegPerRad;
  const auto poses_one = PatternOne(), poses_two = PatternTwo();
  Eigen::MatrixXd rows(3 * one.size(), 5);  // arm x y z, point of C x y
  Eigen::VectorXd right(3 * one.size());
  for (size_t k = 0; k < one.size(); ++k) {
    const FirstOrder f(u, poses_one[k]);
    rows.block<3, 3>(3 * k, 0) = f.r_z + f.s_c * f.r_z - f.r_z * f.s_c;
    rows.block<3, 2>(3 * k, 3) = Matrix3d::Identity().leftCols<2>();
    right.segment<3>(3 * k) = one[k];
  }
  const Eigen::VectorXd first = rows.colPivHouseholderQr().solve(right);
  const Vector3d arm = first.head<3>(), point_of_c(first[3], first[4], 0), probe = arm + point_of_c;
  u[kDrpx] = probe.x();
  u[kDrpy] = -probe.y();
  u[kDrpz] = -probe.z();
  u[kExoc] = point_of_c.x() - design.rcx;
  u[kEyoc] = point_of_c.y() - design.rcy;
  Eigen::MatrixXd rows_b(3 * two.size(), 2);  // point of B x z
  Eigen::VectorXd right_b(3 * two.size());
  for (size_t k = 0; k < two.size(); ++k) {
    const FirstOrder f(u, poses_two[k]);
    const Matrix3d tilt = f.s_b * f.r_y - f.r_y * f.s_b;
    const Vector3d q = f.r_z * arm + point_of_c;
    const Matrix3d of_point = Matrix3d::Identity() - f.r_y - tilt;
    rows_b.block<3, 1>(3 * k, 0) = of_point.col(0);
    rows_b.block<3, 1>(3 * k, 1) = of_point.col(2);
    right_b.segment<3>(3 * k) = two[k] - f.r_y * (q + (f.s_c * f.r_z - f.r_z * f.s_c) * arm) - tilt * q;
  }
  const Eigen::VectorXd point_of_b = rows_b.colPivHouseholderQr().solve(right_b);
  u[kExob] = point_of_b[0] - design.rbx;
  u[kEzob] = -point_of_b[1] - design.rbz;
  return u;
}

std::vector<Vector3d> ExactPoints(const std::vector<RotaryPose>& poses) {
  std::vector<Vector3d> points;
  for (const RotaryPose& pose : poses) points.push_back(ProbeAt(LinesOf(Given()), pose.b_deg, pose.c_deg));
  return points;
}

TEST(FangGrinder, TheStagesAreOffByTheirLinearisation) {
  const Unknowns off = Staged(ExactPoints(PatternOne()), ExactPoints(PatternTwo())) - Given();
  for (int i = 0; i < 11; ++i) {
    const double expected = i == kExob ? 0.0080 : i == kEzob ? 0.0012 : 0.0;
    EXPECT_NEAR(off[i], expected, expected == 0.0 ? 0.00025 : 0.0002) << kNames[i];
  }
}

// ---- noise ----

// d(commands)/d(unknowns) at the given values, by the engine; columns in mm per mm or deg.
Eigen::MatrixXd Jacobian(const std::vector<RotaryPose>& poses) {
  Eigen::MatrixXd jacobian(3 * poses.size(), 11);
  for (int i = 0; i < 11; ++i) {
    constexpr double kStep = 1e-4;
    Unknowns more = Given(), less = Given();
    more[i] += kStep;
    less[i] -= kStep;
    const auto after = EngineCommands(LinesOf(more), poses), before = EngineCommands(LinesOf(less), poses);
    for (size_t k = 0; k < poses.size(); ++k) jacobian.block<3, 1>(3 * k, i) = (after[k] - before[k]) / (2.0 * kStep);
  }
  return jacobian;
}

std::vector<RotaryPose> AllPoses() {
  std::vector<RotaryPose> poses = PatternOne();
  for (const RotaryPose& pose : PatternTwo()) poses.push_back(pose);
  return poses;
}

// Where the commands go per degree of the rotary axis that noise turns: C in pattern I, B in pattern II.
std::vector<Vector3d> Tangents() {
  std::vector<Vector3d> tangents;
  const Lines lines = LinesOf(Given());
  for (const RotaryPose& pose : AllPoses()) {
    const bool is_one = tangents.size() < PatternOne().size();
    constexpr double kStep = 1e-3;
    const double db = is_one ? 0.0 : kStep, dc = is_one ? kStep : 0.0;
    tangents.push_back(
        (CommandsAt(lines, pose.b_deg + db, pose.c_deg + dc) - CommandsAt(lines, pose.b_deg - db, pose.c_deg - dc)) /
        (2.0 * kStep));
  }
  return tangents;
}

constexpr double kLinearMm = 0.004;  // three uniform errors of +-4 um have this standard deviation

// Estimates = matrix x deviations of the commands, near the truth. `rotary_deg` 0: every coordinate alike, as
// `identify` weighs them; else Sigma = s_lin^2 I + s_rot^2 t t'.
Eigen::MatrixXd JointEstimator(double rotary_deg) {
  const std::vector<Vector3d> tangents = Tangents();
  const Eigen::MatrixXd jacobian = Jacobian(AllPoses());
  Eigen::MatrixXd weighted = jacobian;
  for (size_t k = 0; k < tangents.size(); ++k) {
    Matrix3d sigma = kLinearMm * kLinearMm * Matrix3d::Identity();
    sigma += rotary_deg * rotary_deg / 3.0 * tangents[k] * tangents[k].transpose();  // uniform within +-a
    weighted.middleRows<3>(3 * k) = sigma.inverse() * jacobian.middleRows<3>(3 * k);
  }
  return (weighted.transpose() * jacobian).ldlt().solve(weighted.transpose());
}

// The noise of Table 4.6 on every coordinate of every pose, mm.
Eigen::VectorXd DrawNoise(double rotary_deg, std::mt19937_64* random) {
  const auto uniform = [&](double half) { return std::uniform_real_distribution<double>(-half, half)(*random); };
  const Lines lines = LinesOf(Given());
  const std::vector<Vector3d> tangents = Tangents();
  const std::vector<RotaryPose> poses = AllPoses();
  const double xy = uniform(8e-6), xz = uniform(8e-6), yz = uniform(8e-6);  // squareness, per run
  Eigen::VectorXd noise(3 * poses.size());
  for (size_t k = 0; k < poses.size(); ++k) {
    const Vector3d at = CommandsAt(lines, poses[k].b_deg, poses[k].c_deg);
    Vector3d off = tangents[k] * uniform(rotary_deg) + Vector3d(xy * at.y() + xz * at.z(), yz * at.z(), 0);
    for (int i = 0; i < 3; ++i) off[i] += uniform(kLinearMm) + uniform(kLinearMm) + uniform(kLinearMm);
    noise.segment<3>(3 * k) = off;
  }
  return noise;
}

struct Spread {
  Unknowns staged, joint, weighted;
};

// Standard deviations over runs.
Spread SpreadOf(double rotary_deg, int runs) {
  std::mt19937_64 random(11);
  const Eigen::MatrixXd joint = JointEstimator(0.0), weighted = JointEstimator(rotary_deg);
  const std::vector<Vector3d> one = ExactPoints(PatternOne()), two = ExactPoints(PatternTwo());
  Spread sum{Unknowns::Zero(), Unknowns::Zero(), Unknowns::Zero()};
  const Unknowns without_noise = Staged(one, two);
  for (int run = 0; run < runs; ++run) {
    const Eigen::VectorXd noise = DrawNoise(rotary_deg, &random);
    std::vector<Vector3d> noisy_one = one, noisy_two = two;
    for (size_t k = 0; k < one.size(); ++k) noisy_one[k] -= noise.segment<3>(3 * k);
    for (size_t k = 0; k < two.size(); ++k) noisy_two[k] -= noise.segment<3>(3 * (one.size() + k));
    sum.staged += (Staged(noisy_one, noisy_two) - without_noise).cwiseAbs2();
    sum.joint += Unknowns(joint * noise).cwiseAbs2();
    sum.weighted += Unknowns(weighted * noise).cwiseAbs2();
  }
  const auto root = [&](const Unknowns& squares) { return Unknowns((squares / runs).cwiseSqrt()); };
  return {root(sum.staged), root(sum.joint), root(sum.weighted)};
}

// Table 4.7's deviations: staged as published, and what weighing the noise along the arc gains.
TEST(FangGrinder, StandardDeviations) {
  const struct {
    double rotary_deg;
    double staged[4], weighted[4];
  } rows[] = {{0.004, {0.0093, 0.0046, 0.0005, 0.0006}, {0.0074, 0.0034, 0.0005, 0.0006}},
              {0.04, {0.0880, 0.0361, 0.0005, 0.0006}, {0.0111, 0.0043, 0.0005, 0.0006}}};
  constexpr int kUnknowns[] = {kDrpx, kDrpy, kEaob, kEaoc};
  for (const auto& row : rows) {
    const Spread spread = SpreadOf(row.rotary_deg, 1000);
    for (int i = 0; i < 4; ++i) {
      const int unknown = kUnknowns[i];
      constexpr double kRounding = 5e-5, kStagedShare = 0.08, kWeightedShare = 0.15;
      const std::string of = absl::StrFormat("Fang 2022, Table 4.7, rotary error %g deg: deviation of %s, ",
                                             row.rotary_deg, kNames[unknown]),
                        unit = i < 2 ? "mm" : "deg";
      ExpectPublished(spread.staged[unknown], row.staged[i], kStagedShare * row.staged[i] + kRounding,
                      of + "staged, " + unit);
      ExpectPublished(spread.weighted[unknown], row.weighted[i], kWeightedShare * row.weighted[i] + kRounding,
                      of + "noise along the arc weighed, " + unit);
    }
    for (int i = 0; i < 11; ++i) EXPECT_LT(spread.weighted[i], 1.05 * spread.staged[i]) << kNames[i];
    // Every coordinate alike, noise along the arc leaks into the angles and E_XOB.
    for (const int unknown : {kEaoc, kEcob, kEboc, kExob})
      EXPECT_GT(spread.joint[unknown], 1.2 * spread.staged[unknown]) << kNames[unknown];
  }
}

// The printed a = 0.04 deg does not give the printed deviations: 0.004 to 0.0055 does.
TEST(FangGrinder, ThePrintedRotaryErrorIsTenTimesTooLarge) {
  const double printed[] = {0.012, 0.006};  // d_rpx, d_rpy
  const Spread at_4 = SpreadOf(0.004, 300), at_40 = SpreadOf(0.04, 300);
  for (int i = 0; i < 2; ++i) {
    EXPECT_LT(printed[i] / at_4.staged[i], 1.5) << kNames[i];
    EXPECT_GT(at_40.staged[i] / printed[i], 5.0) << kNames[i];
  }
}

// X is off by 2.050 mm at C = 50, B = 0 before compensation, whatever the design of the axes; only D = d + E is seen.
TEST(FangGrinder, OnlyTheSumOfDesignAndErrorIsSeen) {
  for (const Design& design : {Design{}, Design{10, 620, -30, 180}}) {
    Unknowns none = Unknowns::Zero();
    none.head<3>() << 85, 286, 457;
    const Vector3d off_mm = CommandsAt(LinesOf(Given(), design), 0, 50) - CommandsAt(LinesOf(none, design), 0, 50);
    ExpectPublished(
        std::abs(off_mm.x()), 2.050, 0.0005,
        absl::StrFormat("Fang 2022, ch. 4: X at C = 50, B = 0 before compensation, axis C at %g, mm", design.rcx));
    Unknowns shifted = Given();
    shifted[kExoc] -= 1.0;
    Design other = design;
    other.rcx += 1.0;
    const Vector3d shift_mm =
        CommandsAt(LinesOf(shifted, other), 20, 50) - CommandsAt(LinesOf(Given(), design), 20, 50);
    EXPECT_LT(shift_mm.norm(), 1e-9);
  }
}

// ---- the engine ----

machine::ErrorModel Truth() {
  const InEngine engine = ToEngine(LinesOf(Given()));
  machine::ErrorModel truth = machine::DeclaredModel(Machine());
  for (machine::ErrorTerm& term : truth.terms) {
    const int component = static_cast<int>(term.component);
    term.amplitude[0] = term.joint == Machine().tool_joint() ? (engine.tip_mm - kDesignProbeMm)[component]
                                                             : engine.errors[term.joint][component];
  }
  return truth;
}

std::vector<session::Session> Exact(bool one, bool two, std::optional<double> ball_sigma_um) {
  synthetic::NoiseOptions exact;
  exact.sigma_scale = 0.0;
  exact.draw_setup = false;
  std::vector<session::Session> sessions;
  if (one) sessions.push_back(CentresSession("pattern-1", PatternOne(), 0.0, ball_sigma_um));
  if (two) sessions.push_back(CentresSession("pattern-2", PatternTwo(), 2000.0, ball_sigma_um));
  for (session::Session& session : sessions) {
    auto made = synthetic::Simulate(Machine(), Truth(), session, exact);
    EXPECT_TRUE(made.ok()) << made.status();
    session = *made;
  }
  return sessions;
}

TEST(FangGrinder, TheJointFitGivesTheTruth) {
  const auto result = identify::Identify(Machine(), Exact(true, true, 1e-3));
  ASSERT_TRUE(result.ok()) << result.status();
  EXPECT_EQ(result->rank, 11);
  const machine::ErrorModel truth = Truth();
  for (size_t i = 0; i < truth.terms.size(); ++i) {
    const bool is_angle = machine::IsAngle(truth.terms[i].component);
    EXPECT_NEAR(result->estimates[i].value, truth.terms[i].amplitude[0], is_angle ? 1e-11 : 1e-9)
        << result->estimates[i].name;
  }
}

TEST(FangGrinder, WhatEachPatternSees) {
  EXPECT_EQ(identify::Identify(Machine(), Exact(true, false, 1e-3))->rank, 7);
  EXPECT_EQ(identify::Identify(Machine(), Exact(false, true, 1e-3))->rank, 7);
  // With the sphere's place free 11 of 14: a common shift of sphere, probe and both axes is seen by nothing. In the
  // thesis' symbols all seven lengths are lost; ours say where C stands to B and the tip to C, so that B's place and
  // what is along B are.
  const auto free = identify::Identify(Machine(), Exact(true, true, std::nullopt));
  ASSERT_TRUE(free.ok()) << free.status();
  EXPECT_EQ(free->rank, 11 - 3);
  const std::set<std::string> lost = {"EX0B", "EZ0B", "EY0C"};
  for (const identify::Estimate& estimate : free->estimates)
    EXPECT_NE(estimate.identifiable, lost.contains(estimate.name)) << estimate.name;
}

// Amplitudes of the declared errors, in their order, as the thesis' unknowns.
Unknowns FromAmplitudes(const Eigen::VectorXd& amplitudes) {
  machine::ErrorVector<double> of_b = machine::ErrorVector<double>::Zero(), of_c = of_b, of_t = of_b;
  const machine::ErrorModel declared = machine::DeclaredModel(Machine());
  for (size_t i = 0; i < declared.terms.size(); ++i) {
    const machine::ErrorTerm& term = declared.terms[i];
    auto& errors = term.joint == kJointB ? of_b : term.joint == kJointC ? of_c : of_t;
    errors[static_cast<int>(term.component)] = amplitudes[static_cast<Eigen::Index>(i)];
  }
  return FromEngine(of_b, of_c, kDesignProbeMm + of_t.head<3>());
}

// Standard deviations of the thesis' unknowns from those of ours.
Unknowns SigmaOf(const identify::MonteCarloResult& result) {
  const Eigen::Index count = static_cast<Eigen::Index>(result.spreads.size());
  Eigen::VectorXd value(count), sigma(count);
  for (Eigen::Index i = 0; i < count; ++i) {
    value[i] = result.spreads[static_cast<size_t>(i)].value;
    sigma[i] = result.spreads[static_cast<size_t>(i)].sigma;
  }
  const Eigen::MatrixXd covariance = sigma.asDiagonal() * result.correlation * sigma.asDiagonal();
  Eigen::MatrixXd jacobian(11, count);
  for (Eigen::Index i = 0; i < count; ++i) {
    constexpr double kStep = 1e-5;
    Eigen::VectorXd more = value, less = value;
    more[i] += kStep;
    less[i] -= kStep;
    jacobian.col(i) = (FromAmplitudes(more) - FromAmplitudes(less)) / (2.0 * kStep);
  }
  return Unknowns((jacobian * covariance * jacobian.transpose()).diagonal().cwiseSqrt());
}

// Table 4.6 as the error budget of the worked example, through the whole identification: its sources weigh the
// readings.
TEST(FangGrinder, MonteCarloOfTheBudgetGivesTheWeighedDeviations) {
  const auto text = base::ReadFile(base::SourcePath("/deploy/examples/fang-grinder/budget.json"), 1 << 20);
  ASSERT_TRUE(text.ok()) << text.status();
  const auto budget = identify::ReadBudget(*text, Machine());
  ASSERT_TRUE(budget.ok()) << budget.status();
  identify::Options options;
  options.budget = *budget;
  const auto fit = identify::FitSessions(Machine(), Exact(true, true, 1e-3), options);
  ASSERT_TRUE(fit.ok()) << fit.status();
  identify::MonteCarloOptions simulation;
  simulation.runs = 500;
  simulation.budget = *budget;
  const auto result = identify::MonteCarlo(*fit, simulation);
  ASSERT_TRUE(result.ok()) << result.status();
  ASSERT_EQ(result->spreads.size(), 11u);
  EXPECT_EQ(result->failed, 0);
  const Unknowns sigma = SigmaOf(*result);
  const double weighed[] = {0.0074, 0.0034, 0.0005, 0.0006};
  constexpr int kUnknowns[] = {kDrpx, kDrpy, kEaob, kEaoc};
  constexpr double kShare = 0.15, kRounding = 5e-5;
  for (int i = 0; i < 4; ++i)
    EXPECT_NEAR(sigma[kUnknowns[i]], weighed[i], kShare * weighed[i] + kRounding) << kNames[kUnknowns[i]];
  const Spread published = SpreadOf(0.004, 500);
  for (int i = 0; i < 11; ++i) EXPECT_LT(sigma[i], 1.05 * published.staged[i]) << kNames[i];
}

}  // namespace
}  // namespace axiscal::known_answers::grinder
