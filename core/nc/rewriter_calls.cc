// Programs that call subprograms: each run of a subprogram is rewritten where the control runs it, in the state and
// from the positions that it then has. Runs whose texts are the same share one text, in the place of the original; each
// other text becomes a copy with a name of its own, and its calls name that.
#include <algorithm>
#include <map>
#include <optional>

#include "core/base/crc32c.h"
#include "core/nc/mark.h"
#include "core/nc/rewriter_impl.h"

namespace axiscal::nc {
namespace {

constexpr size_t kMostCopyBytes = size_t{1} << 28;

std::string LineEndOf(const std::string& line) { return line.substr(TextSize(line.data(), line.size())); }

std::string WithLineEnd(std::string text, const std::string& line_end) {
  if (!text.empty() && text.back() != '\n') text += line_end.empty() ? "\n" : line_end;
  return text;
}

bool IsDigitAt(const std::string& text, size_t at) { return at < text.size() && text[at] >= '0' && text[at] <= '9'; }

// What stands in a call for the name: "1001" of "O1001", "7" of "LBL 7".
std::string CalledAs(const std::string& name, const Dialect& dialect) {
  if (name.compare(0, 4, "LBL ") == 0 || name.compare(0, 4, "PGM ") == 0) return name.substr(4);
  const bool is_number = name.size() > 1 && (IsDigitAt(name, 1) || name[1] == '<');
  return !dialect.has_equals && is_number ? name.substr(1) : name;
}

// Puts `name` in place of bytes that held a name, with as many digits at least.
std::string Padded(const std::string& name, size_t width) {
  const bool is_number = name.find_first_not_of("0123456789") == std::string::npos;
  return is_number && name.size() < width ? std::string(width - name.size(), '0') + name : name;
}

// Blocks of Klartext without their numbers: they stand a second time.
std::string WithoutNumbers(const std::string& text) {
  std::string bare;
  bool is_continued = false;
  for (size_t at = 0; at < text.size();) {
    const size_t end = std::min(text.find('\n', at), text.size() - 1) + 1;
    size_t begin = at;
    while (!is_continued && (IsDigitAt(text, begin) || text[begin] == ' ')) ++begin;
    bare.append(text, begin, end - begin);
    size_t last = at + TextSize(text.data() + at, end - at);
    while (last > at && (text[last - 1] == ' ' || text[last - 1] == '\t')) --last;
    is_continued = last > at && text[last - 1] == '~';
    at = end;
  }
  return bare;
}

}  // namespace

// A text that some runs of a body agree in: its lines from the head on, with the original's name.
struct Rewriter::Impl::Version {
  std::string text, name;
};

// One run of a body, or of the program itself.
struct Rewriter::Impl::Run {
  struct Callee {
    std::string name;            // of the version that it runs
    std::string text, unrolled;  // of a section: as it stands, and as blocks in place of the call
  };
  int text = 0, body = -1;
  size_t begin = 0;
  std::vector<std::optional<std::string>> written;  // by line from `begin` on; none: as it was
  std::map<size_t, std::vector<Callee>> calls;      // by line
  std::map<size_t, bool> is_packed;
  std::map<size_t, int> section_of;  // the body that each call ran
};

// What is written in the end.
class Rewriter::Impl::Written {
 public:
  Written(Impl* impl, Execution* execution) : impl_(*impl), execution_(*execution) {}

  // A run ended: the version that it is.
  Run::Callee Take(const Run& run) {
    const Body body = execution_.bodies()[static_cast<size_t>(run.body)];
    Run::Callee callee;
    if (body.is_section) {
      for (size_t line = body.begin; line < body.end; ++line) {
        const std::string text = LineOf(run, line);
        callee.text += text;
        const bool is_label = execution_.flow(run.text, line).kind == FlowLine::Kind::kHead;
        if (!is_label) callee.unrolled += WithLineEnd(text, LineEnd(run.text));
      }
      callee.unrolled = WithoutNumbers(callee.unrolled);
      return callee;
    }
    std::string text;
    for (size_t line = body.head; line < body.end; ++line)
      text += line < body.begin ? execution_.lines(run.text)[line] : LineOf(run, line);
    std::vector<Version>& versions = versions_[run.body];
    for (const Version& known : versions) {
      if (known.text == text) {
        callee.name = known.name;
        return callee;
      }
    }
    callee.name = versions.empty() ? body.name : execution_.FreeName(body.name);
    bytes_ += text.size();
    // The label is jumped to: nothing may stand in front of it.
    const std::string& head = execution_.lines(run.text)[body.head];
    const size_t number_end = head.find_first_not_of("0123456789", head.find_first_of("0123456789"));
    if (body.head == body.begin && body.name[0] == 'N' && text.compare(0, number_end, head, 0, number_end) != 0)
      problem_ = absl::StrCat(body.name, ": a block would have to stand in front of it");
    if (bytes_ > kMostCopyBytes) problem_ = "copies of subprograms take more than 256 MB";
    versions.push_back({std::move(text), callee.name});
    return callee;
  }

  // Why it cannot be written, or "".
  const std::string& problem() const { return problem_; }

  // The program's text from its first line that waited on.
  std::string Program(const Run& program) {
    std::string text;
    const size_t count = execution_.lines(0).size();
    for (size_t line = 0; line < count;) {
      const int body = VersionsAt(0, line);
      if (body < 0) {
        text += LineOf(program, line++);
        continue;
      }
      text += Versions(body);
      line = execution_.bodies()[static_cast<size_t>(body)].end;
    }
    return text;
  }

  // Files of subprograms that the program runs.
  std::vector<Subprogram> Files() {
    std::vector<Subprogram> files;
    for (int text = 1; text < execution_.text_count(); ++text) {
      std::string bytes, source;
      std::vector<Subprogram> copies;
      bool is_run = false;
      const std::vector<std::string>& lines = execution_.lines(text);
      for (const std::string& line : lines) source += line;
      for (size_t line = 0; line < lines.size();) {
        const int body = VersionsAt(text, line);
        if (body < 0) {
          bytes += lines[line++];
          continue;
        }
        is_run = true;
        const Body& of = execution_.bodies()[static_cast<size_t>(body)];
        const std::vector<Version>& versions = versions_[body];
        bytes += versions[0].text;
        for (size_t i = 1; i < versions.size(); ++i) copies.push_back(Copy(text, of, versions[i], source));
        line = of.end;
      }
      if (!is_run) continue;
      const size_t head = HeadOf(text);
      if (bytes != source) InsertMark(text, head, source, &bytes);
      files.push_back({execution_.text_name(text), bytes});
      files.insert(files.end(), copies.begin(), copies.end());
    }
    return files;
  }

  // "O1000 is written as O1001 and O1002 too".
  std::vector<Remark> Notes() const {
    std::vector<Remark> notes;
    for (const auto& [body, versions] : versions_) {
      if (versions.size() < 2) continue;
      std::string names;
      for (size_t i = 1; i < versions.size(); ++i) absl::StrAppend(&names, i > 1 ? ", " : "", versions[i].name);
      notes.push_back({"copies", absl::StrCat(versions[0].name, " is not corrected alike by all its calls: ", names,
                                              " ", versions.size() > 2 ? "are copies" : "is a copy",
                                              " for others; no program of the control may have that name")});
    }
    return notes;
  }
  int64_t blocks_inserted() const { return blocks_inserted_; }

 private:
  std::string LineEnd(int text) const {
    const std::vector<std::string>& lines = execution_.lines(text);
    return lines.empty() ? "\n" : WithLineEnd(" ", LineEndOf(lines.front())).substr(1);
  }

  std::string LineOf(const Run& run, size_t line) {
    const auto call = run.calls.find(line);
    if (call != run.calls.end()) return CallOf(run, line, call->second);
    const std::optional<std::string>& written = run.written[line - run.begin];
    return written ? *written : execution_.lines(run.text)[line];
  }

  std::string CallOf(const Run& run, size_t line, const std::vector<Run::Callee>& callees) {
    const std::string& source = execution_.lines(run.text)[line];
    const FlowLine& flow = execution_.flow(run.text, line);
    if (callees.empty()) return source;
    if (flow.is_section) {
      std::string first, unrolled;
      const Body body = execution_.bodies()[static_cast<size_t>(run.section_of.at(line))];
      for (size_t k = body.begin; k < body.end; ++k) first += LineOf(run, k);
      const bool is_alike =
          std::all_of(callees.begin(), callees.end(), [&](const Run::Callee& callee) { return callee.text == first; });
      if (is_alike) return source;
      for (const Run::Callee& callee : callees) unrolled += callee.unrolled;
      blocks_inserted_ += std::count(unrolled.begin(), unrolled.end(), '\n');
      bytes_ += unrolled.size();
      if (bytes_ > kMostCopyBytes) problem_ = "copies of repeated parts take more than 256 MB";
      return unrolled;
    }
    std::string text;
    for (size_t i = 0; i < callees.size();) {
      size_t end = i;
      while (end < callees.size() && callees[end].name == callees[i].name) ++end;
      const bool is_first = i == 0;
      if (is_first && end == callees.size() && callees[i].name == flow.target) return source;
      text += Call(source, flow, callees[i].name, static_cast<int64_t>(end - i), run.is_packed.at(line), is_first);
      if (end < callees.size()) text = WithLineEnd(text, LineEnd(run.text));
      blocks_inserted_ += !is_first;
      i = end;
    }
    return text;
  }

  // The call of `name`, so many times; a further one carries no number of its block.
  std::string Call(const std::string& source, const FlowLine& flow, const std::string& name, int64_t times,
                   bool is_packed, bool is_first) const {
    const Dialect& dialect = impl_.interpreter.dialect();
    const size_t width = flow.target_end - flow.target_at;
    std::string number = CalledAs(name, dialect);
    number = is_packed ? absl::StrFormat("%d%04d", times, std::stoi(number)) : Padded(number, width);
    const bool has_repeats = flow.repeats_end > flow.repeats_at;
    const std::string repeats = absl::StrCat(dialect.has_equals ? "P" : "L", times);
    std::string text = source;
    const auto replace = [&text](size_t at, size_t end, const std::string& by) { text.replace(at, end - at, by); };
    size_t code_end = flow.code_end;
    const auto put = [&](size_t at, size_t end, const std::string& by) {
      replace(at, end, by);
      code_end += by.size();
      code_end -= end - at;
    };
    if (has_repeats && flow.repeats_at > flow.target_at) put(flow.repeats_at, flow.repeats_end, repeats);
    put(flow.target_at, flow.target_end, number);
    if (has_repeats && flow.repeats_at < flow.target_at) put(flow.repeats_at, flow.repeats_end, repeats);
    if (is_first) return text;
    const size_t slash = source.find('/');
    const bool is_deletable = slash != std::string::npos && slash < flow.code_at;
    return (is_deletable ? "/" : "") + text.substr(flow.code_at, code_end - flow.code_at) + LineEndOf(source);
  }

  // The body whose versions begin in that line, -1: none.
  int VersionsAt(int text, size_t line) const {
    for (const auto& [index, versions] : versions_) {
      const Body& body = execution_.bodies()[static_cast<size_t>(index)];
      if (body.text == text && body.head == line) return index;
    }
    return -1;
  }

  // `version` under its own name.
  std::string Renamed(const Body& body, const Version& version) const {
    if (version.name == body.name) return version.text;
    std::string text;
    const Dialect& dialect = impl_.interpreter.dialect();
    const std::string was = CalledAs(body.name, dialect), name = CalledAs(version.name, dialect);
    size_t line = body.head;
    for (size_t at = 0; at < version.text.size(); ++line) {
      const size_t end = std::min(version.text.find('\n', at), version.text.size() - 1) + 1;
      std::string next = version.text.substr(at, end - at);
      at = end;
      // The heads stand in front of all that was rewritten; N500 of M97 is the first of that.
      const FlowLine flow = ReadFlow(next, dialect);
      const bool is_head = line <= body.begin && flow.kind == FlowLine::Kind::kHead;
      const bool is_end_of_word = flow.kind == FlowLine::Kind::kReturn && flow.target == body.name;
      if ((is_head && (flow.target == body.name || dialect.has_equals)) || is_end_of_word) {
        next.replace(flow.target_at, flow.target_end - flow.target_at, Padded(name, flow.target_end - flow.target_at));
      } else if (line == body.head && body.name[0] == 'N' && body.head == body.begin && !dialect.has_equals) {
        const size_t digits = next.find_first_of("0123456789");
        next.replace(digits, next.find_first_not_of("0123456789", digits) - digits, name);
      } else if (flow.kind == FlowLine::Kind::kProgramEnd && flow.is_packed) {
        if (const size_t found = next.find(" " + was + " "); found != std::string::npos)
          next.replace(found + 1, was.size(), name);
      }
      text += next;
    }
    return text;
  }

  std::string Versions(int index) {
    const Body& body = execution_.bodies()[static_cast<size_t>(index)];
    const std::vector<Version>& versions = versions_[index];
    std::string text = versions[0].text;
    for (size_t i = 1; i < versions.size(); ++i) text = WithLineEnd(text, LineEnd(0)) + Renamed(body, versions[i]);
    return text;
  }

  // The line of a text behind which a mark may stand.
  size_t HeadOf(int text) const {
    const size_t count = execution_.lines(text).size();
    size_t head = 0;
    for (size_t line = 0; line < count; ++line) {
      const std::string& source = execution_.lines(text)[line];
      const bool is_frame = source[0] == '%' || execution_.flow(text, line).kind == FlowLine::Kind::kHead;
      if (!is_frame) break;
      head = line + 1;
    }
    return head;
  }

  void InsertMark(int text, size_t head, const std::string& source, std::string* bytes) const {
    size_t at = 0;
    for (size_t line = 0; line < head; ++line) at = std::min(bytes->find('\n', at), bytes->size() - 1) + 1;
    bytes->insert(at, HeadComments(impl_.interpreter.dialect(), impl_.compensator, impl_.options,
                                   base::Crc32c(0, source.data(), source.size()), LineEnd(text)));
  }

  Subprogram Copy(int text, const Body& body, const Version& version, const std::string& source) const {
    const std::vector<std::string>& lines = execution_.lines(text);
    const Dialect& dialect = impl_.interpreter.dialect();
    const bool has_percent = !lines.empty() && lines.front()[0] == '%' && !dialect.has_equals;
    std::string bytes = WithLineEnd(Renamed(body, version), LineEnd(text));
    size_t head = body.begin - body.head;
    if (has_percent) bytes = "%" + LineEnd(text) + bytes + "%" + LineEnd(text), ++head;
    InsertMark(text, head, source, &bytes);
    const std::string& file = execution_.text_name(text);
    const size_t dot = file.find('.');
    const bool is_o = !dialect.takes_loaded_tool && version.name[0] == 'O' && IsDigitAt(version.name, 1);
    std::string stem = is_o ? version.name : CalledAs(version.name, dialect);
    stem.erase(std::remove_if(stem.begin(), stem.end(), [](char c) { return c == '<' || c == '>' || c == '"'; }),
               stem.end());
    return {stem + (dot == std::string::npos ? "" : file.substr(dot)), std::move(bytes)};
  }

  Impl& impl_;
  Execution& execution_;
  std::map<int, std::vector<Version>> versions_;  // by body
  std::string problem_;
  size_t bytes_ = 0;
  int64_t blocks_inserted_ = 0;
};

void Rewriter::Impl::RunCalls() {
  is_running = true;
  OutBuffer held;
  std::swap(out, held);
  if (!has_mark_place) {
    has_mark_place = true;
    mark_place = held.size();
    mark_line_end = LineEndOf(waiting.front());
    if (mark_line_end.empty()) mark_line_end = "\n";
  }
  Execution execution(interpreter.dialect(), options, std::move(waiting), first_waiting);
  Written written(this, &execution);
  std::vector<Run> runs(1);
  runs[0].written.resize(execution.lines(0).size());
  size_t call_line = 0;
  std::vector<size_t> call_lines;
  Execution::Event event;
  size_t held_at = 0;  // the line that waits for its corner
  while (status.ok() && execution.Next(&event)) {
    const std::vector<std::string>& lines = execution.lines(event.text);
    const auto refuse = [&](const std::string& problem) {
      const std::string& line = lines[std::min(event.line, lines.size() - 1)];
      now = {line.data(), line.size(), TextSize(line.data(), line.size()),
             execution.line_number(event.text, event.line)};
      job.SetSource(execution.text_name(event.text));
      if (is_null()) return job.Passed(now, problem, false);
      job.Refused(now, problem, false);
    };
    const auto begin_call = [&] {
      call_line = event.line;
      interpreter.NoteCallBlock(lines[event.line]);
      runs.back().calls[call_line].clear();
      runs.back().is_packed[call_line] = event.is_packed;
    };
    // What a line that is held became stands in its place, with the lines behind it that it waited for.
    const auto release = [&] {
      if (!corners.is_holding()) return;
      corners.Release(kNoMoveBehind, this);
      if (!is_null() && !job.is_refused())
        runs.back().written[held_at - runs.back().begin].emplace(out.data(), out.size());
      out.clear();
    };
    if (event.kind != Execution::Event::Kind::kLine || event.is_call || event.is_followed_return) release();
    switch (event.kind) {
      case Execution::Event::Kind::kEnter: {
        const Body& body = execution.bodies()[static_cast<size_t>(event.body)];
        if (body.states_unit && body.is_inch != interpreter.modal().is_inch)
          refuse(absl::StrCat(body.name, " is in another unit than the program that calls it"));
        Run run;
        run.text = body.text, run.body = event.body, run.begin = body.begin;
        run.written.resize(body.end - body.begin);
        runs.push_back(std::move(run));
        interpreter.EnterLevel();
        call_lines.push_back(call_line);
        break;
      }
      case Execution::Event::Kind::kLeave: {
        interpreter.LeaveLevel();
        if (!event.problem.empty()) refuse(event.problem);
        Run::Callee callee;
        if (!is_null() && !job.is_refused()) callee = written.Take(runs.back());
        const int body = runs.back().body;
        runs.pop_back();
        call_line = call_lines.back();
        call_lines.pop_back();
        runs.back().calls[call_line].push_back(std::move(callee));
        runs.back().section_of[call_line] = body;
        break;
      }
      case Execution::Event::Kind::kApart:
        if (!event.problem.empty()) refuse(event.problem);
        if (event.is_call) begin_call();
        break;
      case Execution::Event::Kind::kLine: {
        if (!event.problem.empty()) refuse(event.problem);
        const std::string& line = lines[event.line];
        job.SetSource(execution.text_name(event.text));
        interpreter.SetLine(execution.line_number(event.text, event.line), event.is_followed_return, event.is_call,
                            event.call_problem);
        const bool was_holding = corners.is_holding();
        Line(line.data(), line.size(), line.size() > kMaxLineBytes);
        const bool keeps = !is_null() && !job.is_refused();
        if (was_holding || corners.is_holding()) {
          std::vector<std::optional<std::string>>& slots = runs.back().written;
          const size_t begin = runs.back().begin;
          if (was_holding && keeps && !out.empty()) slots[held_at - begin].emplace(out.data(), out.size());
          if (keeps && (was_holding && !(corners.is_holding() && !out.empty()))) slots[event.line - begin].emplace();
          if (!was_holding || !out.empty()) held_at = event.line;
          out.clear();
          break;
        }
        const bool is_changed =
            keeps && (out.size() != line.size() || std::memcmp(out.data(), line.data(), line.size()) != 0);
        if (is_changed && event.is_call) refuse("the block would change: put the call alone in its block");
        if (is_changed) runs.back().written[event.line - runs.back().begin] = std::string(out.data(), out.size());
        if (event.is_call) begin_call();
        out.clear();
        break;
      }
    }
  }
  if (corners.is_holding()) {
    corners.Release(kNoMoveBehind, this);
    if (!is_null() && !job.is_refused()) runs[0].written[held_at - runs[0].begin].emplace(out.data(), out.size());
    out.clear();
  }
  is_running = false;
  std::swap(out, held);
  if (!status.ok() || is_null() || job.is_refused()) return;
  const std::string text = written.Program(runs[0]);
  std::vector<Subprogram> files = written.Files();
  if (!written.problem().empty()) {
    now = {"", 0, 0, first_waiting};
    return job.Refused(now, written.problem(), false);
  }
  job.report().blocks_inserted += written.blocks_inserted();
  job.report().subprograms = std::move(files);
  for (Remark& note : written.Notes()) job.report().notes.push_back(std::move(note));
  if (wants_mark) {
    out.insert(is_flushed ? out.size() : mark_place,
               HeadComments(interpreter.dialect(), compensator, options, *options.source_crc32c, mark_line_end));
  }
  out.append(text);
}

}  // namespace axiscal::nc
