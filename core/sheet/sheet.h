// A page to print and sign: facts, sections with tables, room for signatures. Plain text that any writer lays out
// (html.h, pdf.h), so that the page of a browser and the file of the command line say the same.
#ifndef AXISCAL_CORE_SHEET_SHEET_H_
#define AXISCAL_CORE_SHEET_SHEET_H_

#include <string>
#include <vector>

#include "core/base/language.h"

namespace axiscal::sheet {

using base::Language;

struct Fact {
  std::string name, value;
};

// A title, a table where `head` has columns, then lines of text.
struct Section {
  std::string title;
  std::string columns;  // a letter per column: 't' text, 'n' number, set to the right
  std::vector<std::string> head;
  std::vector<std::vector<std::string>> rows;  // as many cells as `columns` has letters
  std::vector<std::string> lines;
};

struct Sheet {
  Language language = Language::kEnglish;
  std::string title, subtitle;
  std::vector<Fact> facts;
  std::vector<Section> sections;
  std::vector<std::string> signatures;  // who signs: a line for date, name and hand each
  std::string footer;
};

}  // namespace axiscal::sheet

#endif  // AXISCAL_CORE_SHEET_SHEET_H_
