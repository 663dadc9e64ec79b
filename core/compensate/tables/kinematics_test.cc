// Tables of points on rotary axes, held against LinuxCNC's own formulas, and tables of volumes.
#include <gmock/gmock.h>

#include <cmath>

#include "core/compensate/tables/testing/made.h"
#include "core/compensate/tables/text.h"
#include "core/machine/chain.h"

namespace axiscal::tables {
namespace {

using testing::Errors;
using ::testing::HasSubstr;
using testing::Made;
using testing::Make;
using testing::NotCarried;
using testing::Request;
using testing::WithTravel;

constexpr char kLocations[] = R"({"EX0C": 53.1, "EY0C": -21.4, "EY0A": 40.2, "EZ0A": -33.3})";

double Pin(const std::string& text, const std::string& pin) {
  const size_t at = text.find("." + pin + " ");
  EXPECT_NE(at, std::string::npos) << pin << text;
  return at == std::string::npos ? std::nan("") : std::stod(text.substr(at + pin.size() + 2));
}

// src/emc/kinematics/trtfuncs.c of LinuxCNC 2.9, xyzacKinematicsInverse: joints of a programmed point.
Eigen::Vector3d XyzacInverse(const std::string& pins, const Eigen::Vector3d& pos, double a, double c) {
  const double x_rot = Pin(pins, "x-rot-point"), y_rot = Pin(pins, "y-rot-point"), z_rot = Pin(pins, "z-rot-point");
  const double dy = Pin(pins, "y-offset"), dz = Pin(pins, "z-offset");
  return {std::cos(c) * (pos.x() - x_rot) - std::sin(c) * (pos.y() - y_rot) + x_rot,
          std::sin(c) * std::cos(a) * (pos.x() - x_rot) + std::cos(c) * std::cos(a) * (pos.y() - y_rot) -
              std::sin(a) * (pos.z() - z_rot) - std::cos(a) * dy + std::sin(a) * dz + dy + y_rot,
          std::sin(c) * std::sin(a) * (pos.x() - x_rot) + std::cos(c) * std::sin(a) * (pos.y() - y_rot) +
              std::cos(a) * (pos.z() - z_rot) - std::sin(a) * dy - std::cos(a) * dz + dz + z_rot};
}

TableRequest WithTip(const std::string& format) {
  TableRequest request = Request(format);
  request.state.tool_tip_mm = {2.5, -4.0, 120.25};
  return request;
}

// The pins of an exact machine and LinuxCNC's formula give what the chain gives: signs and pivots agree.
TEST(LinuxcncXyzac, TheFormulaIsTheChain) {
  const machine::Machine machine = WithTravel();
  const TableRequest request = WithTip("linuxcnc-xyzac");
  const Made exact = Make("{}", request);
  ASSERT_TRUE(exact.status.ok()) << exact.status;
  for (const double a : {-1.2, 0.0, 0.4}) {
    for (const double c : {0.0, 0.9, 4.0}) {
      const Eigen::Vector3d pos(31, -17, 44);  // of the tool point in the table's axes, from where it is at home
      const Eigen::Vector3d joints = XyzacInverse(exact.text, pos, a, c);
      compensate::Positions positions{};
      positions[machine::FindAxis(machine, "X")] = joints.x();
      positions[machine::FindAxis(machine, "Y")] = joints.y();
      positions[machine::FindAxis(machine, "Z")] = joints.z();
      positions[machine::FindAxis(machine, "A")] = a;
      positions[machine::FindAxis(machine, "C")] = c;
      const Eigen::Vector3d tip = machine::TipInTable<double>(
          machine::EvaluateChain<double>(machine, positions.data(), {}), request.state.tool_tip_mm);
      EXPECT_LT((tip - request.state.tool_tip_mm - pos).norm(), 1e-5) << a << " " << c;
    }
  }
}

TEST(LinuxcncXyzac, LocationErrorsMoveThePins) {
  const Made exact = Make("{}", WithTip("linuxcnc-xyzac")), made = Make(kLocations, WithTip("linuxcnc-xyzac"));
  ASSERT_TRUE(made.status.ok()) << made.status;
  EXPECT_NEAR(Pin(made.text, "x-rot-point") - Pin(exact.text, "x-rot-point"), 0.0531, 2e-5);
  EXPECT_NEAR(Pin(made.text, "y-rot-point") - Pin(exact.text, "y-rot-point"), 0.0402 - 0.0214, 2e-5);
  EXPECT_NEAR(Pin(made.text, "z-rot-point") - Pin(exact.text, "z-rot-point"), -0.0333, 2e-5);
  EXPECT_NEAR(Pin(made.text, "y-offset") - Pin(exact.text, "y-offset"), 0.0214, 2e-5);
  const auto& error = made.report["tool_point_error"]["within_ranges"];
  EXPECT_GT(error["before"]["max_um"].get<double>(), 60.0);
  EXPECT_LT(error["after"]["max_um"].get<double>(), 0.05);
  EXPECT_TRUE(made.report["not_carried"].empty()) << NotCarried(made);
}

TEST(LinuxcncXyzac, WhatPinsCannotCarryIsListed) {
  const Made made = Make(
      R"({"EX0C": 53.1, "EA0C": 80, "EC0Y": 40,
           "terms": [{"symbol": "EZC", "shape": "harmonic", "order": 2, "amplitude": 5, "phase_deg": 0}]})",
      WithTip("linuxcnc-xyzac"));
  ASSERT_TRUE(made.status.ok()) << made.status;
  for (const char* term : {"EA0C: ", "EC0Y: ", "EZC:harmonic(2): ", "orientation: "})
    EXPECT_THAT(NotCarried(made), HasSubstr(term));
}

TEST(LinuxcncXyzac, OtherMachinesAreRefused) {
  machine::Machine turned = WithTravel();
  turned.axes[machine::FindAxis(turned, "C")].direction = {0, 0, -1};
  const Made made = Make(turned, kLocations, Request("linuxcnc-xyzac"));
  EXPECT_EQ(made.status.code(), absl::StatusCode::kFailedPrecondition);
  EXPECT_THAT(std::string(made.status.message()), HasSubstr("must turn the table right-handed"));
  EXPECT_EQ(Make(kLocations, Request("linuxcnc-xyzbc")).status.code(), absl::StatusCode::kFailedPrecondition);
}

TEST(LinuxcncXyzac, BadFilesAreNamedByLine) {
  const auto read = LinuxcncXyzacFormat().read;
  const std::string
      head = "# tool point at home: 0 0 0\n",
      pins =
          "setp xyzac-trt-kins.x-rot-point 0\nsetp xyzac-trt-kins.y-rot-point 0\n"
          "setp xyzac-trt-kins.z-rot-point 0\nsetp xyzac-trt-kins.y-offset 0\nsetp xyzac-trt-kins.z-offset 0\n";
  EXPECT_TRUE(read(WithTravel(), head + pins).ok());
  const auto refused = [&](const std::string& text, const std::string& message) {
    EXPECT_THAT(std::string(read(WithTravel(), text).status().message()), HasSubstr(message)) << text;
  };
  refused(pins, "the note of the tool point");
  refused(head + pins + "setp xyzac-trt-kins.z-offset 1\n",
          "line 7: 'xyzac-trt-kins.z-offset', expected every pin once");
  refused(head + "setp xyzac-trt-kins.q 1\n", "line 2");
  refused(head + "setp xyzbc-trt-kins.x-rot-point 1\n", "line 2");
  refused(head + "setp xyzac-trt-kins.x-rot-point 1e-3\n", "line 2");
}

TEST(LinuxcncXyzbc, ATiltingTableAboutB) {
  using machine::testing::Linear, machine::testing::Rotary;
  machine::Machine machine = machine::testing::Make(
      "xyzbc", {Linear("Y", {0, 1, 0}), Linear("Z", {0, 0, 1})},
      {Linear("X", {-1, 0, 0}), Rotary("B", {0, 1, 0}, {12, 0, -30}), Rotary("C", {0, 0, 1}, {-3, 5, 0})}, {});
  TableRequest request = Request("linuxcnc-xyzbc");
  request.ranges = {{"X", -100, 100}, {"Y", -100, 100}, {"Z", -100, 100}, {"B", -1, 1}, {"C", 0, 6}};
  const Made made = Make(machine, R"({"EX0B": 30, "EZ0B": -20, "EX0C": 11, "EY0C": 25})", request);
  ASSERT_TRUE(made.status.ok()) << made.status;
  EXPECT_NEAR(Pin(made.text, "x-rot-point"), -3 + 0.041, 2e-5);
  EXPECT_NEAR(Pin(made.text, "x-offset"), 15 - 0.011, 2e-5);
  EXPECT_NEAR(Pin(made.text, "y-rot-point"), 5.025, 2e-5);
  EXPECT_NEAR(Pin(made.text, "z-rot-point"), -30.020, 2e-5);
  EXPECT_LT(made.report["tool_point_error"]["within_ranges"]["after"]["max_um"].get<double>(), 0.05);
}

// trtfuncs.c of LinuxCNC 2.9.0~pre1, xyzbcKinematicsInverse.
Eigen::Vector3d XyzbcInverse(const std::string& pins, const Eigen::Vector3d& pos, double b, double c) {
  const double x_rot = Pin(pins, "x-rot-point"), y_rot = Pin(pins, "y-rot-point"), z_rot = Pin(pins, "z-rot-point");
  const double dx = Pin(pins, "x-offset"), dz = Pin(pins, "z-offset");
  return {std::cos(c) * std::cos(b) * (pos.x() - x_rot) - std::sin(c) * std::cos(b) * (pos.y() - y_rot) +
              std::sin(b) * (pos.z() - z_rot) - std::cos(b) * dx - std::sin(b) * dz + dx + x_rot,
          std::sin(c) * (pos.x() - x_rot) + std::cos(c) * (pos.y() - y_rot) + y_rot,
          -std::cos(c) * std::sin(b) * (pos.x() - x_rot) + std::sin(c) * std::sin(b) * (pos.y() - y_rot) +
              std::cos(b) * (pos.z() - z_rot) + std::sin(b) * dx - std::cos(b) * dz + dz + z_rot};
}

using Inverse = Eigen::Vector3d (*)(const std::string& pins, const Eigen::Vector3d& pos, double tilt, double c);

// How far LinuxCNC, with these pins, brings the tool point of the machine with its errors from where the program wants
// it, more than at home: what moves all alike belongs into the work offset.
double WorstMm(const machine::Machine& machine, const machine::ErrorModel& errors, const Eigen::Vector3d& tip_mm,
               const std::string& tilting, Inverse inverse, const std::string& pins) {
  const auto error = [&](const Eigen::Vector3d& pos, double tilt, double c) -> Eigen::Vector3d {
    const Eigen::Vector3d joints = inverse(pins, pos, tilt, c);
    std::array<shapes::AxisState, machine::kMaxAxes> axes;
    compensate::Positions positions{};
    for (const auto& [name, value] : std::map<std::string, double>{
             {"X", joints.x()}, {"Y", joints.y()}, {"Z", joints.z()}, {tilting, tilt}, {"C", c}}) {
      const int axis = machine::FindAxis(machine, name);
      positions[axis] = axes[axis].position = value;
    }
    shapes::State state;
    state.axes = {axes.data(), static_cast<size_t>(machine.axis_count())};
    const auto chain =
        machine::EvaluateChain<double>(machine, positions.data(), machine::ErrorsAt(machine, errors, state));
    return machine::TipInTable<double>(chain, tip_mm) - tip_mm - pos;
  };
  const Eigen::Vector3d at_home = error(Eigen::Vector3d::Zero(), 0.0, 0.0);
  double worst = 0.0;
  for (const double tilt : {-1.2, -0.3, 0.0, 0.5}) {
    for (const double c : {0.0, 0.9, 2.5, 4.0}) {
      for (const double place : {-60.0, 0.0, 80.0}) {
        worst = std::max(worst, (error({place, -0.5 * place, 40.0 - place}, tilt, c) - at_home).norm());
      }
    }
  }
  return worst;
}

// The numbers of the pins, by LinuxCNC's own formulas on the machine with its errors: what the file says is what the
// control does with it.
TEST(LinuxcncPins, LinuxcncsFormulasWithThemBringTheToolPointThere) {
  constexpr double kPinsMm = 5e-5;  // four or five pins of 1e-5 mm
  const machine::Machine xyzac = WithTravel();
  TableRequest request = WithTip("linuxcnc-xyzac");
  Eigen::Vector3d tip_mm = request.state.tool_tip_mm;
  machine::ErrorModel errors = Errors(xyzac, kLocations);
  EXPECT_GT(WorstMm(xyzac, errors, tip_mm, "A", XyzacInverse, Make(xyzac, "{}", request).text), 0.05);
  EXPECT_LT(WorstMm(xyzac, errors, tip_mm, "A", XyzacInverse, Make(xyzac, kLocations, request).text), kPinsMm);

  using machine::testing::Linear, machine::testing::Rotary;
  const machine::Machine xyzbc = machine::testing::Make(
      "xyzbc", {Linear("Y", {0, 1, 0}), Linear("Z", {0, 0, 1})},
      {Linear("X", {-1, 0, 0}), Rotary("B", {0, 1, 0}, {12, 0, -30}), Rotary("C", {0, 0, 1}, {-3, 5, 0})}, {});
  constexpr char kTableLocations[] = R"({"EX0B": 30, "EZ0B": -20, "EX0C": 11, "EY0C": 25})";
  request = WithTip("linuxcnc-xyzbc");
  request.ranges = {{"X", -100, 100}, {"Y", -100, 100}, {"Z", -100, 100}, {"B", -1, 1}, {"C", 0, 6}};
  tip_mm = request.state.tool_tip_mm;
  errors = Errors(xyzbc, kTableLocations);
  EXPECT_GT(WorstMm(xyzbc, errors, tip_mm, "B", XyzbcInverse, Make(xyzbc, "{}", request).text), 0.02);
  EXPECT_LT(WorstMm(xyzbc, errors, tip_mm, "B", XyzbcInverse, Make(xyzbc, kTableLocations, request).text), kPinsMm);
  EXPECT_LT(WorstMm(xyzbc, {}, tip_mm, "B", XyzbcInverse, Make(xyzbc, "{}", request).text), kPinsMm);
}

TEST(HeidenhainKinematics, ShiftsFromAxisToAxisOnBothSides) {
  const Made made = Make(kLocations, Request("heidenhain-kinematics"));
  ASSERT_TRUE(made.status.ok()) << made.status;
  EXPECT_THAT(made.text, HasSubstr("BEGIN TABLE.TAB MM\nNR KEY AXIS COORD\n0 TRANS X 0.0000\n1 TRANS Y 0.0402\n"
                                   "2 TRANS Z -50.0333\n3 MAXIS A 0\n4 TRANS X 0.0531\n5 TRANS Y -0.0214\n"));
  EXPECT_LT(made.report["tool_point_error"]["within_ranges"]["after"]["max_um"].get<double>(), 0.3);
  machine::Machine swivel = machine::testing::SwivelHead();
  TableRequest request = Request("heidenhain-kinematics");
  request.state.tool_tip_mm = {0, 0, -200};
  request.ranges = {{"B", -1, 1}, {"C", 0, 6}};
  const Made head = Make(swivel, R"({"EZ0T": 100, "EX0B": 30, "EX0C": 20})", request);
  ASSERT_TRUE(head.status.ok()) << head.status;
  EXPECT_THAT(head.text, HasSubstr("BEGIN HEAD.TAB MM"));
  EXPECT_LT(head.report["tool_point_error"]["within_ranges"]["after"]["max_um"].get<double>(), 0.3);
  EXPECT_FALSE(HeidenhainKinematicsFormat().read(swivel, made.text).ok());
}

TEST(HeidenhainCom, StepsArePowersOfTwo) {
  const Made made =
      Make(R"({"terms": [{"symbol": "EXX", "shape": "quadratic", "amplitude": 10}]})", Request("heidenhain-com"));
  ASSERT_TRUE(made.status.ok()) << made.status;
  EXPECT_THAT(made.text, HasSubstr("BEGIN X.COM DATUM:-300.0000 DIST:"));
  EXPECT_THAT(made.text, HasSubstr("NR X=F(X)\n0 0.01"));  // the error: it goes too far
  EXPECT_LE(made.report["tables"][0]["points"][0].get<int>(), 256);
  EXPECT_LT(made.report["tables"][0]["left_max"].get<double>(), 0.2);
  const auto read = HeidenhainComFormat().read;
  const auto refused = [&](const std::string& text, const std::string& message) {
    EXPECT_THAT(std::string(read(WithTravel(), text).status().message()), HasSubstr(message)) << text;
  };
  refused("BEGIN X.COM DATUM:0 DIST:1.5\n", "line 1");
  refused("BEGIN X.COM DATUM:0 DIST:10\nNR Y=F(X)\n", "line 2");
  refused("BEGIN X.COM DATUM:0 DIST:10\nNR X=F(X)\n0 0\n2 0\n[END]\n", "line 4: '2 0', expected 1");
  refused("BEGIN X.COM DATUM:0 DIST:10\nNR X=F(X)\n0 0\n1 0\n", "then [END]");
}

TEST(IsgVolumetric, ComponentsInMmAndRad) {
  const Made made =
      Make(R"({"EC0Y": -20, "EX0C": 53.1, "EZ0T": 5, "terms": [{"symbol": "EXX", "shape": "linear", "amplitude": 10},
      {"symbol": "EAX", "shape": "linear", "amplitude": 40}, {"symbol": "EYX", "shape": "backlash", "amplitude": 3},
      {"symbol": "EBY", "shape": "linear", "variable": "Z", "amplitude": 10}]})",
           Request("isg-volumetric"));
  ASSERT_TRUE(made.status.ok()) << made.status;
  EXPECT_THAT(made.text,
              HasSubstr("X,-300.0000,-0.0030000,0.0000000,0.0000000,-0.000012000,0.000000000,0.000000000\n"));
  EXPECT_THAT(made.text, HasSubstr("Y,,0.0000000,0.0000000,0.0000000,0.000000000,0.000000000,-0.000020000\n"));
  EXPECT_THAT(made.text, HasSubstr("C,,0.0531000,"));
  EXPECT_THAT(NotCarried(made), HasSubstr("EZ0T: isg-volumetric holds errors of axes only"));
  EXPECT_THAT(NotCarried(made), HasSubstr("EYX:backlash: isg-volumetric knows no sense of motion"));
  EXPECT_THAT(NotCarried(made), HasSubstr("EBY:linear(Z): isg-volumetric holds the errors of an axis over its own"));
  const auto read = IsgVolumetricFormat().read;
  const std::string heading = "axis,position,EX_mm,EY_mm,EZ_mm,EA_rad,EB_rad,EC_rad\n";
  const auto refused = [&](const std::string& text, const std::string& message) {
    EXPECT_THAT(std::string(read(WithTravel(), text).status().message()), HasSubstr(message)) << text;
  };
  refused("axis,position\n", "line 1");
  refused(heading + "X,0,0,0,0,0,0\n", "line 2: 'X,0,0,0,0,0,0', expected 8 cells");
  refused(heading + "X,0,0,0,0,0,0,1e-6\n", "line 2: '1e-6'");
  refused(heading + "X,1,0,0,0,0,0,0\nX,0,0,0,0,0,0,0\n", "line 3: positions must increase");
  refused(heading + "X,,0,0,0,0,0,0\nX,,0,0,0,0,0,0\n", "one row of constants");
}

// An angle with a lever along another axis is what a grid holds and tables of one position cannot.
TEST(FanucGrid, AnglesWithLeversAreTrilinear) {
  const char* const roll =
      R"({"terms": [{"symbol": "EBX", "shape": "linear", "amplitude": 100},
                     {"symbol": "EYY", "shape": "linear", "amplitude": 20}]})";
  TableRequest request = Request("fanuc-3d");
  machine::Machine machine = WithTravel();
  for (machine::Axis& axis : machine.axes) {
    if (axis.kind == machine::AxisKind::kRotary) axis.min_position = axis.max_position = std::nullopt;
  }
  const Made made = Make(machine, roll, request);
  ASSERT_TRUE(made.status.ok()) << made.status;
  const auto& error = made.report["tool_point_error"]["within_ranges"];
  EXPECT_GT(error["before"]["max_um"].get<double>(), 9.0);
  EXPECT_LT(error["after"]["max_um"].get<double>(), 2.0);
  request.resolution = 1e-4;
  const Made fine = Make(machine, roll, request);
  ASSERT_TRUE(fine.status.ok()) << fine.status;
  EXPECT_LT(fine.report["tool_point_error"]["within_ranges"]["after"]["max_um"].get<double>(), 0.4);
  EXPECT_THAT(made.text, HasSubstr("%\nN20000P"));
  const auto read = FanucGridFormat().read;
  std::string bad = made.text;
  bad.replace(bad.find("N20001"), 6, "N20009");
  EXPECT_THAT(std::string(read(machine, bad).status().message()), HasSubstr("line 3: "));
  bad = made.text;
  bad.erase(bad.find("N20000"), bad.find("N20001") - bad.find("N20000"));
  EXPECT_THAT(std::string(read(machine, bad).status().message()), HasSubstr("the notes say"));
}

TEST(FanucGrid, WhatThreeAxesLeaveStaysWithinTheTolerance) {
  TableRequest request = Request("fanuc-3d");
  request.tolerance_mm = 2e-3;
  const Made made = Make(
      R"({"terms": [{"symbol": "EZX", "shape": "harmonic", "variable": "X", "period_mm": 400, "amplitude": 3,
                      "phase_deg": 0},
                    {"symbol": "EZY", "shape": "harmonic", "variable": "Y", "period_mm": 400, "amplitude": 3,
                      "phase_deg": 0},
                    {"symbol": "EZZ", "shape": "quadratic", "amplitude": 8}]})",
      request);
  ASSERT_TRUE(made.status.ok()) << made.status;
  constexpr double kHalfStepUm = 0.5;
  for (const auto& table : made.report["tables"])
    EXPECT_LT(table["left_max"].get<double>(), 2.0 + kHalfStepUm) << table;
}

}  // namespace
}  // namespace axiscal::tables
