// Output that `tandem run` and `tandem-mpi run` have in common.
#include "run_output.h"

#include <algorithm>
#include <cstdio>

namespace tandem {

std::string hex(std::uint64_t x) {
  char text[17];
  std::snprintf(text, sizeof text, "%016llx", static_cast<unsigned long long>(x));
  return text;
}

std::string written(Split split) { return std::to_string(split.broad) + '-' + std::to_string(split.narrow); }

double median(std::vector<double> values) {
  const auto middle = values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2);
  std::nth_element(values.begin(), middle, values.end());
  return *middle;
}

double ms_since(std::chrono::steady_clock::time_point begin) {
  return std::chrono::duration<double, std::milli>(std::chrono::steady_clock::now() - begin).count();
}

void write_contact(JsonWriter& out, std::uint64_t a, std::uint64_t b, const Contact& contact) {
  out.begin_object()
      .member("a", a)
      .member("b", b)
      .member("point", contact.point)
      .member("normal", contact.normal)
      .member("depth", contact.depth)
      .end_object();
}

void append_line(OutputFile& file, JsonWriter& line) {
  file.append(line.text());
  file.append("\n");
  line.clear();
}

void commit_all(std::initializer_list<std::optional<OutputFile>*> files) {
  for (auto* file : files)
    if (*file) (*file)->finish();
  for (auto* file : files)
    if (*file) (*file)->commit();
}

}  // namespace tandem
