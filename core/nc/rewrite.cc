#include "core/nc/rewrite.h"

#include <cerrno>
#include <cstdio>
#include <cstring>
#include <memory>
#include <vector>

#include "core/base/crc32c.h"
#include "core/base/files.h"
#include "core/compensate/compensator.h"

namespace axiscal::nc {
namespace {

constexpr size_t kChunkBytes = 1u << 18;

using File = std::unique_ptr<std::FILE, int (*)(std::FILE*)>;

absl::Status FileError(const std::string& what, const std::string& path) {
  const int error = errno;
  const std::string message = absl::StrCat(what, " ", path, ": ", std::strerror(error));
  if (error == EISDIR) return absl::InvalidArgumentError(message);
  return error == ENOENT ? absl::NotFoundError(message) : absl::UnavailableError(message);
}

absl::StatusOr<File> Open(const std::string& path, const char* mode) {
  File file(std::fopen(path.c_str(), mode), &std::fclose);
  if (file == nullptr) return FileError("cannot open", path);
  std::setvbuf(file.get(), nullptr, _IONBF, 0);  // pieces are large already
  return file;
}

absl::Status ReadAll(const std::string& path, const ByteSink& take) {
  ASSIGN_OR_RETURN(const File file, Open(path, "rb"));
  std::vector<char> buffer(kChunkBytes);
  while (true) {
    const size_t count = std::fread(buffer.data(), 1, buffer.size(), file.get());
    if (count > 0) RETURN_IF_ERROR(take(buffer.data(), count));
    if (count == buffer.size()) continue;
    if (std::ferror(file.get())) return FileError("cannot read", path);
    return absl::OkStatus();
  }
}

}  // namespace

absl::Status RewriteProgram(const ByteSource& source, const ByteSink& sink, const compensate::Compensator& compensator,
                            const RewriteOptions& options, RewriteReport* report) {
  RewriteOptions complete = options;
  if (!complete.source_crc32c && !compensator.is_null()) {
    uint32_t crc = 0;
    RETURN_IF_ERROR(source([&crc](const char* bytes, size_t size) {
      crc = base::Crc32c(crc, bytes, size);
      return absl::OkStatus();
    }));
    complete.source_crc32c = crc;
  }
  ASSIGN_OR_RETURN(Rewriter rewriter, Rewriter::Create(compensator, complete, sink));
  absl::Status status = source([&rewriter](const char* bytes, size_t size) { return rewriter.Feed(bytes, size); });
  if (status.ok()) status = rewriter.Finish();
  *report = rewriter.report();
  return status;
}

absl::StatusOr<std::string> RewriteText(const std::string& program, const compensate::Compensator& compensator,
                                        const RewriteOptions& options, RewriteReport* report) {
  std::string output;
  output.reserve(program.size() + program.size() / 8);
  const ByteSource source = [&program](const ByteSink& take) { return take(program.data(), program.size()); };
  const ByteSink sink = [&output](const char* bytes, size_t size) {
    output.append(bytes, size);
    return absl::OkStatus();
  };
  RETURN_IF_ERROR(RewriteProgram(source, sink, compensator, options, report));
  return output;
}

absl::Status RewriteFileTo(const std::string& input_path, const ByteSink& sink,
                           const compensate::Compensator& compensator, const RewriteOptions& options,
                           RewriteReport* report) {
  const ByteSource source = [&input_path](const ByteSink& take) { return ReadAll(input_path, take); };
  RETURN_IF_ERROR(base::RequireFile(input_path));
  return RewriteProgram(source, sink, compensator, options, report);
}

absl::Status RewriteFile(const std::string& input_path, const std::string& output_path,
                         const compensate::Compensator& compensator, const RewriteOptions& options,
                         RewriteReport* report) {
  const ByteSource source = [&input_path](const ByteSink& take) { return ReadAll(input_path, take); };
  RETURN_IF_ERROR(base::RequireFile(input_path));
  RETURN_IF_ERROR(Open(input_path, "rb").status());
  base::AtomicFile file;
  RETURN_IF_ERROR(file.Open(output_path));
  const ByteSink sink = [&file](const char* bytes, size_t size) { return file.Write({bytes, size}); };
  RETURN_IF_ERROR(RewriteProgram(source, sink, compensator, options, report));
  return file.Commit();
}

}  // namespace axiscal::nc
