// Pair records, the lines of JSON that `tandem query` reads and answers.
#pragma once
#include <array>
#include <cstdint>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "formats/placed_shape.h"
#include "formats/shape_json.h"
#include "tandem/narrowphase/narrow_phase.h"
#include "tandem/narrowphase/penetration.h"

namespace tandem {

/// The requests of a pair record; distance and penetration request the same.
struct Ask {
  bool collide = false;
  bool distance = false;
  bool normal = false;
  bool contacts = false;
  bool triangles = false;
  bool toi = false;
  bool depth_bounds = false;
};

/// A question about two bodies. Where a rotation is not orthonormal to rounding, the points of the shapes are where the
/// record's R v + t puts them.
struct PairRecord {
  Json id;  ///< any JSON value; null if the record has none
  PlacedShape a, b;
  /// The two shapes with triangles as given, where the corners of `a` and `b` were rotated and so rounded. Results that
  /// are exact for the real numbers R v + t (lists of triangle pairs, collision verdicts of meshes) are computed from
  /// these.
  struct Given {
    Shape a;
    Pose pose_a;
    Shape b;
    Pose pose_b;
  };
  std::optional<Given> given;
  Ask ask;
  double margin = 0;  ///< metres, >= 0
  Vec3 velocity_a = Vec3::Zero(), velocity_b = Vec3::Zero();
  double tmax = 0;  ///< s, >= 0
  /// For depth_bounds: the boxes of translations that it may examine.
  std::size_t most_boxes = DepthOptions{}.most_boxes;
};

/// The results that were asked for, and no others.
struct PairRecordAnswer {
  std::optional<bool> collide;
  std::optional<double> signed_distance;
  Vec3 point_a = Vec3::Zero(), point_b = Vec3::Zero();  ///< with signed_distance
  std::optional<Vec3> normal;
  std::optional<std::vector<Contact>> contacts;
  std::optional<std::vector<std::array<std::uint32_t, 2>>> triangles;
  std::optional<std::optional<double>> toi;  ///< empty inside: they do not touch
  std::optional<DepthBounds> depth_bounds;
  Status status = Status::ok;
  double error_bound = 0;  ///< metres, for Status::inexact
};

/// Reads a record. Throws InputError that names the JSON pointer. Unknown keys are ignored.
PairRecord read_pair_record(const Json& json, ShapeReader& shapes);

/// Solves what the record asks for. `options.margin` is replaced by the record's. Throws std::invalid_argument for a
/// bad option or a pair that the solver does not cover.
PairRecordAnswer answer(const PairRecord& record, NarrowPhaseOptions options);

void write_answer(JsonWriter& out, const Json& id, const PairRecordAnswer& answer, std::optional<double> nanoseconds);

/// The answer to one line, as one line.
struct AnsweredLine {
  std::string text;  ///< JSON without a line end
  bool ok = false;
  bool is_record = false;  ///< the line was read as a record, even if it could not be answered
};

struct QueryOptions {
  NarrowPhaseOptions narrow_phase;
  bool time = false;  ///< measure the time: the mean of as many repetitions as fill some milliseconds
};

/// Answers a line. Never throws for the line's content: the answer to a bad record is its error. `line_number` counts
/// from 1.
AnsweredLine answer_line(std::string_view line, std::size_t line_number, ShapeReader& shapes,
                         const QueryOptions& options);

/// The answer to a line that cannot be read.
AnsweredLine bad_line(const Json& id, std::size_t line_number, std::string_view error);

}  // namespace tandem
