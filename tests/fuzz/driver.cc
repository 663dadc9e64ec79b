#include "tests/fuzz/driver.h"

#include <algorithm>
#include <csignal>
#include <cstdint>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <random>
#include <vector>

extern "C" int LLVMFuzzerTestOneInput(const uint8_t* data, size_t size) {
  axiscal::fuzz::Look(std::string(reinterpret_cast<const char*>(data), size));
  return 0;
}

#ifndef AXISCAL_LIBFUZZER
namespace {

std::string Contents(const std::string& path) {
  std::ifstream file(path, std::ios::binary);
  return std::string(std::istreambuf_iterator<char>(file), std::istreambuf_iterator<char>());
}

// The words of a dictionary of libFuzzer: a line "..." each, with \\, \" and \xNN.
std::vector<std::string> WordsOf(const std::string& path) {
  std::vector<std::string> words;
  std::ifstream file(path);
  for (std::string line; std::getline(file, line);) {
    const size_t from = line.find('"'), to = line.rfind('"');
    if (line.empty() || line[0] == '#' || from == to) continue;
    std::string word;
    for (size_t i = from + 1; i < to; ++i) {
      if (line[i] != '\\') {
        word += line[i];
      } else if (line[++i] == 'x') {
        word += static_cast<char>(std::stoi(line.substr(i + 1, 2), nullptr, 16));
        i += 2;
      } else {
        word += line[i];
      }
    }
    words.push_back(word);
  }
  return words;
}

std::string Mutated(const std::vector<std::string>& corpus, const std::vector<std::string>& words,
                    std::mt19937& random) {
  const auto below = [&random](size_t limit) { return static_cast<size_t>(random() % std::max<size_t>(limit, 1)); };
  std::string text = corpus[below(corpus.size())];
  // Mostly few: what is changed in many places is seldom read far.
  for (size_t changes = 1 + below(1 + below(8)); changes > 0; --changes) {
    const size_t at = below(text.size() + 1), length = below(12);
    switch (below(7)) {
      case 0:
        text.erase(at, length);
        break;
      case 1:
        text.insert(at, words[below(words.size())]);
        break;
      case 2:
        text.insert(at, 1, static_cast<char>(below(256)));
        break;
      case 3: {
        const std::string& other = corpus[below(corpus.size())];
        text.insert(at, other.substr(below(other.size() + 1), 4 * length));
        break;
      }
      case 4:
        if (at < text.size()) text[at] = static_cast<char>(text[at] ^ 1 << below(8));
        break;
      case 5:
        text.insert(at, text.substr(at, 8 * length));
        break;
      default:
        // What comes behind a cut is seldom looked at: cut one in eight only.
        if (below(8) == 0) text.resize(at);
    }
  }
  return text;
}

// What is looked at, for the word that is said when it ends the program.
const std::string* looked_at = nullptr;

void KeepAndDie(int) {
  if (std::FILE* const file = std::fopen("fuzz-found", "wb"); file != nullptr) {
    std::fwrite(looked_at->data(), 1, looked_at->size(), file);
    std::fclose(file);
    std::fprintf(stderr, "the bytes are in the file fuzz-found\n");
  }
  std::signal(SIGABRT, SIG_DFL);
  std::abort();
}

void LookAt(const std::string& bytes) {
  looked_at = &bytes;
  axiscal::fuzz::Look(bytes);
}

}  // namespace

int main(int argc, char** argv) {
  if (argc != 4) {
    std::fprintf(stderr, "usage: %s CORPUS_FOLDER DICTIONARY ROUNDS\n", argv[0]);
    return 2;
  }
  std::vector<std::string> paths, corpus;
  for (const auto& entry : std::filesystem::directory_iterator(argv[1])) paths.push_back(entry.path().string());
  std::sort(paths.begin(), paths.end());
  for (const std::string& path : paths) corpus.push_back(Contents(path));
  const std::vector<std::string> words = WordsOf(argv[2]);
  if (corpus.empty() || words.empty()) {
    std::fprintf(stderr, "no file in %s, or no word in %s\n", argv[1], argv[2]);
    return 1;
  }
  std::signal(SIGABRT, KeepAndDie);
  for (const std::string& bytes : corpus) LookAt(bytes);
  std::mt19937 random(2022);
  const int rounds = std::atoi(argv[3]);
  for (int round = 0; round < rounds; ++round) LookAt(Mutated(corpus, words, random));
  std::printf("%zu files and %d mutations\n", corpus.size(), rounds);
  return 0;
}
#endif
