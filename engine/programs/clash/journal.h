#pragma once
#include <filesystem>
#include <map>
#include <utility>
#include <vector>

#include "clash.h"
#include "formats/json_writer.h"
#include "formats/output_file.h"

namespace tandem::clash {

/// A clash as a JSON object, files by name.
void write(JsonWriter& out, const std::vector<Part>& parts, const Clash& clash);

/// Answers in a file, a line each as they come, so that work that was cut off goes on. The first line says of which
/// parts (names, meshes, clearance); a last line that was cut off is written anew.
class Journal {
 public:
  /// Opens, or makes, the file and reads what is in it. Throws InputError for one of other parts or no journal.
  Journal(const std::filesystem::path& path, const std::vector<Part>& parts, double clearance);
  ~Journal();
  Journal(const Journal&) = delete;
  Journal& operator=(const Journal&) = delete;

  const std::map<std::pair<std::size_t, std::size_t>, Answer>& answers() const { return answers_; }
  /// On disk when it returns.
  void add(const Pair& pair, const Answer& answer);

 private:
  std::map<std::pair<std::size_t, std::size_t>, Answer> answers_;
  int descriptor_;
  DescriptorBuffer out_;
};

}  // namespace tandem::clash
