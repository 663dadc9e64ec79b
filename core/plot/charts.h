// Pictures for technicians: values against a variable, polar traces, bars. Axes carry numbers and units; a picture's
// size is bounded whatever the number of points.
#ifndef AXISCAL_CORE_PLOT_CHARTS_H_
#define AXISCAL_CORE_PLOT_CHARTS_H_

#include <string>
#include <vector>

#include "core/base/language.h"
#include "core/plot/svg.h"

namespace axiscal::plot {

struct Point {
  double x = 0.0, y = 0.0;
};

struct Series {
  std::string name;
  std::vector<Point> points;
};

struct Panel {
  std::string title;
  std::vector<Series> series;
};

// Whether y counts from the middle of a panel, up and down, or from its bottom, each point on a line from there.
enum class Ground { kMiddle, kBottom };

// Panels one below the other over one x axis. All have the y scale of the largest, but a panel that would fill less
// than a quarter of it gets its own, and says so in `language`, which also writes the numbers. Points that are not
// finite are left out; of more than 5,000 points of a series each pixel column keeps the highest and the lowest.
std::string ScatterChart(const std::string& title, const std::string& x_label, const std::string& y_label,
                         const std::vector<Panel>& panels, Ground ground = Ground::kMiddle,
                         base::Language language = base::Language::kEnglish);

// Panels side by side; a point's x is the angle (rad, counter-clockwise from the right), its y the deviation from the
// base circle, outwards. `unit`: of y.
std::string PolarChart(const std::string& title, const std::string& unit, const std::vector<Panel>& panels,
                       base::Language language = base::Language::kEnglish);

struct Bar {
  std::string name;
  double value = 0.0;
};

// Bars in the order given, with a dashed line at `threshold`.
std::string BarChart(const std::string& title, const std::string& x_label, const std::vector<Bar>& bars,
                     double threshold, const std::string& threshold_name);

// What a picture shows as a table: "panel,series,X_LABEL,Y_LABEL" and a line per finite point, with a point for
// decimals and at least six digits. Names are quoted where they must be (RFC 4180).
std::string Csv(const std::string& x_label, const std::string& y_label, const std::vector<Panel>& panels);

// Of more than 5,000 points the lowest and the highest of each of so many equal parts of x as a chart has columns of
// pixels: what ScatterChart would show of them.
std::vector<Point> Thinned(std::vector<Point> points);

// Two points, the extremes, per pixel column from `left` to `right`; all points where there are no more than `most`.
std::vector<Pixel> Decimated(const std::vector<Pixel>& points, size_t most, double left, double right);

// Tick marks at 1, 2 or 5 times a power of ten, about `count` of them within [low, high].
std::vector<double> Ticks(double low, double high, int count);

}  // namespace axiscal::plot

#endif  // AXISCAL_CORE_PLOT_CHARTS_H_
