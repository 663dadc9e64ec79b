// The figures that users are asked for, computed from measured sessions as they are: no model of the machine, no set-up
// but the circle's centre and the line's place. Circles and cones of a ball bar (circular.h), sessions in which one
// axis moves alone (positioning.h, line.h), R-tests of one rotary axis (rotary_sessions.h).
#ifndef AXISCAL_CORE_FIGURES_FIGURES_H_
#define AXISCAL_CORE_FIGURES_FIGURES_H_

#include <optional>
#include <string>
#include <vector>

#include "core/figures/positioning.h"
#include "core/instruments/run.h"
#include "core/machine/machine.h"

namespace axiscal::figures {

struct Figure {
  std::string symbol;  // "G", "A(up)"
  std::string text;    // "circular deviation, counter-clockwise"
  double value_mm = 0.0;
  // By the stated repeatability of a reading, how well a length's scale is known and what else is stated, drawn: how
  // far the value scatters,
  // and what a machine without errors would show.
  double sigma_mm = 0.0, of_noise_mm = 0.0;
};

struct MeasuredTest {
  std::string kind;                   // "circle", "cone", "line", "turn" of a rotary axis, "rotary" by an R-test,
                                      // "eccentricity" of a trace
  std::string what;                   // "circle XY, radius 150 mm", "axis X from 0 to 500 mm"
  std::string unit = "um";            // of the figures as they are shown; "urad" where `_mm` below are mm per metre
  std::vector<std::string> sessions;  // it is made of
  std::vector<Figure> figures;
  std::optional<Positioning> positioning;     // of a line: every target
  std::optional<double> temperature_celsius;  // mean, where it was recorded
  std::vector<std::string> notes;
};

struct Figures {
  std::vector<MeasuredTest> tests;
  std::vector<std::string> left_out;  // sessions that no figure is known for, and why
};

// Sessions of the two senses of one circle (plane, radius, ball and tool alike) make one test, wherever they stand.
// Readings count as at 20 deg C where headers state how lengths grow (instruments/stated.h), and notes say so.
Figures FiguresOf(const machine::Machine& machine, const std::vector<instruments::MeasuringRun>& measured);

// Adds what these sessions state, where they state anything.
void NoteStated(const std::vector<const instruments::MeasuringRun*>& runs, std::vector<std::string>* notes);

// Of all readings; nothing where none was recorded.
std::optional<double> MeanTemperature(const std::vector<const instruments::MeasuringRun*>& runs);

}  // namespace axiscal::figures

#endif  // AXISCAL_CORE_FIGURES_FIGURES_H_
