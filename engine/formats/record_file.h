// Recordings of simulations: poses and contacts of every step (docs/record-format.md).
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

/// A contact as a recording stores it, for display. Detection on the recorded poses gives it exactly.
struct RecordedContact {
  std::uint32_t a, b;  ///< body indices
  float point[3], normal[3], depth;
};

/// One step: the poses that detection used, and its contacts.
struct RecordedStep {
  std::uint64_t step = 0;
  std::uint64_t contact_hash = 0;
  std::vector<std::pair<std::uint32_t, Pose>> poses;  ///< of the bodies that are not static, by index
  std::vector<RecordedContact> contacts;
};

/// The parts of a recording (docs/record-format.md), for programs in which several writers each write a share.
namespace record {
constexpr std::size_t step_head_bytes = 28, pose_bytes = 100, contact_bytes = 36;

/// The header, one line.
std::string header(const Scene& scene);
void append_step_head(std::string& out, std::uint64_t step, std::uint64_t contact_hash, std::uint32_t moving,
                      std::uint32_t contacts);
void append_pose(std::string& out, std::uint32_t index, const Pose& pose);
void append_contact(std::string& out, std::uint32_t a, std::uint32_t b, const Contact& contact);
}  // namespace record

/// Writes a recording (docs/record-format.md).
class RecordWriter {
 public:
  RecordWriter(OutputFile& file, const Scene& scene);
  /// Writes a step: the scene as detection saw it, with the bodies that it had when the recording began. Throws
  /// OutputError, and std::invalid_argument if the bodies are others or the contacts are not the scene's.
  void step(std::uint64_t step, std::uint64_t contact_hash, const Scene& scene, const ContactList& contacts);

 private:
  void require_bodies(const Scene& scene) const;

  OutputFile& file_;
  std::vector<BodyId> bodies_;            // by their numbers in the recording
  std::vector<std::uint32_t> number_of_;  // of a body's index
  std::string block_;
};

/// Reads a recording step by step; one step is in memory.
class RecordReader {
 public:
  /// Throws InputError "FILE: ..." for a file that is missing, not a recording or truncated; so does `next`, with the
  /// byte. A pipe is refused, since recordings are read twice.
  explicit RecordReader(const std::filesystem::path& path);
  /// The scene before the first step.
  const Scene& scene() const { return scene_; }
  /// Reads the next step; false at the end.
  bool next(RecordedStep& step);

 private:
  /// The next bytes: `count` numbers of this size.
  std::string_view take(std::size_t count, std::size_t size, std::string_view what);

  InputFile file_;
  std::string bytes_;
  Scene scene_;
};

}  // namespace tandem
