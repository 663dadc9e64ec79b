// Ibaraki, Iritani, Matsushita, "Error calibration on five-axis machine tools by on-the-machine measurement of
// artifacts using a touch-trigger probe": the model, the published identification and what it cannot do, and the fit of
// the one engine.
#include <gtest/gtest.h>

#include <nlohmann/json.hpp>
#include <random>

#include "core/decide/close_loop.h"
#include "core/identify/identify.h"
#include "core/machine/error_json.h"
#include "core/synthetic/simulate.h"
#include "tests/known_answers/ibaraki_columns.h"
#include "tests/known_answers/published.h"

namespace axiscal::known_answers {
namespace {

Pose Six(double x, double y, double z, double a, double b, double c) {
  Pose pose;
  pose << x, y, z, a, b, c;
  return pose;
}

machine::JointErrors<double> ErrorsOf(const Pose& of_a, const Pose& of_c) {
  machine::JointErrors<double> errors;
  errors[kJointA] = FromUmUrad(of_a);
  errors[kJointC] = FromUmUrad(of_c);
  return errors;
}

// Equations 2 to 4 exactly, and equation 11 (first order): all its signs are right.
TEST(Ibaraki, TablePoseErrorsExactAndToFirstOrder) {
  const Pose of_a = Six(10, -5, 8, 20, -15, 10), of_c = Six(4, 6, -3, -12, 25, 8);
  const struct {
    double a_deg, c_deg;
    Pose exact, first_order;
  } rows[] = {
      {-30, 60, Six(14.000047, -1.303696, 2.402058, 7.999939, 10.650497, 4.428066),
       Six(14, -1.303848, 2.401924, 8, 10.650635, 4.428203)},
      {-90, 240, Six(14.000120, -7.999840, 2.000000, 8.000173, -7.000060, -15.000208), Six(14, -8, 2, 8, -7, -15)}};
  for (const auto& row : rows) {
    const Pose ours = TablePoseError(row.a_deg, row.c_deg, ErrorsOf(of_a, of_c));
    const Eigen::Matrix3d tilt = TablePose(row.a_deg, 0, {}).rotation;
    Pose equation_11 = of_a;
    equation_11.head<3>() += tilt * of_c.head<3>();
    equation_11.tail<3>() += tilt * of_c.tail<3>();
    constexpr double kTolerance = 1e-5, kPrinted = 1e-6, kRelative = 1e-4;  // digits
    for (int i = 0; i < 6; ++i) {
      EXPECT_NEAR(ours[i], row.exact[i], kTolerance) << row.a_deg << ' ' << i;
      ExpectPublished(equation_11[i], row.first_order[i], kPrinted,
                      absl::StrFormat("Ibaraki 2010, eq 11 at A %g C %g: E%c of the table, %s", row.a_deg, row.c_deg,
                                      "XYZABC"[i], i < 3 ? "um" : "urad"));
    }
    EXPECT_LT((ours - equation_11).norm(), kRelative * ours.norm());
    EXPECT_GT((ours - equation_11).norm(), 1e-6 * ours.norm());  // it is an approximation
  }
}

TEST(Ibaraki, FifteenTouchesDetermineThePoseOfTheTable) {
  for (const double a_deg : kTiltsDeg) EXPECT_EQ(PublishedSolve(a_deg, 60).completeOrthogonalDecomposition().rank(), 6);
}

// Twelve maps drawn at random, the mean of C's over C zero at every A (1), no error at the reference pose.
struct Drawn {
  std::array<Pose, 4> of_a;
  PoseByIndex of_c;
  machine::JointErrors<double> At(int i, int j) const { return ErrorsOf(of_a[i], of_c[i][j]); }
};

Drawn DrawMaps(bool with_error_at_reference) {
  std::mt19937 random(5);
  std::normal_distribution<double> normal(0.0, 10.0);  // um, urad
  Drawn maps;
  for (int i = 0; i < 4; ++i) {
    Pose mean = Pose::Zero();
    for (int j = 0; j < 6; ++j) {
      for (double& error : maps.of_c[i][j]) error = normal(random);
      mean += maps.of_c[i][j] / 6.0;
    }
    for (Pose& pose : maps.of_c[i]) pose -= mean;
    for (double& error : maps.of_a[i]) error = normal(random);
  }
  if (!with_error_at_reference) maps.of_a[0] = -maps.of_c[0][0];
  return maps;
}

PoseByIndex PublishedPoses(const Drawn& drawn) {
  PoseByIndex poses;
  for (int i = 0; i < 4; ++i) {
    for (int j = 0; j < 6; ++j)
      poses[i][j] = PublishedPoseError(kTiltsDeg[i], kTurnsDeg[j], drawn.At(i, j), drawn.At(0, 0));
  }
  return poses;
}

// Published steps 1 to 3 over the grid of A and C: where the reference pose has no error, both axes' maps come back.
TEST(Ibaraki, ThePublishedStepsSeparateTheMapsOfBothAxes) {
  const Drawn drawn = DrawMaps(false);
  const Maps maps = PublishedMaps(PublishedPoses(drawn));
  constexpr double kToleranceUm = 5e-4, kToleranceUrad = 5e-3;  // second order of 10 um and 10 urad at 170 mm
  for (int i = 0; i < 4; ++i) {
    EXPECT_LT((maps.of_a[i] - drawn.of_a[i]).head<3>().norm(), kToleranceUm * 3) << i;
    EXPECT_LT((maps.of_a[i] - drawn.of_a[i]).tail<3>().norm(), kToleranceUrad) << i;
    for (int j = 0; j < 6; ++j) {
      EXPECT_LT((maps.of_c[i][j] - drawn.of_c[i][j]).head<3>().norm(), kToleranceUm * 3) << i << ' ' << j;
      EXPECT_LT((maps.of_c[i][j] - drawn.of_c[i][j]).tail<3>().norm(), kToleranceUrad) << i << ' ' << j;
    }
  }
}

// Elsewhere each pose error comes back without the reference pose's own, turned with the table: the published steps
// cannot tell an error at A = C = 0 from the place of the artefact.
TEST(Ibaraki, EveryPoseErrorLosesTheErrorOfTheReferencePose) {
  const Drawn drawn = DrawMaps(true);
  const PoseByIndex poses = PublishedPoses(drawn);
  const Pose reference = TablePoseError(0, 0, drawn.At(0, 0));
  ASSERT_GT(reference.norm(), 10.0);
  for (int i = 0; i < 4; ++i) {
    for (int j = 0; j < 6; ++j) {
      const Eigen::Matrix3d turn = TablePose(kTiltsDeg[i], kTurnsDeg[j], {}).rotation;
      Pose expected = TablePoseError(kTiltsDeg[i], kTurnsDeg[j], drawn.At(i, j));
      expected.head<3>() -= turn * reference.head<3>();
      expected.tail<3>() -= turn * reference.tail<3>();
      EXPECT_LT((poses[i][j] - expected).head<3>().norm(), 2e-3) << i << ' ' << j;  // um, second order
      EXPECT_LT((poses[i][j] - expected).tail<3>().norm(), 5e-3) << i << ' ' << j;  // urad
    }
  }
}

// So constant offsets come back as a once-per-turn error of C that is not there, and vanish from the map of A.
TEST(Ibaraki, ConstantOffsetsComeBackAsMaps) {
  const machine::JointErrors<double> errors = ErrorsOf(Six(20, 10, 15, 0, 0, 0), Pose::Zero());
  PoseByIndex poses;
  for (int i = 0; i < 4; ++i) {
    for (int j = 0; j < 6; ++j) poses[i][j] = PublishedPoseError(kTiltsDeg[i], kTurnsDeg[j], errors, errors);
  }
  const Maps maps = PublishedMaps(poses);
  const double dx_of_c[] = {-20.0, -1.3, 18.7, 20.0, 1.3, -18.7}, dy_of_c[] = {-10.0, -22.3, -12.3, 10.0, 22.3, 12.3};
  const double dy_of_a[] = {10, 2.5, -3.0, -5.0}, dz_of_a[] = {0, 2.0, 7.5, 15};
  constexpr double kToleranceUm = 0.051;  // one printed decimal
  for (int i = 0; i < 4; ++i) {
    EXPECT_NEAR(maps.of_a[i][1], dy_of_a[i], kToleranceUm);
    EXPECT_NEAR(maps.of_a[i][2], dz_of_a[i], kToleranceUm);
  }
  for (int j = 0; j < 6; ++j) {
    EXPECT_NEAR(maps.of_c[0][j][0], dx_of_c[j], kToleranceUm);
    EXPECT_NEAR(maps.of_c[0][j][1], dy_of_c[j], kToleranceUm);
  }
}

// What 0.5 um of noise per touch leaves in the maps, touches at the reference pose included: standard deviations,
// root mean square over components and indices. The steps are linear in the touches, so that no simulation is needed.
TEST(Ibaraki, NoiseOfTheMaps) {
  const Eigen::Index touches = static_cast<Eigen::Index>(Columns().size());
  constexpr double kNoiseUm = 0.5;
  double squares_a[2] = {}, squares_c[2] = {};
  for (const double a_deg : kTiltsDeg) {
    // By pose: rows of the pose error, columns one per touch of all 24 poses' worth (the first block: the reference).
    std::vector<Eigen::MatrixXd> poses;
    Eigen::MatrixXd mean = Eigen::MatrixXd::Zero(6, 7 * touches);
    for (int j = 0; j < 6; ++j) {
      const Eigen::MatrixXd solve = PublishedSolve(a_deg, kTurnsDeg[j]);
      poses.push_back(Eigen::MatrixXd::Zero(6, 7 * touches));
      poses[j].leftCols(touches) -= solve;
      // At A = C = 0 the reference is the measurement.
      poses[j].middleCols((a_deg == 0.0 && j == 0) ? 0 : (j + 1) * touches, touches) += solve;
      mean += poses[j] / 6.0;
    }
    for (int part = 0; part < 2; ++part) {
      squares_a[part] += mean.middleRows(3 * part, 3).squaredNorm() / (4 * 3);
      for (const Eigen::MatrixXd& pose : poses)
        squares_c[part] += (pose - mean).middleRows(3 * part, 3).squaredNorm() / (4 * 6 * 3);
    }
  }
  constexpr double kShare = 0.1, kUradPerUmPerMm = 1e3;
  const auto expect = [&](double ours, double published, const std::string& what) {
    ExpectPublished(ours, published, kShare * published, "Ibaraki 2010, noise of the maps: " + what);
  };
  expect(kNoiseUm * std::sqrt(squares_a[0]), 0.23, "A, shifts, um");
  expect(kNoiseUm * std::sqrt(squares_a[1]) * kUradPerUmPerMm, 1.4, "A, turns, urad");
  expect(kNoiseUm * std::sqrt(squares_c[0]), 0.41, "C, shifts, um");
  expect(kNoiseUm * std::sqrt(squares_c[1]) * kUradPerUmPerMm, 3.4, "C, turns, urad");
}

absl::StatusOr<identify::Result> JointFit(const machine::ErrorModel& truth, const machine::ErrorModel& asked) {
  synthetic::NoiseOptions exact;
  exact.sigma_scale = 0.0;
  exact.draw_setup = false;
  const Eigen::Vector3d by_hand(0.2, -0.1, 0.15);
  ASSIGN_OR_RETURN(session::Session session, synthetic::Simulate(TiltingTableAc(), truth, ColumnsSession(), exact));
  session.header = ColumnsSession(by_hand).header;
  identify::Options options;
  options.model = asked;
  for (machine::ErrorTerm& term : options.model->terms) term.amplitude.fill(0.0);
  return identify::Identify(TiltingTableAc(), {session}, options);
}

machine::ErrorModel Model(const std::string& json) { return machine::ReadErrors(json, TiltingTableAc()).value(); }

constexpr char kEight[] =
    R"("EY0A": 10, "EZ0A": -13, "EB0A": 16, "EC0A": -19, "EX0C": 22, "EY0C": -25, "EA0C": 28, "EB0C": -31)";

void ExpectTruth(const identify::Result& result, const machine::ErrorModel& truth) {
  const std::vector<identify::Parameter> parameters = identify::ListParameters(truth, false);
  for (size_t i = 0; i < parameters.size(); ++i) {
    const bool is_angle = machine::IsAngle(truth.terms[parameters[i].term].component);
    EXPECT_NEAR(result.estimates[i].value, identify::ValueOf(truth, parameters[i]), is_angle ? 1e-9 : 1e-6)
        << result.estimates[i].name;
  }
}

// The engine fits all 24 poses at once, the artefact's own place among the unknowns: 8 + 6 of 14.
TEST(Ibaraki, TheJointFitOfErrorsAndArtefactGivesTheTruth) {
  const machine::ErrorModel truth = Model(absl::StrCat("{", kEight, "}"));
  const auto result = JointFit(truth, truth);
  ASSERT_TRUE(result.ok()) << result.status();
  EXPECT_EQ(result->rank, 8);
  ExpectTruth(*result, truth);
  // Two more constants add no rank: EX0A is seen only with EX0C, EZ0C only with the artefact's height.
  const auto wider = JointFit(truth, Model(absl::StrCat("{", kEight, R"(, "EX0A": 0, "EZ0C": 0})")));
  ASSERT_TRUE(wider.ok()) << wider.status();
  EXPECT_EQ(wider->rank, 8);
}

// The twelve maps themselves, a value per node, asked of the engine in the form of errors.json.
std::string MapsJson(const Drawn* drawn) {
  nlohmann::ordered_json terms = nlohmann::ordered_json::array();
  const char* const components[] = {"EX", "EY", "EZ", "EA", "EB", "EC"};
  constexpr int kOrder[] = {3, 2, 1, 0};  // nodes rise: A from -90 to 0
  for (int component = 0; component < 6; ++component) {
    nlohmann::ordered_json of_a = {{"symbol", std::string(components[component]) + "A"},
                                   {"shape", "tabulated"},
                                   {"variable", "A"},
                                   {"nodes_deg", {-90, -60, -30, 0}}};
    nlohmann::ordered_json of_c = {{"symbol", std::string(components[component]) + "C"},
                                   {"shape", "tabulated"},
                                   {"variable", "C"},
                                   {"nodes_deg", {0, 60, 120, 180, 240, 300}},
                                   {"zero_mean", true},
                                   {"over", {{"variable", "A"}, {"nodes_deg", {-90, -60, -30, 0}}}}};
    if (drawn == nullptr) {
      of_a["amplitude"] = of_c["amplitude"] = 0;
    } else {
      for (const int i : kOrder) {
        of_a["values"].push_back(drawn->of_a[i][component]);
        std::vector<double> row;
        for (const Pose& pose : drawn->of_c[i]) row.push_back(pose[component]);
        of_c["values"].push_back(row);
      }
    }
    terms.push_back(of_a);
    terms.push_back(of_c);
  }
  return nlohmann::ordered_json({{"terms", terms}}).dump();
}

absl::StatusOr<identify::Result> MapFit(const Drawn& drawn, std::optional<double> place_sigma_um) {
  synthetic::NoiseOptions exact;
  exact.sigma_scale = 0.0;
  exact.draw_setup = false;
  session::Session planned = ColumnsSession();
  for (const char* key : {"artefact_x_sigma_um", "artefact_y_sigma_um", "artefact_z_sigma_um", "artefact_a_sigma_urad",
                          "artefact_b_sigma_urad", "artefact_c_sigma_urad"}) {
    if (place_sigma_um) planned.header.push_back({key, absl::StrCat(*place_sigma_um)});
  }
  ASSIGN_OR_RETURN(const session::Session session,
                   synthetic::Simulate(TiltingTableAc(), Model(MapsJson(&drawn)), planned, exact));
  identify::Options options;
  options.model = Model(MapsJson(nullptr));
  return identify::Identify(TiltingTableAc(), {session}, options);
}

// Where the columns' place is known the reference pose is a pose like the others: 24 values of A's maps and 120 of C's
// (each row of six sums to zero) come back, error at A = C = 0 and all.
TEST(Ibaraki, TheJointFitGivesTheMapsOfBothAxes) {
  const Drawn drawn = DrawMaps(true);
  const auto result = MapFit(drawn, 1e-3);
  ASSERT_TRUE(result.ok()) << result.status();
  EXPECT_EQ(result->rank, 144);
  const machine::ErrorModel truth = Model(MapsJson(&drawn));
  ASSERT_EQ(result->estimates.size(), truth.terms.size());
  for (size_t i = 0; i < truth.terms.size(); ++i) {
    const bool is_angle = machine::IsAngle(truth.terms[i].component);
    EXPECT_NEAR(result->estimates[i].value, truth.terms[i].amplitude[0], is_angle ? 1e-9 : 1e-6)
        << result->estimates[i].name;
  }
}

// Where it is not, six combinations are the columns' place: no map that they touch is given a number.
TEST(Ibaraki, MapsAndAPlaceThatNobodyKnowsAreNotSeparable) {
  const auto result = MapFit(DrawMaps(true), std::nullopt);
  ASSERT_TRUE(result.ok()) << result.status();
  EXPECT_EQ(result->rank, 144 - 6);
  EXPECT_EQ(result->not_separable.size(), 6u);
}

// The columns as the paper touches them: all fifteen faces at the reference pose, fewer elsewhere. Here the sides that
// the machine reaches from one direction down to A = -30, those opposite beyond.
session::Session FewerElsewhere(session::Session session) {
  const std::vector<double> a_deg = session::FindColumn(session, "A_deg")->values,
                            c_deg = session::FindColumn(session, "C_deg")->values;
  const std::vector<std::string> faces = session::FindColumn(session, "feature")->texts;
  const auto is_touched = [&](size_t k) {
    if ((a_deg[k] == 0 && c_deg[k] == 0) || faces[k].ends_with("top")) return true;
    return faces[k].find('+') != std::string::npos ? a_deg[k] > -45 : a_deg[k] < -45;
  };
  for (session::Column& column : session.columns) {
    std::vector<double> values;
    std::vector<std::string> texts;
    for (size_t k = 0; k < faces.size(); ++k) {
      if (!is_touched(k)) continue;
      if (k < column.values.size()) values.push_back(column.values[k]);
      if (k < column.texts.size()) texts.push_back(column.texts[k]);
    }
    column.values = std::move(values);
    column.texts = std::move(texts);
  }
  return session;
}

// Standard uncertainties of the eight location errors, um and urad, by generalised least squares of what the faces move
// along their normals: touches scatter by `touch_um`, faces stand out by `face_um`, the columns' place is known to 5 mm
// and 20 mrad. Written down from the paper's model alone: nothing of the engine's evaluation is in it.
Eigen::VectorXd ByGeneralisedLeastSquares(const session::Session& session, double touch_um, double face_um) {
  constexpr int kErrors = 8;
  const std::pair<bool, int> errors[kErrors] = {{false, 1}, {false, 2}, {false, 4}, {false, 5},
                                                {true, 0},  {true, 1},  {true, 3},  {true, 4}};  // of C; which of six
  const std::vector<double>&a_deg = session::FindColumn(session, "A_deg")->values,
        &c_deg = session::FindColumn(session, "C_deg")->values;
  const std::vector<std::string>& names = session::FindColumn(session, "feature")->texts;
  const std::vector<Face> faces = Columns();
  std::map<std::string, int> number;  // in the order of Columns(), which is that of the first fifteen touches
  for (const std::string& name : names) number.try_emplace(name, static_cast<int>(number.size()));
  Eigen::Vector3d centre_mm = Eigen::Vector3d::Zero();
  for (const Face& face : faces) centre_mm += face.point_mm / static_cast<double>(faces.size());
  const auto n = static_cast<Eigen::Index>(names.size());
  Eigen::MatrixXd by(n, kErrors + 6), out = Eigen::MatrixXd::Zero(n, static_cast<Eigen::Index>(faces.size()));
  for (Eigen::Index row = 0; row < n; ++row) {
    const auto k = static_cast<size_t>(row);
    const Face& face = faces[static_cast<size_t>(number[names[k]])];
    const geometry::Rigid<double> table = TablePose(a_deg[k], c_deg[k], {});
    const Eigen::Vector3d normal = table.rotation * face.normal, arm_mm = table * face.point_mm;
    for (int i = 0; i < kErrors; ++i) {
      Pose of_a = Pose::Zero(), of_c = Pose::Zero();
      (errors[i].first ? of_c : of_a)[errors[i].second] = 1.0;
      const Pose moved = TablePoseError(a_deg[k], c_deg[k], ErrorsOf(of_a, of_c));  // um, urad
      by(row, i) = normal.dot(moved.head<3>() + 1e-3 * moved.tail<3>().cross(arm_mm));
    }
    by.row(row).segment<3>(kErrors) = face.normal.transpose();
    by.row(row).tail<3>() = 1e-3 * (face.point_mm - centre_mm).cross(face.normal).transpose();
    out(row, number[names[k]]) = 1.0;
  }
  const Eigen::MatrixXd covariance =
      touch_um * touch_um * Eigen::MatrixXd::Identity(n, n) + face_um * face_um * out * out.transpose();
  Eigen::MatrixXd normal = by.transpose() * covariance.ldlt().solve(by);
  for (int i = 0; i < 3; ++i) {
    normal(kErrors + i, kErrors + i) += 1.0 / (5e3 * 5e3);
    normal(kErrors + 3 + i, kErrors + 3 + i) += 1.0 / (20e3 * 20e3);
  }
  return normal.inverse().diagonal().head<kErrors>().cwiseSqrt();
}

// Where the faces of the columns are known to a micrometre the errors are as uncertain as the formula says: hardly more
// than by the touches where all faces are touched at every pose, clearly more where they are not.
TEST(Ibaraki, ErrorsOfTheArtefactAreInTheUncertainties) {
  const machine::ErrorModel truth = Model(absl::StrCat("{", kEight, "}"));
  constexpr double kTouchUm = 0.175, kFaceUm = 1.0;
  for (const bool are_all_touched : {true, false}) {
    session::Session planned = ColumnsSession();
    if (!are_all_touched) planned = FewerElsewhere(std::move(planned));
    const Eigen::VectorXd touches_alone = ByGeneralisedLeastSquares(planned, kTouchUm, 1e-6);
    for (const double face_um : {0.0, kFaceUm}) {
      session::Session stated = planned;
      if (face_um > 0.0) stated.header.push_back({"feature_sigma_um", absl::StrCat(face_um)});
      synthetic::NoiseOptions noise;
      noise.sigma_scale = 0.0;
      noise.draw_setup = false;
      const session::Session session = synthetic::Simulate(TiltingTableAc(), truth, stated, noise).value();
      identify::Options options;
      options.model = truth;
      options.judge_correlation = false;  // readings without noise would be taken for a better probe's
      const auto result = identify::Identify(TiltingTableAc(), {session}, options);
      ASSERT_TRUE(result.ok()) << result.status();
      const Eigen::VectorXd expected = ByGeneralisedLeastSquares(planned, kTouchUm, std::max(face_um, 1e-6));
      ASSERT_EQ(result->estimates.size(), 8u);
      for (size_t i = 0; i < 8; ++i) {
        const identify::Estimate& estimate = result->estimates[i];
        const auto at = static_cast<Eigen::Index>(i);
        constexpr double kFirstOrder = 2e-3;
        EXPECT_NEAR(1e3 * (i == 0 || i == 1 || i == 4 || i == 5 ? 1.0 : 1e3) * estimate.sigma / expected[at], 1.0,
                    kFirstOrder)
            << estimate.name << " " << are_all_touched << " " << face_um;
      }
      const double ratio = (expected.array() / touches_alone.array()).maxCoeff();
      if (face_um == 0.0) continue;
      if (are_all_touched) {
        EXPECT_LT(ratio, 1.01);
      } else {
        EXPECT_GT(ratio, 1.2);  // else the faces would not enter
      }
    }
  }
}

// Columns that move by 4 um between two touches are said to have moved, in that session at that moment.
// All sides stand off by what the radius is wrong, opposite ones in opposite directions; the columns' height takes it
// from the tops. Set aside as chips, all of them, the tops would leave the errors without a number.
TEST(Ibaraki, AWrongStylusRadiusIsRefused) {
  session::Session touched =
      synthetic::Simulate(TiltingTableAc(), machine::ReadErrors(R"({"EX0C": 20})", TiltingTableAc()).value(),
                          ColumnsSession(), {})
          .value();
  ASSERT_TRUE(identify::Identify(TiltingTableAc(), {touched}).ok());
  for (session::HeaderEntry& entry : touched.header) {
    if (entry.key == "stylus_radius_mm") entry.value = "3.02";
  }
  const auto refused = identify::Identify(TiltingTableAc(), {touched});
  ASSERT_FALSE(refused.ok());
  EXPECT_EQ(refused.status().code(), absl::StatusCode::kInvalidArgument);
  EXPECT_NE(std::string(refused.status().message()).find("of the 24 touches of 'column1top' stand out"),
            std::string::npos)
      << refused.status();
  EXPECT_NE(std::string(refused.status().message()).find("is stylus_radius_mm = 3.02 right"), std::string::npos)
      << refused.status();
}

TEST(Ibaraki, TheLoopTellsWhenTheColumnsMoved) {
  const machine::ErrorModel truth = Model(absl::StrCat("{", kEight, "}"));
  synthetic::NoiseOptions noise;
  noise.draw_setup = false;
  session::Session session = synthetic::Simulate(TiltingTableAc(), truth, ColumnsSession(), noise).value();
  const session::Session moved =
      synthetic::Simulate(TiltingTableAc(), truth, ColumnsSession({0.004, 0, 0}), noise).value();
  constexpr size_t kMoved = 200;
  for (size_t i = 0; i < session.columns.size(); ++i) {
    for (size_t k = kMoved; k < session.columns[i].values.size(); ++k)
      session.columns[i].values[k] = moved.columns[i].values[k];
  }
  const auto runs = identify::BindSessions(TiltingTableAc(), {session});
  ASSERT_TRUE(runs.ok()) << runs.status();
  const auto report = decide::CloseLoop(TiltingTableAc(), *runs, {});
  ASSERT_TRUE(report.ok()) << report.status();
  ASSERT_EQ(report->unexplained.size(), 1u);
  EXPECT_EQ(report->unexplained[0].variable, "t");
  EXPECT_NEAR(report->unexplained[0].to, session::FindColumn(session, "t_s")->values[kMoved], 50.0);
}

}  // namespace
}  // namespace axiscal::known_answers
