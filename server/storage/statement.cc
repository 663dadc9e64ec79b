#include "server/storage/statement.h"

namespace axiscal::storage {

Statement::~Statement() {
  if (prepared_ == nullptr) return;
  prepared_->Reset();
  idle_.push_back(std::move(prepared_));
}

std::optional<double> Statement::OptionalReal(int column) const {
  return IsNull(column) ? std::nullopt : std::optional<double>(Real(column));
}

std::optional<base::UtcTime> Statement::OptionalTime(int column) const {
  return IsNull(column) ? std::nullopt : std::optional<base::UtcTime>(Time(column));
}

}  // namespace axiscal::storage
