// Compares a contestant's answers with the certified reference.
#include "accuracy.h"

#include <fmt/format.h>

#include <algorithm>
#include <bit>
#include <charconv>
#include <cmath>
#include <tuple>

#include "formats/shape_json.h"

namespace tandem::bench {
namespace {

struct Verdict {
  bool failed = false, wrong = false, wrong_normal = false;
  double error = 0;
  /// Order: failures first, then wrong verdicts, then by error.
  bool worse_than(const Verdict& other) const {
    return std::tuple(failed, wrong, error) > std::tuple(other.failed, other.wrong, other.error);
  }
};

Verdict judge(const Found& found, const reference::Truth& truth, double size, Request request) {
  Verdict v;
  v.failed = found.failed || (found.measured && !std::isfinite(found.signed_distance)) || !found.normal.allFinite();
  if (v.failed) return v;
  const double gap = std::abs(truth.signed_distance);
  if (found.collide != (truth.signed_distance <= 0) && gap > 1e-15 * size + truth.error) {
    v.wrong = true;
    v.error = gap / size;
    return v;
  }
  // Separated pairs have no contacts, and some libraries measure only pairs that touch.
  if (request == Request::collide || !found.measured) return v;
  v.error = std::max(0.0, std::abs(found.signed_distance - truth.signed_distance) - truth.error) / size;
  v.wrong_normal = truth.normal_unique && !found.normal.isZero() && (found.normal - truth.normal).norm() > 1e-3;
  return v;
}

}  // namespace

void Accuracy::set_errors(std::vector<double> errors) {
  if (errors.empty()) return;
  std::sort(errors.begin(), errors.end());
  const auto at = [&](double q) {
    return errors[static_cast<std::size_t>(std::ceil(q * static_cast<double>(errors.size() - 1)))];
  };
  error_p50 = at(0.5), error_p99 = at(0.99), error_max = errors.back();
}

Accuracy judge(const Workload& work, Request request, std::span<const Found> found) {
  Accuracy out;
  std::vector<double> errors;
  Verdict worst;
  for (std::size_t i = 0; i < found.size(); ++i) {
    const Found& f = found[i];
    const Verdict v = judge(f, work.truths[i], size(work.pairs[i]), request);
    for (const std::uint64_t word : {std::uint64_t{f.failed} << 1 | std::uint64_t{f.collide},
                                     std::bit_cast<std::uint64_t>(f.measured ? f.signed_distance : 0)})
      out.add_to_hash(word);
    out.failed += v.failed;
    out.wrong += v.wrong;
    out.normals += v.wrong_normal;
    out.unmeasured += request == Request::distance && !v.failed && !f.measured;
    if (v.worse_than(worst)) worst = v, out.worst = i;
    const bool judged = request == Request::collide || f.measured || v.wrong;
    if (!v.failed && judged) errors.push_back(v.error);
  }
  out.set_errors(std::move(errors));
  return out;
}

namespace {

/// Begins a record, up to its closing bracket.
JsonWriter begin_record(std::string_view id, const reference::PosedPair& pair, std::string_view request) {
  JsonWriter out;
  out.begin_object().member("id", id);
  write_shape(out.key("shapeA"), pair.a);
  write_pose(out.key("poseA"), pair.pose_a);
  write_shape(out.key("shapeB"), pair.b);
  write_pose(out.key("poseB"), pair.pose_b);
  out.key("ask").begin_array().value(request).end_array();
  return out;
}

}  // namespace

nlohmann::json query_record(const Workload& work, Request request, std::size_t i) {
  JsonWriter out = begin_record(fmt::format("{}/{}/{}", work.kind, work.pair_class, i), work.pairs[i], name(request));
  out.key("expect").begin_object();
  out.member("signed_distance", work.truths[i].signed_distance).member("error", work.truths[i].error);
  out.end_object().end_object();
  return nlohmann::json::parse(out.text());
}

std::optional<nlohmann::json> named_query_record(std::string_view id, std::string_view request, std::size_t n) {
  const std::size_t first = id.find('/'), last = id.rfind('/');
  if (first == last) return std::nullopt;
  std::size_t index = 0;
  const std::from_chars_result read = std::from_chars(id.data() + last + 1, id.data() + id.size(), index);
  if (read.ec != std::errc() || read.ptr != id.data() + id.size()) return std::nullopt;
  const auto pair = named_pair(id.substr(0, first), id.substr(first + 1, last - first - 1), n, index);
  if (!pair) return std::nullopt;
  JsonWriter out = begin_record(id, *pair, request);
  out.end_object();
  return nlohmann::json::parse(out.text());
}

nlohmann::json to_json(const Accuracy& a) {
  return {{"error_p50", a.error_p50}, {"error_p99", a.error_p99},   {"error_max", a.error_max},   {"wrong", a.wrong},
          {"failed", a.failed},       {"wrong_normals", a.normals}, {"unmeasured", a.unmeasured}, {"right", a.right()}};
}

}  // namespace tandem::bench
