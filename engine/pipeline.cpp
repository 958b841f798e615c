#include "tandem/engine/pipeline.h"

#include <algorithm>
#include <cmath>
#include <optional>
#include <stdexcept>
#include <string>

#include "kept_contacts.h"
#include "tandem/flowgraph/executor.h"

namespace tandem {
namespace {

/// A step of a scene as stages of blocks: boxes, the broad phase's stages, and the dispatcher for each pair.
class SceneWork final : public StepWork {
 public:
  explicit SceneWork(const PipelineOptions& options)
      : options_(options),
        narrow_phase_({.tolerance = options.tolerance, .margin = options.margin, .solver = {}}),
        broad_phase_(make_broad_phase(options.broad_phase)) {
    if (!(options.keep_contacts >= 0 && options.keep_contacts <= 0.1))
      throw std::invalid_argument("keep_contacts: " + std::to_string(options.keep_contacts) + " is not in [0, 0.1]");
    if (options.keep_contacts == 0 || options.request == Request::collide) return;
    kept_ = std::make_unique<KeptContacts>(options.request, options.keep_contacts, options.margin);
    for (std::size_t a = 0; a < shape_kinds; ++a)
      for (std::size_t b = 0; b < shape_kinds; ++b) {
        const auto kind_a = static_cast<ShapeKind>(a), kind_b = static_cast<ShapeKind>(b);
        worth_keeping_[a][b] = narrow_phase_.solver_for(kind_a, kind_b, options.request).solver != "closed";
      }
  }

  void look_at(const Scene& scene) {
    scene_ = &scene;
    filter_ = {scene.groups(), scene.masks(), scene.is_static()};
    boxes_.resize(scene.indices());
    broad_phase_->expect(filter_);
    has_mesh_ = std::any_of(scene.shapes().begin(), scene.shapes().end(),
                            [](const Shape& shape) { return shape.kind() == ShapeKind::mesh; });
    if (kept_) kept_->begin_step(scene);
  }
  /// Not to be called after a step that ended early.
  void finish(StepReport& report) {
    if (!kept_) return;
    kept_->end_step();
    const KeptContacts::Counts counts = kept_->counts();
    report.kept_pairs = counts.kept_pairs;
    report.computed_pairs = report.execution.candidate_pairs - counts.kept_pairs;
    report.kept_error_bound = counts.error_bound;
  }

  const BroadPhase& broad_phase() const { return *broad_phase_; }

  std::size_t begin() override { return 1 + broad_phase_->begin(boxes_); }
  std::size_t blocks(std::size_t stage) const override {
    return stage == 0 ? (boxes_.size() + bodies_a_block - 1) / bodies_a_block : broad_phase_->blocks(stage - 1);
  }
  void run(std::size_t stage, std::size_t block) override {
    if (stage == 0)
      update(block);
    else
      broad_phase_->run(stage - 1, block);
  }
  void emit(std::size_t block, PairSink& sink) override { broad_phase_->emit(block, sink); }
  const PairFilter& filter() const override { return filter_; }
  std::size_t bodies() const override { return boxes_.size(); }

  std::size_t keep(std::span<Pair> pairs) const override {
    if (!options_.predicate) return pairs.size();
    const std::size_t kept = options_.predicate(pairs);
    if (kept > pairs.size())
      throw std::out_of_range("predicate: kept " + std::to_string(kept) + " pairs of " + std::to_string(pairs.size()));
    return kept;
  }

  std::size_t heavy_first(std::span<Pair> pairs) const override {
    if (!has_mesh_) return 0;
    // A mesh with another solid takes up to a thousand times as long as two spheres; with a half-space it does not.
    const auto heavy = [this](Pair pair) {
      const ShapeKind a = scene_->shape_of(pair.a).kind(), b = scene_->shape_of(pair.b).kind();
      return (a == ShapeKind::mesh || b == ShapeKind::mesh) && a != ShapeKind::halfspace && b != ShapeKind::halfspace;
    };
    return static_cast<std::size_t>(std::partition(pairs.begin(), pairs.end(), heavy) - pairs.begin());
  }

  void narrow(Batch& batch) const override {
    std::optional<KeptContacts::Batch> kept;
    if (kept_) kept.emplace(*kept_);
    const auto pairs = std::span<const Pair>(batch.pairs).first(batch.count);
    for (std::size_t i = 0; i < pairs.size(); ++i) {
      const Pair pair = pairs[i];
      if (kept) kept->look_ahead(pairs.subspan(i));
      PairResult result{pair.a, pair.b, static_cast<std::uint32_t>(batch.contacts.size()), 0, {}};
      if (kept && is_worth_keeping(pair)) {
        if (!kept->find(pair, result, batch.contacts)) {
          solve(pair, result, batch);
          kept->keep(result, std::span(batch.contacts).subspan(result.first_contact));
        }
      } else {
        solve(pair, result, batch);
      }
      result.contact_count = static_cast<std::uint32_t>(batch.contacts.size()) - result.first_contact;
      batch.inexact |= result.answer.status == Status::inexact;
      if (result.answer.collide || result.contact_count != 0 || options_.request == Request::distance)
        batch.results.push_back(result);
    }
  }

 private:
  static constexpr std::size_t bodies_a_block = 64;

  void solve(Pair pair, PairResult& result, Batch& batch) const {
    const auto poses = scene_->poses();
    result.answer =
        narrow_phase_.solve(scene_->shape_of(pair.a), poses[pair.a], scene_->shape_of(pair.b), poses[pair.b],
                            options_.request, options_.request == Request::contacts ? &batch.contacts : nullptr);
  }

  bool is_worth_keeping(Pair pair) const {
    return worth_keeping_[static_cast<std::size_t>(scene_->shape_of(pair.a).kind())]
                         [static_cast<std::size_t>(scene_->shape_of(pair.b).kind())];
  }

  void update(std::size_t block) {
    // Half the margin on each side: two boxes meet when the gap between their bodies is within the margin.
    const double grow = 0.5 * options_.margin;
    const auto poses = scene_->poses();
    for (std::size_t i = block * bodies_a_block, end = std::min(boxes_.size(), i + bodies_a_block); i < end; ++i) {
      const auto index = static_cast<std::uint32_t>(i);
      if (!scene_->alive(index)) {
        boxes_.set_empty(i);
        continue;
      }
      const Bounds bounds = scene_->shape_of(index).bounds(poses[i]);
      Aabb box;
      for (std::size_t k = 0; k < 3; ++k) {
        box.lo[k] = round_down(bounds.lo[static_cast<Eigen::Index>(k)] - grow);
        box.hi[k] = round_up(bounds.hi[static_cast<Eigen::Index>(k)] + grow);
      }
      boxes_.set(i, box);
    }
  }

  PipelineOptions options_;
  NarrowPhase narrow_phase_;
  std::unique_ptr<BroadPhase> broad_phase_;
  std::unique_ptr<KeptContacts> kept_;  // null: every answer is computed
  bool worth_keeping_[shape_kinds][shape_kinds] = {};
  const Scene* scene_ = nullptr;
  PairFilter filter_;
  BoxArray boxes_;
  bool has_mesh_ = false;
};

}  // namespace

struct Pipeline::Impl {
  explicit Impl(PipelineOptions wanted)
      : options(std::move(wanted)),
        work(options),
        executor(make_executor({.kind = options.executor,
                                .threads = options.threads,
                                .split = options.split,
                                .balance = options.balance,
                                .strict_split = options.strict_split,
                                .batch_pairs = options.batch_pairs,
                                .queue_capacity = options.queue_capacity,
                                .small_step_ms = options.small_step_ms})) {}

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

StepReport Pipeline::step(const Scene& scene, std::stop_token stop) {
  Impl& impl = *impl_;
  StepReport report;
  report.step = impl.step++;
  report.bodies = scene.bodies();
  impl.work.look_at(scene);
  impl.executor->run(impl.work, impl.contacts, report.execution, std::move(stop), impl.timeline);
  if ((report.execution.issues & bit(StepIssue::ended_early)) == 0) impl.work.finish(report);
  for (const PairResult& pair : impl.contacts.pairs) report.colliding_pairs += pair.answer.collide ? 1 : 0;
  for (const Contact& contact : impl.contacts.contacts) {
    report.max_depth = std::max(report.max_depth, contact.depth);
    ++(contact.depth < 0 ? report.gaps : report.contacts);
  }
  report.broad_phase = impl.work.broad_phase().kind();
  report.broad_phase_reason = impl.work.broad_phase().reason();
  if (impl.options.contact_hash) report.contact_hash = hash(impl.contacts);
  return report;
}

const ContactList& Pipeline::contacts() const { return impl_->contacts; }
const PipelineOptions& Pipeline::options() const { return impl_->options; }
void Pipeline::record_to(Timeline* timeline) { impl_->timeline = timeline; }

}  // namespace tandem
