#pragma once

#include "backends/gl/context.hpp"
#include "backends/shared/elastic_device.hpp"

#include <memory>
#include <optional>
#include <utility>

namespace hdmbench::gl {

/// An ElasticDevice over `Steps`, a class with its functions that owns OpenGL objects: makes the context
/// current around them, and around the construction of Steps from Api and the arguments and its destruction.
template <typename Steps>
class ContextElastic final : public ElasticDevice {
public:
  template <typename... Arguments>
  explicit ContextElastic(std::unique_ptr<Context> context, Arguments... arguments)
      : context_(std::move(context)) {
    const Context::Current current(*context_);
    steps_.emplace(context_->api(), arguments...);
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
    const Context::Current current(*context_);
    steps_->load(hierarchy, layout);
  }
  void write(ElasticArray to, const VectorField& values) override {
    const Context::Current current(*context_);
    steps_->write(to, values);
  }
  void read(ElasticArray from, VectorField& values) override {
    const Context::Current current(*context_);
    steps_->read(from, values);
  }
  float read_sum(ElasticArray from) override {
    const Context::Current current(*context_);
    return steps_->read_sum(from);
  }
  void run(std::span<const ElasticWork> work) override {
    const Context::Current current(*context_);
    for (const ElasticWork& piece : work) {
      steps_->run(std::get<ElasticCall>(piece));
    }
  }

private:
  std::unique_ptr<Context> context_;
  std::optional<Steps> steps_;
};

} // namespace hdmbench::gl
