// What of a process's files has not reached the disk yet and is lost with its power: bytes, and the names of files.
#ifndef AXISCAL_TESTS_FAULTS_TESTING_UNSYNCED_H_
#define AXISCAL_TESTS_FAULTS_TESTING_UNSYNCED_H_

#include <cstdint>
#include <map>
#include <random>
#include <string>
#include <vector>

namespace axiscal::testing {

// What a write or a truncation has replaced.
struct Replaced {
  int64_t offset = 0;
  int64_t end = 0;       // of what was written
  int64_t old_size = 0;  // of the file
  std::string old_bytes;
};

// Bytes are safe once their file was synced, names once the folder was. The names that are lost are the last ones: a
// file system writes them in order. Where a file was removed or replaced, its content is kept under a name of our own
// until the folder was synced. Not safe from several threads.
class Unsynced {
 public:
  // Forgets all; what was kept goes.
  void Clear();

  void Wrote(const std::string& path, Replaced replaced);
  void SyncedFile(const std::string& path);
  void SyncedFolderOf(const std::string& path);
  void SyncedFolder(const std::string& folder);

  // Called after it was done.
  void Made(const std::string& path);
  void Exchanged(const std::string& a, const std::string& b);
  // Called before it is done; UndoLast() where it failed.
  void WillRename(const std::string& from, const std::string& to);
  void WillRemove(const std::string& path);
  void UndoLast();

  // Puts the disk into a state that a loss of power may leave; all files must be closed.
  void TakeBack(std::mt19937& random);

 private:
  struct Name {
    enum class Kind { kMade, kRenamed, kExchanged, kRemoved };
    Kind kind = Kind::kMade;
    std::string path, to, kept;  // kept: under which name what was removed or replaced is; empty: nothing was
  };

  std::string Keep(const std::string& path);
  static void Forget(const Name& name);
  void TakeBackName(const Name& name);

  std::map<std::string, std::vector<Replaced>> bytes_;  // by path
  std::vector<Name> names_;
  int kept_ = 0;
};

}  // namespace axiscal::testing

#endif  // AXISCAL_TESTS_FAULTS_TESTING_UNSYNCED_H_
