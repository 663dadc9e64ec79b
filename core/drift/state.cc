#include "core/drift/state.h"

#include <absl/strings/str_cat.h>

#include <bit>
#include <cstring>

#include "core/base/crc32c.h"

namespace axiscal::drift {
namespace {

constexpr char kMagic[] = "AXDRIFT1";  // form and version
constexpr size_t kMagicBytes = 8, kSealBytes = 4;
constexpr uint64_t kMostListed = 4096;  // a list of a state is far shorter; a longer one is damage
static_assert(std::endian::native == std::endian::little);

// The members of a state, told once for both ways: `Io` is StateWriter or StateReader.
class StateWriter {
 public:
  template <typename T>
  void Number(const T& value) {
    bytes_.append(reinterpret_cast<const char*>(&value), sizeof(value));
  }
  uint64_t Count(uint64_t count) {
    Number(count);
    return count;
  }
  std::string& bytes() { return bytes_; }

 private:
  std::string bytes_;
};

class StateReader {
 public:
  explicit StateReader(std::string_view bytes) : bytes_(bytes) {}
  template <typename T>
  void Number(T& value) {
    if (is_short_ || bytes_.size() < sizeof(value)) {
      is_short_ = true;
      return;
    }
    std::memcpy(&value, bytes_.data(), sizeof(value));
    bytes_.remove_prefix(sizeof(value));
  }
  uint64_t Count(uint64_t) {
    uint64_t count = 0;
    Number(count);
    is_short_ |= count > kMostListed;
    return is_short_ ? 0 : count;
  }
  bool is_whole() const { return !is_short_ && bytes_.empty(); }

 private:
  std::string_view bytes_;
  bool is_short_ = false;
};

template <typename Io, typename T>
requires std::is_arithmetic_v<std::remove_const_t<T>>
void Member(Io& io, T& value) { io.Number(value); }

// One byte, 0 or 1.
template <typename Io>
void Flag(Io& io, auto& flag) {
  uint8_t byte = flag ? 1 : 0;
  io.Number(byte);
  if constexpr (!std::is_const_v<std::remove_reference_t<decltype(flag)>>) flag = byte != 0;
}

template <typename Io>
void Time(Io& io, auto& time) {
  int64_t us = base::ToUtcUs(time);
  io.Number(us);
  if constexpr (!std::is_const_v<std::remove_reference_t<decltype(time)>>) time = base::FromUtcUs(us);
}

template <typename Io>
void Numbers(Io& io, auto& list) {
  for (auto& value : list) io.Number(value);
}

template <typename Io>
void List(Io& io, auto& list) {
  const uint64_t count = io.Count(list.size());
  if constexpr (!std::is_const_v<std::remove_reference_t<decltype(list)>>) list.resize(count);
  Numbers(io, list);
}

template <typename Io>
void Vector(Io& io, auto& vector) {
  const uint64_t count = io.Count(static_cast<uint64_t>(vector.size()));
  if constexpr (!std::is_const_v<std::remove_reference_t<decltype(vector)>>) vector.resize(static_cast<long>(count));
  for (long i = 0; i < static_cast<long>(count); ++i) io.Number(vector(i));
}

// Symmetric: the lower triangle, by columns.
template <typename Io>
void Symmetric(Io& io, auto& matrix) {
  const auto count = static_cast<long>(io.Count(static_cast<uint64_t>(matrix.rows())));
  constexpr bool kReads = !std::is_const_v<std::remove_reference_t<decltype(matrix)>>;
  if constexpr (kReads) matrix.resize(count, count);
  for (long j = 0; j < count; ++j) {
    for (long i = j; i < count; ++i) {
      io.Number(matrix(i, j));
      if constexpr (kReads) matrix(j, i) = matrix(i, j);
    }
  }
}

template <typename Io>
void MembersOf(Io& io, auto& outlook) requires requires {
  outlook.models;
}
{
  for (auto& model : outlook.models) {
    Numbers(io, model.mean);
    Numbers(io, model.covariance);
    Member(io, model.log_determinant);
    Member(io, model.squares);
  }
  Member(io, outlook.count);
  Member(io, outlook.week);
}

template <typename Io>
void MembersOf(Io& io, auto& bank) requires requires {
  bank.log_weight;
}
{
  Numbers(io, bank.mean);
  Numbers(io, bank.variance);
  Numbers(io, bank.log_weight);
  Member(io, bank.steps);
  Member(io, bank.squares);
  Member(io, bank.count);
}

template <typename Io>
void MembersOf(Io& io, auto& followed) requires requires {
  followed.stated_sigmas;
}
{
  List(io, followed.symbol);
  uint8_t unit = static_cast<uint8_t>(followed.unit);
  io.Number(unit);
  if constexpr (!std::is_const_v<std::remove_reference_t<decltype(followed)>>) followed.unit = static_cast<Unit>(unit);
  Member(io, followed.unit_size);
  List(io, followed.stated_sigmas);
  Time(io, followed.first_seen);
  Time(io, followed.last_seen);
  Member(io, followed.seen);
  MembersOf(io, followed.bank);
  Time(io, followed.bank_at);
  MembersOf(io, followed.outlook);
  Flag(io, followed.is_wearing);
  Flag(io, followed.is_seasonal);
  Flag(io, followed.is_noisy);
}

template <typename Io>
void MembersOf(Io& io, auto& past) requires requires {
  past.may_start;
}
{
  Time(io, past.at);
  Numbers(io, past.regressors);
  List(io, past.seen);
  Vector(io, past.y);
  Symmetric(io, past.stated);
  Vector(io, past.suspicion);
  Vector(io, past.loosened);
  Flag(io, past.may_start);
  Flag(io, past.is_wear_new);
  Vector(io, past.before.mean);
  Symmetric(io, past.before.covariance);
}

template <typename Io>
void MembersOf(Io& io, auto& state) requires requires {
  state.suspects_in_a_row;
}
{
  constexpr bool kReads = !std::is_const_v<std::remove_reference_t<decltype(state)>>;
  Member(io, state.calibrations);
  Time(io, state.first_at);
  Time(io, state.last_at);
  Time(io, state.last_mark_at);
  const uint64_t errors = io.Count(state.errors.size());
  if constexpr (kReads) state.errors.resize(errors);
  for (auto& followed : state.errors) MembersOf(io, followed);
  Vector(io, state.joint.mean);
  Symmetric(io, state.joint.covariance);
  const uint64_t last = io.Count(state.last.size());
  if constexpr (kReads) state.last.resize(last);
  for (auto& past : state.last) MembersOf(io, past);
  Time(io, state.before_window);
  Time(io, state.told.after);
  Time(io, state.told.by);
  Member(io, state.told.found);
  Vector(io, state.told.sizes);
  Vector(io, state.told.variances);
  Member(io, state.suspects_in_a_row);
  Time(io, state.suspect_since);
  Vector(io, state.mark_loosens);
  Flag(io, state.is_marked);
  Flag(io, state.is_service);
}

// All sizes agree with the number of errors: what computes with a state need not look.
bool IsConsistent(const State& state) {
  const auto n = static_cast<long>(state.errors.size());
  const auto fits = [n](const Joint& joint) {
    return joint.mean.size() == kParts * n && joint.covariance.rows() == kParts * n;
  };
  if (n > kMostErrors || state.last.size() > kWindow || !fits(state.joint) || state.mark_loosens.size() != n ||
      state.told.sizes.size() != n || state.told.variances.size() != n)
    return false;
  for (const Followed& followed : state.errors) {
    if (followed.unit > Unit::kUrad || !(followed.unit_size > 0.0) || followed.stated_sigmas.empty()) return false;
  }
  for (const Past& past : state.last) {
    if (!fits(past.before) || past.y.size() != n || past.stated.rows() != n || past.suspicion.size() != n ||
        past.loosened.size() != n || past.seen.empty())
      return false;
    for (size_t i = 0; i < past.seen.size(); ++i) {
      if (past.seen[i] <= (i == 0 ? -1 : past.seen[i - 1]) || past.seen[i] >= n) return false;
    }
  }
  return true;
}

}  // namespace

double WeeksBetween(base::UtcTime from, base::UtcTime to) {
  return static_cast<double>((to - from).count()) / (7.0 * 86'400e6);
}

std::string WriteState(const State& state) {
  StateWriter writer;
  writer.bytes() = kMagic;
  MembersOf(writer, state);
  const uint32_t seal = base::Crc32c(0, writer.bytes().data(), writer.bytes().size());
  writer.Number(seal);
  return std::move(writer.bytes());
}

absl::StatusOr<State> ReadState(const std::string& bytes) {
  if (bytes.size() < kMagicBytes + kSealBytes)
    return absl::DataLossError(absl::StrCat("drift state: ", bytes.size(), " bytes, which is none"));
  uint32_t seal = 0;
  std::memcpy(&seal, bytes.data() + bytes.size() - kSealBytes, kSealBytes);
  if (base::Crc32c(0, bytes.data(), bytes.size() - kSealBytes) != seal)
    return absl::DataLossError("drift state: its checksum is another, bytes are missing or changed");
  if (bytes.compare(0, kMagicBytes, kMagic) != 0)
    return absl::InvalidArgumentError(absl::StrCat("drift state: another version, expected ", kMagic));
  StateReader reader(std::string_view(bytes).substr(kMagicBytes, bytes.size() - kMagicBytes - kSealBytes));
  State state;
  MembersOf(reader, state);
  if (!reader.is_whole() || !IsConsistent(state)) return absl::DataLossError("drift state: its parts do not fit");
  return state;
}

}  // namespace axiscal::drift
