#include "core/sheet/pdf.h"

#include <cairo-pdf.h>
#include <pango/pangocairo.h>

#include <algorithm>
#include <memory>

namespace axiscal::sheet {
namespace {

// Points of 1/72 inch.
constexpr double kPerMm = 72.0 / 25.4, kWidth = 210.0 * kPerMm, kHeight = 297.0 * kPerMm;
constexpr double kMargin = 15.0 * kPerMm, kInside = kWidth - 2.0 * kMargin, kMostHeight = kHeight - 2.0 * kMargin;
constexpr double kLargest = 9.0, kSmallest = 5.0;

template <auto Release>
struct Releaser {
  template <typename T>
  void operator()(T* object) const {
    Release(object);
  }
};
using Surface = std::unique_ptr<cairo_surface_t, Releaser<cairo_surface_destroy>>;
using Context = std::unique_ptr<cairo_t, Releaser<cairo_destroy>>;
using Layout = std::unique_ptr<PangoLayout, Releaser<g_object_unref>>;
using Font = std::unique_ptr<PangoFontDescription, Releaser<pango_font_description_free>>;

enum class Align { kLeft, kRight };

// Goes down the page and measures it; draws where it is asked to.
class Pen {
 public:
  Pen(cairo_t* cairo, double size, bool draws) : cairo_(cairo), size_(size), draws_(draws) {}

  double y() const { return y_; }
  double size() const { return size_; }
  void Down(double by) { y_ += by; }

  double NaturalWidth(const std::string& text, bool is_bold = false) const {
    return ExtentOf(LayoutOf(text, -1.0, 1.0, is_bold, Align::kLeft).get()).first;
  }
  // At (x, y), within `width`, in lines as many as it takes; its height.
  double Text(double x, double width, const std::string& text, double scale = 1.0, bool is_bold = false,
              Align align = Align::kLeft) {
    const Layout layout = LayoutOf(text, width, scale, is_bold, align);
    if (draws_) {
      cairo_move_to(cairo_, x, y_);
      pango_cairo_show_layout(cairo_, layout.get());
    }
    return ExtentOf(layout.get()).second;
  }
  void Rule(double from, double to, double thickness) {
    if (!draws_) return;
    cairo_set_line_width(cairo_, thickness);
    cairo_move_to(cairo_, from, y_);
    cairo_line_to(cairo_, to, y_);
    cairo_stroke(cairo_);
  }

 private:
  Layout LayoutOf(const std::string& text, double width, double scale, bool is_bold, Align align) const {
    Layout layout(pango_cairo_create_layout(cairo_));
    const Font font(pango_font_description_from_string(is_bold ? "sans-serif bold" : "sans-serif"));
    pango_font_description_set_absolute_size(font.get(), scale * size_ * PANGO_SCALE);
    pango_layout_set_font_description(layout.get(), font.get());
    if (width >= 0.0) pango_layout_set_width(layout.get(), static_cast<int>(width * PANGO_SCALE));
    pango_layout_set_wrap(layout.get(), PANGO_WRAP_WORD_CHAR);
    pango_layout_set_alignment(layout.get(), align == Align::kRight ? PANGO_ALIGN_RIGHT : PANGO_ALIGN_LEFT);
    // Names in a script that runs to the left stay on their side.
    pango_layout_set_auto_dir(layout.get(), FALSE);
    pango_layout_set_text(layout.get(), text.data(), static_cast<int>(text.size()));
    return layout;
  }
  static std::pair<double, double> ExtentOf(PangoLayout* layout) {
    int width = 0, height = 0;
    pango_layout_get_size(layout, &width, &height);
    return {static_cast<double>(width) / PANGO_SCALE, static_cast<double>(height) / PANGO_SCALE};
  }

  cairo_t* const cairo_;
  const double size_;
  const bool draws_;
  double y_ = kMargin;
};

// Columns as wide as their widest cell. Where that is too wide for the page, the widest columns of text give way until
// they are as wide as the next one.
std::vector<double> WidthsOf(const Section& section, const Pen& pen) {
  std::vector<double> widths(section.columns.size(), 0.0), texts;
  double numbers = 0.0;
  for (size_t i = 0; i < widths.size(); ++i) {
    widths[i] = pen.NaturalWidth(section.head[i]);
    for (const auto& row : section.rows) widths[i] = std::max(widths[i], pen.NaturalWidth(row[i]));
    widths[i] += pen.size();
    if (section.columns[i] == 't') {
      texts.push_back(widths[i]);
    } else {
      numbers += widths[i];
    }
  }
  std::sort(texts.begin(), texts.end());
  double left = std::max(kInside - numbers, 0.1 * kInside), most = left;
  for (size_t i = 0; i < texts.size(); ++i) {
    most = left / static_cast<double>(texts.size() - i);
    if (texts[i] > most) break;
    left -= texts[i];
    most = left + texts[i];
  }
  for (size_t i = 0; i < widths.size(); ++i) {
    if (section.columns[i] == 't') widths[i] = std::min(widths[i], std::max(most, 2.0 * pen.size()));
  }
  return widths;
}

void AddRow(const Section& section, const std::vector<std::string>& row, const std::vector<double>& widths, Pen* pen) {
  double x = kMargin, height = 0.0;
  for (size_t i = 0; i < widths.size(); ++i) {
    const Align align = section.columns[i] == 'n' ? Align::kRight : Align::kLeft;
    height = std::max(height, pen->Text(x, widths[i] - pen->size(), row[i], 1.0, false, align));
    x += widths[i];
  }
  pen->Down(height);
}

void AddSection(const Section& section, Pen* pen) {
  pen->Down(0.6 * pen->size());
  pen->Down(pen->Text(kMargin, kInside, section.title, 1.1, true));
  pen->Rule(kMargin, kWidth - kMargin, 0.8);
  pen->Down(0.2 * pen->size());
  if (!section.head.empty()) {
    const std::vector<double> widths = WidthsOf(section, *pen);
    AddRow(section, section.head, widths, pen);
    pen->Rule(kMargin, kWidth - kMargin, 0.4);
    for (const auto& row : section.rows) AddRow(section, row, widths, pen);
  }
  for (const std::string& line : section.lines) pen->Down(pen->Text(kMargin, kInside, line));
}

// Two columns of facts.
void AddFacts(const std::vector<Fact>& facts, Pen* pen) {
  const double half = 0.5 * kInside, gap = pen->size();
  double names = 0.0;
  for (const Fact& fact : facts) names = std::max(names, pen->NaturalWidth(fact.name));
  names = std::min(names, 0.4 * half) + gap;
  for (size_t i = 0; i < facts.size(); i += 2) {
    double height = 0.0;
    for (size_t k = i; k < std::min(i + 2, facts.size()); ++k) {
      const double x = kMargin + static_cast<double>(k - i) * half;
      height = std::max(height, pen->Text(x, names - gap, facts[k].name));
      height = std::max(height, pen->Text(x + names, half - names - gap, facts[k].value, 1.0, true));
    }
    pen->Down(height);
  }
}

void AddSheet(const Sheet& sheet, Pen* pen) {
  pen->Down(pen->Text(kMargin, kInside, sheet.title, 1.6, true));
  pen->Down(pen->Text(kMargin, kInside, sheet.subtitle));
  pen->Down(0.6 * pen->size());
  AddFacts(sheet.facts, pen);
  for (const Section& section : sheet.sections) AddSection(section, pen);
  constexpr double kRoomToSign = 12.0 * kPerMm, kBetween = 10.0 * kPerMm;
  pen->Down(kRoomToSign);
  const double count = static_cast<double>(std::max<size_t>(1, sheet.signatures.size()));
  const double width = (kInside - (count - 1.0) * kBetween) / count;
  double height = 0.0;
  for (size_t i = 0; i < sheet.signatures.size(); ++i) {
    const double x = kMargin + static_cast<double>(i) * (width + kBetween);
    pen->Rule(x, x + width, 0.8);
    height = std::max(height, pen->Text(x, width, sheet.signatures[i]));
  }
  pen->Down(height + 0.6 * pen->size());
  pen->Down(pen->Text(kMargin, kInside, sheet.footer, 0.85));
}

cairo_status_t Append(void* to, const unsigned char* bytes, unsigned int count) {
  static_cast<std::string*>(to)->append(reinterpret_cast<const char*>(bytes), count);
  return CAIRO_STATUS_SUCCESS;
}

bool HasFont() {
  PangoFontFamily** families = nullptr;
  int count = 0;
  pango_font_map_list_families(pango_cairo_font_map_get_default(), &families, &count);
  g_free(families);
  return count > 0;
}

}  // namespace

absl::StatusOr<std::string> ToPdf(const Sheet& sheet) {
  // Pango would end the program.
  if (!HasFont()) {
    return absl::FailedPreconditionError(
        "PDF: this system has no font, expected one, as of Debian's fonts-dejavu-core");
  }
  std::string pdf;
  const Surface surface(cairo_pdf_surface_create_for_stream(Append, &pdf, kWidth, kHeight));
  cairo_pdf_surface_set_metadata(surface.get(), CAIRO_PDF_METADATA_TITLE, sheet.title.c_str());
  cairo_pdf_surface_set_metadata(surface.get(), CAIRO_PDF_METADATA_SUBJECT, sheet.subtitle.c_str());
  {
    const Context cairo(cairo_create(surface.get()));
    double size = kLargest, height = 0.0;
    for (;; size -= 0.25) {
      Pen measure(cairo.get(), size, false);
      AddSheet(sheet, &measure);
      height = measure.y() - kMargin;
      if (height <= kMostHeight || size <= kSmallest) break;
    }
    // What is still too much for the smallest letters is made smaller as a whole.
    if (height > kMostHeight) {
      const double scale = kMostHeight / height;
      cairo_translate(cairo.get(), kMargin, kMargin);
      cairo_scale(cairo.get(), scale, scale);
      cairo_translate(cairo.get(), -kMargin, -kMargin);
    }
    Pen pen(cairo.get(), size, true);
    AddSheet(sheet, &pen);
    cairo_show_page(cairo.get());
  }
  cairo_surface_finish(surface.get());
  if (const cairo_status_t status = cairo_surface_status(surface.get()); status != CAIRO_STATUS_SUCCESS)
    return absl::InternalError(absl::StrCat("PDF: ", cairo_status_to_string(status)));
  return pdf;
}

}  // namespace axiscal::sheet
