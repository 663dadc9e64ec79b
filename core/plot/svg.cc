#include "core/plot/svg.h"

#include <cmath>

#include "core/base/status.h"

namespace axiscal::plot {
namespace {

// Hundredths of a pixel; no exponent, no negative zero.
std::string Number(double number) {
  std::string text = absl::StrFormat("%.2f", std::round(number * 100.0) / 100.0 + 0.0);
  while (text.back() == '0') text.pop_back();
  if (text.back() == '.') text.pop_back();
  return text;
}

}  // namespace

std::string Escape(const std::string& text) {
  std::string out;
  for (const char c : text) {
    if (c == '<') {
      out += "&lt;";
    } else if (c == '>') {
      out += "&gt;";
    } else if (c == '&') {
      out += "&amp;";
    } else if (c == '"') {
      out += "&quot;";
    } else {
      out += static_cast<unsigned char>(c) < ' ' ? ' ' : c;
    }
  }
  return out;
}

Svg::Svg(double width, double height) {
  body_ = absl::StrFormat(
      "<?xml version=\"1.0\" encoding=\"UTF-8\"?>\n<svg xmlns=\"http://www.w3.org/2000/svg\" version=\"1.1\" "
      "width=\"%s\" height=\"%s\" viewBox=\"0 0 %s %s\" font-family=\"sans-serif\">\n",
      Number(width), Number(height), Number(width), Number(height));
  Rectangle({0, 0}, width, height, "none", "#ffffff");
}

void Svg::Line(Pixel from, Pixel to, const std::string& color, double width, bool is_dashed) {
  absl::StrAppend(&body_, "<line x1=\"", Number(from.x), "\" y1=\"", Number(from.y), "\" x2=\"", Number(to.x),
                  "\" y2=\"", Number(to.y), "\" stroke=\"", color, "\" stroke-width=\"", Number(width), "\"",
                  is_dashed ? " stroke-dasharray=\"6 4\"" : "", "/>\n");
}

void Svg::Polyline(const std::vector<Pixel>& points, const std::string& color, double width) {
  if (points.empty()) return;
  absl::StrAppend(&body_, "<polyline fill=\"none\" stroke=\"", color, "\" stroke-width=\"", Number(width),
                  "\" points=\"");
  for (size_t i = 0; i < points.size(); ++i)
    absl::StrAppend(&body_, i == 0 ? "" : " ", Number(points[i].x), ",", Number(points[i].y));
  body_ += "\"/>\n";
}

void Svg::Circle(Pixel center, double radius, const std::string& stroke, const std::string& fill) {
  absl::StrAppend(&body_, "<circle cx=\"", Number(center.x), "\" cy=\"", Number(center.y), "\" r=\"", Number(radius),
                  "\" stroke=\"", stroke, "\" fill=\"", fill, "\"/>\n");
}

void Svg::Dots(const std::vector<Pixel>& points, const std::string& color) {
  if (points.empty()) return;
  absl::StrAppend(&body_, "<path fill=\"none\" stroke=\"", color,
                  "\" stroke-width=\"2.5\" stroke-linecap=\"round\" stroke-opacity=\"0.7\" d=\"");
  for (const Pixel& point : points) absl::StrAppend(&body_, "M", Number(point.x), " ", Number(point.y), "h0");
  body_ += "\"/>\n";
}

void Svg::Rectangle(Pixel corner, double width, double height, const std::string& stroke, const std::string& fill) {
  absl::StrAppend(&body_, "<rect x=\"", Number(corner.x), "\" y=\"", Number(corner.y), "\" width=\"", Number(width),
                  "\" height=\"", Number(height), "\" stroke=\"", stroke, "\" fill=\"", fill, "\"/>\n");
}

void Svg::Text(Pixel at, const std::string& text, Anchor anchor, double size, bool is_bold, bool is_upright) {
  const char* anchors[] = {"start", "middle", "end"};
  absl::StrAppend(&body_, "<text x=\"", Number(at.x), "\" y=\"", Number(at.y), "\" text-anchor=\"",
                  anchors[static_cast<int>(anchor)], "\" font-size=\"", Number(size), "\"",
                  is_bold ? " font-weight=\"bold\"" : "");
  if (is_upright) absl::StrAppend(&body_, " transform=\"rotate(-90 ", Number(at.x), " ", Number(at.y), ")\"");
  absl::StrAppend(&body_, ">", Escape(text), "</text>\n");
}

}  // namespace axiscal::plot
