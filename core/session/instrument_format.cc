#include "core/session/instrument_format.h"

#include "core/base/status.h"

namespace axiscal::session {
namespace {

HeaderRule PointMm(const std::string& key) {
  return {key, 3, -kMaxLengthMm, kMaxLengthMm, absl::StrFormat("three numbers in mm within +-%g", kMaxLengthMm)};
}

HeaderRule LengthMm(const std::string& key, double min, double max) {
  return {key, 1, min, max, absl::StrFormat("a length in mm from %g to %g", min, max)};
}

HeaderRule AngleDeg(const std::string& key, double limit) {
  return {key, 1, -limit, limit, absl::StrFormat("an angle in deg within +-%g", limit)};
}

HeaderRule Text(const std::string& key) { return {key, 0, 0, 0, "a text"}; }

ReadingColumn Number(const std::string& name, const std::string& unit, double limit, const std::string& hint = "") {
  return {name, -limit, limit, absl::StrFormat("%s within +-%g%s", unit, limit, hint), false, false};
}

ReadingColumn MaybeEmpty(ReadingColumn column) {
  column.may_be_empty = true;
  return column;
}

ReadingColumn Planned(ReadingColumn column) {
  column.source = ColumnSource::kPlan;
  return column;
}

ReadingColumn FromTouches(ReadingColumn column) {
  column.source = ColumnSource::kFromTouches;
  return column;
}

ReadingColumn Name(const std::string& name) { return {name, 0, 0, "a name", true, false}; }

ReadingColumn Optional(ReadingColumn column) {
  column.is_optional = true;
  return column;
}

ReadingColumn Deviation(const std::string& name) { return Number(name, "mm", kMaxDeviationMm, " (are these um?)"); }

ReadingColumn Position(const std::string& name) { return Number(name, "mm", kMaxLengthMm); }

std::vector<InstrumentFormat> Table() {
  constexpr double kMaxEccentricityUm = 1e4;
  constexpr double kMaxTurnMmPerM = 100;  // 0.1 rad: more is another unit
  return {
      {"ballbar",
       {PointMm("table_ball_mm"), LengthMm("bar_length_mm", kMinBarLengthMm, kMaxBarLengthMm)},
       {},
       {Deviation("dL_mm")},
       AxisColumns::kAll,
       true},
      {"tracker",
       {},
       {},
       {Optional(Planned(Name("target"))), Position("px_mm"), Position("py_mm"), Position("pz_mm")},
       AxisColumns::kAll,
       true},
      {"rtest",
       {PointMm("table_ball_mm")},
       {},
       {Deviation("dx_mm"), Deviation("dy_mm"), Deviation("dz_mm")},
       AxisColumns::kAll,
       true},
      {"touch",
       {LengthMm("stylus_radius_mm", 0.01, 100)},
       {{"sphere", 4, "x y z radius in mm"}, {"plane", 6, "x y z in mm and the outward normal nx ny nz"}},
       {Planned(Number("nx", "a component of a unit vector", 1)),
        Planned(Number("ny", "a component of a unit vector", 1)),
        Planned(Number("nz", "a component of a unit vector", 1)), Planned(Name("feature"))},
       AxisColumns::kAll,
       true},
      {"centres",
       {PointMm("table_ball_mm")},
       {},
       {FromTouches(Position("cx_mm")), FromTouches(Position("cy_mm")), FromTouches(Position("cz_mm"))},
       AxisColumns::kRotaryOnly,
       true},
      {"length", {}, {}, {Position("L_mm")}, AxisColumns::kAll, true},
      {"direction", {PointMm("about")}, {}, {Number("turn_mm_per_m", "mm/m", kMaxTurnMmPerM)}, AxisColumns::kAll, true},
      {"eccentricity",
       {},
       {},
       {Planned(Name("run")), Planned(Number("sense", "the sense of motion", 1)),
        MaybeEmpty(Number("ex_um", "um", kMaxEccentricityUm)), MaybeEmpty(Number("ey_um", "um", kMaxEccentricityUm)),
        MaybeEmpty(Number("ez_um", "um", kMaxEccentricityUm))},
       AxisColumns::kNone,
       false},
      {"tool-setter",
       {{"beam", 3, -1e3, 1e3, "R_l in mm, yaw and pitch in deg"}},
       {{"rod", 6, "R_r R_f phi tau L_r theta_th in mm and deg"}},
       {Planned(Name("rod")), Planned(Number("readout", "the number of the readout", 1e6)), Position("Z_mm")},
       AxisColumns::kNone,
       false},
      {"tool-curve",
       {LengthMm("tool_radius_mm", 0.1, 500),
        LengthMm("insert_radius_mm", 0.1, 100),
        {"inserts", 1, 1, 24, "the number of inserts, 1 to 24"},
        AngleDeg("radial_angle_deg", 45),
        AngleDeg("axial_angle_deg", 45),
        LengthMm("offset_d_mm", -600, 600),
        LengthMm("beam_radius_mm", 1e-3, 5),
        {"spindle_rpm", 1, 1, 1e6, "a speed in rpm from 1 to 1e+06"},
        {"feed_mm_min", 1, 1e-3, 1e5, "a feed in mm/min from 0.001 to 100000"}},
       {},
       {Planned(Number("start_deg", "deg", kMaxAngleDeg)), Position("length_mm")},
       AxisColumns::kNone,
       false},
  };
}

}  // namespace

const std::vector<InstrumentFormat>& InstrumentFormats() {
  static const auto* const formats = new std::vector<InstrumentFormat>(Table());
  return *formats;
}

const InstrumentFormat* FindInstrumentFormat(const std::string& name) {
  for (const InstrumentFormat& format : InstrumentFormats()) {
    if (format.name == name) return &format;
  }
  return nullptr;
}

std::string InstrumentNames() {
  std::string names;
  for (const InstrumentFormat& format : InstrumentFormats()) {
    absl::StrAppend(&names, names.empty() ? "" : ", ", format.name);
  }
  return names;
}

const std::vector<HeaderRule>& CommonHeader() {
  // A sigma of 0 would weigh a reading without limit; 1e5 um is 0.1 m.
  static const auto* const rules = new std::vector<HeaderRule>{
      Text("machine"),
      Text("session"),
      Text("instrument"),
      {"sigma_um", 1, 1e-6, 1e5, "one number in um from 1e-06 to 100000, the 1-sigma repeatability of a reading"},
      PointMm("tool_tip_mm")};
  return *rules;
}

}  // namespace axiscal::session
