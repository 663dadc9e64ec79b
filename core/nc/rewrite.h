// Rewrites NC programs so that the tool point goes where the program says, on this machine.
//
// Programs of linear moves and arcs in axis positions or stated work coordinates (docs/nc.md). Every byte that is not a
// corrected word stays. A null correction returns the program byte for byte, whatever it holds. Any other output
// carries a mark in a comment and is refused as input. What is written before an error must not be used: RewriteText
// and RewriteFile hand out nothing in that case.
#ifndef AXISCAL_CORE_NC_REWRITE_H_
#define AXISCAL_CORE_NC_REWRITE_H_

#include <cstddef>
#include <functional>
#include <memory>
#include <string>

#include "core/base/status.h"
#include "core/nc/options.h"
#include "core/nc/report.h"

namespace axiscal::compensate {
class Compensator;
}

namespace axiscal::nc {

// Takes the next bytes of the output. An error ends the job with that error.
using ByteSink = std::function<absl::Status(const char* bytes, size_t size)>;

// Streaming form, in constant memory. Not thread safe. Feed and Finish return INVALID_ARGUMENT for a program that was
// compensated before; Finish returns FAILED_PRECONDITION when blocks were refused, a correction is beyond its limit or
// a travel limit is exceeded (report().refused says where and why); both return any error of the sink. After an error
// no more bytes reach the sink and every later call returns the same error.
class Rewriter {
 public:
  // `compensator` must outlive the rewriter. INVALID_ARGUMENT on bad options.
  static absl::StatusOr<Rewriter> Create(const compensate::Compensator& compensator, const RewriteOptions& options,
                                         ByteSink sink);
  Rewriter(Rewriter&&) noexcept;
  ~Rewriter();

  // Any number of bytes, cut anywhere. A refused block does not end the reading: Finish reports all of them.
  absl::Status Feed(const char* bytes, size_t size);
  absl::Status Finish();
  // Complete after Finish, also when it failed.
  const RewriteReport& report() const;

 private:
  struct Impl;
  explicit Rewriter(std::unique_ptr<Impl> impl);
  std::unique_ptr<Impl> impl_;
};

// Bytes of the source, in order, each time from the start: called twice (checksum, then rewriting) unless
// options.source_crc32c is given. Calls `take` with each piece and returns its error, or its own.
using ByteSource = std::function<absl::Status(const ByteSink& take)>;

// `report` is filled also when the program is refused.
absl::Status RewriteProgram(const ByteSource& source, const ByteSink& sink, const compensate::Compensator& compensator,
                            const RewriteOptions& options, RewriteReport* report);

// The whole program in memory.
absl::StatusOr<std::string> RewriteText(const std::string& program, const compensate::Compensator& compensator,
                                        const RewriteOptions& options, RewriteReport* report);

// From file to file, in constant memory. The output takes its place only when it is whole (base::AtomicFile), so a
// refused program leaves no output and an existing file as it was. NOT_FOUND, INVALID_ARGUMENT (a pipe, a folder) or
// UNAVAILABLE with the path when the input cannot be read; errors of base::AtomicFile.
absl::Status RewriteFile(const std::string& input_path, const std::string& output_path,
                         const compensate::Compensator& compensator, const RewriteOptions& options,
                         RewriteReport* report);

// The same to a sink. What was taken before an error must not be used.
absl::Status RewriteFileTo(const std::string& input_path, const ByteSink& sink,
                           const compensate::Compensator& compensator, const RewriteOptions& options,
                           RewriteReport* report);

}  // namespace axiscal::nc

#endif  // AXISCAL_CORE_NC_REWRITE_H_
