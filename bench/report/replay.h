// The packed recording that the page's replay draws.
#pragma once
#include <filesystem>
#include <functional>
#include <nlohmann/json.hpp>
#include <string>

namespace tandem::bench {

/// A packed recording, as the page's replay draws it. Everything in `data` is little-endian.
struct Replay {
  nlohmann::json about;  ///< scene, shapes, frames, ranges, what was checked; page/replay_data.js reads it
  std::string poses;     ///< a frame, 6 channels, a moving body: 16 bits
  std::string contacts;  ///< contacts that touch or overlap, frame by frame
  std::string costs;     ///< candidate pairs and narrow-phase time of each body, at some of the frames
  std::size_t size() const { return poses.size() + contacts.size() + costs.size(); }
};

/// Reads a recording of `tandem run`. Every k-th step becomes a frame, with the least k for which there are at most
/// `most_frames` and the compressed data take at most `most_bytes`. At up to 24 of the frames detection is run again on
/// the recorded poses: its hash is compared with the recorded one, and each pair's narrow phase is timed. Throws
/// InputError for what RecordReader refuses, and for a recording without a step. `done` is called with the number of
/// steps read, and of all.
Replay read_replay(const std::filesystem::path& path, std::size_t most_frames, std::size_t most_bytes,
                   const std::function<void(std::size_t done, std::size_t of)>& done);

}  // namespace tandem::bench
