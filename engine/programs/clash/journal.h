// Clashes as JSON, and the journal from which an interrupted run continues.
#pragma once
#include <filesystem>
#include <map>
#include <utility>
#include <vector>

#include "clash.h"
#include "formats/json_writer.h"
#include "formats/output_file.h"

namespace tandem::clash {

/// Writes a clash as a JSON object, files by name.
void write(JsonWriter& out, const std::vector<Part>& parts, const Clash& clash);

/// A file of answers, a line each as they are found, so that an interrupted run can continue. The first line identifies
/// the input (names, meshes, clearance); an incomplete last line is written anew.
class Journal {
 public:
  /// Opens or creates the file and reads its answers. Throws InputError if it is of other input or no journal.
  Journal(const std::filesystem::path& path, const std::vector<Part>& parts, double clearance);
  ~Journal();
  Journal(const Journal&) = delete;
  Journal& operator=(const Journal&) = delete;

  const std::map<std::pair<std::size_t, std::size_t>, Answer>& answers() const { return answers_; }
  /// Writes an answer; it is on disk when the call returns.
  void add(const Pair& pair, const Answer& answer);

 private:
  std::map<std::pair<std::size_t, std::size_t>, Answer> answers_;
  int descriptor_;
  DescriptorBuffer out_;
};

}  // namespace tandem::clash
