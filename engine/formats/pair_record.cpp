// Pair records of `tandem query`: reading, answering, writing.
#include "formats/pair_record.h"

#include <algorithm>
#include <chrono>

namespace tandem {
namespace {

constexpr std::string_view asks =
    "collide, distance, penetration, normal, contacts, triangles_intersect, toi, depth_bounds";

bool has_triangles(const Shape& shape) {
  return shape.kind() == ShapeKind::triangle || shape.kind() == ShapeKind::mesh;
}

Ask read_ask(const JsonRef& json, const Shape& a, const Shape& b) {
  json.require_array("an array of " + std::string(asks));
  if (json.size() == 0) json.refuse("one or more of " + std::string(asks));
  Ask ask;
  for (std::size_t i = 0; i < json.size(); ++i) {
    const JsonRef word = json.at(i);
    const std::string& what = word.text();
    if (what == "collide") {
      ask.collide = true;
    } else if (what == "distance" || what == "penetration") {
      ask.distance = true;
    } else if (what == "normal") {
      ask.normal = true;
    } else if (what == "contacts") {
      ask.contacts = true;
    } else if (what == "triangles_intersect") {
      if (!has_triangles(a) || !has_triangles(b)) word.refuse("for triangles and meshes only");
      ask.triangles = true;
    } else if (what == "toi") {
      ask.toi = true;
    } else if (what == "depth_bounds") {
      ask.depth_bounds = true;
    } else {
      word.refuse(asks);
    }
  }
  return ask;
}

Vec3 velocity(const JsonRef& record, std::string_view key) {
  const auto json = record.find(key);
  return json ? json->vec3_up_to(1e30) : Vec3::Zero();
}

void note_status(PairRecordAnswer& out, const PairAnswer& answer) {
  if (answer.status == Status::ok) return;
  out.status = answer.status;
  out.error_bound = std::max(out.error_bound, answer.error_bound);
}

template <typename Work>
double mean_nanoseconds(Work&& work) {
  using Clock = std::chrono::steady_clock;
  constexpr auto enough = std::chrono::milliseconds(2);
  constexpr int most = 10'000;
  const auto begin = Clock::now();
  int runs = 0;
  do {
    work();
    ++runs;
  } while (runs < most && Clock::now() - begin < enough);
  return std::chrono::duration<double, std::nano>(Clock::now() - begin).count() / runs;
}

}  // namespace

PairRecord read_pair_record(const Json& json, ShapeReader& shapes) {
  const JsonRef record(json);
  const auto id = record.find("id");
  const Shape shape_a = shapes.read(record.at("shapeA")), shape_b = shapes.read(record.at("shapeB"));
  const Pose pose_a = read_pose(record.at("poseA")), pose_b = read_pose(record.at("poseB"));
  const Ask ask = read_ask(record.at("ask"), shape_a, shape_b);
  const bool exact = has_triangles(shape_a) && has_triangles(shape_b) &&
                     (ask.triangles || !shape_a.is_convex() || !shape_b.is_convex());
  const bool place_them = !exact || ask.distance || ask.normal || ask.contacts || ask.toi || ask.depth_bounds;
  PairRecord out{.id = id ? id->value() : Json(),
                 .a = place_them ? place(shape_a, pose_a) : PlacedShape{shape_a, pose_a, {}},
                 .b = place_them ? place(shape_b, pose_b) : PlacedShape{shape_b, pose_b, {}},
                 .given = {},
                 .ask = ask};
  if (exact && (out.a.pose.rotation != pose_a.rotation || out.b.pose.rotation != pose_b.rotation))
    out.given = {shape_a, pose_a, shape_b, pose_b};
  if (const auto margin = record.find("margin")) out.margin = margin->number_up_to(1e30);
  if (const auto most = record.find("most_boxes"))
    out.most_boxes = most->whole(1'000'000'000);
  out.velocity_a = velocity(record, "velA");
  out.velocity_b = velocity(record, "velB");
  if (const auto tmax = record.find("tmax"))
    out.tmax = tmax->number_up_to(1e30);
  else if (out.ask.toi)
    throw InputError("/tmax", "missing", "a number >= 0, as toi is asked for");
  return out;
}

PairRecordAnswer answer(const PairRecord& record, NarrowPhaseOptions options) {
  options.margin = record.margin;
  const WorkLimit* limit = options.limit;
  const NarrowPhase narrow_phase(std::move(options));
  const Ask& ask = record.ask;
  const auto solve = [&](Request request, std::vector<Contact>* contacts = nullptr) {
    const std::string reason = narrow_phase.refuses(record.a.shape, record.b.shape, request);
    if (!reason.empty()) throw InputError({}, reason);
    return tandem::solve(narrow_phase, record.a, record.b, request, contacts);
  };
  PairRecordAnswer out;
  if (ask.collide && record.given) {
    const PairRecord::Given& given = *record.given;
    out.collide = narrow_phase.solve(given.a, given.pose_a, given.b, given.pose_b, Request::collide).collide;
  }
  if (ask.distance || ask.normal) {
    const PairAnswer found = solve(Request::distance);
    note_status(out, found);
    if (ask.collide && !out.collide) out.collide = found.collide;
    if (ask.distance) {
      out.signed_distance = found.signed_distance;
      out.point_a = found.point_a;
      out.point_b = found.point_b;
    }
    if (ask.normal) out.normal = found.normal;
  }
  if (ask.contacts) {
    out.contacts.emplace();
    const PairAnswer found = solve(Request::contacts, &*out.contacts);
    note_status(out, found);
    if (ask.collide && !out.collide) out.collide = found.collide;
  }
  if (ask.collide && !out.collide) {
    const PairAnswer found = solve(Request::collide);
    note_status(out, found);
    out.collide = found.collide;
  }
  if (ask.triangles) {
    const PairRecord::Given given =
        record.given.value_or(PairRecord::Given{record.a.shape, record.a.pose, record.b.shape, record.b.pose});
    out.triangles = narrow_phase.intersecting_triangles(given.a, given.pose_a, given.b, given.pose_b);
    // For meshes the collision verdict is exact anyway.
    const bool two_triangles =
        record.a.shape.kind() == ShapeKind::triangle && record.b.shape.kind() == ShapeKind::triangle;
    if (ask.collide && two_triangles) out.collide = !out.triangles->empty();
  }
  if (ask.depth_bounds) {
    if (record.a.rest || record.b.rest)
      throw InputError("/ask", "depth_bounds", "for rotations that are orthonormal to 1e-14, of cylinders and cones");
    out.depth_bounds = penetration_depth(record.a.shape, record.a.pose, record.b.shape, record.b.pose,
                                         {.most_boxes = record.most_boxes, .limit = limit});
  }
  if (ask.toi)
    out.toi = time_of_impact(narrow_phase, record.a, record.velocity_a, record.b, record.velocity_b, record.tmax);
  return out;
}

void write_answer(JsonWriter& out, const Json& id, const PairRecordAnswer& answer, std::optional<double> nanoseconds) {
  out.begin_object().key("id").raw(id.dump());
  out.member("status", answer.status == Status::ok ? "ok" : "inexact");
  if (answer.status != Status::ok) out.member("error_bound", answer.error_bound);
  if (answer.collide) out.member("collide", *answer.collide);
  if (answer.signed_distance)
    out.member("signed_distance", *answer.signed_distance)
        .key("points")
        .begin_array()
        .value(answer.point_a)
        .value(answer.point_b)
        .end_array();
  if (answer.normal) out.member("normal", *answer.normal);
  if (answer.contacts) {
    out.key("contacts").begin_array();
    for (const Contact& contact : *answer.contacts)
      out.begin_object()
          .member("point", contact.point)
          .member("normal", contact.normal)
          .member("depth", contact.depth)
          .end_object();
    out.end_array();
  }
  if (answer.triangles) {
    out.key("triangles").begin_array();
    for (const auto& [i, j] : *answer.triangles) out.begin_array().value(i).value(j).end_array();
    out.end_array();
  }
  if (answer.toi) {
    out.key("toi");
    if (*answer.toi)
      out.value(**answer.toi);
    else
      out.null();
  }
  if (answer.depth_bounds)
    out.key("depth_bounds")
        .begin_object()
        .member("lower", answer.depth_bounds->lower)
        .member("upper", answer.depth_bounds->upper)
        .member("translation", answer.depth_bounds->translation)
        .end_object();
  if (nanoseconds) out.member("ns", *nanoseconds);
  out.end_object();
}

AnsweredLine answer_line(std::string_view line, std::size_t line_number, ShapeReader& shapes,
                         const QueryOptions& options) {
  Json json, id;
  bool is_record = false;
  const auto find_id = [&] {
    if (json.is_object() && json.contains("id")) id = json["id"];
  };
  try {
    json = parse_json(line, &json);
    find_id();
    const PairRecord record = read_pair_record(json, shapes);
    is_record = true;
    const PairRecordAnswer found = answer(record, options.narrow_phase);
    std::optional<double> nanoseconds;
    if (options.time) nanoseconds = mean_nanoseconds([&] { (void)answer(record, options.narrow_phase); });
    JsonWriter out;
    write_answer(out, id, found, nanoseconds);
    return {out.text(), true, is_record};
  } catch (const std::exception& error) {
    find_id();  // An incomplete line may still have its id.
    AnsweredLine answered = bad_line(id, line_number, error.what());
    answered.is_record = is_record;
    return answered;
  }
}

AnsweredLine bad_line(const Json& id, std::size_t line_number, std::string_view error) {
  JsonWriter out;
  out.begin_object().key("id").raw(id.dump()).member("line", line_number).member("status", "error");
  out.member("error", std::string_view(shortened(on_one_line(error), limits::message_bytes))).end_object();
  return {out.text()};
}

}  // namespace tandem
