#pragma once

#include "backends/gl/context.hpp"
#include "backends/shared/arithmetic.hpp"
#include "backends/shared/driver_trial.hpp"
#include "backends/shared/elastic_device.hpp"

#include <memory>
#include <optional>
#include <string>

namespace hdmbench::gl {

/// A Session over `Sweep`, a class with load, write, step, read and changed that owns OpenGL objects: makes
/// the context current around every call, and around the Sweep's construction from Api and Work and its
/// destruction.
template <typename Sweep>
class ContextSession final : public Session {
public:
  ContextSession(std::unique_ptr<Context> context, Work work) : context_(std::move(context)) {
    const Context::Current current(*context_);
    sweep_.emplace(context_->api(), work);
  }
  ContextSession(const ContextSession&) = delete;
  ContextSession& operator=(const ContextSession&) = delete;
  ~ContextSession() override {
    try {
      const Context::Current current(*context_);
      // An error may have left drawing behind, and OSMesa does not wait for it when a context goes.
      context_->api().quietly(context_->api().Finish);
      sweep_.reset();
    } catch (const DeviceError&) {
      context_->abandon();
    }
  }

private:
  void do_load(const Level& level) override {
    const Context::Current current(*context_);
    sweep_->load(level);
  }
  void do_write(const VectorField& displacement) override {
    const Context::Current current(*context_);
    sweep_->write(displacement);
  }
  void do_step(int first, int sweeps) override {
    const Context::Current current(*context_);
    sweep_->step(first, sweeps);
  }
  void do_read(VectorField& displacement) override {
    const Context::Current current(*context_);
    sweep_->read(displacement);
  }
  std::int64_t do_changed() override {
    const Context::Current current(*context_);
    return sweep_->changed();
  }
  void do_load_pyramid(const Pyramid& pyramid) override {
    const Context::Current current(*context_);
    sweep_->load(pyramid);
  }
  void do_solve(const Advance& advance) override {
    const Context::Current current(*context_);
    sweep_->solve(advance);
  }

  std::unique_ptr<Context> context_;
  std::optional<Sweep> sweep_;
};

/// A Backend whose sessions are ContextSession<Sweep> on the contexts of a platform. Sweep declares
/// bytes_per_update(kind) and ceilings(api), language and evaluate(api, cases) for Backend's functions of
/// these names, and elastic(context).
template <typename Sweep>
class ContextBackend final : public Backend, public ArithmeticProgram {
public:
  ContextBackend(std::string_view name, std::string_view description, std::unique_ptr<Platform> platform,
                 Version version)
      : name_(name), description_(description), platform_(std::move(platform)), version_(version) {}

  std::string_view name() const override { return name_; }
  std::string_view description() const override { return description_; }
  std::vector<Device> devices() const override {
    require_answer(name_);
    return platform_->devices(version_);
  }
  double bytes_per_update(SiteKind kind, int /*sweeps*/) const override {
    return Sweep::bytes_per_update(kind);
  }
  bool has_elastic() const override { return true; }
  std::string_view language() const override { return Sweep::language; }
  std::vector<float> evaluate(std::size_t device, std::span<const ArithmeticCase> cases) const override {
    const std::unique_ptr<Context> context = platform_->open(device, version_);
    const Context::Current current(*context);
    return Sweep::evaluate(context->api(), cases);
  }

private:
  std::unique_ptr<ElasticSession> do_open_elastic(std::size_t index,
                                                  const SessionOptions& /*options*/) const override {
    return make_elastic_session(name_, Sweep::elastic(platform_->open(index, version_)));
  }
  std::unique_ptr<Session> do_open(std::size_t index, const SessionOptions& options) const override {
    return std::make_unique<ContextSession<Sweep>>(platform_->open(index, version_), options.work);
  }
  std::optional<Ceilings> do_measure_ceilings(std::size_t index,
                                              const SessionOptions& /*options*/) const override {
    const std::unique_ptr<Context> context = platform_->open(index, version_);
    const Context::Current current(*context);
    return Sweep::ceilings(context->api());
  }

  std::string name_;
  std::string description_;
  std::unique_ptr<Platform> platform_;
  Version version_;
};

} // namespace hdmbench::gl
