#pragma once
#include <cstdint>
#include <filesystem>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "formats/output_file.h"
#include "formats/text_file.h"
#include "tandem/engine/scene.h"
#include "tandem/flowgraph/contact_list.h"

namespace tandem {

/// What a contact looks like in a record: for looking at. The poses give it again exactly.
struct RecordedContact {
  std::uint32_t a, b;  ///< body indices
  float point[3], normal[3], depth;
};

/// One step: the poses that detection saw, and what it found.
struct RecordedStep {
  std::uint64_t step = 0;
  std::uint64_t contact_hash = 0;
  std::vector<std::pair<std::uint32_t, Pose>> poses;  ///< of the bodies that are not static, by index
  std::vector<RecordedContact> contacts;
};

/// The parts of a record, as docs/record-format.md describes them, for who puts one together of several writers'
/// shares.
namespace record {
constexpr std::size_t step_head_bytes = 28, pose_bytes = 100, contact_bytes = 36;

/// One line.
std::string header(const Scene& scene);
void append_step_head(std::string& out, std::uint64_t step, std::uint64_t contact_hash, std::uint32_t moving,
                      std::uint32_t contacts);
void append_pose(std::string& out, std::uint32_t index, const Pose& pose);
void append_contact(std::string& out, std::uint32_t a, std::uint32_t b, const Contact& contact);
}  // namespace record

/// Writes a record, as docs/record-format.md describes it.
class RecordWriter {
 public:
  RecordWriter(OutputFile& file, const Scene& scene);
  /// The scene as detection saw it, with the bodies that it had when the record began. Throws OutputError, and
  /// std::invalid_argument for other bodies and for contacts that are not the scene's.
  void step(std::uint64_t step, std::uint64_t contact_hash, const Scene& scene, const ContactList& contacts);

 private:
  void require_bodies(const Scene& scene) const;

  OutputFile& file_;
  std::vector<BodyId> bodies_;            // by their numbers in the record
  std::vector<std::uint32_t> number_of_;  // of a body's index
  std::string block_;
};

/// Reads a record step by step; in memory is one step.
class RecordReader {
 public:
  /// Throws InputError "FILE: ..." for a file that is missing, no record or cut off; so does `next`, with the byte. A
  /// pipe is refused: who reads records reads them twice.
  explicit RecordReader(const std::filesystem::path& path);
  /// As it was before the first step.
  const Scene& scene() const { return scene_; }
  /// False at the end.
  bool next(RecordedStep& step);

 private:
  /// The next bytes, as many as `count` numbers of this size take.
  std::string_view take(std::size_t count, std::size_t size, std::string_view what);

  InputFile file_;
  std::string bytes_;
  Scene scene_;
};

}  // namespace tandem
