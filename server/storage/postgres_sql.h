// The store's SQL as PostgreSQL takes it. The store writes what both engines take wherever there is such a form; what
// is left of SQLite's own is said otherwise here, and nowhere else:
//   ?5                       $2, the second that this text uses: PostgreSQL wants none that it does not use
//   INDEXED BY name          nothing: PostgreSQL has no hints
//   a CROSS JOIN b ON ...    a JOIN b ON ...: the order of loops is a hint, too
//   +a.name                  a.name: "not by its index" is a hint, too; a sum has blanks on both sides
//   sqlite_sequence          given_number: the last number of what is numbered without gaps
//   json_each(?5)            the numbers of a JSON list, each as a row with the column `value`
//   /*! text */              text: what several that write at a time have to say, and SQLite's one writer has not
#ifndef AXISCAL_SERVER_STORAGE_POSTGRES_SQL_H_
#define AXISCAL_SERVER_STORAGE_POSTGRES_SQL_H_

#include <string>
#include <vector>

namespace axiscal::storage {

struct PostgresSql {
  std::string text;
  std::vector<int> parameters;  // [k]: which of the store's parameters, from 1, is $(k + 1)
};

PostgresSql ToPostgres(const std::string& sql);

}  // namespace axiscal::storage

#endif  // AXISCAL_SERVER_STORAGE_POSTGRES_SQL_H_
