// The entry point of libFuzzer for the reader TANDEM_READER.
#include <cstddef>
#include <cstdint>
#include <cstdio>
#include <cstdlib>
#include <string_view>

#include "reader_judge.h"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  const std::string wrong = tandem::test::judge_reader(TANDEM_READER, {reinterpret_cast<const char*>(data), size});
  if (wrong.empty()) return 0;
  std::fprintf(stderr, "%s: %s\n", TANDEM_READER, wrong.c_str());
  std::abort();
}
