// A small writer of SVG 1.1: lines, circles, rectangles and text in pixels from the top left. The same calls give the
// same bytes.
#ifndef AXISCAL_CORE_PLOT_SVG_H_
#define AXISCAL_CORE_PLOT_SVG_H_

#include <string>
#include <vector>

namespace axiscal::plot {

struct Pixel {
  double x = 0.0, y = 0.0;
};

enum class Anchor { kStart, kMiddle, kEnd };

// `<`, `&` and quotes as XML wants them; control characters, which XML forbids, as blanks.
std::string Escape(const std::string& text);

class Svg {
 public:
  Svg(double width, double height);

  // Colours as in SVG: "#1f77b4", "none".
  void Line(Pixel from, Pixel to, const std::string& color, double width = 1.0, bool is_dashed = false);
  void Polyline(const std::vector<Pixel>& points, const std::string& color, double width = 1.0);
  void Circle(Pixel center, double radius, const std::string& stroke, const std::string& fill = "none");
  // One dot per point, as one path.
  void Dots(const std::vector<Pixel>& points, const std::string& color);
  void Rectangle(Pixel corner, double width, double height, const std::string& stroke, const std::string& fill);
  void Text(Pixel at, const std::string& text, Anchor anchor = Anchor::kStart, double size = 12.0, bool is_bold = false,
            bool is_upright = false);

  std::string Finish() const { return body_ + "</svg>\n"; }

 private:
  std::string body_;
};

}  // namespace axiscal::plot

#endif  // AXISCAL_CORE_PLOT_SVG_H_
