// Judges inputs of the fuzz target without libFuzzer: files, or pseudo-random bytes. Prints failures; exit status 1 if
// there are any. Also writes initial inputs for libFuzzer: one for every two kinds of shape.
#include <cstdint>
#include <cstdio>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <set>
#include <string>
#include <vector>

#include "judge.h"
#include "pair_bytes.h"
#include "pair_fuzz.h"
#include "random.h"

namespace {

std::vector<std::uint8_t> random_input(std::uint64_t seed) {
  tandem::reference::Random r(seed);
  std::vector<std::uint8_t> input(400);
  for (auto& b : input) b = static_cast<std::uint8_t>(r.bits());
  return input;
}

/// The first pseudo-random input of every two kinds, without unused bytes.
void write_seeds(const std::filesystem::path& folder) {
  std::set<std::string> written;
  for (std::uint64_t k = 0; k < 2000; ++k) {
    std::vector<std::uint8_t> input = random_input(k);
    const auto pair = tandem::test::pair_from_bytes(input);
    if (!pair) continue;
    const std::string name = std::string(tandem::name(pair->a.kind())).append("-").append(tandem::name(pair->b.kind()));
    if (!written.insert(name).second) continue;
    const std::string record = tandem::test::record(*pair);
    for (; !input.empty(); input.pop_back()) {
      const auto less = tandem::test::pair_from_bytes(std::span(input).first(input.size() - 1));
      if (!less || tandem::test::record(*less) != record) break;
    }
    std::ofstream(folder / name, std::ios::binary)
        .write(reinterpret_cast<const char*>(input.data()), static_cast<std::streamsize>(input.size()));
  }
}

}  // namespace

int main(int argc, char** argv) {
  std::vector<std::string> words(argv + 1, argv + argc);
  using tandem::test::Asked;
  const bool strictly = !words.empty() && words[0] == "--strict";
  if (strictly) words.erase(words.begin());
  if (words.empty() || (words[0] == "--random" && words.size() != 3)) {
    std::fprintf(stderr, "usage: pair_replay [--strict] FILE... | [--strict] --random FIRST COUNT | --seeds FOLDER\n");
    return 2;
  }
  if (words[0] == "--seeds" && words.size() == 2) {
    write_seeds(words[1]);
    return 0;
  }
  int wrong = 0;
  const auto judge = [&](const std::vector<std::uint8_t>& input, const std::string& name) {
    const std::string what = tandem::test::judge_bytes(input, strictly ? Asked::strictly : Asked::of_flat_strictly);
    if (what.empty()) return;
    ++wrong;
    std::printf("%s\n  ^ input %s\n", what.c_str(), name.c_str());
  };
  if (words[0] == "--random") {
    const std::uint64_t first = std::stoull(words[1]), count = std::stoull(words[2]);
    for (std::uint64_t k = first; k < first + count; ++k) judge(random_input(k), std::to_string(k));
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
