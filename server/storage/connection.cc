#include "server/storage/connection.h"

namespace axiscal::storage {

absl::StatusOr<Statement> Connection::Prepare(const std::string& sql) {
  // References into an unordered_map stay valid.
  Statement::Idle& idle = idle_[sql];
  if (idle.empty()) {
    ASSIGN_OR_RETURN(std::unique_ptr<Prepared> prepared, Compile(sql));
    return Statement(std::move(prepared), idle);
  }
  std::unique_ptr<Prepared> prepared = std::move(idle.back());
  idle.pop_back();
  return Statement(std::move(prepared), idle);
}

}  // namespace axiscal::storage
