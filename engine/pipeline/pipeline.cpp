// The pipeline of a step: boxes, broad phase, batches for the narrow phase, and the list of contacts with its report.
#include "tandem/engine/pipeline.h"

#include <algorithm>
#include <array>
#include <atomic>
#include <limits>
#include <optional>
#include <stdexcept>
#include <string>
#include <type_traits>

#include "pipeline/body_boxes.h"
#include "pipeline/kept_batch.h"
#include "pipeline/kept_handover.h"
#include "pipeline/pair_costs.h"
#include "pipeline/pipeline_parts.h"
#include "tandem/narrowphase/several_pairs.h"
#include "tandem/narrowphase/work_limit.h"

namespace tandem {
namespace {

/// Converts to the result of `make`: a container constructs the element in place, without a copy.
template <class Make>
struct InPlace {
  Make make;
  operator std::invoke_result_t<const Make&>() const { return make(); }
};
template <class Make>
InPlace(Make) -> InPlace<Make>;

/// The work of a step as stages of blocks: boxes, the broad phase's stages, and the narrow phase for each pair.
class SceneWork final : public StepWork {
 public:
  explicit SceneWork(const PipelineOptions& options)
      : options_(options),
        narrow_phase_(narrow_options(true)),
        without_gaps_(narrow_options(false)),
        several_pairs_(narrow_options(false)),
        broad_phase_(broad_phase_of(options)),
        own_costs_(costs_of(options)),
        kept_(keeps_answers(options) ? std::make_unique<KeptContacts>(
                                           options.answer.request, options.answer.keep_contacts, options.answer.margin)
                                     : nullptr),
        together_(!kept_ && options.answer.request == Request::contacts),
        boxes_(options.answer.margin, kept_.get(), together_) {
    if (!kept_) return;
    for (std::size_t a = 0; a < shape_kinds; ++a)
      for (std::size_t b = 0; b < shape_kinds; ++b) {
        const auto kind_a = static_cast<ShapeKind>(a), kind_b = static_cast<ShapeKind>(b);
        worth_moving_[a][b] = narrow_phase_.solver_for(kind_a, kind_b, options.answer.request).solver != "closed";
      }
  }

  /// `contacts`: the last step's answer.
  void read_scene(const Scene& scene, ContactList& contacts, const std::stop_token& stop,
                  std::chrono::steady_clock::time_point deadline) {
    scene_ = &scene;
    limit_.stop = stop;
    limit_.ended = {};  // the last step's; the executor sets that of this step
    limit_.deadline = deadline;
    incomplete_.store(false, std::memory_order_relaxed);
    abandoned_.store(false, std::memory_order_relaxed);
    filter_ = {scene.groups(), scene.masks(), scene.is_static()};
    boxes_.begin_step(scene, limit_);
    changes_filter_ = {filter_.group, filter_.mask, boxes_.still()};
    broad_phase_->expect(filter_);
    only_changes_ = kept_ && begin_kept(contacts);
    if (boxes_.changes_known()) broad_phase_->expect_changes(boxes_.changed());
    if (only_changes_) broad_phase_->expect_only_changes();
    has_mesh_ = scene.has_kind(ShapeKind::mesh) || scene.has_kind(ShapeKind::voxels);
    if (own_costs_)
      own_costs_->begin_step(scene);
    else if (has_mesh_)
      costs_.begin_step(scene.indices());
    screens_ = !kept_ && options_.answer.request == Request::collide && scene.has_kind(ShapeKind::box);
    has_sphere_ = scene.has_kind(ShapeKind::sphere);
    found_.clear();
  }
  /// Must not be called after a step that ended early.
  void finish(ContactList& contacts, StepReport& report) {
    if (options_.own_broad_phase || options_.own_executor) require_canonical(options_, bodies(), contacts);
    if (incomplete_.load(std::memory_order_relaxed)) return finish_incomplete(contacts, report);
    boxes_.end_step();
    if (kept_) return put_together(contacts, report);
    report.colliding_pairs = found_.colliding_pairs.load(std::memory_order_relaxed);
    report.contacts = found_.contacts.load(std::memory_order_relaxed);
    report.gaps = found_.gaps.load(std::memory_order_relaxed);
    report.max_depth = found_.max_depth.load(std::memory_order_relaxed);
  }

  /// True if the broad phase need only report changes.
  bool begin_kept(ContactList& contacts) {
    try {
      return kept_->begin_step(*scene_, contacts, boxes_.changes_known() && !options_.predicate, limit_);
    } catch (const WorkStopped&) {
      abandon();
      return false;
    }
  }

  KeptContacts* kept() { return kept_.get(); }
  /// Discards what earlier steps recorded.
  void begin_anew() {
    boxes_.begin_anew();
    if (kept_) kept_->begin_anew();
  }

  const BroadPhase& broad_phase() const { return *broad_phase_; }
  /// Without the executor and the list.
  PipelineMemory memory() const {
    PipelineMemory memory;
    memory.bodies = boxes_.memory();
    memory.broad_phase = broad_phase_->memory();
    if (kept_) memory.kept_answers = kept_->memory();
    return memory;
  }

  void work_with(Crew* crew) override { crew_ = crew; }
  void ended_by(std::function<bool()> ended) override { limit_.ended = std::move(ended); }
  std::size_t begin() override {
    stages_ = 1 + broad_phase_->begin(boxes_.boxes());
    return stages_;
  }
  std::size_t blocks(std::size_t stage) const override {
    if (abandoned_.load(std::memory_order_relaxed)) return 0;
    if (stage == 0) return boxes_.blocks();
    return broad_phase_->blocks(stage - 1) + (stage + 1 == stages_ && has_restless() ? 1 : 0);
  }
  void run(std::size_t stage, std::size_t block) override {
    if (is_late()) return abandon();
    if (stage == 0)
      update_boxes(block);
    else
      broad_phase_->run(stage - 1, block);
  }
  void emit(std::size_t block, PairSink& sink) override {
    if (is_late()) return incomplete_.store(true, std::memory_order_relaxed);
    if (!has_restless()) return broad_phase_->emit(block, sink);
    if (block != 0) return broad_phase_->emit(block - 1, sink);
    for (const Pair pair : kept_->restless())
      if (kept_->both_rest(pair)) sink.put_allowed(pair);
  }
  const PairFilter& filter() const override { return only_changes_ ? changes_filter_ : filter_; }
  std::size_t bodies() const override { return boxes_.boxes().size(); }

  std::size_t keep(std::span<Pair> pairs) const override {
    const std::size_t kept = options_.predicate ? kept_by(options_.predicate, pairs, *scene_) : pairs.size();
    return has_sphere_ && together_ ? keep_near_spheres(pairs.first(kept)) : kept;
  }

  HeavyPairs heavy_first(std::span<Pair> pairs, std::chrono::nanoseconds batch) const override {
    if (own_costs_) return heavy_by_guess(pairs, batch);
    if (!has_mesh_) return {};
    const auto rest = std::partition(pairs.begin(), pairs.end(), [this](Pair pair) { return is_heavy(pair); });
    const auto heavy = std::partition(pairs.begin(), rest, [&](Pair pair) { return costs_.is_costliest(pair, batch); });
    return {static_cast<std::size_t>(heavy - pairs.begin()), static_cast<std::size_t>(rest - pairs.begin())};
  }
  void took(const Batch& batch, std::chrono::nanoseconds time) const override {
    const auto pairs = std::span(batch.pairs).first(batch.count);
    if (own_costs_) return own_costs_->took(pairs, time);
    const auto count = std::count_if(pairs.begin(), pairs.end(), [this](Pair pair) { return is_heavy(pair); });
    for (const Pair pair : pairs)
      if (is_heavy(pair)) costs_.learn(pair, time / count);
  }

  void narrow(Batch& batch) const override {
    const std::size_t before = batch.results.size();
    answer(batch);
    const auto fresh = std::span<const PairResult>(batch.results).subspan(before);
    if (options_.on_answers && !fresh.empty()) options_.on_answers(fresh, batch.contacts);
  }

 private:
  static constexpr std::size_t screened = 32;

  void answer(Batch& batch) const {
    if (is_late()) return leave_unfinished(batch);
    if (together_) return narrow_together(batch);
    std::optional<KeptContacts::Batch> kept;
    if (kept_) kept.emplace(*kept_, batch.results, batch.contacts);
    const std::size_t first_contact = batch.contacts.size();
    std::uint64_t colliding_pairs = 0;
    const auto pairs = std::span<const Pair>(batch.pairs).first(batch.count);
    std::array<std::uint8_t, screened> apart{};
    for (std::size_t i = 0; i < pairs.size(); ++i) {
      if (kept) i += kept->append_valid(pairs.subspan(i));
      if (i == pairs.size()) break;
      const Pair pair = pairs[i];
      if (screens_ && i % screened == 0) screen(pairs.subspan(i), apart);
      if (apart[i % screened] != 0) continue;
      // Pairs are sorted by their first body; only this prefetch makes the second one's data predictable.
      if (constexpr std::size_t ahead = 3; i + ahead < pairs.size()) {
        const char* pose = reinterpret_cast<const char*>(&scene_->poses()[pairs[i + ahead].b]);
        __builtin_prefetch(pose);
        __builtin_prefetch(pose + sizeof(Pose) - 1);
      }
      const auto first = static_cast<std::uint32_t>(batch.contacts.size());
      const bool may_move = kept && is_worth_moving(pair);
      PairResult* result;
      if (may_move) {
        result = &batch.results.emplace_back(PairResult{pair.a, pair.b, first, 0, {}});
        // The verdict of two meshes takes a tenth of the time of their contacts.
        const auto collide = [&] { return solve(pair, Request::collide, nullptr).collide; };
        if (!(are_meshes(pair) ? kept->extrapolate(pair, *result, collide) : kept->extrapolate(pair, *result))) {
          // A pair that touched will probably touch again; a lower bound on the gap helps only if it does not.
          result->answer =
              solve(pair, options_.answer.request, &batch.contacts, kept->touched() ? without_gaps_ : narrow_phase_);
          kept->store(*result, std::span(batch.contacts).subspan(first));
        }
      } else {
        result = &batch.results.emplace_back(InPlace{[&] {
          return PairResult{pair.a, pair.b, first, 0, solve(pair, options_.answer.request, &batch.contacts)};
        }});
      }
      const bool reported = complete_last(batch, colliding_pairs) || options_.answer.request == Request::distance;
      if (kept) kept->record(*result, std::span(batch.contacts).subspan(first), reported);
      if (!reported) batch.results.pop_back();
    }
    if (!kept) found_.add(colliding_pairs, std::span(batch.contacts).subspan(first_contact));
  }

  /// By the user's cost model: pairs so costly that a few of them, or one, fill a batch.
  HeavyPairs heavy_by_guess(std::span<Pair> pairs, std::chrono::nanoseconds batch) const {
    constexpr int few = 8;
    const auto costs = [this](std::chrono::nanoseconds most) {
      return [this, most](Pair pair) { return own_costs_->guess(pair) >= most; };
    };
    const auto rest = std::partition(pairs.begin(), pairs.end(), costs(std::max(batch, shortest_batch) / few));
    const auto heavy = std::partition(pairs.begin(), rest, costs(std::max(batch, shortest_batch)));
    return {static_cast<std::size_t>(heavy - pairs.begin()), static_cast<std::size_t>(rest - pairs.begin())};
  }

  bool is_late() const {
    using Clock = std::chrono::steady_clock;
    return limit_.deadline != Clock::time_point::max() && Clock::now() >= limit_.deadline;
  }

  /// A block of a stage before the last was not run: later stages depend on it and are skipped, too.
  void abandon() {
    abandoned_.store(true, std::memory_order_relaxed);
    incomplete_.store(true, std::memory_order_relaxed);
  }

  /// Past the deadline, pairs are reported as not finished.
  void leave_unfinished(Batch& batch) const {
    PairAnswer unfinished;
    unfinished.status = Status::stopped;
    unfinished.error_bound = std::numeric_limits<double>::infinity();
    const auto contacts = static_cast<std::uint32_t>(batch.contacts.size());
    for (const Pair pair : std::span(batch.pairs).first(batch.count))
      batch.results.push_back(PairResult{pair.a, pair.b, contacts, 0, unfinished});
    if (batch.count != 0) incomplete_.store(true, std::memory_order_relaxed);
  }

  /// The report of a step whose deadline passed: counts alone, without data for the next step's decisions.
  static void finish_incomplete(const ContactList& contacts, StepReport& report) {
    report.execution.issues |= bit(StepIssue::incomplete);
    for (const PairResult& pair : contacts.pairs) report.colliding_pairs += pair.answer.collide ? 1 : 0;
    for (const Contact& contact : contacts.contacts) {
      ++(contact.depth < 0 ? report.gaps : report.contacts);
      report.max_depth = std::max(report.max_depth, contact.depth);
    }
  }

  /// Leaves out pairs of spheres whose boxes overlap but which are separated: before pairs are sorted, and while their
  /// data is in the caches.
  std::size_t keep_near_spheres(std::span<Pair> pairs) const {
    constexpr std::size_t block = SeveralPairs::most_screened;
    const PlacedSphere* const all = boxes_.spheres().data();
    std::array<PlacedSpheres, block> spheres;
    std::size_t kept = 0;
    for (std::size_t first = 0; first < pairs.size(); first += block) {
      const auto some = pairs.subspan(first, std::min(block, pairs.size() - first));
      for (const Pair pair : pairs.subspan(first + some.size(), std::min(block, pairs.size() - first - some.size()))) {
        __builtin_prefetch(all + pair.a);
        __builtin_prefetch(all + pair.b);
      }
      for (std::size_t i = 0; i < some.size(); ++i) spheres[i] = {all + some[i].a, all + some[i].b};
      const std::uint32_t near = several_pairs_.near(std::span(spheres).first(some.size()));
      for (std::size_t i = 0; i < some.size(); ++i) {
        pairs[kept] = some[i];
        kept += near >> i & 1u;
      }
    }
    return kept;
  }

  /// Marks those of the first pairs that need no answer.
  void screen(std::span<const Pair> pairs, std::array<std::uint8_t, screened>& apart) const {
    const std::size_t count = std::min(pairs.size(), screened);
    std::array<PlacedPair, screened> posed;
    place(pairs.first(count), posed);
    narrow_phase_.mark_apart(std::span(posed).first(count), std::span(apart).first(count));
  }

  /// Counts the last result and the contacts that follow it; returns whether it is reported.
  bool complete_last(Batch& batch, std::uint64_t& colliding_pairs) const {
    PairResult& result = batch.results.back();
    result.contact_count = static_cast<std::uint32_t>(batch.contacts.size()) - result.first_contact;
    batch.inexact |= result.answer.status == Status::inexact;
    colliding_pairs += result.answer.collide ? 1 : 0;
    const bool stopped = result.answer.status == Status::stopped;
    if (stopped) incomplete_.store(true, std::memory_order_relaxed);
    return result.answer.collide || result.contact_count != 0 || stopped;
  }

  /// Appends answers to a batch if they are reported.
  class ReportedAnswers final : public AnswerSink {
   public:
    ReportedAnswers(const SceneWork& work, Batch& batch, const Pair* pairs)
        : work_(work), batch_(batch), pairs_(pairs) {}
    PairAnswer& begin(std::size_t pair) override {
      const auto [a, b] = pairs_[pair];
      PairResult& result = batch_.results.emplace_back();
      result.a = a;
      result.b = b;
      result.first_contact = static_cast<std::uint32_t>(batch_.contacts.size());
      return result.answer;
    }
    void end() override {
      if (!work_.complete_last(batch_, colliding_pairs_)) batch_.results.pop_back();
    }
    std::uint64_t colliding_pairs() const { return colliding_pairs_; }

   private:
    const SceneWork& work_;
    Batch& batch_;
    const Pair* pairs_;
    std::uint64_t colliding_pairs_ = 0;
  };

  /// Contacts of several pairs at a time, all computed.
  void narrow_together(Batch& batch) const {
    constexpr std::size_t most = 128;
    const std::size_t first_contact = batch.contacts.size();
    std::uint64_t colliding_pairs = 0;
    std::array<PlacedPair, most> placed;
    std::array<PlacedSpheres, most> spheres;
    for (auto left = std::span<const Pair>(batch.pairs).first(batch.count); !left.empty();) {
      const auto pairs = left.first(std::min(left.size(), most));
      const bool all_spheres = place_spheres(pairs, spheres);
      std::size_t done = 0;
      if (all_spheres) done = append_spheres(pairs, std::span(spheres).first(pairs.size()), batch, colliding_pairs);
      // After pairs that were solved together the next one is a pair that rounding decides, solved alone. If none were
      // (no kernel for this processor, or the first pair is such a one), all remaining pairs are solved one by one.
      const std::size_t next = done > 0 ? std::min(done + 1, pairs.size()) : pairs.size();
      if (done != next) {
        const auto others = pairs.subspan(done, next - done);
        place(others, placed);
        ReportedAnswers reported(*this, batch, others.data());
        several_pairs_.solve(std::span(placed).first(others.size()), batch.contacts, reported,
                             std::span(spheres).subspan(done, others.size()));
        colliding_pairs += reported.colliding_pairs();
      }
      left = left.subspan(next);
    }
    found_.add(colliding_pairs, std::span(batch.contacts).subspan(first_contact));
  }

  /// Answers the leading pairs of spheres that can be solved together; returns their number.
  std::size_t append_spheres(std::span<const Pair> pairs, std::span<const PlacedSpheres> spheres, Batch& batch,
                             std::uint64_t& colliding_pairs) const {
    const std::size_t first = batch.results.size(), first_contact = batch.contacts.size();
    // Copies of one value: compilers call a function for each constructor.
    batch.results.resize(first + pairs.size(), PairResult{});
    batch.contacts.resize(first_contact + pairs.size(), Contact{Vec3::Zero(), Vec3::Zero()});
    std::array<std::uint32_t, 128> numbers;
    const SpheresSolved solved = several_pairs_.solve_spheres(
        spheres, {&batch.results[first].answer, sizeof(PairResult), &batch.contacts[first_contact], numbers.data()});
    batch.results.resize(first + solved.answers);
    batch.contacts.resize(first_contact + solved.answers);
    for (std::size_t k = 0; k < solved.answers; ++k) {
      PairResult& result = batch.results[first + k];
      result.a = pairs[numbers[k]].a;
      result.b = pairs[numbers[k]].b;
      result.first_contact = static_cast<std::uint32_t>(first_contact + k);
      result.contact_count = 1;
      colliding_pairs += result.answer.collide ? 1 : 0;
    }
    return solved.pairs;
  }

  void place(std::span<const Pair> pairs, std::span<PlacedPair> placed) const {
    const auto poses = scene_->poses();
    for (std::size_t i = 0; i < pairs.size(); ++i)
      placed[i] = {&scene_->shape_of(pairs[i].a), &poses[pairs[i].a], &scene_->shape_of(pairs[i].b),
                   &poses[pairs[i].b]};
  }

  /// True if all are pairs of spheres.
  bool place_spheres(std::span<const Pair> pairs, std::span<PlacedSpheres> spheres) const {
    // Pairs are sorted by their first body; the second one lies anywhere.
    const PlacedSphere* const placed = boxes_.spheres().data();
    for (const Pair pair : pairs) __builtin_prefetch(placed + pair.b);
    bool all = true;
    const auto sphere = [&](std::uint32_t body) {
      const bool is_one = is_sphere(placed[body]);
      all &= is_one;
      return is_one ? placed + body : nullptr;
    };
    for (std::size_t i = 0; i < pairs.size(); ++i) spheres[i] = {sphere(pairs[i].a), sphere(pairs[i].b)};
    return all;
  }

  NarrowPhaseOptions narrow_options(bool mesh_gaps) {
    return {.tolerance = options_.answer.tolerance,
            .margin = options_.answer.margin,
            .solver = {},
            .parts = [this](std::size_t parts, const auto& part) { share(parts, part); },
            .mesh_gaps = mesh_gaps && options_.answer.keep_contacts != 0,
            .mesh_bounds = false,
            .mesh_margin = options_.answer.mesh_margin,
            .limit = &limit_};
  }

  void share(std::size_t parts, const std::function<void(std::size_t)>& part) const {
    if (crew_ != nullptr) return crew_->share(parts, part);
    for (std::size_t i = 0; i < parts; ++i) part(i);
  }

  /// A mesh with another solid takes up to a thousand times as long as two spheres; with a half-space it does not.
  bool is_heavy(Pair pair) const {
    const Shape &a = scene_->shape_of(pair.a), &b = scene_->shape_of(pair.b);
    return !(a.is_convex() && b.is_convex()) && a.is_bounded() && b.is_bounded();
  }

  bool are_meshes(Pair pair) const {
    return scene_->shape_of(pair.a).kind() == ShapeKind::mesh && scene_->shape_of(pair.b).kind() == ShapeKind::mesh;
  }

  PairAnswer solve(Pair pair, Request request, std::vector<Contact>* contacts) const {
    return solve(pair, request, contacts, narrow_phase_);
  }
  PairAnswer solve(Pair pair, Request request, std::vector<Contact>* contacts, const NarrowPhase& with) const {
    const auto poses = scene_->poses();
    return with.solve(scene_->shape_of(pair.a), poses[pair.a], scene_->shape_of(pair.b), poses[pair.b], request,
                      request == Request::contacts ? contacts : nullptr);
  }

  bool is_worth_moving(Pair pair) const {
    return worth_moving_[static_cast<std::size_t>(scene_->shape_of(pair.a).kind())]
                        [static_cast<std::size_t>(scene_->shape_of(pair.b).kind())];
  }

  /// The step's stop or deadline can end the building of a mesh's hull.
  void update_boxes(std::size_t block) {
    try {
      boxes_.update(block);
    } catch (const WorkStopped&) {
      abandon();
    }
  }

  bool has_restless() const { return only_changes_ && !kept_->restless().empty(); }

  void put_together(ContactList& contacts, StepReport& report) {
    const auto begin = std::chrono::steady_clock::now();
    kept_->end_step(contacts);
    const KeptContacts::Counts counts = kept_->counts();
    report.colliding_pairs = counts.colliding_pairs;
    report.contacts = counts.touching;
    report.gaps = counts.gaps;
    report.max_depth = counts.max_depth;
    report.kept_error_bound = counts.error_bound;
    ExecutionReport& execution = report.execution;
    if (only_changes_) execution.candidate_pairs = counts.candidates;
    report.computed_pairs = counts.computed_pairs;
    report.kept_pairs = counts.candidates - counts.computed_pairs;
    if (counts.inexact != 0) execution.issues |= bit(StepIssue::inexact);
    const double ms = std::chrono::duration<double, std::milli>(std::chrono::steady_clock::now() - begin).count();
    for (double* time : {&execution.detect_ms, &execution.join_ms, &execution.busy_ms}) *time += ms;
    if (execution.form != StepForm::caller) execution.serial.join += ms;
  }

  /// Sums over the batches; the order of additions does not affect them.
  struct Found {
    alignas(64) std::atomic<std::uint64_t> colliding_pairs{0};
    std::atomic<std::uint64_t> contacts{0}, gaps{0};
    std::atomic<double> max_depth{0};

    void clear() {
      for (auto* count : {&colliding_pairs, &contacts, &gaps}) count->store(0, std::memory_order_relaxed);
      max_depth.store(0, std::memory_order_relaxed);
    }
    void add(std::uint64_t pairs, std::span<const Contact> fresh) {
      std::uint64_t touching = 0;
      double deepest = 0;
      for (const Contact& contact : fresh) {
        touching += contact.depth < 0 ? 0 : 1;
        deepest = std::max(deepest, contact.depth);
      }
      colliding_pairs.fetch_add(pairs, std::memory_order_relaxed);
      contacts.fetch_add(touching, std::memory_order_relaxed);
      gaps.fetch_add(fresh.size() - touching, std::memory_order_relaxed);
      double known = max_depth.load(std::memory_order_relaxed);
      while (known < deepest && !max_depth.compare_exchange_weak(known, deepest, std::memory_order_relaxed)) {
      }
    }
  };

  PipelineOptions options_;
  WorkLimit limit_;  // of the current step
  NarrowPhase narrow_phase_;
  NarrowPhase without_gaps_;  // between meshes
  SeveralPairs several_pairs_;
  std::unique_ptr<BroadPhase> broad_phase_;
  std::unique_ptr<CostModel> own_costs_;  // null: costs_
  std::unique_ptr<KeptContacts> kept_;    // null: every answer is computed
  bool together_;                         // contacts are computed for several pairs at a time
  BodyBoxes boxes_;
  bool worth_moving_[shape_kinds][shape_kinds] = {};
  const Scene* scene_ = nullptr;
  Crew* crew_ = nullptr;  // of the current step
  PairFilter filter_;
  // Among pairs with unchanged boxes only those that the last step's answers name are solved again.
  bool only_changes_ = false;
  PairFilter changes_filter_;
  std::size_t stages_ = 0;
  bool has_mesh_ = false, has_sphere_ = false;  // has_mesh_: or voxels
  bool screens_ = false;                        // separated pairs are excluded several at a time
  mutable Found found_;                         // of the current step
  mutable std::atomic<bool> incomplete_{false};
  std::atomic<bool> abandoned_{false};  // the boxes, or the broad phase's data, are incomplete
  mutable PairCosts costs_;             // if there are meshes
};

}  // namespace

struct Pipeline::Impl {
  explicit Impl(PipelineOptions wanted)
      : options(checked(std::move(wanted))), work(options), executor(executor_of(options)) {}

  PipelineOptions options;
  SceneWork work;
  std::unique_ptr<Executor> executor;
  ContactList contacts;
  Timeline* timeline = nullptr;
  std::uint64_t step = 0;
};

Pipeline::Pipeline(PipelineOptions options) : impl_(std::make_unique<Impl>(std::move(options))) {}
Pipeline::~Pipeline() = default;
Pipeline::Pipeline(Pipeline&&) noexcept = default;
Pipeline& Pipeline::operator=(Pipeline&&) noexcept = default;

StepReport Pipeline::step(const Scene& scene, std::stop_token stop, std::chrono::steady_clock::time_point deadline) {
  Impl& impl = *impl_;
  StepReport report;
  report.step = impl.step++;
  report.bodies = scene.bodies();
  impl.work.read_scene(scene, impl.contacts, stop, deadline);
  impl.executor->run(impl.work, impl.contacts, report.execution, std::move(stop), impl.timeline);
  if ((report.execution.issues & bit(StepIssue::ended_early)) == 0) impl.work.finish(impl.contacts, report);
  report.broad_phase = impl.work.broad_phase().kind();
  report.broad_phase_reason = impl.work.broad_phase().reason();
  if (impl.options.answer.contact_hash) report.contact_hash = hash(impl.contacts);
  return report;
}

const ContactList& Pipeline::contacts() const { return impl_->contacts; }
PipelineMemory Pipeline::memory() const {
  PipelineMemory memory = impl_->work.memory();
  memory.executor = impl_->executor->memory();
  memory.contacts =
      impl_->contacts.pairs.capacity() * sizeof(PairResult) + impl_->contacts.contacts.capacity() * sizeof(Contact);
  return memory;
}
const PipelineOptions& Pipeline::options() const { return impl_->options; }
void Pipeline::record_to(Timeline* timeline) { impl_->timeline = timeline; }

bool KeptHandover::keeps() const { return pipeline_.impl_->work.kept() != nullptr; }
std::optional<KeptRest> KeptHandover::rest(const Scene& scene, std::uint32_t body) const {
  return pipeline_.impl_->work.kept()->rest(scene, body);
}
std::vector<KeptRecord> KeptHandover::leaving(const std::function<bool(Pair)>& leaves) const {
  return pipeline_.impl_->work.kept()->leaving(pipeline_.impl_->contacts, leaves);
}
void KeptHandover::take_in(const Scene& scene, std::span<const KeptBody> bodies, std::vector<KeptRecord> pairs) {
  pipeline_.impl_->work.kept()->take_in(scene, pipeline_.impl_->contacts, bodies, std::move(pairs));
}
void KeptHandover::begin_anew() { pipeline_.impl_->work.begin_anew(); }

}  // namespace tandem
