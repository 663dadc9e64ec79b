// One SQL statement with its parameters bound; steps through its rows.
#ifndef AXISCAL_SERVER_STORAGE_STATEMENT_H_
#define AXISCAL_SERVER_STORAGE_STATEMENT_H_

#include <memory>
#include <optional>
#include <string>
#include <type_traits>
#include <utility>
#include <vector>

#include "core/base/clock.h"
#include "core/base/ids.h"
#include "core/base/status.h"

namespace axiscal::storage {

// Marks bytes to be bound as BLOB, without a copy: they must outlive the statement.
struct Blob {
  const std::string& bytes;
};

// What a parameter is. In this order.
enum class ValueType { kInt, kReal, kText, kBlob };

// What an engine has of a prepared statement. Columns of the present row count from 0, parameters from 1.
class Prepared {
 public:
  Prepared() = default;
  Prepared(const Prepared&) = delete;
  Prepared& operator=(const Prepared&) = delete;
  virtual ~Prepared() = default;

  // The next row is there, or not.
  virtual absl::StatusOr<bool> Step() = 0;
  // Ends the run and forgets the parameters.
  virtual void Reset() = 0;

  virtual bool IsNull(int column) const = 0;
  virtual int64_t Int(int column) const = 0;
  virtual double Real(int column) const = 0;
  virtual std::string Text(int column) const = 0;  // as UTF-8; or a blob as it is; NULL is ""

  virtual void BindInt(int index, int64_t number) = 0;
  virtual void BindReal(int index, double number) = 0;
  virtual void BindText(int index, const std::string& text) = 0;
  virtual void BindBlob(int index, Blob blob) = 0;
  virtual void BindNull(int index, ValueType type) = 0;
};

// Borrowed from its connection, given back reset when it goes.
class Statement {
 public:
  using Idle = std::vector<std::unique_ptr<Prepared>>;
  // `idle`, where it is given back, outlives it.
  Statement(std::unique_ptr<Prepared> prepared, Idle& idle) : prepared_(std::move(prepared)), idle_(idle) {}
  Statement(Statement&&) noexcept = default;
  Statement& operator=(Statement&&) = delete;
  ~Statement();

  // The next row is there, or not.
  absl::StatusOr<bool> Step() { return prepared_->Step(); }

  // Columns of the present row, from 0.
  bool IsNull(int column) const { return prepared_->IsNull(column); }
  int64_t Int(int column) const { return prepared_->Int(column); }
  bool Bool(int column) const { return Int(column) != 0; }
  double Real(int column) const { return prepared_->Real(column); }
  std::string Text(int column) const { return prepared_->Text(column); }  // as UTF-8; or a blob as it is; NULL is ""
  base::UtcTime Time(int column) const { return base::FromUtcUs(Int(column)); }
  template <typename Enum>
  Enum As(int column) const {
    return static_cast<Enum>(Int(column));
  }
  std::optional<double> OptionalReal(int column) const;
  std::optional<base::UtcTime> OptionalTime(int column) const;

  // Parameters, from 1.
  void Bind(int index, int64_t number) { prepared_->BindInt(index, number); }
  void Bind(int index, int number) { prepared_->BindInt(index, number); }
  void Bind(int index, bool flag) { prepared_->BindInt(index, flag ? 1 : 0); }
  void Bind(int index, double number) { prepared_->BindReal(index, number); }
  void Bind(int index, const std::string& text) { prepared_->BindText(index, text); }
  void Bind(int index, const char* text) = delete;
  void Bind(int index, Blob blob) { prepared_->BindBlob(index, blob); }
  void BindNull(int index, ValueType type) { prepared_->BindNull(index, type); }
  void Bind(int index, base::UtcTime time) { Bind(index, base::ToUtcUs(time)); }
  template <typename Tag>
  void Bind(int index, base::NumberId<Tag> id) {
    Bind(index, id.number());
  }
  template <typename T>
  void Bind(int index, const std::optional<T>& present) {
    if (present.has_value()) return Bind(index, *present);
    constexpr ValueType kType = std::is_same_v<T, double>        ? ValueType::kReal
                                : std::is_same_v<T, std::string> ? ValueType::kText
                                                                 : ValueType::kInt;
    prepared_->BindNull(index, kType);
  }

 private:
  std::unique_ptr<Prepared> prepared_;  // null: moved from
  Idle& idle_;
};

}  // namespace axiscal::storage

#endif  // AXISCAL_SERVER_STORAGE_STATEMENT_H_
