#pragma once

#include "backends/backend.hpp"

#include <functional>
#include <ostream>
#include <string>

namespace hdmbench::test {

/// Mistakes a backend could make, planted between the caller and a sound session.
struct Fault {
  std::string name;
  std::function<void(Level&)> in_level{};                    ///< spoils what load() uploads
  std::function<void(VectorField&)> in_write{};              ///< spoils what write() uploads
  std::function<int(int)> in_step = [](int n) { return n; }; ///< sweeps really done
  std::function<void(VectorField&)> in_read{};               ///< spoils what read() returns
  std::function<std::int64_t(std::int64_t)> in_changed{};    ///< spoils the count
  bool one_write_behind = false; ///< uploads what the call before should have uploaded

  friend void PrintTo(const Fault& fault, std::ostream* stream) { *stream << fault.name; }
};

class FaultySession final : public Session {
public:
  FaultySession(std::unique_ptr<Session> sound, Fault fault)
      : sound_(std::move(sound)), fault_(std::move(fault)) {}

private:
  void do_load(const Level& level) override {
    Level spoilt = level;
    if (fault_.in_level) {
      fault_.in_level(spoilt);
    }
    sound_->load(spoilt);
  }
  void do_write(const VectorField& displacement) override {
    VectorField spoilt = displacement;
    if (fault_.in_write) {
      fault_.in_write(spoilt);
    }
    if (fault_.one_write_behind && write_before_.extent == spoilt.extent) {
      std::swap(spoilt, write_before_);
    } else {
      write_before_ = spoilt;
    }
    sound_->write(spoilt);
  }
  void do_step(int /*first*/, int sweeps) override { sound_->step(fault_.in_step(sweeps)); }
  void do_read(VectorField& displacement) override {
    sound_->read(displacement);
    if (fault_.in_read) {
      fault_.in_read(displacement);
    }
  }
  std::int64_t do_changed() override {
    const std::int64_t changed = sound_->changed();
    return fault_.in_changed ? fault_.in_changed(changed) : changed;
  }

  std::unique_ptr<Session> sound_;
  Fault fault_;
  VectorField write_before_;
};

class FaultyBackend final : public Backend {
public:
  FaultyBackend(const Backend& sound, Fault fault) : sound_(sound), fault_(std::move(fault)) {}
  std::string_view name() const override { return fault_.name; }
  std::string_view description() const override { return "planted fault"; }
  std::vector<Device> devices() const override { return sound_.devices(); }

private:
  std::unique_ptr<Session> do_open(std::size_t /*index*/, const SessionOptions& options) const override {
    return std::make_unique<FaultySession>(sound_.open(options), fault_);
  }

  const Backend& sound_;
  Fault fault_;
};

} // namespace hdmbench::test
