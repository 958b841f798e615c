// Checks files without libFuzzer: `reader_replay READER FILE...`, or `reader_replay --mutate READER FIRST_SEED COUNT
// FOLDER`: the folder's files and COUNT pseudo-random changes of them. Prints failures; exit status 1 if there are any.
#include <sys/resource.h>

#include <algorithm>
#include <cstdint>
#include <cstdio>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <random>
#include <string>
#include <vector>

#include "reader_judge.h"

namespace {

namespace fs = std::filesystem;

constexpr std::size_t most_bytes = 8192;
constexpr rlim_t most_memory = rlim_t{2} << 30;

std::string bytes_of(const fs::path& path) {
  std::ifstream file(path, std::ios::binary);
  if (!file) throw std::runtime_error("cannot read " + path.string());
  return {std::istreambuf_iterator<char>(file), {}};
}

/// Changes at which readers are known to fail, the same on every machine.
class Mutator {
 public:
  explicit Mutator(std::uint64_t seed) : random_(seed) {}

  std::string changed(std::string bytes, const std::string& other) {
    for (std::size_t i = 0, changes = 1 + below(4); i < changes; ++i) change(bytes, other);
    bytes.resize(std::min(bytes.size(), most_bytes));
    return bytes;
  }

 private:
  std::size_t below(std::size_t n) { return n == 0 ? 0 : static_cast<std::size_t>(random_() % n); }

  void change(std::string& bytes, const std::string& other) {
    static const std::string words[] = {"1e999",
                                        "-0.0",
                                        "5e-324",
                                        "1e308",
                                        "NaN",
                                        "null",
                                        "[",
                                        "]",
                                        "{",
                                        "}",
                                        "\"",
                                        ",",
                                        "\n",
                                        "\xff",
                                        "\xef\xbb\xbf",
                                        "\\u0000",
                                        "-1",
                                        "/",
                                        "\\\n",
                                        "#",
                                        "0",
                                        "4294967296",
                                        "[[[[[[[[",
                                        "18446744073709551616",
                                        " ",
                                        std::string(1, '\0'),
                                        std::string(4, '\xff'),
                                        "STEP"};
    const std::size_t at = below(bytes.size() + 1), count = 1 + below(8);
    switch (below(7)) {
      case 0:  // one bit
        if (at < bytes.size()) bytes[at] = static_cast<char>(bytes[at] ^ (1 << below(8)));
        break;
      case 1:
        bytes.resize(at);
        break;
      case 2:
        bytes.erase(at, count);
        break;
      case 3:
        bytes.insert(at, words[below(std::size(words))]);
        break;
      case 4:  // in place of a number, half of the time
        bytes.replace(at, std::min(count, bytes.size() - at), words[below(std::size(words))]);
        break;
      case 5:
        bytes.insert(at, bytes.substr(below(bytes.size() + 1), 64 * count));
        break;
      default:
        bytes = bytes.substr(0, at) + other.substr(below(other.size() + 1));
    }
  }

  std::mt19937_64 random_;
};

int usage() {
  std::fprintf(stderr, "usage: reader_replay READER FILE... | --mutate READER FIRST_SEED COUNT FOLDER\n");
  return 2;
}

int run(const std::vector<std::string>& words) {
  int wrong = 0;
  const auto judge = [&](const std::string& reader, const std::string& bytes, const std::string& name) {
    const std::string what = tandem::test::judge_reader(reader, bytes);
    if (what.empty()) return;
    ++wrong;
    std::printf("%s\n  ^ %s\n", what.c_str(), name.c_str());
  };
  if (!words.empty() && words[0] == "--mutate") {
    if (words.size() != 5) return usage();
    std::vector<fs::path> files;
    for (const auto& entry : fs::directory_iterator(words[4])) files.push_back(entry.path());
    std::sort(files.begin(), files.end());  // the order of a folder's files differs between machines
    std::vector<std::string> seeds;
    for (const fs::path& file : files) {
      seeds.push_back(bytes_of(file));
      judge(words[1], seeds.back(), file.string());
    }
    if (seeds.empty()) throw std::runtime_error("no files in " + words[4]);
    const std::uint64_t first = std::stoull(words[2]), count = std::stoull(words[3]);
    for (std::uint64_t seed = first; seed < first + count; ++seed) {
      const std::string bytes =
          Mutator(seed).changed(seeds[seed % seeds.size()], seeds[seed / seeds.size() % seeds.size()]);
      judge(words[1], bytes, "--mutate " + words[1] + ' ' + std::to_string(seed) + " 1 " + words[4]);
    }
  } else {
    if (words.size() < 2) return usage();
    for (std::size_t i = 1; i < words.size(); ++i) judge(words[0], bytes_of(words[i]), words[i]);
  }
  std::printf("%d wrong\n", wrong);
  return wrong > 0 ? 1 : 0;
}

}  // namespace

int main(int argc, char** argv) {
  // Memory is limited, so that excessive requests fail with std::bad_alloc, which no reader may throw for a small file.
  const rlimit memory{most_memory, most_memory};
  ::setrlimit(RLIMIT_AS, &memory);
  try {
    return run({argv + 1, argv + argc});
  } catch (const std::exception& error) {
    std::fprintf(stderr, "reader_replay: %s\n", error.what());
    return 2;
  }
}
