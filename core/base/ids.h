// Names of stored things are types of their own, so that a session's name cannot be passed for a machine's.
#ifndef AXISCAL_CORE_BASE_IDS_H_
#define AXISCAL_CORE_BASE_IDS_H_

#include <compare>
#include <cstdint>
#include <functional>
#include <string>
#include <utility>

namespace axiscal::base {

// A text id: what users write (`machine mt`). `Tag` only tells the types apart.
template <typename Tag>
class TextId {
 public:
  TextId() = default;
  explicit TextId(std::string text) : text_(std::move(text)) {}
  const std::string& text() const { return text_; }
  bool empty() const { return text_.empty(); }
  auto operator<=>(const TextId&) const = default;

 private:
  std::string text_;
};

// A number given by the database; 0 is never a stored row.
template <typename Tag>
class NumberId {
 public:
  NumberId() = default;
  explicit NumberId(int64_t number) : number_(number) {}
  int64_t number() const { return number_; }
  auto operator<=>(const NumberId&) const = default;

 private:
  int64_t number_ = 0;
};

}  // namespace axiscal::base

namespace axiscal {

using MachineId = base::TextId<struct MachineIdTag>;
using SessionId = base::NumberId<struct SessionIdTag>;
using CalibrationId = base::NumberId<struct CalibrationIdTag>;
using JobId = base::NumberId<struct JobIdTag>;
using ProgramId = base::NumberId<struct ProgramIdTag>;
using MarkId = base::NumberId<struct MarkIdTag>;
using EventId = base::NumberId<struct EventIdTag>;
using RoutineId = base::NumberId<struct RoutineIdTag>;
using RunId = base::NumberId<struct RunIdTag>;
using WebhookId = base::NumberId<struct WebhookIdTag>;

}  // namespace axiscal

template <typename Tag>
struct std::hash<axiscal::base::TextId<Tag>> {
  size_t operator()(const axiscal::base::TextId<Tag>& id) const { return std::hash<std::string>()(id.text()); }
};
template <typename Tag>
struct std::hash<axiscal::base::NumberId<Tag>> {
  size_t operator()(const axiscal::base::NumberId<Tag>& id) const { return std::hash<int64_t>()(id.number()); }
};

#endif  // AXISCAL_CORE_BASE_IDS_H_
