#pragma once

#include "backends/gl/context.hpp"

#include <memory>
#include <optional>
#include <string>
#include <type_traits>

namespace hdmbench::gl {

/// A Session over `Sweep`, a class with load, write, step, read and changed that owns OpenGL objects: makes
/// the context current around every call, and around the Sweep's construction and destruction. Sweeps that
/// can are constructed with the Work, and have load_pyramid and solve.
template <typename Sweep>
class ContextSession : public Session {
public:
  ContextSession(std::unique_ptr<Context> context, Work work) : context_(std::move(context)) {
    const Context::Current current(*context_);
    if constexpr (std::is_constructible_v<Sweep, const Api&, Work>) {
      sweep_.emplace(context_->api(), work);
    } else {
      sweep_.emplace(context_->api());
    }
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

protected:
  std::unique_ptr<Context> context_;
  std::optional<Sweep> sweep_;
};

/// Of a Sweep that also has load_pyramid and solve.
template <typename Sweep>
class SolvingContextSession final : public ContextSession<Sweep> {
public:
  using ContextSession<Sweep>::ContextSession;

private:
  void do_load_pyramid(const Pyramid& pyramid) override {
    const Context::Current current(*this->context_);
    this->sweep_->load_pyramid(pyramid);
  }
  void do_solve(const Session::Advance& advance) override {
    const Context::Current current(*this->context_);
    this->sweep_->solve(advance);
  }
};

template <typename Sweep>
concept SolvesPyramids = requires(Sweep& sweep, const Pyramid& pyramid, const Session::Advance& advance) {
  sweep.load_pyramid(pyramid);
  sweep.solve(advance);
};

/// A Backend whose sessions are ContextSession<Sweep> on the contexts of a platform.
template <typename Sweep>
class ContextBackend final : public Backend {
public:
  ContextBackend(std::string_view name, std::string_view description, std::unique_ptr<Platform> platform,
                 Version version)
      : name_(name), description_(description), platform_(std::move(platform)), version_(version) {}

  std::string_view name() const override { return name_; }
  std::string_view description() const override { return description_; }
  std::vector<Device> devices() const override { return platform_->devices(version_); }

private:
  std::unique_ptr<Session> do_open(std::size_t index, const SessionOptions& options) const override {
    using Made =
        std::conditional_t<SolvesPyramids<Sweep>, SolvingContextSession<Sweep>, ContextSession<Sweep>>;
    return std::make_unique<Made>(platform_->open(index, version_), options.work);
  }

  std::string name_;
  std::string description_;
  std::unique_ptr<Platform> platform_;
  Version version_;
};

} // namespace hdmbench::gl
