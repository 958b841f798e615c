#pragma once
#include <filesystem>
#include <functional>
#include <nlohmann/json.hpp>
#include <string>

namespace tandem::bench {

/// A recording made small: what the page's replay draws. Everything in `data` is little-endian.
struct Replay {
  nlohmann::json about;  ///< scene, shapes, frames, ranges, what was checked; page/replay_data.js reads it
  std::string poses;     ///< a frame, 6 channels, a moving body: 16 bits
  std::string contacts;  ///< those that touch or overlap, frame by frame
  std::string costs;     ///< candidate pairs and narrow-phase time a body, at some of the frames
  std::size_t size() const { return poses.size() + contacts.size() + costs.size(); }
};

/// Reads a record of `tandem run`. Of its steps every k-th is a frame, k the least with which there are at most
/// `most_frames` and the compressed parts take at most `most_bytes`. At up to 24 of the frames detection is run
/// anew on the recorded poses: its hash is compared with the recorded one, and each pair's narrow phase is timed.
/// Throws InputError for what RecordReader refuses, and for a record without a step.
/// `done` receives the steps read, of how many.
Replay read_replay(const std::filesystem::path& path, std::size_t most_frames, std::size_t most_bytes,
                   const std::function<void(std::size_t done, std::size_t of)>& done);

}  // namespace tandem::bench
