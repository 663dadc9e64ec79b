// Files on their way to the server, on disk: what is in a spool survives a power cut at any moment, is sent in order,
// and leaves it only when the server has it. One spool is shared by axiscal-cell, `axiscal spool` and programs that use
// this library, at the same time.
//
//   FOLDER/waiting/000000000017-<id>/   content, entry.json; of a log template, plan
//   FOLDER/refused/...                  the same and reason.json: what the server refused; never sent again by itself
//   FOLDER/sent/...                     the same and receipt.json: copies of what was sent last, the first to go
//   FOLDER/tmp/                         what is being written; cleared by the next one who writes
//   FOLDER/lock, FOLDER/sender          held while the spool is changed, and by the one who sends
//
// A folder with its files is written in tmp, synced, and renamed: it is there whole or not at all.
#ifndef AXISCAL_CLIENT_SPOOL_SPOOL_H_
#define AXISCAL_CLIENT_SPOOL_SPOOL_H_

#include <cstdint>
#include <memory>
#include <string>
#include <unordered_map>
#include <utility>
#include <vector>

#include "client/spool/entry.h"
#include "core/base/mutex.h"

namespace axiscal::spool {

struct SpoolOptions {
  std::string folder;                              // made where it is missing; on a local disk
  int64_t max_bytes = int64_t{1} << 30;            // of all that it holds
  int64_t max_file_bytes = records::kMaxLogBytes;  // of one file, which is held in memory
  int max_sent = 1000;                             // copies of what was sent that are kept at most
};

enum class Place { kWaiting, kRefused, kSent };

struct Added {
  int64_t number = 0;
  bool was_there = false;  // the same item and bytes: it waits, was refused, or was sent not long ago
  Place place = Place::kWaiting;
};

struct Usage {
  int64_t waiting = 0, refused = 0, sent = 0;  // entries
  int64_t waiting_bytes = 0, refused_bytes = 0, sent_bytes = 0;
  int64_t bytes() const { return waiting_bytes + refused_bytes + sent_bytes; }
};

// Safe from any thread and process. Errors of the disk are those of base::AtomicFile.
class Spool {
 public:
  static absl::StatusOr<Spool> Open(const SpoolOptions& options);

  // Durable when it returns. RESOURCE_EXHAUSTED SPOOL_FULL, where no copy of what was sent is left to go: nothing that
  // was not sent is ever dropped for it. INVALID_ARGUMENT SPOOL_FILE_INVALID: empty, too large, no name.
  absl::StatusOr<Added> Add(const Item& item, const std::string& bytes);

  // Numbers in their order.
  absl::StatusOr<std::vector<int64_t>> Numbers(Place place) const;
  absl::StatusOr<Usage> Measure() const;
  // NOT_FOUND SPOOL_ENTRY_NOT_FOUND; DATA_LOSS SPOOL_DAMAGED where the disk has changed it.
  absl::StatusOr<Entry> Get(Place place, int64_t number) const;
  absl::StatusOr<std::string> Content(Place place, int64_t number) const;
  // Why it was refused, or what was answered; empty where nothing is written.
  Note NoteOf(Place place, int64_t number) const;

  // What waits was taken by the server; its source goes where the item says so.
  absl::Status MarkSent(int64_t number, const Note& receipt);
  // Removes the sources of what was sent that are still there, unchanged: whoever was killed between MarkSent()'s two
  // steps has left one. How many.
  absl::StatusOr<int> RemoveSentSources();
  // What waits was refused for good.
  absl::Status Refuse(int64_t number, const Note& reason);
  // What was refused waits again, in its old place in the order.
  absl::Status Retry(int64_t number);
  // Copies of what was sent wait again, in their old places in the order: a server that was restored from a backup may
  // lack them, any other says that it has them. How many.
  absl::StatusOr<int> SendAgain();
  // What was refused goes for good.
  absl::Status Drop(int64_t number);

  const SpoolOptions& options() const { return options_; }

 private:
  // Sizes of entries that were asked for, by place and name: what an entry holds does not change while it stays in its
  // place, and a spool of thousands is measured for each file that comes and goes.
  struct Sizes {
    base::Mutex mutex;
    std::unordered_map<std::string, int64_t> bytes[3] AXISCAL_GUARDED_BY(mutex);
  };

  explicit Spool(SpoolOptions options) : options_(std::move(options)), sizes_(std::make_shared<Sizes>()) {}
  std::string FolderOf(Place place) const;
  absl::StatusOr<std::string> Find(Place place, int64_t number) const;
  absl::Status Move(Place from, Place to, int64_t number, const std::string& note_file, const Note& note);
  absl::Status Remove(const std::string& path) const;
  absl::Status MakeRoom(int64_t bytes) const;

  SpoolOptions options_;
  std::shared_ptr<Sizes> sizes_;
};

// Whoever holds it sends; nobody else does meanwhile.
class SenderLock {
 public:
  // UNAVAILABLE SPOOL_BUSY: another process sends.
  static absl::StatusOr<SenderLock> Take(const std::string& folder);
  SenderLock(SenderLock&& other) noexcept : descriptor_(std::exchange(other.descriptor_, -1)) {}
  SenderLock& operator=(SenderLock&&) = delete;
  ~SenderLock();

 private:
  explicit SenderLock(int descriptor) : descriptor_(descriptor) {}
  int descriptor_;
};

}  // namespace axiscal::spool

#endif  // AXISCAL_CLIENT_SPOOL_SPOOL_H_
