// The entry point of libFuzzer. `pair_fuzz --strict ...` judges strictly; other arguments are libFuzzer's.
#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <cstdio>
#include <cstdlib>
#include <string_view>

#include "pair_fuzz.h"

namespace {
tandem::test::Asked asked = tandem::test::Asked::of_plump;
}

extern "C" int LLVMFuzzerInitialize(int* argc, char*** argv) {
  char** const end = *argv + *argc;
  char** const kept = std::remove_if(*argv, end, [](const char* word) { return std::string_view(word) == "--strict"; });
  if (kept != end) asked = tandem::test::Asked::strictly;
  *argc = static_cast<int>(kept - *argv);
  return 0;
}

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  const std::string wrong = tandem::test::judge_bytes({data, size}, asked);
  if (wrong.empty()) return 0;
  std::fprintf(stderr, "%s\n", wrong.c_str());
  std::abort();
}
