#include "harness/faults/faulty_backend.hpp"

namespace hdmbench::faults {

namespace {

class FaultySession final : public Session {
public:
  FaultySession(std::unique_ptr<Session> sound, Fault fault, const Scene* scene)
      : sound_(std::move(sound)), fault_(std::move(fault)), scene_(scene) {}

private:
  void do_load(const Level& level) override {
    Level spoilt = level;
    if (fault_.in_level) {
      fault_.in_level(spoilt);
    }
    if (fault_.in_pyramid && scene_ != nullptr) {
      fault_.in_pyramid(spoilt, *scene_);
    }
    sound_->load(spoilt);
    begins_ = true;
  }

  void do_write(const VectorField& displacement) override {
    VectorField spoilt = displacement;
    if (begins_ && fault_.in_begin && last_read_.extent != Extent{}) {
      fault_.in_begin(spoilt, last_read_);
    }
    begins_ = false;
    if (fault_.in_write) {
      fault_.in_write(spoilt);
    }
    sound_->write(spoilt);
    before_ = spoilt;
  }

  void do_step(int /*first*/, int sweeps) override {
    const int done = fault_.in_step(sweeps);
    if (fault_.in_output && done > 0) {
      sound_->step(done - 1);
      sound_->read(before_);
      sound_->step(1);
    } else {
      sound_->step(done);
    }
  }

  void do_read(VectorField& displacement) override {
    sound_->read(displacement);
    if (fault_.in_output) {
      fault_.in_output(displacement, before_);
    }
    if (fault_.in_read) {
      fault_.in_read(displacement);
    }
    last_read_ = displacement;
  }

  std::int64_t do_changed() override {
    const std::int64_t changed = sound_->changed();
    return fault_.in_changed ? fault_.in_changed(changed) : changed;
  }

  std::unique_ptr<Session> sound_;
  Fault fault_;
  const Scene* scene_;
  VectorField before_;    ///< the last sweep
  VectorField last_read_; ///< empty before the first read
  bool begins_ = false;   ///< loaded and not yet written
};

} // namespace

std::unique_ptr<Session> FaultyBackend::do_open(std::size_t /*index*/, const SessionOptions& options) const {
  return std::make_unique<FaultySession>(sound_.open(options), fault_, scene_);
}

} // namespace hdmbench::faults
