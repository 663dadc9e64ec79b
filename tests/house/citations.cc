#include "tests/house/citations.h"

#include <algorithm>
#include <array>
#include <cctype>

namespace axiscal::house {
namespace {

constexpr std::array kEndings = {".md", ".h", ".cc", ".proto", ".sql", ".cmake"};
constexpr std::array kFolders = {"client/", "cmake/", "core/",  "deploy/", "docs/",
                                 "migrations/", "proto/", "server/", "tests/"};

bool IsNameCharacter(char c) {
  return std::isalnum(static_cast<unsigned char>(c)) || c == '_' || c == '.' || c == '/' || c == '*' || c == '-';
}

// The end of the word that begins at `at`: name characters and groups like {h,cc}.
size_t EndOfWord(const std::string& text, size_t at) {
  while (at < text.size()) {
    if (text[at] == '{') {
      const size_t close = text.find_first_of("} \n", at);
      if (close == std::string::npos || text[close] != '}' || text.find(',', at) > close) return at;
      at = close + 1;
    } else if (IsNameCharacter(text[at])) {
      ++at;
    } else {
      return at;
    }
  }
  return at;
}

bool IsCitation(const std::string& word) {
  if (word.ends_with(".pb.h") || word.starts_with("//")) return false;  // generated; on the net
  if (word.front() == '*' && word.find('/') == std::string::npos) return false;  // "*_test.cc": a kind of file
  for (const std::string ending : kEndings) {
    if (word.ends_with(ending)) return word.size() > ending.size();
  }
  return (word.ends_with("}") && word.find(".{") != std::string::npos) ||
         std::any_of(kFolders.begin(), kFolders.end(), [&](const std::string folder) {
           return word.starts_with(folder) && word.size() > folder.size();
         });
}

// Of [text](name).
bool IsLinkTarget(const std::string& text, size_t begin, size_t end) {
  return begin >= 2 && text.compare(begin - 2, 2, "](") == 0 && end < text.size() && text[end] == ')';
}

// Without {a,b}: one name for each choice.
std::vector<std::string> Spelled(const std::string& name) {
  const size_t open = name.find('{'), close = name.find('}');
  if (open == std::string::npos || close == std::string::npos) return {name};
  std::vector<std::string> names;
  for (size_t begin = open + 1; begin <= close;) {
    const size_t end = std::min(name.find(',', begin), close);
    for (const std::string& rest : Spelled(name.substr(close + 1)))
      names.push_back(name.substr(0, open) + name.substr(begin, end - begin) + rest);
    begin = end + 1;
  }
  return names;
}

// "" above the root.
std::string FolderOf(const std::string& path) {
  const size_t slash = path.rfind('/');
  return slash == std::string::npos ? "" : path.substr(0, slash);
}

}  // namespace

std::string CommentsOf(const std::string& source) {
  std::string comments(source.size(), ' ');
  enum class In { kCode, kComment, kString, kCharacter } in = In::kCode;
  for (size_t i = 0; i < source.size(); ++i) {
    const char c = source[i];
    if (c == '\n') {
      comments[i] = c;
      in = In::kCode;  // no string of ours goes over a line's end but raw ones, which hold no quote at it
    } else if (in == In::kComment) {
      comments[i] = c;
    } else if (in == In::kCode) {
      if (c == '/' && i + 1 < source.size() && source[i + 1] == '/') {
        in = In::kComment;
        comments[i] = c;
      }
      if (c == '"') in = In::kString;
      // 1'000 has no character in it.
      if (c == '\'' && (i == 0 || !std::isalnum(static_cast<unsigned char>(source[i - 1])))) in = In::kCharacter;
    } else if (c == '\\') {
      ++i;
    } else if (c == (in == In::kString ? '"' : '\'')) {
      in = In::kCode;
    }
  }
  return comments;
}

std::string HashCommentsOf(const std::string& source) {
  std::string comments(source.size(), ' ');
  bool is_comment = false;
  for (size_t i = 0; i < source.size(); ++i) {
    if (source[i] == '#') is_comment = true;
    if (source[i] == '\n') is_comment = false;
    if (is_comment || source[i] == '\n') comments[i] = source[i];
  }
  return comments;
}

std::vector<Citation> CitationsIn(const std::string& text) {
  std::vector<Citation> citations;
  int line = 1;
  for (size_t at = 0; at < text.size();) {
    const size_t end = EndOfWord(text, at);
    if (end == at) {
      line += text[at] == '\n' ? 1 : 0;
      ++at;
      continue;
    }
    std::string word = text.substr(at, end - at);
    while (!word.empty() && (word.back() == '.' || word.back() == '/' || word.back() == '-')) word.pop_back();
    if (word.starts_with("./")) word.erase(0, 2);
    if (!word.empty() && (IsCitation(word) || IsLinkTarget(text, at, end))) citations.push_back({line, word});
    at = end;
  }
  return citations;
}

bool IsThere(const std::string& name, const std::string& from,
             const std::function<bool(const std::string& pattern)>& exists) {
  const std::vector<std::string> names = Spelled(name);
  return std::all_of(names.begin(), names.end(), [&](const std::string& spelled) {
    for (std::string folder = FolderOf(from);; folder = FolderOf(folder)) {
      if (exists(folder.empty() ? spelled : folder + "/" + spelled)) return true;
      if (folder.empty()) return false;
    }
  });
}

bool Fits(const std::string& path, const std::string& pattern) {
  // Greedy with one way back, as no star passes a slash.
  size_t p = 0, s = 0, star = std::string::npos, resume = 0;
  while (p < path.size()) {
    if (s < pattern.size() && pattern[s] == '*') {
      star = s++;
      resume = p;
    } else if (s < pattern.size() && pattern[s] == path[p]) {
      ++s, ++p;
    } else if (star != std::string::npos && path[resume] != '/') {
      s = star + 1;
      p = ++resume;
    } else {
      return false;
    }
  }
  while (s < pattern.size() && pattern[s] == '*') ++s;
  return s == pattern.size();
}

}  // namespace axiscal::house
