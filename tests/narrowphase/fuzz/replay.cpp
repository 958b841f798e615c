// Judges inputs of the fuzz target without libFuzzer: files, or pseudo-random bytes. Prints what fails; 1 if any does.
#include <cstdint>
#include <cstdio>
#include <cstdlib>
#include <fstream>
#include <iterator>
#include <string>
#include <vector>

#include "pair_fuzz.h"
#include "random.h"

int main(int argc, char** argv) {
  std::vector<std::string> words(argv + 1, argv + argc);
  const bool strictly = !words.empty() && words[0] == "--strict";
  if (strictly) words.erase(words.begin());
  if (words.empty() || (words[0] == "--random" && words.size() != 3)) {
    std::fprintf(stderr, "usage: pair_replay [--strict] FILE... | [--strict] --random FIRST COUNT\n");
    return 2;
  }
  int wrong = 0;
  const auto judge = [&](const std::vector<std::uint8_t>& input, const std::string& name) {
    const std::string what = tandem::test::judge_bytes(input, strictly);
    if (what.empty()) return;
    ++wrong;
    std::printf("%s\n  ^ input %s\n", what.c_str(), name.c_str());
  };
  if (words[0] == "--random") {
    const std::uint64_t first = std::stoull(words[1]), count = std::stoull(words[2]);
    for (std::uint64_t k = first; k < first + count; ++k) {
      tandem::reference::Random r(k);
      std::vector<std::uint8_t> input(400);
      for (auto& b : input) b = static_cast<std::uint8_t>(r.bits());
      judge(input, std::to_string(k));
    }
  } else {
    for (const std::string& name : words) {
      std::ifstream file(name, std::ios::binary);
      if (!file) {
        std::fprintf(stderr, "pair_replay: cannot read %s\n", name.c_str());
        return 2;
      }
      const std::vector<char> bytes{std::istreambuf_iterator<char>(file), {}};
      judge({bytes.begin(), bytes.end()}, name);
    }
  }
  std::printf("%d wrong\n", wrong);
  return wrong > 0 ? 1 : 0;
}
