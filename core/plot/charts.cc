#include "core/plot/charts.h"

#include <algorithm>
#include <cmath>
#include <map>

#include "core/base/status.h"

namespace axiscal::plot {
namespace {

constexpr double kWidth = 960.0, kLeft = 80.0, kRight = 20.0, kTop = 44.0, kPanelHeight = 230.0, kGap = 46.0;
constexpr char kInk[] = "#333333", kGrid[] = "#dddddd";
const char* const kColors[] = {"#1f77b4", "#d95f02", "#1b9e77", "#7570b3", "#e7298a", "#66a61e", "#a6761d", "#666666"};

std::string ColorOf(size_t series) { return kColors[series % std::size(kColors)]; }

using base::Language;

std::string NumberText(double number, Language language = Language::kEnglish) {
  return base::NumberIn(language, absl::StrFormat("%.6g", number + 0.0));
}

// Legends longer than a line are cut: the rest is "and n more".
void Legend(const std::vector<Series>& series, double y, Language language, Svg* svg) {
  if (series.size() < 2) return;
  constexpr size_t kNamed = 8;
  constexpr double kPerLetter = 7.0;
  double x = kLeft;
  for (size_t i = 0; i < series.size(); ++i) {
    const double width = 22.0 + kPerLetter * static_cast<double>(series[i].name.size());
    if (i == kNamed || x + width > kWidth - 120.0) {
      svg->Text({x, y + 4.0},
                language == Language::kGerman ? absl::StrCat("und ", series.size() - i, " weitere")
                                              : absl::StrCat("and ", series.size() - i, " more"),
                Anchor::kStart, 11.0);
      return;
    }
    svg->Circle({x + 4.0, y}, 4.0, "none", ColorOf(i));
    svg->Text({x + 12.0, y + 4.0}, series[i].name, Anchor::kStart, 11.0);
    x += width;
  }
}

struct Span {
  double low = INFINITY, high = -INFINITY;

  void Add(double value) {
    if (!std::isfinite(value)) return;
    low = std::min(low, value);
    high = std::max(high, value);
  }
  // With a margin; something where nothing was added.
  Span Padded() const {
    if (low > high) return {-1.0, 1.0};
    const double margin = high > low ? 0.04 * (high - low) : std::max(1e-6, 0.1 * std::abs(high));
    return {low - margin, high + margin};
  }
};

bool IsDrawn(const Point& point) { return std::isfinite(point.x) && std::isfinite(point.y); }

// Of a series; a chart is not read more finely.
constexpr size_t kMostPoints = 5000;

double LargestOf(const Panel& panel) {
  double largest = 0.0;
  for (const Series& series : panel.series) {
    for (const Point& point : series.points) {
      if (IsDrawn(point)) largest = std::max(largest, std::abs(point.y));
    }
  }
  return largest;
}

// Scale of each panel: that of the largest, or its own where it would be a flat line.
std::vector<double> ScalesOf(const std::vector<Panel>& panels) {
  double largest = 0.0;
  for (const Panel& panel : panels) largest = std::max(largest, LargestOf(panel));
  std::vector<double> scales;
  for (const Panel& panel : panels) {
    const double own = LargestOf(panel);
    scales.push_back(own > 0.0 && own < 0.25 * largest ? own : std::max(largest, 1e-9));
  }
  return scales;
}

std::string TitleOf(const Panel& panel, double scale, const std::vector<double>& scales, Language language) {
  const double largest = *std::max_element(scales.begin(), scales.end());
  if (scale >= largest) return panel.title;
  const std::string times = base::NumberIn(language, absl::StrFormat("%.1f", largest / scale));
  return absl::StrCat(panel.title, language == Language::kGerman ? absl::StrCat(" (", times, "-mal größer gezeichnet)")
                                                                 : absl::StrCat(" (drawn ", times, " times larger)"));
}

}  // namespace

std::vector<double> Ticks(double low, double high, int count) {
  std::vector<double> ticks;
  if (!(high > low) || count < 1) return ticks;
  const double rough = (high - low) / count, power = std::pow(10.0, std::floor(std::log10(rough)));
  double step = 10.0 * power;
  for (const double nice : {1.0, 2.0, 5.0}) {
    if (rough <= nice * power) {
      step = nice * power;
      break;
    }
  }
  const double first = std::ceil(low / step);
  for (double k = first; k * step <= high + 1e-9 * step; k += 1.0) ticks.push_back(k * step);
  return ticks;
}

std::vector<Pixel> Decimated(const std::vector<Pixel>& points, size_t most, double left, double right) {
  if (points.size() <= most) return points;
  std::map<int, std::pair<Pixel, Pixel>> columns;  // lowest, highest
  for (const Pixel& point : points) {
    const int column = static_cast<int>(std::floor(std::clamp(point.x, left, right)));
    const auto [it, is_new] = columns.emplace(column, std::pair<Pixel, Pixel>(point, point));
    if (is_new) continue;
    if (point.y < it->second.first.y) it->second.first = point;
    if (point.y > it->second.second.y) it->second.second = point;
  }
  std::vector<Pixel> kept;
  for (const auto& [column, extremes] : columns) {
    kept.push_back(extremes.first);
    kept.push_back(extremes.second);
  }
  return kept;
}

std::string Csv(const std::string& x_label, const std::string& y_label, const std::vector<Panel>& panels) {
  const auto cell = [](const std::string& text) {
    if (text.find_first_of(",\"\r\n") == std::string::npos) return text;
    std::string quoted = "\"";
    for (const char c : text) quoted += c == '"' ? "\"\"" : std::string(1, c);
    return quoted + "\"";
  };
  std::string csv = absl::StrCat("panel,series,", cell(x_label), ",", cell(y_label), "\r\n");
  for (const Panel& panel : panels) {
    for (const Series& series : panel.series) {
      const std::string names = absl::StrCat(cell(panel.title), ",", cell(series.name), ",");
      for (const Point& point : series.points) {
        if (IsDrawn(point)) absl::StrAppend(&csv, names, NumberText(point.x), ",", NumberText(point.y), "\r\n");
      }
    }
  }
  return csv;
}

std::vector<Point> Thinned(std::vector<Point> points) {
  if (points.size() <= kMostPoints) return points;
  Span span;
  for (const Point& point : points) {
    if (IsDrawn(point)) span.Add(point.x);
  }
  if (!(span.high > span.low)) return points;
  std::vector<Pixel> pixels;
  const double columns = kWidth - kLeft - kRight, scale = columns / (span.high - span.low);
  for (const Point& point : points) {
    if (IsDrawn(point)) pixels.push_back({(point.x - span.low) * scale, point.y});
  }
  points.clear();
  for (const Pixel& kept : Decimated(pixels, 0, 0.0, columns)) points.push_back({span.low + kept.x / scale, kept.y});
  return points;
}

std::string ScatterChart(const std::string& title, const std::string& x_label, const std::string& y_label,
                         const std::vector<Panel>& panels, Ground ground, Language language) {
  const double height = kTop + static_cast<double>(panels.size()) * (kPanelHeight + kGap) + 40.0;
  Svg svg(kWidth, height);
  svg.Text({kLeft, 24.0}, title, Anchor::kStart, 16.0, true);
  Span x_span;
  for (const Panel& panel : panels) {
    for (const Series& series : panel.series) {
      for (const Point& point : series.points) {
        if (IsDrawn(point)) x_span.Add(point.x);
      }
    }
  }
  x_span = x_span.Padded();
  const std::vector<double> scales = ScalesOf(panels);
  const double right = kWidth - kRight;
  const auto x_of = [&](double x) { return kLeft + (x - x_span.low) / (x_span.high - x_span.low) * (right - kLeft); };
  for (size_t p = 0; p < panels.size(); ++p) {
    const double top = kTop + 20.0 + static_cast<double>(p) * (kPanelHeight + kGap), bottom = top + kPanelHeight;
    const double reach = 1.08 * scales[p];
    const bool is_up = ground == Ground::kBottom;
    const auto y_of = [&](double y) {
      return is_up ? bottom - y / reach * kPanelHeight : 0.5 * (top + bottom) - y / reach * 0.5 * kPanelHeight;
    };
    svg.Text({kLeft, top - 7.0}, TitleOf(panels[p], scales[p], scales, language), Anchor::kStart, 13.0, true);
    for (const double tick : Ticks(is_up ? 0.0 : -reach, reach, 6)) {
      svg.Line({kLeft, y_of(tick)}, {right, y_of(tick)}, tick == 0.0 ? kInk : kGrid);
      svg.Text({kLeft - 8.0, y_of(tick) + 4.0}, NumberText(tick, language), Anchor::kEnd);
    }
    for (const double tick : Ticks(x_span.low, x_span.high, 10)) {
      svg.Line({x_of(tick), top}, {x_of(tick), bottom}, kGrid);
      svg.Text({x_of(tick), bottom + 16.0}, NumberText(tick, language), Anchor::kMiddle);
    }
    svg.Rectangle({kLeft, top}, right - kLeft, kPanelHeight, kInk, "none");
    svg.Text({20.0, 0.5 * (top + bottom)}, y_label, Anchor::kMiddle, 12.0, false, true);
    for (size_t s = 0; s < panels[p].series.size(); ++s) {
      std::vector<Pixel> pixels;
      for (const Point& point : panels[p].series[s].points) {
        if (IsDrawn(point)) pixels.push_back({x_of(point.x), y_of(point.y)});
      }
      for (const Pixel& pixel : pixels) {
        if (is_up) svg.Line({pixel.x, bottom}, pixel, ColorOf(s), 1.5);
      }
      svg.Dots(Decimated(pixels, kMostPoints, kLeft, right), ColorOf(s));
    }
  }
  svg.Text({0.5 * (kLeft + right), height - 34.0}, x_label, Anchor::kMiddle, 13.0);
  if (!panels.empty()) Legend(panels[0].series, height - 12.0, language, &svg);
  return svg.Finish();
}

std::string PolarChart(const std::string& title, const std::string& unit, const std::vector<Panel>& panels,
                       Language language) {
  constexpr double kSide = 470.0, kBase = 120.0, kReach = 70.0;  // base circle and what stands for the scale, pixels
  const double width = std::max(1.0, static_cast<double>(panels.size())) * kSide + 20.0, height = kSide + 90.0;
  Svg svg(width, height);
  svg.Text({20.0, 24.0}, title, Anchor::kStart, 16.0, true);
  const std::vector<double> scales = ScalesOf(panels);
  for (size_t p = 0; p < panels.size(); ++p) {
    const Pixel center = {20.0 + kSide * (static_cast<double>(p) + 0.5), 66.0 + 0.5 * kSide};
    svg.Text({center.x, 56.0}, TitleOf(panels[p], scales[p], scales, language), Anchor::kMiddle, 13.0, true);
    const double per_pixel = scales[p] / kReach;
    for (double angle = 0.0; angle < 359.0; angle += 45.0) {
      const double c = std::cos(angle * M_PI / 180.0), s = -std::sin(angle * M_PI / 180.0), end = kBase + kReach + 10.0;
      svg.Line(center, {center.x + end * c, center.y + end * s}, kGrid);
      svg.Text({center.x + (end + 16.0) * c, center.y + (end + 14.0) * s + 4.0}, NumberText(angle), Anchor::kMiddle,
               11.0);
    }
    for (const double tick : Ticks(-scales[p], scales[p], 4)) {
      svg.Circle(center, kBase + tick / per_pixel, tick == 0.0 ? kInk : kGrid);
    }
    for (size_t s = 0; s < panels[p].series.size(); ++s) {
      std::vector<Pixel> trace;
      const std::vector<Point>& points = panels[p].series[s].points;
      const size_t stride = points.size() / kMostPoints + 1;
      for (size_t i = 0; i < points.size(); i += stride) {
        if (!IsDrawn(points[i])) continue;
        const double radius = std::max(0.0, kBase + points[i].y / per_pixel);
        trace.push_back({center.x + radius * std::cos(points[i].x), center.y - radius * std::sin(points[i].x)});
      }
      svg.Polyline(trace, ColorOf(s), 1.2);
    }
    // Over the traces, each on a patch of paper.
    for (const double tick : Ticks(-scales[p], scales[p], 4)) {
      const std::string text = tick == 0.0 ? "0 " + unit : NumberText(tick, language);
      const double y = center.y - kBase - tick / per_pixel, text_width = 6.0 * static_cast<double>(text.size()) + 4.0;
      svg.Rectangle({center.x - 0.5 * text_width, y - 7.0}, text_width, 14.0, "none", "#ffffff");
      svg.Text({center.x, y + 4.0}, text, Anchor::kMiddle, 11.0);
    }
  }
  if (!panels.empty()) {
    for (size_t s = 0; s < panels[0].series.size(); ++s) {
      const size_t column = s % 3, row = s / 3;
      const double x = 20.0 + 260.0 * static_cast<double>(column), y = height - 28.0 + 16.0 * static_cast<double>(row);
      svg.Line({x, y}, {x + 20.0, y}, ColorOf(s), 2.0);
      svg.Text({x + 26.0, y + 4.0}, panels[0].series[s].name);
    }
  }
  return svg.Finish();
}

std::string BarChart(const std::string& title, const std::string& x_label, const std::vector<Bar>& bars,
                     double threshold, const std::string& threshold_name) {
  constexpr double kNames = 240.0, kRow = 20.0;
  const double bottom = kTop + 20.0 + kRow * static_cast<double>(bars.size()), right = kWidth - 70.0;
  Svg svg(kWidth, bottom + 70.0);
  svg.Text({20.0, 24.0}, title, Anchor::kStart, 16.0, true);
  double largest = 1.2 * threshold, smallest = 0.0;
  for (const Bar& bar : bars) {
    if (!std::isfinite(bar.value)) continue;
    largest = std::max(largest, bar.value);
    smallest = std::min(smallest, bar.value);
  }
  if (!(largest > smallest)) largest = smallest + 1.0;
  const auto x_of = [&](double value) { return kNames + (value - smallest) / (largest - smallest) * (right - kNames); };
  for (const double tick : Ticks(smallest, largest, 8)) {
    svg.Line({x_of(tick), kTop + 10.0}, {x_of(tick), bottom}, kGrid);
    svg.Text({x_of(tick), bottom + 16.0}, NumberText(tick), Anchor::kMiddle);
  }
  for (size_t i = 0; i < bars.size(); ++i) {
    const double y = kTop + 16.0 + kRow * static_cast<double>(i);
    svg.Text({kNames - 8.0, y + 11.0}, bars[i].name, Anchor::kEnd);
    if (!std::isfinite(bars[i].value)) continue;
    const double from = std::min(x_of(0.0), x_of(bars[i].value)), to = std::max(x_of(0.0), x_of(bars[i].value));
    svg.Rectangle({from, y}, to - from, kRow - 6.0, "none", bars[i].value > threshold ? ColorOf(0) : "#999999");
    svg.Text({to + 5.0, y + 11.0}, absl::StrFormat("%.4g", bars[i].value), Anchor::kStart, 11.0);
  }
  svg.Line({x_of(threshold), kTop + 6.0}, {x_of(threshold), bottom}, "#c00000", 1.5, true);
  svg.Text({x_of(threshold) + 4.0, kTop + 8.0}, threshold_name, Anchor::kStart, 11.0);
  svg.Text({0.5 * (kNames + right), bottom + 44.0}, x_label, Anchor::kMiddle, 13.0);
  return svg.Finish();
}

}  // namespace axiscal::plot
