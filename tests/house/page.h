// Reads what a page of docs/ says in tables, for tests that compare it with the tree.
#ifndef AXISCAL_TESTS_HOUSE_PAGE_H_
#define AXISCAL_TESTS_HOUSE_PAGE_H_

#include <string>
#include <vector>

namespace axiscal::house {

// The text of a file of the checkout ("docs/architecture.md"). Fails the running test when there is none.
std::string ReadPage(const std::string& path);

// What stands below the heading ("## The map") up to the next heading of the same or a higher level; empty when the
// page does not have it.
std::string Section(const std::string& page, const std::string& heading);

// The rows of all tables in `text` without their heads and rulers; each is its cells, trimmed.
std::vector<std::vector<std::string>> TableRows(const std::string& text);

// What stands between backquotes, in order: "`a`, `b` and c" gives a and b.
std::vector<std::string> Quoted(const std::string& text);

}  // namespace axiscal::house

#endif  // AXISCAL_TESTS_HOUSE_PAGE_H_
