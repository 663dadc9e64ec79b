// The picture of docs/architecture.md, drawn by the product's own writer: docs/frames.svg is what is drawn here.
#include <gtest/gtest.h>

#include <cmath>
#include <fstream>

#include "core/plot/svg.h"
#include "tests/house/page.h"

namespace axiscal::house {
namespace {

using plot::Anchor;
using plot::Pixel;
using plot::Svg;

constexpr char kBlack[] = "#222222", kGrey[] = "#8a8a8a", kLight[] = "#dddddd", kTool[] = "#b03a2e",
               kWork[] = "#1f618d";

void Arrow(Svg& svg, Pixel from, Pixel to, const std::string& color, double width = 1.5) {
  svg.Line(from, to, color, width);
  const double length = std::hypot(to.x - from.x, to.y - from.y);
  const double x = (to.x - from.x) / length * 8.0, y = (to.y - from.y) / length * 8.0;
  for (const double side : {0.5, -0.5}) svg.Line(to, {to.x - x - side * y, to.y - y + side * x}, color, width);
}

void DrawMachine(Svg& svg) {
  svg.Text({20, 24}, "Two branches from the bed", Anchor::kStart, 14, true);
  svg.Rectangle({40, 262}, 400, 26, kBlack, kLight);
  svg.Text({52, 280}, "bed: frame machine");
  svg.Rectangle({60, 80}, 34, 182, kBlack, kLight);
  svg.Rectangle({94, 80}, 150, 34, kBlack, kLight);
  svg.Rectangle({205, 114}, 34, 44, kBlack, kLight);
  svg.Text({100, 101}, "axes X, Z, B");
  svg.Text({247, 140}, "spindle (T)");
  svg.Line({222, 158}, {222, 204}, kBlack, 4.0);
  svg.Dots({{222, 206}}, kTool);
  svg.Text({212, 196}, "tool", Anchor::kEnd);
  svg.Text({212, 214}, "tool point", Anchor::kEnd, 12, true);
  svg.Rectangle({180, 248}, 170, 14, kBlack, kLight);
  svg.Rectangle({205, 232}, 120, 16, kBlack, kLight);
  svg.Text({265, 245}, "table: axes Y, C", Anchor::kMiddle, 11);
  svg.Line({310, 232}, {310, 222}, kBlack, 2.0);
  svg.Circle({310, 215}, 7, kWork, "#ffffff");
  svg.Text({322, 211}, "table ball (W)", Anchor::kStart, 12, true);

  Arrow(svg, {77, 262}, {77, 97}, kTool);
  Arrow(svg, {77, 97}, {96, 97}, kTool);
  Arrow(svg, {222, 114}, {222, 154}, kTool);
  Arrow(svg, {390, 262}, {354, 254}, kWork);
  Arrow(svg, {330, 240}, {314, 224}, kWork);

  svg.Text({470, 60}, "tool branch", Anchor::kStart, 12, true);
  svg.Text({470, 78}, "bed_from_tool = E_X J_X E_Z J_Z E_B J_B E_T");
  svg.Text({470, 108}, "work branch", Anchor::kStart, 12, true);
  svg.Text({470, 126}, "bed_from_table = E_Y J_Y E_C J_C E_W");
  svg.Text({470, 156}, "J: motion by the command, E: error of the joint,");
  svg.Text({470, 172}, "in front of its motion");
  Arrow(svg, {490, 262}, {550, 262}, kBlack);
  Arrow(svg, {490, 262}, {490, 202}, kBlack);
  svg.Text({556, 266}, "x");
  svg.Text({486, 196}, "z", Anchor::kMiddle);
  svg.Circle({490, 262}, 6, kBlack, "#ffffff");
  svg.Line({486, 258}, {494, 266}, kBlack);
  svg.Line({486, 266}, {494, 258}, kBlack);
  svg.Text({470, 280}, "y, away from the reader");
}

void DrawStraightness(Svg& svg) {
  svg.Text({20, 326}, "Sign of an error: actual - nominal (seen from above)", Anchor::kStart, 14, true);
  svg.Line({60, 440}, {430, 440}, kGrey, 1.0, true);
  svg.Text({60, 458}, "nominal line of X");
  std::vector<Pixel> actual;
  for (int x = 0; x <= 370; x += 10) actual.push_back({60.0 + x, 440.0 - 60.0 * std::sin(x * M_PI / 370.0)});
  svg.Polyline(actual, kTool, 2.0);
  svg.Text({90, 388}, "actual", Anchor::kStart);
  Arrow(svg, {245, 440}, {245, 383}, kBlack, 2.0);
  svg.Text({252, 420}, "EYX > 0", Anchor::kStart, 12, true);
  Arrow(svg, {400, 440}, {450, 440}, kBlack);
  Arrow(svg, {30, 440}, {30, 390}, kBlack);
  svg.Text({456, 444}, "+X");
  svg.Text({30, 382}, "+Y", Anchor::kMiddle);
  svg.Text({490, 380}, "X carries the tool: the tool is too far +Y");
  svg.Text({490, 398}, "X carries the table: the tool is too far -Y");
  svg.Text({490, 416}, "(both as seen from the workpiece)");
  svg.Text({490, 440}, "correction = - error", Anchor::kStart, 12, true);
}

TEST(Frames, ThePictureIsWhatIsDrawnHere) {
  Svg svg(780, 470);
  DrawMachine(svg);
  DrawStraightness(svg);
  const std::string drawn = svg.Finish(), path = ::testing::TempDir() + "frames.svg";
  std::ofstream(path) << drawn;
  EXPECT_TRUE(drawn == ReadPage("docs/frames.svg")) << "docs/frames.svg is another picture than " << path;
}

}  // namespace
}  // namespace axiscal::house
