#include "core/records/chunked_session.h"

#include "core/base/sha256.h"
#include "core/session/checksum.h"

namespace axiscal::records {

ChunkedSession::ChunkedSession(const session::Session& session, int chunk_readings)
    : session_(session),
      chunk_readings_(chunk_readings),
      reading_count_(static_cast<int64_t>(session.reading_count())),
      chunk_count_((reading_count_ + chunk_readings - 1) / chunk_readings),
      crc32cs_(static_cast<size_t>(chunk_count_)) {}

Chunk ChunkedSession::At(int64_t seq) {
  const int64_t begin = seq * chunk_readings_, end = ReadingsBelow(seq + 1);
  std::vector<session::Column> columns;
  for (const session::Column& column : session_.columns) {
    session::Column part{column.name, {}, {}};
    if (column.texts.empty()) {
      part.values.assign(column.values.begin() + begin, column.values.begin() + end);
    } else {
      part.texts.assign(column.texts.begin() + begin, column.texts.begin() + end);
    }
    columns.push_back(std::move(part));
  }
  Chunk chunk = Chunk::Seal(seq, std::move(columns));
  crc32cs_[static_cast<size_t>(seq)] = chunk.crc32c();
  return chunk;
}

SessionTotals ChunkedSession::Totals() {
  std::vector<uint32_t> crcs;
  for (int64_t seq = 0; seq < chunk_count_; ++seq) {
    const std::optional<uint32_t>& known = crc32cs_[static_cast<size_t>(seq)];
    crcs.push_back(known ? *known : At(seq).crc32c());
  }
  return {chunk_count_, reading_count_, session::SessionHash(crcs)};
}

std::string ContentId(const MachineId& machine, const session::Session& session, int chunk_readings) {
  base::Sha256 sha;
  // Every text with its length before it, so that no two sessions give the same bytes.
  const auto add = [&](const std::string& text) { sha.Add(absl::StrCat(text.size(), ":", text)); };
  add(machine.text());
  add(absl::StrCat(chunk_readings));
  for (const session::HeaderEntry& entry : session.header) {
    add(entry.key);
    add(entry.value);
  }
  for (const session::Column& column : session.columns) {
    add(column.name);
    add(absl::StrCat(column.values.size(), ",", column.texts.size()));
    sha.Add(column.values.data(), column.values.size() * sizeof(double));
    for (const std::string& text : column.texts) add(text);
  }
  return sha.HexDigest();
}

}  // namespace axiscal::records
