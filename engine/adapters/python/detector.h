// A pipeline with a timeline, as Python sees it.
#pragma once
#include <memory>

#include "shared_use.h"
#include "tandem/engine/pipeline.h"
#include "tandem/flowgraph/timeline.h"

namespace tandem::python {

/// A pipeline with the timeline that it records to.
struct Detector {
  explicit Detector(PipelineOptions options) : pipeline(std::move(options)) {}

  std::unique_ptr<Timeline> timeline;
  Pipeline pipeline;
};
using SharedPipeline = SharedUse<Detector>;

}  // namespace tandem::python
