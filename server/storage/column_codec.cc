#include "server/storage/column_codec.h"

#include <bit>
#include <cstring>

#include "core/base/status.h"
#include "core/records/chunk.h"
#include "server/storage/byte_shuffle.h"
#include "server/storage/decimal_grid.h"
#include "server/storage/zstd_bytes.h"

namespace axiscal::storage {
namespace {

// Never renumber.
enum class Coding : char { kPlanes = 1, kGrid = 2, kTexts = 3 };

// Below this a grid is taken without trying planes, which then hardly ever win and cost as much again.
constexpr size_t kGoodBytesPerValue = 2;

absl::Status Damaged(const std::string& what) { return absl::DataLossError(what); }

std::string EncodePlanes(const std::vector<double>& values) {
  std::vector<uint64_t> words(values.size());
  std::memcpy(words.data(), values.data(), values.size() * sizeof(double));
  return static_cast<char>(Coding::kPlanes) + Compress(Shuffle(words, 8));
}

// decimals, order, number of planes, the first `order` entries as varints, the planes of the rest.
std::string EncodeGrid(DecimalGrid grid) {
  const int order = BestOrder(grid.steps);
  Difference(grid.steps, order);
  std::string heads;
  std::vector<uint64_t> words;
  words.reserve(grid.steps.size());
  uint64_t all_bits = 0;
  for (size_t i = 0; i < grid.steps.size(); ++i) {
    const uint64_t code = ZigZag(grid.steps[i]);
    if (i < static_cast<size_t>(order)) {
      PutVarint(heads, code);
    } else {
      words.push_back(code);
      all_bits |= code;
    }
  }
  const int planes = (std::bit_width(all_bits) + 7) / 8;
  std::string bytes = {static_cast<char>(Coding::kGrid), static_cast<char>(grid.decimals), static_cast<char>(order),
                       static_cast<char>(planes)};
  bytes += heads;
  if (planes > 0) bytes += Compress(Shuffle(words, planes));
  return bytes;
}

absl::StatusOr<std::vector<uint64_t>> DecodePlanes(ByteReader& bytes, int planes, size_t count) {
  if (planes == 0) return std::vector<uint64_t>(count);
  const size_t size = bytes.left();
  ASSIGN_OR_RETURN(const std::string raw, Decompress(bytes.Take(size), size, planes * PlaneSize(count)));
  return Unshuffle(raw, planes, count);
}

absl::StatusOr<std::vector<double>> DecodeGrid(ByteReader& bytes, size_t count) {
  DecimalGrid grid;
  grid.decimals = bytes.Byte();
  const size_t order = bytes.Byte(), planes = bytes.Byte();
  if (grid.decimals > kMaxDecimals || order > 2 || planes > 8 || order > count) return Damaged("impossible grid");
  for (size_t i = 0; i < order; ++i) grid.steps.push_back(UnZigZag(bytes.Varint()));
  if (!bytes.ok()) return Damaged("grid is cut off");
  ASSIGN_OR_RETURN(const std::vector<uint64_t> words, DecodePlanes(bytes, static_cast<int>(planes), count - order));
  for (const uint64_t word : words) grid.steps.push_back(UnZigZag(word));
  Integrate(grid.steps, static_cast<int>(order));
  return FromGrid(grid);
}

}  // namespace

std::string EncodeNumbers(const std::vector<double>& values) {
  std::optional<DecimalGrid> grid = FindGrid(values);
  if (!grid.has_value()) return EncodePlanes(values);
  std::string as_grid = EncodeGrid(*std::move(grid));
  if (as_grid.size() <= kGoodBytesPerValue * values.size()) return as_grid;
  std::string as_planes = EncodePlanes(values);
  return as_planes.size() < as_grid.size() ? as_planes : as_grid;
}

std::string EncodeTexts(const std::vector<std::string>& texts) {
  std::string raw;
  for (const std::string& text : texts) {
    PutVarint(raw, text.size());
    raw += text;
  }
  std::string bytes = {static_cast<char>(Coding::kTexts)};
  PutVarint(bytes, raw.size());
  return bytes + Compress(raw);
}

absl::StatusOr<std::vector<double>> DecodeNumbers(ByteReader bytes, size_t count) {
  const Coding coding = static_cast<Coding>(bytes.Byte());
  if (coding == Coding::kGrid) return DecodeGrid(bytes, count);
  if (coding != Coding::kPlanes) return Damaged("unknown coding of numbers");
  ASSIGN_OR_RETURN(const std::vector<uint64_t> words, DecodePlanes(bytes, 8, count));
  std::vector<double> values(count);
  std::memcpy(values.data(), words.data(), count * sizeof(double));
  return values;
}

absl::StatusOr<std::vector<std::string>> DecodeTexts(ByteReader bytes, size_t count) {
  if (static_cast<Coding>(bytes.Byte()) != Coding::kTexts) return Damaged("unknown coding of texts");
  const uint64_t raw_size = bytes.Varint();
  if (!bytes.ok() || raw_size > 2 * records::kMaxChunkTextBytes) return Damaged("impossible size of texts");
  const size_t size = bytes.left();
  ASSIGN_OR_RETURN(const std::string raw, Decompress(bytes.Take(size), size, raw_size));
  ByteReader reader(raw);
  std::vector<std::string> texts(count);
  for (std::string& text : texts) {
    const uint64_t length = reader.Varint();
    const char* const start = reader.Take(length);
    if (start == nullptr) return Damaged("texts are cut off");
    text.assign(start, length);
  }
  if (reader.left() != 0) return Damaged("texts are left over");
  return texts;
}

}  // namespace axiscal::storage
