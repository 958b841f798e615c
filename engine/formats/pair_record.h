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

/// What a pair record asks for; distance and penetration ask for the same.
struct Ask {
  bool collide = false;
  bool distance = false;
  bool normal = false;
  bool contacts = false;
  bool triangles = false;
  bool toi = false;
  bool depth_bounds = false;
};

/// A question about two bodies. Where a rotation is not orthonormal to rounding their points are where the record's
/// R v + t puts them.
struct PairRecord {
  Json id;  ///< any JSON value; null if the record has none
  PlacedShape a, b;
  /// Two with triangles as they were given, where `a` and `b` have corners that were turned and so rounded: what is
  /// exact for the real numbers R v + t, lists and meshes' yes or no, is told from these.
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
  std::size_t most_boxes = DepthOptions{}.most_boxes;  ///< that depth_bounds may look at
};

/// What was asked, and nothing else.
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
  double error_bound = 0;  ///< metres, with Status::inexact
};

/// Throws InputError that names the JSON pointer. Keys of the record that are not known are passed over.
PairRecord read_pair_record(const Json& json, ShapeReader& shapes);

/// Solves what the record asks for. `options.margin` is replaced by the record's. Throws std::invalid_argument for a
/// bad option or a pair that the solver does not cover.
PairRecordAnswer answer(const PairRecord& record, NarrowPhaseOptions options);

void write_answer(JsonWriter& out, const Json& id, const PairRecordAnswer& answer, std::optional<double> nanoseconds);

/// One line in, one line out.
struct AnsweredLine {
  std::string text;  ///< JSON without a line end
  bool ok = false;
  bool is_record = false;  ///< it was read as one, also if it could not be answered
};

struct QueryOptions {
  NarrowPhaseOptions narrow_phase;
  bool time = false;  ///< measure the answer: the mean of as many repeats as fill some milliseconds
};

/// Never throws for what the line says: a bad record's answer is its error. `line_number` counts from 1.
AnsweredLine answer_line(std::string_view line, std::size_t line_number, ShapeReader& shapes,
                         const QueryOptions& options);

/// The answer to a line that cannot be read.
AnsweredLine bad_line(const Json& id, std::size_t line_number, std::string_view error);

}  // namespace tandem
