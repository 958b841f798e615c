// Whole steps with contacts kept from the step before (AnswerOptions::keep_contacts): time against the true error of
// every answer, which is compared with that of a pipeline that computes all contacts anew on the same poses.
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <unordered_map>

#include "answer_hash.h"
#include "benches.h"
#include "clocks.h"
#include "progress.h"
#include "tandem/engine/builtin_scenes.h"
#include "tandem/engine/pipeline.h"
#include "tandem/engine/response.h"

namespace tandem::bench {
namespace {

constexpr double tolerances[] = {0, 1e-6, 1e-5, 1e-4, 1e-3, 1e-2};
/// The difference that rounding may cause between two computations of a number, relative to the size of the bodies and
/// their distance from the origin.
constexpr double rounding_of_steps = 1e-11;

/// Errors of kept answers, relative to the smaller body's size, and in radians.
struct Errors {
  Samples told, distance, depth, normal, point;
  std::uint64_t answers = 0, beyond = 0, beyond_meshes = 0, wrong_verdicts = 0, wrong_verdicts_meshes = 0;
  std::uint64_t jumps =
      0;  ///< unproven depths that are kept as the motion allows, while computed ones differ by more

  struct Computed {
    double distance, depth;
  };
  std::unordered_map<std::uint64_t, Computed> last;  ///< the last computed answer of each pair
};

std::uint64_t key(const PairResult& pair) { return std::uint64_t{pair.a} << 32 | pair.b; }

/// The pairs of two lists side by side: both answers, or one where the other list has none.
template <class Visit>
void each_pair(const ContactList& x, const ContactList& y, const Visit& visit) {
  auto i = x.pairs.begin(), j = y.pairs.begin();
  while (i != x.pairs.end() || j != y.pairs.end()) {
    const bool first = j == y.pairs.end() || (i != x.pairs.end() && key(*i) <= key(*j));
    const bool second = i == x.pairs.end() || (j != y.pairs.end() && key(*j) <= key(*i));
    visit(first ? &*i : nullptr, second ? &*j : nullptr);
    i += first ? 1 : 0;
    j += second ? 1 : 0;
  }
}

double deepest_depth(std::span<const Contact> contacts) {
  double depth = -std::numeric_limits<double>::infinity();
  for (const Contact& contact : contacts) depth = std::max(depth, contact.depth);
  return depth;
}

double to_nearest(const Vec3& point, std::span<const Contact> contacts) {
  double least = std::numeric_limits<double>::infinity();
  for (const Contact& contact : contacts) least = std::min(least, (contact.point - point).norm());
  return least;
}

class Judge {
 public:
  Judge(const Scene& scene, const ContactList& kept, const ContactList& truth, Errors& errors)
      : scene_(scene), kept_(kept), truth_(truth), errors_(errors) {}
  void look() const {
    each_pair(kept_, truth_, [this](const PairResult* kept, const PairResult* truth) { look_at(kept, truth); });
  }

 private:
  void look_at(const PairResult* kept, const PairResult* truth) const {
    const PairResult& any = kept != nullptr ? *kept : *truth;
    const Shape &a = scene_.shape_of(any.a), &b = scene_.shape_of(any.b);
    const bool meshes = !a.is_convex() || !b.is_convex();
    if ((kept != nullptr && kept->answer.collide) != (truth != nullptr && truth->answer.collide))
      ++(meshes ? errors_.wrong_verdicts_meshes : errors_.wrong_verdicts);
    if (kept == nullptr || truth == nullptr) return;
    ++errors_.answers;
    const PairAnswer &x = kept->answer, &y = truth->answer;
    const auto theirs = kept_.of(*kept), right = truth_.of(*truth);
    const double distance = std::abs(x.signed_distance - y.signed_distance);
    const double depth = theirs.empty() || right.empty() ? 0 : std::abs(deepest_depth(theirs) - deepest_depth(right));
    const double reach =
        a.size() + b.size() + scene_.poses()[any.a].translation.norm() + scene_.poses()[any.b].translation.norm();
    const double allowed = x.error_bound + y.error_bound + rounding_of_steps * reach;
    const bool is_computed = x.error_bound <= y.error_bound;
    if (is_computed) errors_.last[key(any)] = {x.signed_distance, deepest_depth(theirs)};
    if (distance > allowed || depth > allowed) {
      // The deepest contact of two meshes is not continuous in the poses, and has no proven bound: the error added by
      // keeping is compared with the answer computed last.
      const auto then = errors_.last.find(key(any));
      const bool as_told = x.status == Status::unproven && !is_computed && then != errors_.last.end() &&
                           std::abs(x.signed_distance - then->second.distance) <= allowed &&
                           (theirs.empty() || std::abs(deepest_depth(theirs) - then->second.depth) <= allowed);
      ++(as_told ? errors_.jumps : meshes ? errors_.beyond_meshes : errors_.beyond);
    }
    if (is_computed) return;
    const double size = a.size() > 0 && b.size() > 0 ? std::min(a.size(), b.size()) : a.size() + b.size();
    errors_.told.add(x.error_bound / size);
    errors_.distance.add(distance / size);
    errors_.depth.add(depth / size);
    errors_.normal.add(2 * std::asin(std::min(1.0, (x.normal - y.normal).norm() / 2)));
    double point = 0;
    if (!right.empty())
      for (const Contact& contact : theirs) point = std::max(point, to_nearest(contact.point, right));
    errors_.point.add(point / size);
  }

  const Scene& scene_;
  const ContactList &kept_, &truth_;
  Errors& errors_;
};

struct StepContestant {
  double tolerance;
  Pipeline pipeline;
  Samples time;
  Errors errors;
  double kept = 0, candidates = 0;
  std::uint64_t hash = hash_start;
};

nlohmann::json quantiles(const Samples& samples) {
  return {{"p50", samples.quantile(0.5)}, {"p99", samples.quantile(0.99)}, {"max", samples.quantile(1)}};
}

void run(Scene& scene, std::vector<StepContestant>& all, int steps) {
  Response response;
  Progress progress(scene.name, steps);
  for (int step = 0; step < steps; ++step) {
    for (std::size_t turn = 0; turn < all.size(); ++turn) {
      StepContestant& who = all[(turn + static_cast<std::size_t>(step)) % all.size()];
      const double begin = cpu_ns();
      const StepReport report = who.pipeline.step(scene);
      const double ns = cpu_ns() - begin;
      who.hash = (who.hash ^ hash(who.pipeline.contacts())) * 0x100000001b3u;
      if (2 * step < steps) continue;  // bodies come to rest in the second half
      who.time.add(ns);
      who.kept += static_cast<double>(report.kept_pairs);
      who.candidates += static_cast<double>(report.execution.candidate_pairs);
    }
    const ContactList& truth = all.front().pipeline.contacts();
    for (StepContestant& who : all) Judge(scene, who.pipeline.contacts(), truth, who.errors).look();
    response.step(scene, truth);
    progress.at(step + 1);
  }
}

Row row_of(const Scene& scene, StepContestant& who, double computed_ns) {
  const Errors& e = who.errors;
  Row row{"steps",
          scene.name,
          who.tolerance == 0 ? "computed" : fmt::format("kept {:.0e}", who.tolerance),
          1,
          scene.bodies(),
          who.time,
          who.hash,
          {{"tolerance", who.tolerance},
           {"ratio_to_computed", who.time.median() / computed_ns},
           {"kept_share", who.candidates > 0 ? who.kept / who.candidates : 0},
           {"answers", e.answers},
           {"kept_answers", e.told.size()},
           {"beyond_bound", e.beyond},
           {"beyond_bound_meshes", e.beyond_meshes},
           {"jumps_meshes", e.jumps},
           {"wrong", e.wrong_verdicts},
           {"wrong_meshes", e.wrong_verdicts_meshes}}};
  for (const auto& [key, samples] :
       {std::pair("told", &e.told), std::pair("distance", &e.distance), std::pair("depth", &e.depth),
        std::pair("normal", &e.normal), std::pair("point", &e.point)})
    row.more[key] = quantiles(*samples);
  return row;
}

}  // namespace

std::vector<Row> steps_bench(const Settings& settings) {
  std::vector<std::string> scenes = settings.scenes;
  if (scenes.empty())
    scenes = {"cubes-on-plane", "spheres-on-plane", "mixed-grains", "tori-on-cones", "screws-in-bowl"};
  const std::size_t bodies = settings.bodies != 0 ? settings.bodies : settings.quick ? 60 : 400;
  const int steps = settings.steps != 0 ? settings.steps : settings.quick ? 120 : 400;
  std::vector<Row> rows;
  fmt::print(
      "Steps with contacts kept, beside all computed, on the same poses: processor time of a step in the second\n"
      "half; errors relative to the smaller body (normal: radians), beside the bound that was told; answers beyond\n"
      "it and wrong verdicts: between convex bodies, + with meshes; jumps: depths of two meshes that are unproven, "
      "kept\n"
      "as they were computed, where those computed anew differ by more.\n"
      "{:<17} {:<9} {:>8} {:>6} {:>6} {:>9} | {:>8} {:>8} {:>8} | {:>8} {:>8} {:>8} | {:>8} {:>8} | {:>7} {:>5} "
      "{:>7}\n",
      "scene", "contacts", "ms", "ratio", "kept", "answers", "told max", "dist p99", "max", "depth 50", "99", "max",
      "normal99", "point 99", "beyond", "jumps", "wrong");
  for (const std::string& name : scenes) {
    Scene scene = make_builtin_scene(name, bodies);
    const double margin = recommended_margin(scene);
    std::vector<StepContestant> all;
    for (const double tolerance : tolerances)
      all.push_back(
          {tolerance,
           Pipeline({.executor = ExecutorKind::sequential, .answer = {.margin = margin, .keep_contacts = tolerance}}),
           {},
           {}});
    run(scene, all, steps);
    for (StepContestant& who : all) {
      const Row& row = rows.emplace_back(row_of(scene, who, all.front().time.median()));
      const Errors& e = who.errors;
      fmt::print(
          "{:<17} {:<9} {:>8.3f} {:>6.2f} {:>6.2f} {:>9} | {:>8.1e} {:>8.1e} {:>8.1e} | {:>8.1e} {:>8.1e} {:>8.1e} "
          "| {:>8.1e} {:>8.1e} | {:>7} {:>5} {:>7}\n",
          name, row.contestant, 1e-6 * row.time.median(), row.more["ratio_to_computed"].get<double>(),
          row.more["kept_share"].get<double>(), e.told.size(), e.told.quantile(1), e.distance.quantile(0.99),
          e.distance.quantile(1), e.depth.median(), e.depth.quantile(0.99), e.depth.quantile(1),
          e.normal.quantile(0.99), e.point.quantile(0.99), fmt::format("{}+{}", e.beyond, e.beyond_meshes), e.jumps,
          fmt::format("{}+{}", e.wrong_verdicts, e.wrong_verdicts_meshes));
    }
  }
  return rows;
}

}  // namespace tandem::bench
