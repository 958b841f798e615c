#include "tandem/engine/pipeline.h"

#include <algorithm>
#include <cmath>
#include <stdexcept>
#include <string>

#include "tandem/flowgraph/executor.h"

namespace tandem {
namespace {

/// A step of a scene as stages of blocks: boxes, the broad phase's stages, and the dispatcher for each pair.
class SceneWork final : public StepWork {
 public:
  explicit SceneWork(const PipelineOptions& options)
      : options_(options),
        narrow_phase_({.tolerance = options.tolerance, .margin = options.margin, .solver = {}}),
        broad_phase_(make_broad_phase(options.broad_phase)) {}

  void look_at(const Scene& scene) {
    scene_ = &scene;
    filter_ = {scene.groups(), scene.masks(), scene.is_static()};
    boxes_.resize(scene.indices());
    broad_phase_->expect(filter_);
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

  void narrow(Batch& batch) const override {
    const Scene& scene = *scene_;
    const auto poses = scene.poses();
    const bool contacts = options_.request == Request::contacts;
    for (const Pair pair : std::span(batch.pairs).first(batch.count)) {
      PairResult result{pair.a, pair.b, static_cast<std::uint32_t>(batch.contacts.size()), 0, {}};
      result.answer = narrow_phase_.solve(scene.shape_of(pair.a), poses[pair.a], scene.shape_of(pair.b), poses[pair.b],
                                          options_.request, contacts ? &batch.contacts : nullptr);
      result.contact_count = static_cast<std::uint32_t>(batch.contacts.size()) - result.first_contact;
      batch.inexact |= result.answer.status == Status::inexact;
      if (result.answer.collide || result.contact_count != 0 || options_.request == Request::distance)
        batch.results.push_back(result);
    }
  }

 private:
  static constexpr std::size_t bodies_a_block = 256;

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
  const Scene* scene_ = nullptr;
  PairFilter filter_;
  BoxArray boxes_;
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
