#pragma once

#include "backends/gl/context.hpp"
#include "backends/shared/elastic_device.hpp"

#include <memory>
#include <optional>
#include <utility>
#include <vector>

namespace hdmbench::gl {

/// An ElasticDevice over `Steps`, a class with its functions that owns OpenGL objects: makes the context
/// current around them, and around the construction of Steps from Api and its destruction. Steps of a level
/// are kept until something is read, as making a context current takes longer than a small level.
template <typename Steps>
class ContextElastic final : public ElasticDevice {
public:
  explicit ContextElastic(std::unique_ptr<Context> context) : context_(std::move(context)) {
    const Context::Current current(*context_);
    steps_.emplace(context_->api());
  }
  ContextElastic(const ContextElastic&) = delete;
  ContextElastic& operator=(const ContextElastic&) = delete;
  ~ContextElastic() override {
    try {
      const Context::Current current(*context_);
      // An error may have left drawing behind, and OSMesa does not wait for it when a context goes.
      context_->api().quietly(context_->api().Finish);
      steps_.reset();
    } catch (const DeviceError&) {
      context_->abandon();
    }
  }

  int block() const override { return Steps::block; }
  void load(const ElasticHierarchy& hierarchy, const ElasticLayout& layout) override {
    calls_.clear();
    const Context::Current current(*context_);
    steps_->load(hierarchy, layout);
  }
  void write(ElasticArray to, const VectorField& values) override {
    const Context::Current current(*context_);
    run_all();
    steps_->write(to, values);
  }
  void read(ElasticArray from, VectorField& values) override {
    const Context::Current current(*context_);
    run_all();
    steps_->read(from, values);
  }
  float read_sum(ElasticArray from) override {
    const Context::Current current(*context_);
    run_all();
    return steps_->read_sum(from);
  }
  void run(const ElasticCall& call) override {
    constexpr std::size_t most = 1024;
    calls_.push_back(call);
    if (calls_.size() == most) {
      const Context::Current current(*context_);
      run_all();
    }
  }

private:
  void run_all() {
    for (const ElasticCall& call : std::exchange(calls_, {})) {
      steps_->run(call);
    }
  }

  std::unique_ptr<Context> context_;
  std::optional<Steps> steps_;
  std::vector<ElasticCall> calls_;
};

} // namespace hdmbench::gl
