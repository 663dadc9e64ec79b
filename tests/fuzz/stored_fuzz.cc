// Bytes that come from the disk: chunks of readings and states of the drift detector, whole, damaged or made up.
#include "core/drift/state.h"
#include "server/storage/chunk_codec.h"
#include "tests/fuzz/driver.h"

namespace axiscal::fuzz {

void Look(const std::string& bytes) {
  const std::vector<storage::ColumnSpec> specs = {{"t_s", false}, {"X_mm", false}, {"feature", true}};
  const auto columns = storage::DecodeChunk(bytes, specs);
  if (columns.ok()) {
    MUST(columns->size() == specs.size());
    const size_t count = (*columns)[0].values.size();
    MUST((*columns)[1].values.size() == count && (*columns)[2].texts.size() == count);
    const auto again = storage::DecodeChunk(storage::EncodeChunk(*columns), specs);
    MUST(again.ok());
  } else {
    MUST(absl::IsDataLoss(columns.status()));
  }
  const auto state = drift::ReadState(bytes);
  MUST(state.ok() ? drift::WriteState(*state) == bytes
                  : absl::IsDataLoss(state.status()) || absl::IsInvalidArgument(state.status()));
}

}  // namespace axiscal::fuzz
